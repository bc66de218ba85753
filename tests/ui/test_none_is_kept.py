"""Qt calls that return None give None back: PySide6 6.12.0 dropped a reference with each.

Since Python 3.12 None is immortal and its count stands still, which is right, too.
"""

import sys

from PySide6.QtCore import QObject
from PySide6.QtGui import QImage, QPainter, QPen
from PySide6.QtWidgets import QWidget

N_CALLS = 20_000
N_OTHERS = 500
"""So many references may come and go meanwhile for reasons of their own."""


def test_no_reference_to_none_is_lost(qtbot):
    widget, thing, image = QWidget(), QObject(), QImage(8, 8, QImage.Format.Format_RGB32)
    qtbot.addWidget(widget)
    painter, pen = QPainter(image), QPen()
    calls = (
        lambda: thing.setObjectName("x"),
        lambda: widget.setEnabled(True),
        lambda: painter.setPen(pen),
        lambda: painter.drawPoint(1, 1),
        thing.parent,
    )
    before = sys.getrefcount(None)
    for _round in range(N_CALLS // len(calls)):
        for call in calls:
            call()
    after = sys.getrefcount(None)
    painter.end()
    assert abs(after - before) < N_OTHERS
