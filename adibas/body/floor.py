"""The floor in a depth image, where one is seen."""

from dataclasses import dataclass

import numpy as np

from adibas.arrays import BoolArray, Float32Array, FloatArray
from adibas.body.grid_kernels import grid_normals
from adibas.body.rays import viewing_rays
from adibas.data.calibration import CameraCalibration
from adibas.geometry.planes import Plane

MIN_POINTS = 60
MAX_WITNESSES = 1000
BELOW = 12.0
"""A point is under the floor by so many times its half thickness."""
N_PROPOSALS = 150
REFINEMENTS = (3.0, 2.0, 1.5, 1.0, 1.0)
"""Thickness of the floor in each round of the fit, in units of the last."""


@dataclass(frozen=True, slots=True)
class FloorParams:
    """Settings of the search for the floor.

    Attributes
    ----------
    grid_px : int
        Only every n-th row and column is looked at. 6: a floor has thousands of pixels.
    max_tilt_rad : float
        Between the floor's normal and up. 40 degrees: the most that a tripod is tilted while a
        standing person is in view.
    band_per_m : float
        Half thickness of the floor at one metre, metres; it grows with the square of the depth.
        0.002: three standard deviations of structured-light noise (1.4 mm at 1 m, Khoshelham &
        Elberink 2012) at the usual slant of 30 degrees.
    max_unevenness_rad : float
        Between the normal measured at one place and that of the floor, 25 degrees: the noise of a
        normal at 3 m.
    min_share : float
        Of the measured pixels that the floor must hold. 0.02.
    max_below_share : float
        Of the measured pixels that may lie under the floor. 0.01: reflections.
    """

    grid_px: int = 6
    max_tilt_rad: float = 0.7
    band_per_m: float = 0.002
    max_unevenness_rad: float = 0.44
    min_share: float = 0.02
    max_below_share: float = 0.01


def find_floor(
    depth_m: Float32Array,
    depth_camera: CameraCalibration,
    up: FloatArray | None = None,
    params: FloorParams | None = None,
) -> Plane | None:
    """Return the floor, or None where none is seen.

    Each point of a coarse grid proposes the plane through itself with its local normal; the lowest
    one with many points is refined by least squares of the inverse depth.

    Parameters
    ----------
    depth_m : (H, W) float32 array
        Along the depth camera's z, metres; NaN where not measured.
    depth_camera : CameraCalibration
        Of the camera that took `depth_m`.
    up : (3,) array or None
        Unit vector in the depth camera's axes; (0, -1, 0) where not known.

    Returns
    -------
    floor : Plane or None
        Normal up, in the depth camera's axes.
    """
    params = params or FloorParams()
    up = np.array([0.0, -1.0, 0.0]) if up is None else np.asarray(up, float)
    points_m, normals = level_grid(depth_m, depth_camera, params.grid_px)
    measured_m = points_m[np.isfinite(points_m[..., 2])]
    with np.errstate(invalid="ignore"):
        level = normals @ up > np.cos(params.max_tilt_rad)
    if level.sum() < MIN_POINTS:
        return None
    plane = _best_proposal(points_m[level], normals[level], measured_m, params)
    for widening in REFINEMENTS:
        if plane is None:
            return None
        with np.errstate(invalid="ignore"):
            level = normals @ plane.normal > np.cos(params.max_unevenness_rad)
        plane = _refined(points_m[level], plane, widening, params)
    if plane is None or plane.tilt_rad(up) > params.max_tilt_rad:  # drawn onto a wall
        return None
    return plane if _is_floor(plane, measured_m, params) else None


def level_grid(
    depth_m: Float32Array, camera: CameraCalibration, step: int
) -> tuple[FloatArray, FloatArray]:
    """Return (h, w, 3) points and unit normals that point to the camera; NaN where unknown."""
    z_m = np.asarray(depth_m[::step, ::step], float)
    points_m = viewing_rays(camera)[::step, ::step] * z_m[..., None]
    return points_m, grid_normals(points_m)


def _band_m(points_m: FloatArray, params: FloorParams) -> FloatArray:
    band: FloatArray = params.band_per_m * np.maximum(points_m[:, 2], 1.0) ** 2
    return band


def _best_proposal(
    points_m: FloatArray, normals: FloatArray, measured_m: FloatArray, params: FloorParams
) -> Plane | None:
    """Return the plane of one point that the most others share, with nothing under it."""
    chosen = np.linspace(0, len(points_m) - 1, N_PROPOSALS).astype(int)
    offsets_m = -(normals[chosen] * points_m[chosen]).sum(axis=1)
    distances_m = points_m @ normals[chosen].T + offsets_m
    counts = (np.abs(distances_m) < REFINEMENTS[0] * _band_m(points_m, params)[:, None]).sum(axis=0)
    witnesses_m = measured_m[:: max(1, len(measured_m) // MAX_WITNESSES)]
    heights_m = witnesses_m @ normals[chosen].T + offsets_m
    is_below = heights_m < -BELOW * _band_m(witnesses_m, params)[:, None]
    counts[is_below.mean(axis=0) > params.max_below_share] = 0
    best = int(counts.argmax())
    if counts[best] < MIN_POINTS:
        return None
    return Plane(normals[chosen[best]], float(offsets_m[best]))


def _refined(
    points_m: FloatArray, plane: Plane, widening: float, params: FloorParams
) -> Plane | None:
    """Fit 1/z, where the noise is constant and a plane is linear, to the points near `plane`."""
    band_m = widening * _band_m(points_m, params)
    inside: BoolArray = np.abs(plane.signed_distance_m(points_m)) < band_m
    if inside.sum() < MIN_POINTS:
        return None
    z_m = points_m[inside, 2:]
    inverse_normal = np.linalg.lstsq(points_m[inside] / z_m, 1.0 / z_m[:, 0])[0].astype(float)
    length = float(np.linalg.norm(inverse_normal))
    return Plane(-inverse_normal / length, 1.0 / length)


def _is_floor(plane: Plane, measured_m: FloatArray, params: FloorParams) -> bool:
    heights_m = plane.signed_distance_m(measured_m)
    band_m = _band_m(measured_m, params)
    is_on = np.abs(heights_m) < 2.0 * band_m
    is_below = heights_m < -BELOW * band_m
    return bool(is_on.mean() > params.min_share and is_below.mean() < params.max_below_share)
