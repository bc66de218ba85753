"""Colours in lists and on buttons."""

import pytest
from PySide6.QtCore import QSize
from PySide6.QtGui import QColor, QIcon

from ui.widgets.swatch import swatch, true_icon

pytestmark = pytest.mark.usefixtures("qapp")


def shown(icon, mode):
    return icon.pixmap(QSize(16, 16), mode).toImage()


def test_a_colour_is_the_same_where_its_line_is_chosen():
    icon = true_icon(swatch(QColor("#A2B06B"), 16))
    chosen = shown(icon, QIcon.Mode.Selected)
    assert chosen == shown(icon, QIcon.Mode.Normal)
    assert chosen.pixelColor(8, 8).name() == "#a2b06b"


@pytest.mark.parametrize("color", ["#000000", "#FFFFFF"])
def test_black_and_white_have_a_border_that_is_seen_on_either(color):
    border = swatch(QColor(color), 16).toImage().pixelColor(0, 8)
    assert 60 < border.lightness() < 195
