"""What an axis is stands beside it, all of it, also with large letters."""

import pytest
from PySide6.QtWidgets import QApplication

from adibas.texts import speaking
from adibas.texts import translate as _
from ui.widgets.plot import Plot


class Empty(Plot):
    """Axes around nothing."""

    @property
    def is_drawn(self):
        return True

    def draw(self, plot):
        self.name_axes(plot, "", _("Height over the floor [m]"))


@pytest.mark.usefixtures("large_letters")
@pytest.mark.parametrize("height_px", [240, 320, 700])
def test_a_title_that_is_longer_than_its_axis_goes_on_in_another_line(qtbot, theme, height_px):
    with speaking("es"):
        plot = Empty(theme)
        qtbot.addWidget(plot)
        plot.resize(420, height_px)
        plot.show()
        plot.redraw()
        for _step in range(3):
            QApplication.processEvents()
        axis = plot._widget.getAxis("left")
        title = axis.label.mapRectToScene(axis.label.boundingRect())
    assert axis.label.toPlainText().split() == ["Altura", "sobre", "el", "suelo", "[m]"]
    assert title.top() >= -1
    assert title.bottom() <= plot.height() + 1
    assert title.left() >= -4
    is_long = height_px < 500
    assert ("\n" in axis.label.toPlainText()) == is_long
