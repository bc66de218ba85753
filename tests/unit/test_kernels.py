"""Compiled functions: what they need of the disk, and what not."""

import subprocess
import sys
from pathlib import Path

import pytest

PROJECT = Path(__file__).parents[2]

ON_A_FULL_DISK = """
import resource
from adibas.recordings.rvl import decode_rvl, encode_rvl
import numpy as np

resource.setrlimit(resource.RLIMIT_FSIZE, (100, 100))
depth = np.arange(12, dtype=np.uint16).reshape(3, 4)
print(np.array_equal(decode_rvl(encode_rvl(depth), depth.shape), depth))
"""


def test_a_cache_that_cannot_be_written_fails_nothing(tmp_path):
    run = subprocess.run(
        [sys.executable, "-W", "error", "-c", ON_A_FULL_DISK],
        cwd=PROJECT,
        env={
            "NUMBA_CACHE_DIR": str(tmp_path),
            "PATH": "/usr/bin:/bin",
            "PYTHONDONTWRITEBYTECODE": "1",  # else a cut .pyc would stay for everybody
        },
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert (run.stdout, run.stderr) == ("True\n", "")
    assert all(path.stat().st_size <= 100 for path in tmp_path.rglob("*") if path.is_file())


@pytest.mark.parametrize(("own", "wanted"), [({}, "1000"), ({"GOMP_SPINCOUNT": "7"}, "7")])
def test_threads_that_wait_for_loops_sleep_soon_unless_the_user_wants_otherwise(own, wanted):
    # libgomp reads it when it is loaded, with the first parallel loop.
    told = (
        "import sys, adibas.kernels, os;"
        "assert not any('omppool' in name for name in sys.modules);"
        "print(os.environ['GOMP_SPINCOUNT'])"
    )
    run = subprocess.run(
        [sys.executable, "-c", told],
        cwd=PROJECT,
        env={"PATH": "/usr/bin:/bin", "PYTHONDONTWRITEBYTECODE": "1", **own},
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert run.stdout.strip() == wanted, run.stderr
