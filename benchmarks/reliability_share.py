"""A network share that vanishes while a store on it is worked in.

The share is a file system of bindfs, whose server is killed at a random moment: every call then
fails as on a share whose connection is gone. ``--amount`` is the number of moments in this run.
"""

import json
import shutil
import tempfile
from collections.abc import Iterable

from adibas.errors import FileError
from benchmarks.long_run import Run, problem_rows
from benchmarks.own_disk import can_mount, on_own_disks
from benchmarks.table import Row

WHOLE, QUICK = 200, 3


def rows(run: Run) -> Iterable[Row]:
    """Let it vanish."""
    if not can_mount() or shutil.which("bindfs") is None:
        raise FileError("No share can be mounted here. Install bindfs, and allow user namespaces.")
    done = run.kept("share", {"n_moments": 0, "seconds": 0.0, "problems": []})
    to_do = run.n_to_do(WHOLE, done["n_moments"], QUICK)
    with tempfile.TemporaryDirectory() as folder:
        words = (folder, str(done["n_moments"]), str(to_do))
        with on_own_disks("benchmarks.share_child", *words) as lines:
            for number, line in enumerate(lines):
                told = json.loads(line)
                done["n_moments"] += 1
                done["seconds"] = max(done["seconds"], told["seconds"])
                found = [f"{told['moment_s']:.3f} s: {one}" for one in told["problems"]]
                done["problems"] += found
                done.keep()
                run.progress(number, to_do)
    yield Row("moments at which the share vanished", done["n_moments"], "moments", WHOLE, "goal")
    yield Row("longest until it was told in a sentence", done["seconds"], "s", 10, "goal <")
    yield from problem_rows("things lost, damaged or untold", done["problems"])
