"""Works in a store for a while in this process, and looks afterwards for what is missing."""

import json
import threading
from pathlib import Path

import numpy as np

from adibas.clock import Clock, utc_now
from adibas.errors import AdibasError
from adibas.sessions import open_store
from benchmarks.crash_trial import Acknowledged, Outcome, look
from benchmarks.crash_victim import CHEAP, PASSPHRASE, Victim

FRAMES = 20


class Notes:
    """What the store has acknowledged, noted as it comes."""

    def __init__(self) -> None:
        self.acknowledged = Acknowledged()

    def send_bytes(self, data: bytes, /) -> None:
        """Note one thing."""
        self.acknowledged.take(json.loads(data))


def make_store(folder: Path) -> Acknowledged:
    """Make a store with one session in it."""
    notes = Notes()
    failed = work(folder, 0, notes)
    if failed is not None:
        raise failed
    return notes.acknowledged


def work(folder: Path, seed: int, notes: Notes, clock: Clock = utc_now) -> AdibasError | None:
    """Add a patient with a session, a recording and captures; return what was told, or None.

    Anything but an `AdibasError` is raised: a program must not end so.
    """
    rng = np.random.default_rng(seed)
    try:
        with open_store(folder, PASSPHRASE, key_params=CHEAP, clock=clock) as store:
            victim = Victim(store, notes, rng, FRAMES)
            victim.work_once(victim.add_patient())
    except AdibasError as error:
        return error
    return None


def problems_in(folder: Path, acknowledged: Acknowledged) -> list[str]:
    """Open the store again; return everything that must not be."""
    outcome = Outcome(0, 0.0)
    look(folder, outcome, acknowledged, Acknowledged())
    return outcome.problems


def threads_left(before: int) -> list[str]:
    """Say which threads a failure left behind, where there are more than `before`."""
    names = [one.name for one in threading.enumerate()]
    return [f"threads are left: {names}"] if len(names) > before else []
