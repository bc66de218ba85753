"""Kills a process that works in a store, opens the store again, and looks for what is missing."""

import json
import multiprocessing
import shutil
import time
import zlib
from collections.abc import Iterator
from dataclasses import dataclass, field
from multiprocessing.connection import Connection
from multiprocessing.context import ForkServerContext
from pathlib import Path

import numpy as np

from adibas.errors import AdibasError
from adibas.sessions import SessionStore, open_store
from benchmarks.crash_victim import CHEAP, PASSPHRASE, work

Said = list[str | int]

KILLS_PER_STORE = 10
SECONDS_TO_MAKE = 0.4
"""The first kill of a store comes within this time of its start: while the store is made."""
SECONDS_TO_OPEN = 0.15
SECONDS_OF_WORK = 0.6
OPENINGS_OF_WORK = 5.0
"""So many times what opening takes, where a busy computer would not come to anything in less."""
SECONDS_TO_START = 60.0


@dataclass(slots=True)
class Acknowledged:
    """What the processes said was saved, over all kills of one store.

    Attributes
    ----------
    patients, sessions : set of str
        Pseudonyms and ids.
    captures, corrections : dict
        Checksum of the picture, and number of corrections, by capture.
    frames, recordings : dict
        Frames written up to now, and frames of a closed recording, by recording.
    """

    patients: set[str] = field(default_factory=set)
    sessions: set[str] = field(default_factory=set)
    captures: dict[str, int] = field(default_factory=dict)
    corrections: dict[str, int] = field(default_factory=dict)
    frames: dict[str, int] = field(default_factory=dict)
    recordings: dict[str, int] = field(default_factory=dict)

    def take(self, said: Said) -> None:
        """Note one line."""
        match said:
            case ["patient", str(name)]:
                self.patients.add(name)
            case ["session", str(name)]:
                self.sessions.add(name)
            case ["capture", str(name), int(checksum)]:
                self.captures[name] = checksum
            case ["correction", str(name), int(count)]:
                self.corrections[name] = count
            case ["frame", str(name), int(number)]:
                self.frames[name] = number + 1
            case ["recording", str(name), int(count)]:
                self.recordings[name] = count


@dataclass(slots=True)
class Outcome:
    """What one kill did.

    Attributes
    ----------
    seed : int
        Of the moment and of the work.
    moment_s : float
        From the start of the process, or from its opening of the store where it had opened it.
    n_saved : int
        Acknowledged things in the store up to now.
    n_frames_lost : int
        Acknowledged frames of this process that are not in the store.
    n_interrupted : int
        Recordings of this process that say that they were interrupted.
    opening_s : float
        How long the next opening took.
    problems : list of str
        Everything that must not be.
    """

    seed: int
    moment_s: float
    n_saved: int = 0
    n_frames_lost: int = 0
    n_interrupted: int = 0
    opening_s: float = 0.0
    problems: list[str] = field(default_factory=list)


def kill_often(folder: Path, seeds: range) -> Iterator[Outcome]:
    """Kill one process for each seed; the store in `folder` is new after `KILLS_PER_STORE`."""
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(["benchmarks.crash_victim"])
    for number, seed in enumerate(seeds):
        if number % KILLS_PER_STORE == 0:
            shutil.rmtree(folder, ignore_errors=True)
            acknowledged = Acknowledged()
        yield _kill_once(context, folder, seed, acknowledged, is_new=not folder.exists())


def _kill_once(
    context: ForkServerContext, folder: Path, seed: int, before: Acknowledged, *, is_new: bool
) -> Outcome:
    rng = np.random.default_rng(seed)
    is_early = is_new or rng.random() < 0.2
    share = float(rng.random())
    outcome = Outcome(seed, share * (SECONDS_TO_MAKE if is_new else SECONDS_TO_OPEN))
    receiver, sender = context.Pipe(duplex=False)
    process = context.Process(target=work, args=(str(folder), seed, sender), daemon=True)
    start_s = time.monotonic()
    process.start()
    sender.close()
    latest = Acknowledged()
    if not is_early:
        if not receiver.poll(SECONDS_TO_START):
            outcome.problems.append("the process did not open the store")
        opening_s = time.monotonic() - start_s
        outcome.moment_s = share * max(SECONDS_OF_WORK, OPENINGS_OF_WORK * opening_s)
    _listen(receiver, time.monotonic() + outcome.moment_s, before, latest)
    if not process.is_alive():
        outcome.problems.append(f"the process ended by itself: {process.exitcode}")
    process.kill()
    process.join()
    _listen(receiver, time.monotonic() + SECONDS_TO_START, before, latest)
    receiver.close()
    look(folder, outcome, before, latest)
    return outcome


def _listen(receiver: Connection, until_s: float, *listeners: Acknowledged) -> None:
    """Read what the process says until then, or until it has said the last."""
    try:
        while receiver.poll(max(0.0, until_s - time.monotonic())):
            said = json.loads(receiver.recv_bytes())
            for listener in listeners:
                listener.take(said)
    except (EOFError, OSError):
        return


def look(folder: Path, outcome: Outcome, everything: Acknowledged, latest: Acknowledged) -> None:
    """Open the store again and compare it with what was acknowledged."""
    start_s = time.perf_counter()
    try:
        with open_store(folder, PASSPHRASE, key_params=CHEAP) as store:
            outcome.opening_s = time.perf_counter() - start_s
            _compare(store, outcome, everything)
            _compare_recordings(store, outcome, everything, latest)
            outcome.problems += [finding.text for finding in store.verify().findings]
            outcome.problems += [f"{path.name} is left over" for path in folder.rglob(".*")]
    except AdibasError as error:
        outcome.problems.append(str(error))


def _compare(store: SessionStore, outcome: Outcome, everything: Acknowledged) -> None:
    for pseudonym in everything.patients:
        store.patients.get(pseudonym)
    for session_id in everything.sessions:
        store.sessions.get(session_id)
    for capture_id, checksum in everything.captures.items():
        if zlib.crc32(store.captures.picture(capture_id).tobytes()) != checksum:
            outcome.problems.append(f"another picture in capture {capture_id}")
        history = store.captures.get(capture_id).history
        if history.n_done < everything.corrections.get(capture_id, 0):
            outcome.problems.append(f"corrections of capture {capture_id} are missing")
    outcome.n_saved = sum(
        len(things)
        for things in (
            everything.patients,
            everything.sessions,
            everything.captures,
            everything.recordings,
        )
    )


def _compare_recordings(
    store: SessionStore, outcome: Outcome, everything: Acknowledged, latest: Acknowledged
) -> None:
    for recording_id, n_frames in everything.frames.items():
        with store.recordings.open(recording_id) as reader:
            n_lost = n_frames - len(reader)
            has_notice = reader.notice is not None
            if len(reader) and reader.read(len(reader) - 1).sequence != len(reader) - 1:
                outcome.problems.append(f"wrong frames in recording {recording_id}")
        is_closed = recording_id in everything.recordings
        if is_closed and (n_lost or has_notice):
            outcome.problems.append(f"recording {recording_id} was whole")
        if recording_id in latest.frames:
            outcome.n_frames_lost = max(outcome.n_frames_lost, n_lost)
            outcome.n_interrupted += has_notice
