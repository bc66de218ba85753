"""Starting is light: what a command does not need is not imported. And nothing in a circle."""

import ast
import subprocess
import sys
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

PROJECT = Path(__file__).parents[2]
HEAVY = {
    "cv2",
    "numba",
    "scipy",
    "openpyxl",
    "PySide6",
    "pyqtgraph",
    "mcap",
    "openni",
    "PIL",
    "ezc3d",
    "hmmlearn",
    "sklearn",
    "fhir",
    "highdicom",
    "pydicom",
    "pynetdicom",
}


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


def imported(path, modules):
    """Yield the modules of `adibas` and `ui` that a file imports, also for its types alone."""
    for node in ast.walk(ast.parse(path.read_text("utf-8"))):
        if isinstance(node, ast.Import):
            yield from modules & {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            names = {f"{node.module}.{alias.name}" for alias in node.names}
            yield from modules & names or modules & {node.module}


def test_no_modules_import_one_another():
    paths = {}
    for path in (*(PROJECT / "adibas").rglob("*.py"), *(PROJECT / "ui").rglob("*.py")):
        name = ".".join(path.relative_to(PROJECT).with_suffix("").parts)
        paths[name.removesuffix(".__init__")] = path
    graph = {name: set(imported(path, paths.keys())) for name, path in paths.items()}
    assert len(tuple(TopologicalSorter(graph).static_order())) == len(paths) > 100
