"""What is on the screen: regions lie where their pixels do, and nothing stays that was drawn."""

import numpy as np
import pytest
from PySide6.QtGui import QColor, QImage
from PySide6.QtWidgets import QApplication

from ui.theme import DRAWN
from ui.widgets.image_geometry import ImagePlacement
from ui.widgets.image_view import ImageView
from ui.widgets.overlays import Curve, Dot, Line, Region, Text
from ui.widgets.region_image import BORDER_WIDGET_PX, region_image

WIDTH, HEIGHT = 80, 60
SEED = 7


@pytest.fixture
def view(qtbot):
    view = ImageView()
    qtbot.addWidget(view)
    view.resize(320, 400)  # the picture leaves room above and below
    view.show()
    QApplication.processEvents()
    return view


def picture(rng):
    return rng.integers(0, 256, (HEIGHT, WIDTH, 3), dtype=np.uint8)


def drawn_things(rng):
    """Overlays of every kind, some of them beside the picture, of which some are drawn."""
    u, v = rng.uniform(-20, 90, 2)
    things = [
        Dot(u, v, 3.0, "a long name of a marker"),
        Dot(u, v, 3.0),
        Line(u, v, 40.0, 30.0, text="12.3 mm"),
        Line(10.0, v, 70.0, v, "plumb"),
        Line(40.0, -0.5, 39.0, 59.5, "plumb", "+0.1°"),
        Curve(((10.0, 10.0), (u, v), (60.0, 50.0)), text="90°"),
        Text(u, v, "here"),
        Region(rng.random((HEIGHT, WIDTH)) > 0.5, is_filled=True),
    ]
    return tuple(thing for thing in things if rng.random() > 0.7)


def on_screen(view):
    for _ in range(4):  # what was cut off at first is painted two turns later
        QApplication.processEvents()
    shown = view.screen().grabWindow(view.winId()).toImage()
    return shown.convertToFormat(QImage.Format.Format_RGB32)


@pytest.mark.parametrize("rotation_deg", [0, 90])
def test_the_screen_shows_after_each_change_what_is_painted_anew(view, rotation_deg):
    rng = np.random.default_rng(SEED)
    view.set_rotation(rotation_deg)
    for _ in range(60):
        if rng.random() < 0.5:
            view.set_picture(picture(rng))
        view.set_overlays(drawn_things(rng))
        shown = on_screen(view)
        view.update()
        assert shown == on_screen(view)


@pytest.mark.parametrize("rotation_deg", [0, 90, 180, 270])
@pytest.mark.parametrize("widget", [(40, 33), (200, 170), (640, 480)])
@pytest.mark.parametrize("zoom", [1.0, 3.5])
@pytest.mark.parametrize("ratio", [1.0, 2.0])
def test_a_region_lies_over_its_pixels(rotation_deg, widget, zoom, ratio):
    rng = np.random.default_rng(SEED)
    blocks = rng.random((6, 8)) > 0.5
    mask = np.kron(blocks, np.ones((10, 10))) > 0
    placement = ImagePlacement((WIDTH, HEIGHT), widget, rotation_deg).fitted()
    placement = placement.zoomed(zoom, widget[0] / 3, widget[1] / 4)
    found = region_image(Region(mask, "selected", is_filled=True), placement, ratio)
    assert found is not None
    image, place = found
    inside_alpha = 90
    step = 1.5 / placement.scale  # of rounding to pixels of the screen, and of a border
    n_seen = 0
    for x, y in rng.uniform((0, 0), widget, (300, 2)):
        u, v = placement.to_picture(x, y)
        near = [
            (round(u + du * step), round(v + dv * step)) for du in (-1, 0, 1) for dv in (-1, 0, 1)
        ]
        levels = {0 <= a < WIDTH and 0 <= b < HEIGHT and bool(mask[b, a]) for a, b in near}
        if len(levels) > 1:
            continue  # at an edge
        at = ratio * (x - place.x()), ratio * (y - place.y())
        is_in = 0 <= at[0] < image.width() and 0 <= at[1] < image.height()
        alpha = image.pixelColor(int(at[0]), int(at[1])).alpha() if is_in else 0
        assert alpha > 0 if levels.pop() else alpha == 0
        n_seen += alpha in (inside_alpha, 255)
    assert n_seen > 0


def test_a_regions_border_is_as_wide_as_told_and_inside_of_it():
    mask = np.zeros((HEIGHT, WIDTH), dtype=bool)
    mask[20:40, 20:60] = True
    placement = ImagePlacement((WIDTH, HEIGHT), (160, 120)).fitted()
    image, place = region_image(Region(mask), placement, 1.0)
    assert (place.x(), place.y()) == (40.0, 40.0)
    assert (image.width(), image.height()) == (80, 40)
    column = [image.pixelColor(40, y) for y in range(40)]
    border = QColor(DRAWN["outline"])
    assert [color.alpha() for color in column] == (
        [255] * BORDER_WIDGET_PX + [0] * (40 - 2 * BORDER_WIDGET_PX) + [255] * BORDER_WIDGET_PX
    )
    assert column[0] == border


def test_a_region_out_of_sight_has_no_image():
    mask = np.zeros((HEIGHT, WIDTH), dtype=bool)
    placement = ImagePlacement((WIDTH, HEIGHT), (160, 120)).fitted()
    assert region_image(Region(mask), placement, 1.0) is None
    mask[50:58, 70:78] = True
    assert region_image(Region(mask), placement.zoomed(10.0, 0.0, 0.0), 1.0) is None
