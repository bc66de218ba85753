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


def run_python(*arguments, cwd=PROJECT, **variables):
    """Run Python with no other variables; a .pyc that a full disk cuts would stay for everybody."""
    return subprocess.run(
        [sys.executable, *map(str, arguments)],
        cwd=cwd,
        env={"PATH": "/usr/bin:/bin", "PYTHONDONTWRITEBYTECODE": "1", **variables},
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )


def test_a_cache_that_cannot_be_written_fails_nothing(tmp_path):
    run = run_python("-W", "error", "-c", ON_A_FULL_DISK, NUMBA_CACHE_DIR=str(tmp_path))
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
    run = run_python("-c", told, **own)
    assert run.stdout.strip() == wanted, run.stderr


LOOPS_OF_FOUR_THREADS = """
import threading
import numpy as np
from adibas.kernels import compiled_parallel, parallel_range

@compiled_parallel
def squares(numbers):
    out = np.empty_like(numbers)
    for i in parallel_range(numbers.size):
        out[i] = numbers[i] ** 2
    return out

numbers = np.arange(200_000.0)
at_once = threading.Barrier(4)
wrong = []

def work():
    at_once.wait()
    wrong.extend(i for i in range(100) if not np.array_equal(squares(numbers), numbers**2))

threads = [threading.Thread(target=work) for _ in range(4)]
for one in threads:
    one.start()
for one in threads:
    one.join()
print(len(wrong))
"""


@pytest.mark.parametrize("layer", ["workqueue", "default"])
def test_parallel_loops_of_several_threads_end_well_whatever_runs_them(tmp_path, layer):
    script = tmp_path / "loops.py"
    script.write_text(LOOPS_OF_FOUR_THREADS, encoding="utf-8")
    own = {"NUMBA_CACHE_DIR": str(tmp_path / "kept"), "PYTHONPATH": str(PROJECT)}
    run = run_python(script, NUMBA_THREADING_LAYER=layer, **own)
    assert (run.returncode, run.stdout) == (0, "0\n"), run.stderr


NUMBERS = "STEP = {step}\n"
CALLED = """
from adibas.kernels import compiled

@compiled
def twice(x):
    return {factor} * x
"""
CALLER = """
from adibas.kernels import compiled
from called import twice
from numbers_of_it import STEP

@compiled
def more(x):
    return below(x) + twice(x)

@compiled
def below(x):
    return x - STEP
"""


class TestKeptMachineCode:
    """Of a caller whose own file never changes."""

    @pytest.fixture
    def result(self, tmp_path):
        """Return a function: write what is called and a number of another module, then call."""
        (tmp_path / "caller.py").write_text(CALLER)

        def call(factor, step):
            for name, text in (
                ("called.py", CALLED.format(factor=factor)),
                ("numbers_of_it.py", NUMBERS.format(step=step)),
            ):
                if not (tmp_path / name).exists() or (tmp_path / name).read_text() != text:
                    (tmp_path / name).write_text(text)
            asked = "import caller; print(caller.more(10.0))"
            own = {"NUMBA_CACHE_DIR": str(tmp_path / "kept"), "PYTHONPATH": str(PROJECT)}
            run = run_python("-W", "error", "-c", asked, cwd=tmp_path, **own)
            assert run.returncode == 0, run.stderr
            return float(run.stdout)

        return call

    def test_is_not_run_any_more_when_what_it_calls_has_changed(self, result):
        assert result(factor=2.0, step=1.0) == 29.0
        assert result(factor=3.0, step=1.0) == 39.0

    def test_is_not_run_any_more_when_a_number_of_another_module_has_changed(self, result):
        assert result(factor=2.0, step=1.0) == 29.0
        assert result(factor=2.0, step=4.0) == 26.0

    def test_is_run_again_when_nothing_has_changed(self, result, tmp_path):
        result(factor=2.0, step=1.0)
        made = {path: path.stat().st_mtime_ns for path in (tmp_path / "kept").rglob("*.nbc")}
        assert len(made) == 3
        result(factor=2.0, step=1.0)
        assert made == {
            path: path.stat().st_mtime_ns for path in (tmp_path / "kept").rglob("*.nbc")
        }
