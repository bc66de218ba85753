"""LED markers: bright blobs in an infrared-filtered, dark image.

Source: thesis, section 6.1.1.2.
"""

import math
from dataclasses import dataclass, field
from typing import TypeVar

import cv2
import numpy as np
from numpy.typing import NDArray

from adibas.arrays import BoolArray, Float32Array, FloatArray, UInt8Array, check_shape
from adibas.data.markers import RejectedBlob
from adibas.markers.blobs import (
    Blob,
    BlobParams,
    Groups,
    chosen_groups,
    connected_groups,
    judge,
    measure_blobs,
)
from adibas.markers.detection import Detections, bounding_box

Number = TypeVar("Number", np.float32, np.bool_)

LEVEL_STEP = 0.85
"""From one level of peaks to the next: a blob's rim is at most that much too high."""


@dataclass(frozen=True, slots=True)
class LedParams:
    """How LEDs are found.

    Attributes
    ----------
    least_brightness : float
        Of an LED's brightest pixel over what is about it and over the body's median, grey levels
        of 255: 60.
    rim_share : float
        Of the LED's own brightest pixel; what is brighter belongs to it: 0.35.
    greatest_share : float
        Of the body, that may lie in bright pieces larger than any marker: 0.05. Where more does,
        the image is no dark one.
    surround_factor : float
        What is larger than this many times the greatest marker is background, and no piece of one:
        1.5.
    blobs : BlobParams
        Size and shape; bloom makes LEDs look larger than they are.
    """

    least_brightness: float = 60.0
    rim_share: float = 0.35
    greatest_share: float = 0.05
    surround_factor: float = 1.5
    blobs: BlobParams = field(default_factory=BlobParams)


def find_led_markers(
    color_rgb: UInt8Array,
    body: BoolArray,
    depth_m: Float32Array,
    focal_px: float,
    params: LedParams,
) -> Detections:
    """Find the bright blobs on the body.

    Parameters
    ----------
    color_rgb : (H, W, 3) array
        The dark image.
    body : (H, W) bool array
        The person in it.
    depth_m : (H, W) array
        Depth registered to it, NaN = unknown: for the size of things.
    focal_px : float
        Of the colour camera.
    """
    check_shape("body", body, color_rgb.shape[:2])
    window = bounding_box(body)
    if window is None:
        return Detections((), (), 0.0)
    inside = body[window]
    brightness = color_rgb[window].max(axis=2).astype(np.float32)
    dark = float(np.median(brightness[inside]))
    brightest = float(brightness[inside].max())
    if brightest - dark < params.least_brightness:
        return Detections((), (), 0.0)
    size_px = _surround_px(depth_m[window], focal_px, params)
    is_bright = inside & (brightness > dark + params.rim_share * (brightest - dark))
    matched = _large_pieces_px(is_bright, size_px) / float(np.count_nonzero(inside))
    if matched > params.greatest_share:
        return Detections((), (), matched)
    # A saturated LED is a plateau: the blur makes its middle the brightest place again.
    smooth = cv2.GaussianBlur(brightness, (0, 0), 1.0).astype(np.float32)
    background = _background(np.where(inside, smooth, np.float32(dark)), size_px)
    background = np.maximum(background, np.float32(dark))
    excess = np.where(inside, brightness - background, np.float32(0.0))
    # The inverse of the light, so that a dim LED stands out as a bright one does; squared, since
    # the glow about a saturated one has half of its light.
    distance = 1.0 / (1.0 + np.maximum(smooth - background, 0.0)) ** 2
    groups = _groups(excess, params)
    offset_uv = np.array([window[1].start, window[0].start], float)
    judged = [
        judge(blob, offset_uv, depth_m, focal_px, params.blobs)
        for blob in measure_blobs(smooth[..., None], distance, groups)
    ]
    return Detections(
        tuple(found for found in judged if isinstance(found, Blob)),
        tuple(found for found in judged if isinstance(found, RejectedBlob)),
        matched,
    )


def _surround_px(depth_m: Float32Array, focal_px: float, params: LedParams) -> int:
    """Return the odd width of what no marker fills, where most of the picture's things are."""
    known_m = depth_m[np.isfinite(depth_m)]
    distance_m = float(np.median(known_m)) if len(known_m) else params.blobs.unknown_distance_m
    width_m = params.surround_factor * params.blobs.greatest_diameter_m
    return round(width_m * focal_px / distance_m) | 1


def _large_pieces_px(is_bright: BoolArray, size_px: int) -> int:
    """Return how many pixels lie in pieces with more of them than a disc of that width.

    The glow about LEDs has its own width in pixels, and far away much of the body is glow.
    """
    _, pieces = cv2.connectedComponents(is_bright.view(np.uint8), None, 8, cv2.CV_32S)
    areas_px = np.bincount(pieces[is_bright])
    return int(areas_px[areas_px > math.pi / 4.0 * size_px**2].sum())


def _background(brightness: Float32Array, size_px: int) -> Float32Array:
    """Return the brightness without all that is narrower than a square of `size_px`."""
    square = np.ones((size_px, size_px), np.uint8)
    return np.asarray(cv2.morphologyEx(brightness, cv2.MORPH_OPEN, square), np.float32)


def _groups(excess: Float32Array, params: LedParams) -> Groups:
    """Return the pixels of every blob: what is brighter than the rim's share of its own peak.

    From the brightest peaks to the least that count. A blob that would hang together with a
    brighter one ends above the place where they meet.
    """
    taken = np.zeros(excess.shape, np.bool_)
    found: list[Groups] = []
    waiting: Groups = connected_groups(taken, taken)
    for peak in _levels(float(excess.max()), params.least_brightness):
        groups = connected_groups(excess > params.rim_share * peak, taken)
        is_free = np.zeros(excess.shape, np.bool_)
        is_free[groups[:2]] = True
        merged = chosen_groups(waiting, ~_greatest(is_free, waiting))
        peaks = _greatest(excess, groups)
        is_bright = peaks >= max(LEVEL_STEP * peak, params.least_brightness)
        bright = chosen_groups(groups, is_bright)
        taken[bright[:2]] = taken[merged[:2]] = True
        found += [bright, merged]
        waiting = chosen_groups(groups, ~is_bright & (peaks >= params.least_brightness))
    return _joined(found)


def _levels(brightest: float, least: float) -> FloatArray:
    """Return the peaks to look for, each a step below the one before; the last is the least."""
    n_steps = math.ceil(math.log(max(brightest / least, 1.0)) / -math.log(LEVEL_STEP))
    return np.geomspace(max(brightest, least), least, n_steps + 1)


def _greatest(values: NDArray[Number], groups: Groups) -> NDArray[Number]:
    """Return the greatest value in each group."""
    rows, columns, starts = groups
    return np.maximum.reduceat(values[rows, columns], starts[:-1]) if len(rows) else values[0, :0]


def _joined(parts: list[Groups]) -> Groups:
    rows, columns = (np.concatenate([part[axis] for part in parts]) for axis in (0, 1))
    sizes = np.concatenate([np.diff(part[2]) for part in parts])
    return rows, columns, np.append(0, np.cumsum(sizes))
