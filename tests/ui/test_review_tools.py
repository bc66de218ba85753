"""The tools of the review where there is no room for them all."""

import pytest
from PySide6.QtWidgets import QApplication, QToolButton, QVBoxLayout, QWidget

from ui.review.tools import MORE_BUTTON, ReviewTools


@pytest.mark.parametrize("font_scale", [1.0, 2.0])
def test_the_arrow_to_the_tools_that_do_not_fit_is_seen_whole(qtbot, theme, font_scale):
    theme.use("light", font_scale)
    window = QWidget()
    qtbot.addWidget(window)
    column = QVBoxLayout(window)
    tools = ReviewTools(theme, window)
    tools.retranslate()
    column.addWidget(tools)
    window.resize(round(400 * font_scale), 200)
    window.show()
    QApplication.processEvents()
    more = tools.findChild(QToolButton, MORE_BUTTON)
    assert more.isVisible()
    assert more.visibleRegion().boundingRect() == more.rect()
    theme.use("light", 1.0)
