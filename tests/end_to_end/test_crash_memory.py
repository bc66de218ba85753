"""A crash leaves no image of the memory, in which patients and the key of the store are."""

import json
import signal
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
linux_only = pytest.mark.skipif(sys.platform != "linux", reason="asks Linux")
PATTERN = Path("/proc/sys/kernel/core_pattern")
ALLOWED = "import resource; resource.setrlimit(resource.RLIMIT_CORE, (2**24, {hard}))"
CRASHES = """
import os, sys
{allow}
if sys.argv[1] == "kept out":
    from adibas.crash_memory import keep_out_of_crash_dumps
    keep_out_of_crash_dumps()
{raised}
os.abort()
"""
STARTS = """
import json, resource, sys
from contextlib import suppress
from pathlib import Path
{allow}
sys.argv = ["adibas", "--version"]
from ui.main import main
with suppress(SystemExit):
    main()
limit = resource.getrlimit(resource.RLIMIT_CORE)[0]
print(json.dumps([limit, Path("/proc/self/coredump_filter").read_text().strip("0\\n")]))
"""


def allowed():
    """The line that lets a dump be made, or a skip where the system allows none anyhow."""
    import resource

    hard = resource.getrlimit(resource.RLIMIT_CORE)[1]
    if hard != resource.RLIM_INFINITY:
        pytest.skip("this computer allows no dump anyhow")
    return ALLOWED.format(hard=hard)


def run(code, *words, folder):
    return subprocess.run(
        [sys.executable, "-c", code, *words],
        cwd=folder,
        env={"PYTHONPATH": str(ROOT), "PATH": "/usr/bin:/bin"},
        capture_output=True,
        text=True,
        check=False,
    )


@linux_only
def test_a_crash_leaves_no_file(tmp_path):
    if "/" in PATTERN.read_text() or PATTERN.read_text().startswith("|"):
        pytest.skip("dumps go elsewhere here")
    code = CRASHES.format(allow=allowed(), raised="")
    for words, n_files in (("as it was", 1), ("kept out", 0)):
        folder = tmp_path / words
        folder.mkdir()
        assert run(code, words, folder=folder).returncode == -signal.SIGABRT
        assert len(list(folder.iterdir())) == n_files, words


@linux_only
def test_a_dump_that_is_made_all_the_same_holds_no_memory(tmp_path):
    """A service that takes dumps over need not ask for the limit."""
    if "/" in PATTERN.read_text() or PATTERN.read_text().startswith("|"):
        pytest.skip("dumps go elsewhere here")
    words = "Rosa" + "Quetzal"
    sizes = {}
    for kind in ("as it was", "kept out"):
        folder = tmp_path / kind
        folder.mkdir()
        told = f"name = 'Rosa' + 'Quetzal' * len(sys.argv)\n{allowed()}"
        run(CRASHES.format(allow=allowed(), raised=told), kind, folder=folder)
        (dump,) = folder.iterdir()
        sizes[kind] = words.encode() in dump.read_bytes()
    assert sizes == {"as it was": True, "kept out": False}


@linux_only
def test_the_program_asks_for_it_before_anything_else(tmp_path):
    said = run(STARTS.format(allow=allowed()), folder=tmp_path)
    assert said.returncode == 0, said.stderr
    assert json.loads(said.stdout.splitlines()[-1]) == [0, ""]
