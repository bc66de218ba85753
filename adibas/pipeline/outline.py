"""The person in the colour image, also where the depth camera's picture ends.

The colour camera of a PrimeSense sees some 4 degrees more at the top and at the bottom than its
depth camera: there feet and head go on, and so do their markers.
"""

import math

import cv2
import numpy as np

from adibas.alignment.registration import Registration
from adibas.arrays import BoolArray, Float32Array, UInt8Array
from adibas.data.calibration import CameraCalibration

BORDER_PX = 12
"""Depth pixels at the edge of the picture that may be without depth."""
DEFAULT_DISTANCE_M = 2.0
FOOT_M = 0.03
"""By so much a leg or a head grows wider on either side where it is carried on."""
WIDENING = 0.5
"""How fast it does: by so much to either side for each unit of the way."""
HALF_PERCENT = 50
HOLE_RADIUS_M = 0.05
"""A place without depth inside the body, up to a disc of this radius, is taken for the body."""


def body_in_color(
    body: BoolArray, registration: Registration, color: CameraCalibration, margin_m: float
) -> BoolArray:
    """Move a body mask into the colour image.

    Parameters
    ----------
    body : (H, W) bool array
        Of the depth image.
    registration : Registration
        Of that depth image.
    color : CameraCalibration
        Of the colour camera.
    margin_m : float
        By how much the outline is widened.

    Returns
    -------
    outline : (H', W') bool array
        Closed over holes of up to `margin_m` in radius (an LED's, the outline's), and over places
        without depth up to `HOLE_RADIUS_M` that the body surrounds. What is known to lie behind
        the body is left out, but for half that margin, by which outlines of depth are unsure.
        Carried on to the edge of the colour image where the depth camera's picture cuts the body
        off. Its border is smooth: a pixel's noise of depth is not seen in it.
    """
    moved = registration.moved(body).astype(np.uint8)
    depths_m = registration.depth_m[moved > 0]
    depths_m = depths_m[np.isfinite(depths_m)]
    distance_m = float(np.median(depths_m)) if depths_m.size else DEFAULT_DISTANCE_M
    reach = max(2, round(margin_m * color.intrinsics.fx / distance_m))
    _carry_on(moved, body, round(FOOT_M * color.intrinsics.fx / distance_m))
    outline = np.zeros(moved.shape, np.bool_)
    if not moved.any():
        return outline
    window = _window(moved, 2 * reach)
    near = moved[window]
    px_per_m = color.intrinsics.fx / distance_m
    _fill_holes(near, registration.depth_m[window], math.pi * (HOLE_RADIUS_M * px_per_m) ** 2)
    widened = cv2.dilate(cv2.morphologyEx(near, cv2.MORPH_CLOSE, _disc(reach)), _disc(reach))
    other = np.isfinite(registration.depth_m[window]) & (near == 0)
    behind = cv2.erode(other.astype(np.uint8), _disc((reach + 1) // 2))
    outline[window] = _smooth((widened > 0) & (behind == 0), reach)
    return outline


def _smooth(body: BoolArray, radius_px: int) -> BoolArray:
    """Round off what sticks out of the border or into it and is narrower than the radius."""
    side = 2 * radius_px + 1
    percent = body.view(np.uint8) * np.uint8(100)
    share = cv2.blur(percent, (side, side), borderType=cv2.BORDER_REPLICATE)
    smooth: BoolArray = share >= HALF_PERCENT
    return smooth


def _fill_holes(body: UInt8Array, depth_m: Float32Array, greatest_px: float) -> None:
    """Fill, in place, what the body surrounds where nothing was measured."""
    n_groups, labels, stats, _ = cv2.connectedComponentsWithStats(1 - body, connectivity=4)
    height, width = body.shape
    measured = np.bincount(labels[np.isfinite(depth_m)], minlength=n_groups)
    left, top, right, bottom = (
        stats[:, cv2.CC_STAT_LEFT],
        stats[:, cv2.CC_STAT_TOP],
        stats[:, cv2.CC_STAT_LEFT] + stats[:, cv2.CC_STAT_WIDTH],
        stats[:, cv2.CC_STAT_TOP] + stats[:, cv2.CC_STAT_HEIGHT],
    )
    is_inside = (left > 0) & (top > 0) & (right < width) & (bottom < height)
    is_hole = is_inside & (measured == 0) & (stats[:, cv2.CC_STAT_AREA] <= greatest_px)
    is_hole[0] = False  # the body itself
    body[is_hole[labels]] = 1


def _window(image: UInt8Array, margin_px: int) -> tuple[slice, slice]:
    """Return the rows and columns about what is not 0."""
    used = [np.flatnonzero(image.any(axis=axis)) for axis in (1, 0)]
    first, last = ([int(lines[end]) for lines in used] for end in (0, -1))
    return (
        slice(max(first[0] - margin_px, 0), last[0] + margin_px + 1),
        slice(max(first[1] - margin_px, 0), last[1] + margin_px + 1),
    )


def _disc(radius_px: int) -> UInt8Array:
    size = 2 * radius_px + 1
    disc: UInt8Array = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (size, size)).astype(np.uint8)
    return disc


def _carry_on(moved: UInt8Array, body: BoolArray, widening_px: int) -> None:
    """Carry the body on to those edges of the colour image at which the depth image cut it."""
    for turns in range(4):
        if moved.any() and np.rot90(body, turns)[-BORDER_PX:].any():
            _carry_down(np.rot90(moved, turns), widening_px)


def _carry_down(moved: UInt8Array, widening_px: int) -> None:
    """Repeat the lowest stretch of the body down to the last row, a little wider, in place."""
    last_row = int(np.flatnonzero(moved.any(axis=1))[-1])
    lowest = moved[max(last_row - widening_px, 0) : last_row + 1].max(axis=0)
    for row in range(last_row, len(moved)):
        wider = min(round(WIDENING * (row - last_row)), widening_px)
        moved[row] |= cv2.dilate(lowest[None, :], np.ones((1, 2 * wider + 1), np.uint8))[0]
