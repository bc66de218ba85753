"""Regions of a picture as the screen has them: made small first, then drawn without a detour."""

import math
from functools import cache, lru_cache

import cv2
import numpy as np
from PySide6.QtCore import QPointF
from PySide6.QtGui import QColor, QImage

from adibas.arrays import UInt8Array
from ui.theme import DRAWN
from ui.widgets.image_geometry import ImagePlacement
from ui.widgets.overlays import Region, Role

BORDER_WIDGET_PX = 2
TINT_ALPHA = 90
TINTED, BORDERED = 1, 2
N_KEPT = 4

Box = tuple[int, int, int, int]
"""Left, top, right and bottom; the last two are not inside."""


@lru_cache(maxsize=N_KEPT)
def region_image(
    region: Region, placement: ImagePlacement, ratio: float
) -> tuple[QImage, QPointF] | None:
    """Return what of a region is in sight, with its border, and where that lies in the widget.

    None where nothing of it is. What is drawn anew, because the mouse moves or a marker was found,
    is made once.

    Parameters
    ----------
    region : Region
    placement : ImagePlacement
        Of the picture.
    ratio : float
        Of the screen's pixels to Qt's.
    """
    border_px = round(BORDER_WIDGET_PX * ratio)
    scale = placement.scale * ratio
    mask = region.pixels.view(np.uint8)
    left, top, right, bottom = _in_sight(mask, placement, border_px / scale)
    if left >= right or top >= bottom:
        return None
    size = max(1, round((right - left) * scale)), max(1, round((bottom - top) * scale))
    inside = cv2.resize(mask[top:bottom, left:right], size, interpolation=cv2.INTER_NEAREST)
    turned: UInt8Array = np.ascontiguousarray(
        np.rot90(inside, -placement.rotation_deg // 90), np.uint8
    )
    levels = _levels(turned, border_px, is_filled=region.is_filled)
    height, width = levels.shape
    indexed = QImage(levels.data, width, height, width, QImage.Format.Format_Indexed8)
    indexed.setColorTable(_palette(region.role))
    image = indexed.convertToFormat(QImage.Format.Format_ARGB32_Premultiplied)
    image.setDevicePixelRatio(ratio)
    corners = (left - 0.5, top - 0.5), (right - 0.5, bottom - 0.5)
    xs, ys = zip(*(placement.to_widget(*corner) for corner in corners), strict=True)
    return image, QPointF(round(min(xs) * ratio) / ratio, round(min(ys) * ratio) / ratio)


def _in_sight(mask: UInt8Array, placement: ImagePlacement, margin_px: float) -> Box:
    """Return which pixels of the picture are needed: around the region, and not beside the widget.

    With a margin: the border of what is cut off is out of sight.
    """
    left, top, width, height = cv2.boundingRect(mask)
    corners = placement.to_picture(0, 0), placement.to_picture(*placement.widget)
    (low_u, high_u), (low_v, high_v) = (sorted(ends) for ends in zip(*corners, strict=True))
    margin_px += 1.0
    return (
        max(left, math.floor(low_u - margin_px)),
        max(top, math.floor(low_v - margin_px)),
        min(left + width, math.ceil(high_u + margin_px) + 1),
        min(top + height, math.ceil(high_v + margin_px) + 1),
    )


def _levels(inside: UInt8Array, border_px: int, *, is_filled: bool) -> UInt8Array:
    """Return the index of each pixel's colour: 0 outside, `BORDERED`, and `TINTED` within."""
    square = np.ones((2 * border_px + 1, 2 * border_px + 1), np.uint8)
    core = cv2.erode(inside, square, borderType=cv2.BORDER_CONSTANT, borderValue=0)
    of_sums = np.zeros(256, np.uint8)
    of_sums[1:3] = BORDERED, TINTED if is_filled else 0
    levels: UInt8Array = cv2.LUT(cv2.add(inside, core), of_sums).astype(np.uint8, copy=False)
    return levels


@cache
def _palette(role: Role) -> list[int]:
    """Return what 0, `TINTED` and `BORDERED` look like."""
    tint, border = QColor(DRAWN[role]), QColor(DRAWN[role])
    tint.setAlpha(TINT_ALPHA)
    return [0, tint.rgba(), border.rgba()]
