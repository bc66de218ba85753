"""Machine code that comes with an installed program is found, and nothing is compiled again."""

import os
import platform
import subprocess
import sys
from pathlib import Path

import pytest
from llvmlite import binding

from adibas import shipped_kernels
from adibas.shipped_kernels import X86_FEATURES, X86_KIND, ModuleLocator, processor_kind
from installers.freezing import pack

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
    kind = processor_kind()
    run_frozen(tmp_path, kernels / kind, NUMBA_CPU_NAME=kind, NUMBA_CPU_FEATURES="")
    assert list(kernels.rglob("*.nbc"))
    pack(kernels)
    assert not list(kernels.rglob("*.nbc"))
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
@pytest.mark.parametrize(("lacks", "kind"), [(None, X86_KIND), ("sse4.2", "host")])
def test_what_a_processor_lacks_it_is_not_given(monkeypatch, lacks, kind):
    has = {name: name != lacks for name in X86_FEATURES}
    monkeypatch.setattr(binding, "get_host_cpu_features", lambda: has)
    assert processor_kind() == kind


def test_functions_of_one_file_name_in_two_packages_do_not_meet(monkeypatch, tmp_path):
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    one = ModuleLocator.from_function(processor_kind, "kernels.py")
    other = ModuleLocator.from_function(run_frozen, "kernels.py")
    assert one.get_cache_path() != other.get_cache_path()
