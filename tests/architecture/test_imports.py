"""Starting is light: what a command does not need is not imported."""

import subprocess
import sys

import pytest

HEAVY = {"cv2", "numba", "scipy", "openpyxl", "PySide6", "pyqtgraph", "mcap", "openni", "PIL"}


def modules_after(statement):
    script = f"{statement}\nimport sys\nprint(*{{name.split('.')[0] for name in sys.modules}})"
    run = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    return set(run.stdout.split())


@pytest.mark.parametrize(
    "statement",
    [
        "import adibas",
        "from adibas.cli.command_line import build_parser; build_parser()",
        "import adibas.recordings, adibas.sensors, adibas.reports",
    ],
)
def test_start_up_imports_nothing_heavy(statement):
    assert not modules_after(statement) & HEAVY


def test_the_console_script_needs_no_qt_for_a_command():
    statement = "import ui.main, sys; sys.argv = ['adibas', 'doctor']; ui.main.main()"
    assert "PySide6" not in modules_after(statement)
