"""A clock that is set back or ahead between any two looks at it: nothing is lost or confused.

``--amount`` is the number of stores in this run; the next one goes on with other seeds.
"""

import tempfile
from collections.abc import Iterable
from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np

from benchmarks.long_run import Run, problem_rows
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
    done = run.kept("clock", {"n_stores": 0, "n_back": 0, "problems": []})
    to_do = run.n_to_do(WHOLE, done["n_stores"], QUICK)
    for number in range(to_do):
        run.progress(number, to_do)
        n_back, problems = trial(done["n_stores"])
        done["n_stores"] += 1
        done["n_back"] += n_back
        done["problems"] += problems
        done.keep()
    yield Row("stores made with a jumping clock", done["n_stores"], "stores", WHOLE, "goal")
    yield Row("jumps back between two looks", done["n_back"], "jumps")
    yield from problem_rows("things lost, damaged or refused", done["problems"])


def trial(seed: int) -> tuple[int, list[str]]:
    """Work in a new store; return how often the clock jumped back, and what is wrong."""
    clock = JumpingClock(np.random.default_rng([7, seed]))
    notes = Notes()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name) / "store"
        told = [work(folder, seed + k, notes, clock) for k in range(SESSIONS)]
        problems = [f"seed {seed}: {error}" for error in told if error is not None]
        return clock.n_back, [*problems, *problems_in(folder, notes.acknowledged)]
