"""What a reliability benchmark is told, and how it goes on where it was interrupted."""

import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from adibas.files import written_whole
from adibas.progress import Progress
from benchmarks.table import Row

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

    def kept(self, name: str, nothing: Mapping[str, Any]) -> "Kept":
        """Return what earlier runs have counted; a quick run begins with nothing."""
        return Kept(None if self.is_quick else self.folder / f"{name}.json", nothing)


class Kept(dict[str, Any]):
    """What a benchmark has counted: a later run goes on with it.

    Parameters
    ----------
    file : Path or None
        Where it is kept between runs; None: nowhere.
    nothing : mapping
        What is counted, before anything is done.
    """

    def __init__(self, file: Path | None, nothing: Mapping[str, Any]) -> None:
        super().__init__(nothing)
        self._file = file
        if file is not None and file.is_file():
            self.update(json.loads(file.read_text(encoding="utf-8")))

    def keep(self) -> None:
        """Write it down: whole, or as it was before."""
        if self._file is not None:
            with written_whole(self._file) as unfinished:
                unfinished.write_text(json.dumps(self, indent=1), encoding="utf-8")


def problem_rows(what: str, problems: list[str]) -> Iterable[Row]:
    """Give the row of how many there are, which should be none, then one for each."""
    yield Row(what, len(problems), "things", 0, "goal")
    for problem in problems:
        yield Row(problem, 1, "things", 0, "goal")
