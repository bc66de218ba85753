"""Machine code that comes with an installed program is found, and nothing is compiled again."""

import os
import platform
import subprocess
import sys
from pathlib import Path

import pytest

from adibas import shipped_kernels
from adibas.shipped_kernels import X86_LEVELS, ModuleLocator, processor_level

PROJECT = Path(__file__).parents[2]
FROZEN = """
import sys
from pathlib import Path

sys._MEIPASS = sys.argv[1]
import numpy as np
from adibas.recordings.rvl import decode_rvl, encode_rvl

depth = np.arange(12, dtype=np.uint16).reshape(3, 4)
print(np.array_equal(decode_rvl(encode_rvl(depth), depth.shape), depth))
"""


def run_frozen(bundle, cache, **more):
    names = ("NUMBA_CPU_NAME", "NUMBA_CPU_FEATURES")
    environment = {name: value for name, value in os.environ.items() if name not in names}
    run = subprocess.run(
        [sys.executable, "-W", "error", "-c", FROZEN, str(bundle)],
        cwd=PROJECT,
        env={**environment, "NUMBA_CACHE_DIR": str(cache), **more},
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert (run.stdout, run.stderr) == ("True\n", "")


def test_what_was_compiled_by_the_builder_is_not_compiled_again(tmp_path):
    kernels, home = tmp_path / "resources" / "kernels", tmp_path / "home"
    kernels.mkdir(parents=True)
    (kernels / "sources.txt").write_text("a mark\n")
    level = processor_level()
    run_frozen(tmp_path, kernels / level, NUMBA_CPU_NAME=level, NUMBA_CPU_FEATURES="")
    assert list(kernels.rglob("*.nbc"))
    run_frozen(tmp_path, home)
    assert not home.exists()


def test_machine_code_of_other_sources_is_compiled_anew_into_the_users_own_folder(tmp_path):
    kernels, home = tmp_path / "resources" / "kernels", tmp_path / "home"
    kernels.mkdir(parents=True)
    (kernels / "sources.txt").write_text("a mark\n")
    run_frozen(tmp_path, home)
    (folder,) = home.iterdir()
    assert folder.name == "adibas.recordings.rvl_kernels"


def test_a_source_tree_ships_nothing():
    assert shipped_kernels.build_mark() is None
    assert shipped_kernels.shipped_folder() is None


@pytest.mark.skipif(platform.machine() != "x86_64", reason="kinds of x86 processors")
@pytest.mark.parametrize(("level", "needed"), X86_LEVELS)
def test_a_processor_gets_the_best_level_it_has_all_features_of(monkeypatch, level, needed):
    from llvmlite import binding

    has = {name: name in needed for _level, names in X86_LEVELS for name in names}
    monkeypatch.setattr(binding, "get_host_cpu_features", lambda: has)
    assert processor_level() == level


def test_functions_of_one_file_name_in_two_packages_do_not_meet(monkeypatch, tmp_path):
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    one = ModuleLocator.from_function(processor_level, "kernels.py")
    other = ModuleLocator.from_function(run_frozen, "kernels.py")
    assert one.get_cache_path() != other.get_cache_path()
