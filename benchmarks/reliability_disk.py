"""A disk that is full at every write: with room for 0, 1, 2, ... pages until everything fits.

On each of these disks a session is recorded and saved, files of seven kinds and a backup are
written; each of them is whole or refused in a sentence, and what was saved before and during it is
there afterwards. ``--amount`` is the number of disks in this run. Linux only.
"""

import json
import tempfile
from collections.abc import Iterable

from adibas.errors import FileError
from benchmarks.long_run import Run, problem_rows
from benchmarks.own_disk import can_mount, on_own_disks
from benchmarks.table import Row

WHOLE, QUICK = 400, 4
"""With 300 pages of 4 KiB and more everything has room."""


def rows(run: Run) -> Iterable[Row]:
    """Fill disks."""
    if not can_mount():
        raise FileError("No disk can be mounted here. Allow user namespaces, or work as root.")
    done = run.kept("disk", {"n_disks": 0, "n_refused": 0, "n_full": 0, "problems": []})
    to_do = run.n_to_do(WHOLE, done["n_disks"], QUICK)
    with tempfile.TemporaryDirectory() as folder:
        words = (folder, str(done["n_disks"]), str(to_do))
        with on_own_disks("benchmarks.full_disk_child", *words) as lines:
            for number, line in enumerate(lines):
                told = json.loads(line)
                done["n_disks"] += 1
                done["n_refused"] += len(told["told"])
                done["n_full"] += bool(told["told"])
                found = [f"{told['n_pages']} pages: {one}" for one in told["problems"]]
                done["problems"] += found
                done.keep()
                run.progress(number, to_do)
    yield Row("disks with room for 0, 1, 2, ... pages", done["n_disks"], "disks", WHOLE, "goal")
    yield Row("of these too small for something", done["n_full"], "disks")
    yield Row("sentences that said so", done["n_refused"], "sentences")
    yield from problem_rows("things lost, damaged or left over", done["problems"])
