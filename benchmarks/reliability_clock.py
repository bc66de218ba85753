"""A clock that is set back or ahead between any two looks at it: nothing is lost or confused.

``--amount`` is the number of stores in this run; the next one goes on with other seeds.
"""

import tempfile
from collections.abc import Iterable
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.long_run import Run, keep_state, load_state
from benchmarks.store_work import Notes, problems_in, work
from benchmarks.table import Row

WHOLE, QUICK = 100, 3
SESSIONS = 3
START = datetime(2026, 11, 21, 9, 0, tzinfo=UTC)
JUMPS = (timedelta(0), timedelta(seconds=1), timedelta(hours=1), timedelta(days=2),
         timedelta(days=400), timedelta(days=4000))  # fmt: skip
"""A summer time that was not told, an empty battery, a wrong year."""


class JumpingClock:
    """Goes on by a second at each look, or jumps, in half of the looks backwards."""

    def __init__(self, rng: np.random.Generator) -> None:
        self._rng = rng
        self._now = START
        self.n_back = 0

    def __call__(self) -> datetime:
        """Return the time."""
        jump = JUMPS[int(self._rng.integers(len(JUMPS)))]
        is_back = bool(self._rng.random() < 0.5)
        self.n_back += is_back and jump > timedelta(0)
        self._now += timedelta(seconds=1) + (-jump if is_back else jump)
        if not START - timedelta(days=9000) < self._now < START + timedelta(days=9000):
            self._now = START
        return self._now


def rows(run: Run) -> Iterable[Row]:
    """Work with such clocks."""
    path = run.folder / "clock.json"
    done: dict[str, Any] = {"n_stores": 0, "n_back": 0, "problems": []}
    if not run.is_quick:
        done |= load_state(path)
    to_do = run.n_to_do(WHOLE, done["n_stores"], QUICK)
    for number in range(to_do):
        run.progress(number, to_do)
        n_back, problems = trial(done["n_stores"])
        done["n_stores"] += 1
        done["n_back"] += n_back
        done["problems"] = [*done["problems"], *problems]
        if not run.is_quick:
            keep_state(path, done)
    yield Row("stores made with a jumping clock", done["n_stores"], "stores", WHOLE, "goal")
    yield Row("jumps back between two looks", done["n_back"], "jumps")
    yield Row("things lost, damaged or refused", len(done["problems"]), "things", 0, "goal")
    for problem in done["problems"]:
        yield Row(problem, 1, "things", 0, "goal")


def trial(seed: int) -> tuple[int, list[str]]:
    """Work in a new store; return how often the clock jumped back, and what is wrong."""
    clock = JumpingClock(np.random.default_rng([7, seed]))
    notes = Notes()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name) / "store"
        told = [work(folder, seed + k, notes, clock) for k in range(SESSIONS)]
        problems = [f"seed {seed}: {error}" for error in told if error is not None]
        return clock.n_back, [*problems, *problems_in(folder, notes.acknowledged)]
