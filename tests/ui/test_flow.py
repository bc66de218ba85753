"""Controls in a flow: side by side where there is room, else in rows; hidden ones take none."""

import pytest
from PySide6.QtCore import QRect, QSize
from PySide6.QtWidgets import QVBoxLayout, QWidget

from ui.widgets.flow import FlowLayout, in_a_flow

WIDTHS = (100, 60, 80)
HEIGHT = 20
GAP = 8


class Block(QWidget):
    """A control of a fixed size."""

    def __init__(self, width, parent):
        super().__init__(parent)
        self.setFixedSize(QSize(width, HEIGHT))


@pytest.fixture
def panel(qtbot):
    """A panel with three blocks in a flow; the panel, the blocks, the flow."""
    panel = QWidget()
    qtbot.addWidget(panel)
    blocks = [Block(width, panel) for width in WIDTHS]
    flow = in_a_flow(*blocks)
    column = QVBoxLayout(panel)
    column.setContentsMargins(0, 0, 0, 0)
    column.addLayout(flow)
    column.addStretch(1)
    return panel, blocks, flow


def corners(blocks):
    return [(block.x(), block.y()) for block in blocks]


@pytest.mark.parametrize(
    ("width", "expected"),
    [
        (256, [(0, 0), (108, 0), (176, 0)]),
        (255, [(0, 0), (108, 0), (0, 28)]),
        (150, [(0, 0), (0, 28), (68, 28)]),
        (101, [(0, 0), (0, 28), (0, 56)]),
    ],
)
def test_what_has_no_room_goes_into_the_next_row(panel, width, expected):
    widget, blocks, flow = panel
    widget.resize(width, 200)
    widget.show()
    assert corners(blocks) == expected
    assert flow.heightForWidth(width) == expected[-1][1] + HEIGHT


@pytest.mark.parametrize(
    ("width", "expected"),
    [(300, [(44, 0), (152, 0), (220, 0)]), (200, [(32, 0), (140, 0), (120, 28)])],
)
def test_rows_that_end_at_the_right_begin_where_they_must(qtbot, width, expected):
    widget = QWidget()
    qtbot.addWidget(widget)
    blocks = [Block(one, widget) for one in WIDTHS]
    column = QVBoxLayout(widget)
    column.setContentsMargins(0, 0, 0, 0)
    column.addLayout(in_a_flow(*blocks, at_right=True))
    column.addStretch(1)
    widget.resize(width, 200)
    widget.show()
    assert corners(blocks) == expected


def test_it_wants_one_row_and_needs_the_widest_control(panel):
    _widget, _blocks, flow = panel
    assert flow.sizeHint() == QSize(sum(WIDTHS) + 2 * GAP, HEIGHT)
    assert flow.minimumSize() == QSize(100, HEIGHT)


def test_a_hidden_control_takes_no_room(panel):
    widget, blocks, flow = panel
    widget.resize(150, 200)
    widget.show()
    blocks[0].hide()
    flow.setGeometry(QRect(0, 0, 150, 200))
    assert corners(blocks)[1:] == [(0, 0), (68, 0)]
    assert flow.minimumSize() == QSize(80, HEIGHT)
    for block in blocks:
        block.hide()
    assert (flow.heightForWidth(150), flow.sizeHint()) == (0, QSize(0, 0))


def test_controls_can_be_taken_out(panel):
    _widget, _blocks, flow = panel
    assert flow.itemAt(3) is None
    assert flow.takeAt(1).widget() is _blocks[1]
    assert flow.count() == 2
    assert flow.takeAt(5) is None
    assert isinstance(flow, FlowLayout)
