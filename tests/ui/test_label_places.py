"""Names as they are painted: letters and lines leave all rings as they are."""

import numpy as np
import pytest
from PySide6.QtGui import QColor, QImage, QPainter

from ui.widgets.image_geometry import ImagePlacement
from ui.widgets.overlay_painter import HALF_PEN_PX, LEAST_RADIUS_PX, paint_overlays
from ui.widgets.overlays import Dot

SIZE = 400, 300
GROUND = QColor("#7F7F7F")
SEED = 3


def painted(overlays, letter_px):
    """Return the picture's pixels after overlays were painted, and where those reach."""
    image = QImage(*SIZE, QImage.Format.Format_RGB32)
    image.fill(GROUND)
    painter = QPainter(image)
    font = painter.font()
    font.setPixelSize(letter_px)
    painter.setFont(font)
    reach = paint_overlays(painter, ImagePlacement(SIZE, SIZE).fitted(), overlays)
    painter.end()
    return np.array(image.constBits()).reshape(SIZE[1], SIZE[0], 4), reach


def discs(dots, radius):
    """Return which pixels lie within circles about dots."""
    rows, columns = np.indices((SIZE[1], SIZE[0]))
    return np.any([np.hypot(columns - dot.u, rows - dot.v) < radius for dot in dots], axis=0)


@pytest.mark.parametrize("letter_px", [13, 26])
def test_names_and_values_leave_every_ring_as_it_is_without_them(letter_px):
    rng = np.random.default_rng(SEED)
    for _ in range(20):
        places = rng.uniform((100, 50), (300, 250), (10, 2))
        named = [Dot(u, v, 3.0, f"marker {i}") for i, (u, v) in enumerate(places[:7])]
        nameless = [Dot(u, v, 3.0, role="rejected") for u, v in places[7:]]
        bare = [Dot(dot.u, dot.v, 3.0) for dot in named]
        with_names, reach = painted((*nameless, *named), letter_px)
        without, _reach = painted((*nameless, *bare), letter_px)
        differs = (with_names != without).any(axis=2)
        assert differs.any()
        assert not differs[discs(nameless, LEAST_RADIUS_PX + HALF_PEN_PX)].any()
        assert not differs[discs(named, LEAST_RADIUS_PX)].any()  # its line begins at its edge
        rows, columns = np.nonzero(differs)
        assert columns.min() >= reach.left()
        assert columns.max() <= reach.right()
        assert rows.min() >= reach.top()
        assert rows.max() <= reach.bottom()


def test_the_earlier_ring_of_a_marker_does_not_drive_its_name_away():
    earlier = Dot(197.0, 151.0, 3.0, role="earlier", key="left_patella")
    later = Dot(200.0, 150.0, 3.0, "Patella, left", "later", key="left_patella")
    bare = Dot(200.0, 150.0, 3.0, role="later")
    names = [
        painted((*rings, later), 13)[0] != painted((*rings, bare), 13)[0]
        for rings in ((), (earlier,))
    ]
    assert names[0].any()
    np.testing.assert_array_equal(*names)
