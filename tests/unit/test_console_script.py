"""Ctrl-C before the command has begun, and after it is done."""

import subprocess
import sys

import pytest

BEGINNING = """
import os, signal, sys

class CtrlC:
    def find_spec(self, name, path=None, target=None):
        if name == {module!r}:
            os.kill(os.getpid(), signal.SIGINT)

sys.meta_path.insert(0, CtrlC())
sys.argv = ["adibas", "--version"]
from ui.main import main
sys.exit(main())
"""
ENDING = """
import atexit, os, signal, sys

atexit.register(lambda: os.kill(os.getpid(), signal.SIGINT))
sys.argv = ["adibas", "--version"]
from ui.main import main
sys.exit(main())
"""
BEFORE_THE_COMMAND_LINE_LISTENS = """
import sys
import adibas.cli

def main(_argv):
    raise KeyboardInterrupt

adibas.cli.main = main
from ui.main import main
sys.exit(main())
"""
IGNORED = "import signal\nsignal.signal(signal.SIGINT, signal.SIG_IGN)\n"


def run(script):
    words = [sys.executable, "-c", script]
    return subprocess.run(words, capture_output=True, text=True, check=False)


@pytest.mark.parametrize("module", ["adibas.cli", "tqdm", "importlib.metadata"])
def test_ctrl_c_during_the_imports_ends_without_a_word(module):
    done = run(BEGINNING.format(module=module))
    assert (done.returncode, done.stdout, done.stderr) == (130, "", "")


def test_ctrl_c_between_imports_and_command_ends_without_a_word():
    done = run(BEFORE_THE_COMMAND_LINE_LISTENS)
    assert (done.returncode, done.stdout, done.stderr) == (130, "", "")


def test_ctrl_c_while_libraries_unload_ends_without_a_word():
    done = run(ENDING)
    assert (done.returncode, done.stderr) == (130, "")
    assert done.stdout.startswith("adibas ")


@pytest.mark.parametrize("script", [BEGINNING.format(module="tqdm"), ENDING])
def test_a_program_that_was_told_to_ignore_ctrl_c_ignores_it(script):
    done = run(IGNORED + script)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.startswith("adibas ")
