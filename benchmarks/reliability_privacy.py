"""No network is asked for anything, and nothing of a patient is left outside the store.

The main jobs of the command line and a whole session in the window (by mouse: new patient, four
captures, review, report) are run in a namespace without a network, with a home of their own. Every
file that is there afterwards is searched for the patient, and every file that was removed before.
It takes some minutes, and is not resumed.
"""

import json
import tempfile
import time
from collections.abc import Iterable
from datetime import date
from pathlib import Path

from adibas.data.patients import Identity
from adibas.errors import FileError
from adibas.simulation.scenes import open_scene
from benchmarks.first_report_probe import NAME, RECORD
from benchmarks.identity_search import found_below, secrets_of
from benchmarks.long_run import Run
from benchmarks.private_home import Watched, can_be_alone, run_alone
from benchmarks.table import Row

PERSON = Identity(NAME, date(1971, 4, 3), RECORD)
"""The birth date of the window's hand, or the other reading of it, is searched in every order."""
N_CLICKS = 3
COLOR_SIZE = (1024, 1280)


def rows(run: Run) -> Iterable[Row]:
    """Run and search; with `quick` the command line alone."""
    if not can_be_alone():
        raise FileError("No namespace can be made here. Allow user namespaces, or work as root.")
    kinds = ("commands",) if run.is_quick else ("commands", "a session in the window")
    for number, kind in enumerate(kinds):
        run.progress(number, len(kinds))
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            watched = run_alone(folder, _words(kind, folder), _secrets())
            yield from _told(kind, watched, folder)


def _secrets() -> tuple[str, ...]:
    other = Identity(NAME, date(1971, 3, 4), RECORD)
    return tuple(dict.fromkeys((*secrets_of(PERSON), *secrets_of(other))))


def _words(kind: str, folder: Path) -> list[str]:
    (folder / "work").mkdir()
    if kind == "commands":
        return ["benchmarks.cli_jobs", str(folder / "work")]
    markers = open_scene("anterior", color_size=COLOR_SIZE).frame(0).truth.markers
    seen = sorted((one for one in markers if one.is_visible), key=lambda one: one.view_angle_rad)
    stickers = json.dumps([(one.u, one.v) for one in seen[:N_CLICKS]])
    words = ["benchmarks.first_report_probe", "mouse", str(folder / "work")]
    return [*words, stickers, str(time.time())]


def _told(kind: str, watched: Watched, folder: Path) -> Iterable[Row]:
    how = "Python's events and the system's calls" if watched.is_traced else "Python's events"
    yield Row(
        f"{kind}: attempts to reach a network ({how})", len(watched.attempts), "attempts", 0, "goal"
    )
    for attempt in watched.attempts:
        yield Row(attempt, 1, "attempts", 0, "goal")
    left = found_below(folder, _secrets())
    n_files = sum(path.is_file() for path in folder.rglob("*"))
    yield Row(f"{kind}: files searched afterwards", n_files, "files")
    yield Row(f"{kind}: files with the patient in them", len(left), "files", 0, "goal")
    for name, found in left.items():
        yield Row(f"{name}: {', '.join(sorted(found))}", 1, "files", 0, "goal")
    n_removed = len(watched.removed)
    yield Row(f"{kind}: of files that came and went", n_removed, "files", 0, "goal")
    temporary = sum(path.is_file() for path in (folder / "tmp").rglob("*"))
    yield Row(f"{kind}: files left in the folder for temporary ones", temporary, "files", 0, "goal")
