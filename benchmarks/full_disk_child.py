"""Works on a disk that has room for so many pages more, and looks at what became of everything.

``python -m benchmarks.full_disk_child FOLDER FIRST N``, run by `own_disk.on_own_disks`, prints a
line of JSON for each of N numbers of free pages from FIRST on.
"""

import json
import os
import shutil
import sys
import tempfile
import threading
from collections.abc import Callable, Iterator
from pathlib import Path

from adibas.calibration.files import read_calibration, write_calibration
from adibas.errors import AdibasError
from adibas.recordings import open_recording
from adibas.recordings.codings import read_codings
from adibas.sessions import open_store
from adibas.sessions.trial_restore import verify_backup
from benchmarks import fuzz_seeds as samples
from benchmarks.crash_trial import Acknowledged
from benchmarks.crash_victim import PASSPHRASE
from benchmarks.own_disk import mount_small
from benchmarks.store_work import Notes, make_store, problems_in, threads_left, work

PAGE = 4096
DISK_BYTES = 64 * 2**20

Write = Callable[[Path], object]
FILES: dict[str, tuple[Write, Write]] = {
    "a.mcap": (lambda path: samples.recording(path, "jpeg"), open_recording),
    "b.oni": (lambda path: samples.recording(path, "jpeg"), open_recording),
    "c": (lambda path: samples.tum(path, ""), open_recording),
    "d.json": (lambda path: write_calibration(path, samples.CALIBRATION), read_calibration),
    "e.xlsx": (lambda path: samples.coding(path, ""), read_codings),
    "f.eaf": (lambda path: samples.coding(path, ""), read_codings),
    "g.boris": (lambda path: samples.coding(path, ""), read_codings),
}
"""How each file is written, and read again."""


def main() -> None:
    """Do so for each number of pages."""
    folder, first, n_numbers = Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3])
    template = folder / "template"
    acknowledged = make_store(template)
    disk = folder / "disk"
    mount_small(disk, DISK_BYTES)
    for n_pages in range(first, first + n_numbers):
        shutil.copytree(template, disk / "store")
        told = _tried(disk, n_pages, acknowledged)
        print(json.dumps(told), flush=True)  # noqa: T201
        for path in disk.iterdir():
            shutil.rmtree(path) if path.is_dir() else path.unlink()


def _tried(disk: Path, n_pages: int, before: Acknowledged) -> dict[str, object]:
    n_threads = threading.active_count()
    ballast = disk / "ballast"
    _fill(disk, ballast, n_pages)
    notes = Notes()
    for name in Acknowledged.__slots__:
        getattr(notes.acknowledged, name).update(getattr(before, name))
    failed = work(disk / "store", n_pages, notes)
    told = [] if failed is None else [str(failed)]
    written, problems = [], []
    for name, (write, _read) in FILES.items():
        error = _error_of(write, disk / name)
        told += [error] if error else []
        written += [] if error else [name]
    told += [error] if (error := _error_of(_back_up, disk)) else []
    ballast.unlink()
    problems += problems_in(disk / "store", notes.acknowledged)
    problems += list(_unreadable(disk, written))
    problems += threads_left(n_threads)
    return {"n_pages": n_pages, "told": told, "problems": problems}


def _fill(disk: Path, ballast: Path, n_pages: int) -> None:
    """Leave room for so many pages."""
    with ballast.open("wb") as file:
        at = os.statvfs(disk)
        os.posix_fallocate(file.fileno(), 0, max(1, (at.f_bavail - n_pages) * at.f_frsize))


def _error_of(write: Write, path: Path) -> str:
    """Return what the user is told; empty where it went well."""
    try:
        write(path)
    except AdibasError as error:
        return str(error)
    return ""


def _back_up(disk: Path) -> None:
    with open_store(disk / "store", PASSPHRASE) as store:
        store.backups.write(disk / "x.backup")


def _unreadable(disk: Path, written: list[str]) -> Iterator[str]:
    """Say what was written, and cannot be read, and what is left over of what was not."""
    for path in disk.iterdir():
        name = path.name
        if name in ("store", "a.calibration.json", "b.calibration.json"):
            continue
        if name in FILES and name in written:
            if error := _error_of(FILES[name][1], path):
                yield f"{name} was written, but {error}"
        elif name == "x.backup":
            with tempfile.TemporaryDirectory() as room:  # of another disk, which is not full
                verify_backup(path, PASSPHRASE, room=Path(room))
        elif ".part" in name:  # the frames until then, as the sentence says
            if error := _error_of(open_recording, path):
                yield f"{name} was kept, but {error}"
        else:
            yield f"{name} is left over"


if __name__ == "__main__":
    main()
