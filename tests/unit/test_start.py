"""What the frozen program does before it begins."""

import os
import subprocess
import sys

import pytest

from installers.start import give_libraries_back

SAYS = [sys.executable, "-c", "import os; print(os.environ.get('LD_LIBRARY_PATH'))"]


@pytest.mark.parametrize(
    ("given", "is_frozen", "expected"),
    [
        ({"LD_LIBRARY_PATH": "/ours"}, True, "None"),
        ({"LD_LIBRARY_PATH": "/ours", "LD_LIBRARY_PATH_ORIG": "/mine"}, True, "/mine"),
        ({"LD_LIBRARY_PATH": "/mine"}, False, "/mine"),
        ({}, True, "None"),
    ],
)
def test_programs_that_it_starts_load_their_own_libraries(monkeypatch, given, is_frozen, expected):
    for name in ("LD_LIBRARY_PATH", "LD_LIBRARY_PATH_ORIG"):
        monkeypatch.delenv(name, raising=False)
    for name, value in given.items():
        monkeypatch.setenv(name, value)
    monkeypatch.setattr(sys, "frozen", is_frozen, raising=False)
    give_libraries_back()
    assert "LD_LIBRARY_PATH_ORIG" not in os.environ
    done = subprocess.run(SAYS, capture_output=True, text=True, check=True)
    assert done.stdout.strip() == expected


PLOT = """
import sys

sys.frozen = True
from installers.start import leave_out_open_gl

leave_out_open_gl()
from PySide6.QtGui import QColor
from PySide6.QtWidgets import QApplication

application = QApplication([])
import pyqtgraph

widget = pyqtgraph.PlotWidget(background="w")
widget.addItem(pyqtgraph.PColorMeshItem())
widget.plot([1, 2, 1], pen=pyqtgraph.mkPen("#ff0000", width=5))
image = widget.grab().toImage()
colors = {image.pixel(x, y) for x in range(image.width()) for y in range(image.height())}
print(QColor("#ff0000").rgb() in colors, hasattr(sys.modules["PySide6.QtOpenGL"], "QOpenGLBuffer"))
"""


def test_plots_are_drawn_without_qts_module_for_opengl():
    environment = {**os.environ, "QT_QPA_PLATFORM": "offscreen"}
    command = [sys.executable, "-c", PLOT]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    assert (done.stdout, done.stderr) == ("True False\n", "")
