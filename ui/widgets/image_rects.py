"""Where a fitted picture lies on the screen's pixels, and what of its widget is left beside it."""

from functools import lru_cache

from PySide6.QtCore import QRect

from ui.widgets.image_geometry import ImagePlacement

RIM_PX = 4
"""Beside the picture, for circles and lines that end at its edge."""
N_PLACES_KEPT = 16


def fitted_size(placement: ImagePlacement, ratio: float) -> tuple[int, int]:
    """Return width and height of the picture, not turned, in pixels of the screen."""
    width, height = (max(1, round(ratio * placement.scale * side)) for side in placement.picture)
    return width, height


def covered_rect(placement: ImagePlacement, ratio: float) -> QRect:
    """Return where the whole picture lies in the widget."""
    width, height = fitted_size(placement, ratio)
    if placement.rotation_deg in (90, 270):
        width, height = height, width
    left = (placement.widget[0] - width / ratio) / 2
    top = (placement.widget[1] - height / ratio) / 2
    return QRect(round(left), round(top), int(width / ratio), int(height / ratio))


@lru_cache(maxsize=N_PLACES_KEPT)
def rect_with_rim(placement: ImagePlacement, ratio: float) -> QRect:
    """Return where the whole picture lies, with a rim for what ends at its edge."""
    return covered_rect(placement, ratio).adjusted(-RIM_PX, -RIM_PX, RIM_PX, RIM_PX)


def rects_beside(whole: QRect, covered: QRect) -> tuple[QRect, ...]:
    """Return what is left of `whole` above, below, and at the sides, where anything is."""
    top, bottom = covered.top() - whole.top(), whole.bottom() - covered.bottom()
    left, right = covered.left() - whole.left(), whole.right() - covered.right()
    bands = (
        whole.adjusted(0, 0, 0, -bottom - covered.height()),
        whole.adjusted(0, top + covered.height(), 0, 0),
        whole.adjusted(0, top, -right - covered.width(), -bottom),
        whole.adjusted(left + covered.width(), top, 0, -bottom),
    )
    return tuple(band for band in bands if not band.isEmpty())
