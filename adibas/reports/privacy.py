"""Pictures that may leave the clinic: nobody can be recognised, or only the depth is shown."""

from collections.abc import Sequence

import cv2
import numpy as np

from adibas.alignment.registration import register_pixels
from adibas.arrays import BoolArray, Float32Array, UInt8Array
from adibas.body.rays import viewing_rays
from adibas.data.calibration import CameraCalibration, RgbdCalibration
from adibas.data.markers import Marker
from adibas.data.posture import PostureAnalysis
from adibas.errors import ReportError
from adibas.measures.sight_plane import up_without_floor
from adibas.pipeline.posture import PostureParams, Sight, floor_below, see_person
from adibas.reports.head import head_in_color

CELL_M = 0.05
"""Side of the squares that are averaged: a head is then three by five values."""
SHARP_MARGIN_M = 0.03
"""Around the body, that stays as it is."""
LEAST_ON_BODY = 0.7
"""Share of the markers that lie on a body that is whole."""
DEPTH_PERCENTILES = (1.0, 99.0)
"""Of the body's depth, that take the two ends of the colours."""
LIGHT = np.array([0.3, -0.5, -0.81])
"""From the surface, in the depth camera's axes: from the upper left behind the camera."""
DARKEST = 0.3
UNSEEN = 40
"""Grey of what has no depth."""
SURROUND = 0.5
"""Brightness of what is not the body."""


def see_patient(analysis: PostureAnalysis, rotation_deg: int) -> Sight | None:
    """Return where the patient is in the pictures of a capture; None where nobody is seen.

    Parameters
    ----------
    rotation_deg : int
        How far the picture is turned clockwise to be upright.

    Raises
    ------
    ReportError
        No depth was kept with the capture.
    """
    calibration, depth_m = analysis.calibration, _depth_m(analysis)
    _cameras(calibration)
    params = PostureParams(rotation_deg=rotation_deg)
    return see_person(depth_m, floor_below(depth_m, calibration, params), calibration, params)


def blurred(analysis: PostureAnalysis, rotation_deg: int) -> UInt8Array:
    """Return the (H, W, 3) picture in which nobody can be recognised.

    Head and surroundings (bystanders, mirrors, names on a wall) are averaged over squares of
    `CELL_M` and blurred: nothing brings back what was there. The rest of the patient's body stays
    as it is.

    Raises
    ------
    ReportError
        No depth was kept, or no head is found, or some of the markers lie beside the body that is
        found, so that it may not be whole: then there is no such picture.
    """
    sight = see_patient(analysis, rotation_deg)
    up = up_without_floor(analysis.calibration, rotation_deg)
    head = None if sight is None else head_in_color(sight, analysis.calibration, up)
    if sight is None or head is None or not _is_whole(analysis.markers, sight.outline):
        raise ReportError(
            "No head is found in the depth of the capture, so it cannot be hidden. Choose depth "
            "pictures."
        )
    color = _cameras(analysis.calibration)[1]
    is_body = sight.outline & np.isfinite(sight.registration.depth_m)
    px_per_m = color.intrinsics.fx / float(np.median(sight.registration.depth_m[is_body]))
    reach = 2 * round(SHARP_MARGIN_M * px_per_m) + 1
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (reach, reach))
    is_sharp = cv2.dilate(sight.outline.astype(np.uint8), disc).astype(np.bool_) & ~head
    hidden = _unrecognisable(analysis.picture_rgb, max(4, round(CELL_M * px_per_m)))
    return np.where(is_sharp[..., None], analysis.picture_rgb, hidden)


def _is_whole(markers: Sequence[Marker], outline: BoolArray) -> bool:
    """Say whether most markers lie on a body: who bends down may be found in part, or another part.

    `outline` (H, W) is the body in the colour image.
    """
    height, width = outline.shape
    places = [(round(one.v), round(one.u)) for one in markers]
    seen = [(v, u) for v, u in places if 0 <= v < height and 0 <= u < width]
    return sum(bool(outline[place]) for place in seen) >= LEAST_ON_BODY * len(seen)


def _unrecognisable(picture_rgb: UInt8Array, cell_px: int) -> UInt8Array:
    """Average over squares, then blur their borders away."""
    height, width = picture_rgb.shape[:2]
    few = (max(1, width // cell_px), max(1, height // cell_px))
    averaged = cv2.resize(picture_rgb, few, interpolation=cv2.INTER_AREA)
    squares = cv2.resize(averaged, (width, height), interpolation=cv2.INTER_NEAREST)
    soft: UInt8Array = cv2.GaussianBlur(squares, (0, 0), cell_px / 4).astype(np.uint8)
    return soft


def depth_picture(analysis: PostureAnalysis, rotation_deg: int) -> UInt8Array:
    """Return the (H, W, 3) shaded depth as the colour camera sees it, the body in colours.

    Near is yellow and far is blue (Viridis: told apart by colour-blind readers too); surroundings
    are grey.

    Raises
    ------
    ReportError
        No depth was kept with the capture.
    """
    sight = see_patient(analysis, rotation_deg)
    depth_m = _depth_m(analysis)
    registration = (
        register_pixels(depth_m, analysis.calibration) if sight is None else sight.registration
    )
    body = np.isfinite(depth_m) if sight is None else sight.body.pixels
    shaded = _shaded(depth_m, body, _cameras(analysis.calibration)[0])
    flat = np.vstack([shaded.reshape(-1, 3), np.full((1, 3), UNSEEN, np.uint8)])
    return np.ascontiguousarray(flat[registration.source])  # -1 reads the last one


def _shaded(depth_m: Float32Array, body: BoolArray, camera: CameraCalibration) -> UInt8Array:
    """Return the (H, W, 3) colours of a depth image of `camera`."""
    measured = depth_m[body & np.isfinite(depth_m)]
    near_m, far_m = np.percentile(measured, DEPTH_PERCENTILES) if measured.size else (0.5, 4.0)
    with np.errstate(invalid="ignore"):
        share = np.clip((far_m - depth_m) / max(far_m - near_m, 1e-6), 0.0, 1.0)
    levels = np.nan_to_num(255.0 * share).astype(np.uint8)
    colors = cv2.applyColorMap(levels, cv2.COLORMAP_VIRIDIS)[..., ::-1]
    grey = np.float32(SURROUND) * (levels[..., None] / 2 + 96)
    light = _light(depth_m, camera)[..., None]
    picture = np.where(body[..., None], colors, grey) * light
    picture[np.isnan(depth_m)] = UNSEEN
    shaded: UInt8Array = np.clip(picture, 0, 255).astype(np.uint8)
    return shaded


def _light(depth_m: Float32Array, camera: CameraCalibration) -> Float32Array:
    """Return how brightly each pixel's surface is lit, `DARKEST` ... 1."""
    known = np.isfinite(depth_m).astype(np.float32)
    weight = cv2.GaussianBlur(known, (0, 0), 1.5)
    total = cv2.GaussianBlur(np.nan_to_num(depth_m), (0, 0), 1.5)
    smooth_m = total / np.maximum(weight, np.float32(1e-6))
    points_m = viewing_rays(camera) * smooth_m[..., None]
    normals = np.cross(np.gradient(points_m, axis=0), np.gradient(points_m, axis=1))
    lengths = np.maximum(np.linalg.norm(normals, axis=2), 1e-12)
    facing = np.clip((normals @ LIGHT) / lengths, 0.0, 1.0)
    light: Float32Array = (DARKEST + (1 - DARKEST) * facing).astype(np.float32)
    return light


def _depth_m(analysis: PostureAnalysis) -> Float32Array:
    if analysis.surface_per_m is None:
        raise ReportError(
            "No depth was kept with the capture, so there is neither a depth picture nor one with "
            "the face blurred. Choose pictures as they are."
        )
    depth_m: Float32Array = (1.0 / analysis.surface_per_m).astype(np.float32)
    return depth_m


def _cameras(calibration: RgbdCalibration) -> tuple[CameraCalibration, CameraCalibration]:
    if calibration.depth is None or calibration.color is None:
        raise ReportError(
            "The calibration lacks a camera, so there is neither a depth picture nor one with the "
            "face blurred. Choose pictures as they are."
        )
    return calibration.depth, calibration.color
