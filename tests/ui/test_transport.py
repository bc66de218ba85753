"""The row under the video."""

import pytest
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QApplication, QSplitter, QVBoxLayout, QWidget

from ui.behaviour.presenter import Position
from ui.behaviour.transport import Transport

HOUR_MS = 3_600_000


@pytest.fixture
def row(qtbot):
    """A row below a video, left of a panel and above a timeline, as on the screen."""
    row, left, video = Transport(), QWidget(), QWidget()
    video.setMinimumHeight(80)
    column = QVBoxLayout(left)
    column.setContentsMargins(0, 0, 0, 0)
    column.addWidget(video, 1)
    column.addWidget(row)
    across, down = QSplitter(), QSplitter(Qt.Orientation.Vertical)
    for part in (left, QWidget()):
        across.addWidget(part)
    timeline = QWidget()
    for part in (across, timeline):
        down.addWidget(part)
    for splitter in (across, down):
        splitter.setChildrenCollapsible(False)
    row.height_changed.connect(across.updateGeometry)
    qtbot.addWidget(down)
    down.resize(420, 500)
    down.setSizes([100, 400])
    down.show()
    yield row
    down.hide()


def test_all_of_it_is_seen_also_when_its_words_become_longer(row):
    row.show_position(Position(0, 99_999, HOUR_MS, 0, 30 * HOUR_MS))
    for _ in range(3):
        QApplication.processEvents()
    assert row.heightForWidth(row.width()) > row.sizeHint().height(), "more than one row"
    assert row.height() >= row.heightForWidth(row.width())
