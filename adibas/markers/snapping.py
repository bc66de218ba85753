"""From a click near a marker to the marker's own centre, in one picture."""

from dataclasses import replace
from typing import NamedTuple

import cv2
import numpy as np

from adibas.arrays import BoolArray, Float32Array, FloatArray, UInt8Array, check_shape
from adibas.markers.blobs import Blob, BlobParams, connected_groups, judge, measure_blobs
from adibas.markers.burst import BurstParams
from adibas.markers.color_model import ColorModel
from adibas.markers.detection import DetectionParams, find_color_markers
from adibas.markers.lab import rgb_to_lab
from adibas.markers.led import LedParams, find_led_markers

SURROUND_PX = 61
"""About the reach of the click: half the largest surround that blobs are compared with."""

SMALL_SURROUNDS_PX = (31, 61)
LEAST_CONTRAST = 12.0
"""CIELAB units, lightness counting half: less is shading, or noise of the picture."""

LIGHTNESS_WEIGHT = 0.5
FREE_BLOBS = BlobParams(least_prominence=0.0)
"""Prominence is nearness to a learned colour, and here is none."""

HAND_SD_PX = 1.0
HAND_RADIUS_PX = 4.0
"""Drawn about a point that was set by hand; about that of a 10 mm sticker at 2 m."""


class Snap(NamedTuple):
    """A place in the picture.

    Attributes
    ----------
    u, v, radius_px : float
        Centre and size, pixels.
    covariance_px2 : (2, 2) array
        Of (u, v).
    is_blob : bool
        False where nothing stood out, so that it is the click itself.
    """

    u: float
    v: float
    radius_px: float
    covariance_px2: FloatArray
    is_blob: bool


def by_hand(u: float, v: float) -> Snap:
    """Return a place as it was clicked, as sure as a hand is: one pixel."""
    return Snap(u, v, HAND_RADIUS_PX, np.eye(2) * HAND_SD_PX**2, is_blob=False)


def snap(
    picture_rgb: UInt8Array,
    click_uv: tuple[float, float],
    reach_px: float,
    target: ColorModel | LedParams | None,
    size: tuple[float | None, float],
) -> Snap:
    """Return the centre of the blob nearest to a click, or the click where there is none.

    Parameters
    ----------
    picture_rgb : (H, W, 3) array
        The whole picture.
    click_uv : (float, float)
        Where it was clicked, pixels.
    reach_px : float
        How far from the click the centre may be.
    target : ColorModel, LedParams or None
        What markers look like; None takes any small blob that stands out.
    size : (distance_m, focal_px)
        Distance of the place, None where unknown, and the camera's focal length: what size a
        marker has there.
    """
    check_shape("picture_rgb", picture_rgb, (None, None, 3))
    window = _window(picture_rgb.shape[:2], click_uv, reach_px + SURROUND_PX)
    if window is None:
        return by_hand(*click_uv)
    found = (
        _free_blobs(picture_rgb, window, size)
        if target is None
        else _target_blobs(picture_rgb, window, target, size)
    )
    click = np.array(click_uv)
    distances_px = [float(np.linalg.norm([blob.u, blob.v] - click)) for blob in found]
    if min(distances_px, default=np.inf) > reach_px:
        return by_hand(*click_uv)
    blob = found[int(np.argmin(distances_px))]
    lasting_px2 = BurstParams().centre_variance_px2(blob.radius_px)
    covariance_px2 = blob.covariance_px2 + np.eye(2) * lasting_px2
    return Snap(blob.u, blob.v, blob.radius_px, covariance_px2, is_blob=True)


def _window(
    shape: tuple[int, ...], click_uv: tuple[float, float], margin_px: float
) -> tuple[slice, slice] | None:
    """Return the rows and columns about a click; None where it is outside the picture."""
    u, v = click_uv
    if not (0 <= round(u) < shape[1] and 0 <= round(v) < shape[0]):
        return None
    rows, columns = (
        slice(max(int(at - margin_px), 0), min(int(at + margin_px) + 2, length))
        for at, length in zip((v, u), shape, strict=False)
    )
    return rows, columns


def _target_blobs(
    picture_rgb: UInt8Array,
    window: tuple[slice, slice],
    target: ColorModel | LedParams,
    size: tuple[float | None, float],
) -> tuple[Blob, ...]:
    """Return what the search in a whole picture would find in the window."""
    inside = np.zeros(picture_rgb.shape[:2], np.bool_)
    inside[window] = True
    distance_m, focal_px = size
    depth_m = _flat(inside.shape, distance_m)
    if isinstance(target, LedParams):
        return find_led_markers(picture_rgb, inside, depth_m, focal_px, target).blobs
    params = DetectionParams()
    return find_color_markers(picture_rgb, inside, depth_m, focal_px, target, params).blobs


def _free_blobs(
    picture_rgb: UInt8Array, window: tuple[slice, slice], size: tuple[float | None, float]
) -> tuple[Blob, ...]:
    """Return every small blob in the window that differs from what is about it."""
    lab = rgb_to_lab(np.ascontiguousarray(picture_rgb[window]))
    distance_m, focal_px = size
    depth_m = _flat(lab.shape[:2], distance_m)
    nothing = np.zeros(2)
    left, top = window[1].start, window[0].start
    found: list[Blob] = []
    for width_px in SMALL_SURROUNDS_PX:
        contrast = _contrast(lab, width_px)
        stands_out: BoolArray = contrast > LEAST_CONTRAST
        groups = connected_groups(stands_out, np.zeros(stands_out.shape, np.bool_))
        # A model of nothing but contrast: the nearest pixels are those that differ most.
        unlike = np.ascontiguousarray(contrast.max() - contrast)
        for blob in measure_blobs(lab, unlike, groups):
            judged = judge(blob, nothing, depth_m, focal_px, FREE_BLOBS)
            if isinstance(judged, Blob):
                found.append(replace(judged, u=judged.u + left, v=judged.v + top))
    return tuple(found)


def _contrast(lab: Float32Array, width_px: int) -> Float32Array:
    """Return the (h, w) difference of every pixel from the mean about it."""
    difference = lab - cv2.blur(lab, (width_px, width_px))
    difference[..., 0] *= LIGHTNESS_WEIGHT
    contrast: Float32Array = np.sqrt((difference**2).sum(axis=2))
    return contrast


def _flat(shape: tuple[int, ...], distance_m: float | None) -> Float32Array:
    return np.full(shape, np.nan if distance_m is None else distance_m, np.float32)
