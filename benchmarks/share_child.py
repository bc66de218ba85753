"""Works on a network share that vanishes at a random moment.

``python -m benchmarks.share_child FOLDER FIRST N``, run by `own_disk.on_own_disks`, prints a line
of JSON for each of N moments.
"""

import faulthandler
import json
import shutil
import sys
import threading
import time
import traceback
from pathlib import Path

import numpy as np

from benchmarks.own_disk import mount_share, unmount, vanish
from benchmarks.store_work import Notes, make_store, problems_in, threads_left, work

LONGEST_S = 1.5
"""After which the share vanishes, at the latest: the work takes about so long."""


def main() -> None:
    """Do so at each moment."""
    faulthandler.enable()
    folder, first, n_moments = Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3])
    for seed in range(first, first + n_moments):
        print(json.dumps(_tried(folder, seed)), flush=True)  # noqa: T201


def _tried(folder: Path, seed: int) -> dict[str, object]:
    kept, share = folder / "kept", folder / "share"
    shutil.rmtree(kept, ignore_errors=True)
    kept.mkdir()
    notes = Notes()
    server = mount_share(kept, share)
    notes.acknowledged = make_store(share / "store")
    n_threads = threading.active_count()
    moment_s = float(np.random.default_rng([3, seed]).random()) * LONGEST_S
    vanishing = threading.Timer(moment_s, vanish, (server,))
    vanishing.start()
    start_s = time.monotonic()
    told, problems = _worked(share / "store", seed, notes)
    seconds = time.monotonic() - start_s - moment_s
    vanishing.join()
    if (kept / "store" / "adibas.db-shm").exists():
        problems.append("a file of the share was mapped into memory")
    unmount(share)
    problems += problems_in(kept / "store", notes.acknowledged)
    problems += threads_left(n_threads)
    return {
        "moment_s": moment_s, "told": str(told), "seconds": seconds, "problems": problems
    }  # fmt: skip


def _worked(store: Path, seed: int, notes: Notes) -> tuple[str, list[str]]:
    """Work until something is told; return it, and what was no sentence."""
    told = None
    try:
        while told is None:
            told = work(store, seed, notes)
    except Exception as error:  # noqa: BLE001  (every one of them is a finding)
        frames = [f for f in traceback.extract_tb(error.__traceback__) if "adibas" in f.filename]
        where = [f"{Path(frame.filename).name}:{frame.lineno}" for frame in frames]
        return "", [f"{type(error).__name__} in {', '.join(where[-3:])}: {error}"]
    return str(told), []


if __name__ == "__main__":
    main()
