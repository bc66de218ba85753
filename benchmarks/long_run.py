"""What a reliability benchmark is told, and how it goes on where it was interrupted."""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from adibas.files import written_whole
from adibas.progress import Progress

STATE_FOLDER = Path(__file__).parents[1] / "build" / "reliability"


@dataclass(frozen=True, slots=True)
class Run:
    """One run of `benchmarks/reliability_NAME.py`, whose ``rows(run)`` gives the table's rows.

    Attributes
    ----------
    is_quick : bool
        Do a few only, to see that it runs, and leave what is kept of longer runs alone.
    amount : float or None
        How much this run does, in the benchmark's own unit; None: all that is left of the whole.
    progress : callable
        Told what is done, and all.
    folder : Path
        Keeps what is done between runs.
    """

    is_quick: bool
    amount: float | None
    progress: Progress
    folder: Path = STATE_FOLDER

    def n_to_do(self, whole: int, done: int, quick: int) -> int:
        """Return how many things this run does, where `done` of the `whole` are done."""
        if self.is_quick:
            return quick
        left = max(0, whole - done)
        return left if self.amount is None else min(left, round(self.amount))


def load_state(path: Path) -> dict[str, Any]:
    """Return what was kept at `path`; nothing where there is none."""
    if not path.is_file():
        return {}
    state: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    return state


def keep_state(path: Path, state: Mapping[str, object]) -> None:
    """Keep `state` at `path`: whole, or as it was before."""
    with written_whole(path) as unfinished:
        unfinished.write_text(json.dumps(state, indent=1), encoding="utf-8")
