"""Where the head is, out of the shape of the body: no face needs to be seen for that.

A face detector misses profiles and the backs of heads. Here the head is the uppermost part over
the trunk that is wider than a raised arm, and what is covered is larger than the head on purpose:
hair gives no depth.
"""

from dataclasses import dataclass
from itertools import product

import cv2
import numpy as np

from adibas.arrays import BoolArray, FloatArray, UInt8Array
from adibas.body.rays import viewing_rays
from adibas.data.calibration import RgbdCalibration
from adibas.geometry.pinhole import project
from adibas.pipeline.posture import Sight

BEYOND_M = 1.0
"""What is covered above a body that the depth image cuts off: to the edge of any colour image."""


@dataclass(frozen=True, slots=True)
class HeadParams:
    """How much is covered.

    Attributes
    ----------
    share : float
        From the crown down, of the height in view: 0.155. An adult's head has 0.13 of the height,
        that of a child of six years 0.17 (Tilley, The measure of man and woman).
    least_m : float
        But never less, 0.26: enough for a child, and the feet may be out of the picture.
    side_m, above_m : float
        Margin beside the head and above it: 0.06 and 0.12, hair without depth.
    trunk_share : tuple
        Part of the height where the body's middle is looked for: 0.45 to 0.65.
    reach_m : float
        Half the width of the strip over that middle that the head is in: 0.2.
    arm_m : float
        What is narrower is a raised arm: 0.11.
    arm_height_m : float
        A head is wider than an arm over that height: 0.1.
    widest_m : float
        What is wider is the back of someone who bends: 0.4.
    gap_m : float
        Of the height without depth inside the head, at most: 0.06.
    cell_m : float
        Of the grid in which widths are counted: 0.015.
    edge_share : float
        A body that comes nearer to the edge of the depth image than this share of it, 0.03, may
        go on beyond.
    """

    share: float = 0.155
    least_m: float = 0.26
    side_m: float = 0.06
    above_m: float = 0.12
    trunk_share: tuple[float, float] = (0.45, 0.65)
    reach_m: float = 0.2
    arm_m: float = 0.11
    arm_height_m: float = 0.1
    widest_m: float = 0.4
    gap_m: float = 0.06
    cell_m: float = 0.015
    edge_share: float = 0.03


@dataclass(frozen=True, slots=True)
class Head:
    """The block that holds the head, in metres along `_Axes`.

    Attributes
    ----------
    across, height, ahead : tuple
        First and last coordinate; the heights are from the chin to over the crown.
    """

    across: tuple[float, float]
    height: tuple[float, float]
    ahead: tuple[float, float]


def head_in_color(
    sight: Sight, calibration: RgbdCalibration, up: FloatArray, params: HeadParams | None = None
) -> BoolArray | None:
    """Return the pixels of the colour image that may show the head, with a wide margin.

    Parameters
    ----------
    sight : Sight
        Where the person is.
    calibration : RgbdCalibration
        Of both cameras.
    up : (3,) array
        Unit vector in the depth camera's axes; a floor that was seen is trusted more.

    Returns
    -------
    region : (H', W') bool array or None
        None where nothing over the trunk has the shape of a head.
    """
    params = params or HeadParams()
    if calibration.depth is None or calibration.color is None:
        raise ValueError("a head is looked for with the calibration of both cameras")
    axes = _axes(up if sight.floor is None else sight.floor.normal)
    seen = sight.body.pixels & np.isfinite(sight.depth_m)
    rays = viewing_rays(calibration.depth)
    points_m = (rays[seen] * sight.depth_m[seen][:, None]).astype(float) @ axes.T
    bottom_m = None if sight.floor is None else -sight.floor.offset_m
    is_cut = _is_cut(sight.body.pixels, axes[1], params)
    head = _find_head(points_m, bottom_m, params, is_cut=is_cut)
    if head is None:
        return None
    corners_m = np.array(list(product(head.across, head.height, head.ahead))) @ axes
    corners_px = project(
        calibration.color_from_depth.apply(corners_m), calibration.color.intrinsics
    )
    region: UInt8Array = np.zeros(sight.outline.shape, np.uint8)
    cv2.fillConvexPoly(region, cv2.convexHull(np.rint(corners_px).astype(np.int32)), 1)
    return region.astype(np.bool_)


def _axes(up: FloatArray) -> FloatArray:
    """Return the rows across, up and ahead as unit vectors of the depth camera."""
    ahead = np.array([0.0, 0.0, 1.0]) - up[2] * up
    ahead /= np.linalg.norm(ahead)
    return np.stack([np.cross(up, ahead), up, ahead])


def _find_head(
    points_m: FloatArray, bottom_m: float | None, params: HeadParams, *, is_cut: bool
) -> Head | None:
    """Return the head of (N, 3) points (across, up, ahead) of a body.

    Of one that is cut off by the upper edge of the depth image, everything above is the head.
    """
    across_m, heights_m, ahead_m = points_m.T
    low_m = float(heights_m.min()) if bottom_m is None else bottom_m
    span_m = float(heights_m.max()) - low_m
    is_trunk = (heights_m > low_m + params.trunk_share[0] * span_m) & (
        heights_m < low_m + params.trunk_share[1] * span_m
    )
    if not is_trunk.any():
        return None
    middle_m = float(np.median(across_m[is_trunk]))
    crown_m = _crown_m(
        across_m - middle_m, heights_m, low_m + params.trunk_share[1] * span_m, params
    )
    if crown_m is None and is_cut:
        crown_m = float(heights_m.max())
    if crown_m is None:
        return None
    chin_m = crown_m - max(params.share * (crown_m - low_m), params.least_m)
    is_head = (heights_m > chin_m) & (np.abs(across_m - middle_m) < params.reach_m)
    first_m, last_m = np.percentile(across_m[is_head], (0.5, 99.5))
    near_m, far_m = np.percentile(ahead_m[is_head], (1.0, 99.0))
    return Head(
        (first_m - params.side_m, last_m + params.side_m),
        (chin_m, crown_m + (BEYOND_M if is_cut else params.above_m)),
        (near_m, far_m),
    )


def _crown_m(
    offsets_m: FloatArray, heights_m: FloatArray, from_m: float, params: HeadParams
) -> float | None:
    """Return the height of the head's top; None where no head is over the trunk.

    Parameters
    ----------
    offsets_m, heights_m : (N,) array
        Of points of the body: beside its middle, and up.
    from_m : float
        Height of the trunk.
    """
    cell_m = params.cell_m
    above = heights_m > from_m
    rows = ((heights_m[above] - from_m) / cell_m).astype(int)
    columns = np.floor(offsets_m[above] / cell_m).astype(int)
    first = columns.min(initial=0)
    filled = np.zeros((rows.max(initial=0) + 1, columns.max(initial=0) - first + 1), np.uint8)
    filled[rows, columns - first] = 1
    filled = cv2.morphologyEx(filled, cv2.MORPH_CLOSE, np.ones((3, 3), np.uint8))
    reach = round(params.reach_m / cell_m)
    strip = filled[:, max(-first - reach, 0) : max(-first + reach, 0) + 1]
    used = np.flatnonzero(strip.any(axis=1))
    gaps = np.flatnonzero(np.diff(used, prepend=-1) > params.gap_m / cell_m + 1)
    used = used[: gaps[0]] if gaps.size else used
    wide = np.zeros(len(filled), np.bool_)
    wide[used] = [_longest_run(strip[row]) * cell_m > params.arm_m for row in used]
    n_lines = round(params.arm_height_m / cell_m)
    enough = np.convolve(wide, np.ones(n_lines, int))[: len(wide)] == n_lines
    if not enough.any():
        return None
    top = int(np.flatnonzero(enough)[-1])
    is_wide = max(_longest_run(filled[row]) for row in range(top - n_lines + 1, top + 1))
    return None if is_wide * cell_m > params.widest_m else from_m + (top + 1) * cell_m


def _longest_run(line: UInt8Array) -> int:
    """Return the greatest number of neighbouring cells that are filled."""
    ends = np.flatnonzero(np.diff(line, prepend=0, append=0))
    return int((ends[1::2] - ends[::2]).max(initial=0))


def _is_cut(body: BoolArray, up: FloatArray, params: HeadParams) -> bool:
    """Say whether the body may go on beyond the upper edge of the (H, W) depth image."""
    if abs(up[1]) >= abs(up[0]):
        towards_up = body if up[1] < 0 else body[::-1]
    else:
        towards_up = body.T if up[0] < 0 else body.T[::-1]
    n_lines = max(1, round(params.edge_share * len(towards_up)))
    return bool(towards_up[:n_lines].any())
