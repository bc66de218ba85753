"""What a new calibration of a sensor changes against the one before."""

import math
import warnings
from dataclasses import dataclass

import numpy as np

from adibas.arrays import FloatArray
from adibas.calibration.depth_bias import depth_sd_m
from adibas.data.calibration import CameraCalibration, RgbdCalibration
from adibas.geometry.distortion import FoldWarning, undistort_pixels
from adibas.geometry.rigid import rotation_vector

GRID = 9
DISTANCE_M = 2.0
"""Where the patient stands."""

LENGTH_M = 0.5
"""A thigh, a trunk: what is measured."""

DEPTHS_M = (1.0, 2.0, 3.0)
"""Of the working volume."""


@dataclass(frozen=True, slots=True)
class ParameterChange:
    """One parameter, before and now.

    Attributes
    ----------
    name : str
        As in `RgbdCalibration.parameter_names`.
    before, now : float
        In the parameter's own unit.
    sigma : float
        Standard deviation of their difference by both calibrations' own account; NaN where one
        does not say.
    """

    name: str
    before: float
    now: float
    sigma: float


@dataclass(frozen=True, slots=True)
class DepthChange:
    """What both calibrations make of one reading of the depth, in the image's middle.

    Attributes
    ----------
    measured_m : float
        The reading.
    before_m, now_m : float
        Corrected.
    sigma_m : float
        Standard deviation of their difference by both calibrations' own account; NaN where one
        does not say.
    """

    measured_m: float
    before_m: float
    now_m: float
    sigma_m: float


@dataclass(frozen=True, slots=True)
class Comparison:
    """Two calibrations of one sensor.

    Attributes
    ----------
    parameters : tuple of ParameterChange
        Of the colour camera.
    largest_change_m : float
        By how much a length of half a metre at two metres changes where it changes most.
    depths : tuple of DepthChange
        At `DEPTHS_M`; none where one of them has no depth camera of this size.
    turn_rad, shift_m : float
        By which the depth camera's pose changed; NaN likewise.
    """

    parameters: tuple[ParameterChange, ...]
    largest_change_m: float
    depths: tuple[DepthChange, ...] = ()
    turn_rad: float = math.nan
    shift_m: float = math.nan


def compare(before: RgbdCalibration, now: RgbdCalibration) -> Comparison | None:
    """Return what changed; None where the images have another size or there is no colour camera."""
    if before.color is None or now.color is None:
        return None
    if (before.color.width, before.color.height) != (now.color.width, now.color.height):
        return None
    depths = tuple(_depth_changes(before, now))
    turn_rad = shift_m = math.nan
    if depths:
        old, new = before.color_from_depth, now.color_from_depth
        turn_rad = float(np.linalg.norm(rotation_vector(new.rotation @ old.rotation.T)))
        shift_m = float(np.linalg.norm(new.translation_m - old.translation_m))
    return Comparison(
        parameters=tuple(_changes(before, now)),
        largest_change_m=_largest_change_m(before.color, now.color),
        depths=depths,
        turn_rad=turn_rad,
        shift_m=shift_m,
    )


def _depth_changes(before: RgbdCalibration, now: RgbdCalibration) -> list[DepthChange]:
    if before.depth is None or now.depth is None:
        return []
    if (before.depth.width, before.depth.height) != (now.depth.width, now.depth.height):
        return []
    measured_m = np.array(DEPTHS_M)
    old_m, new_m = (
        one.depth_bias.a + measured_m * (one.depth_bias.b + one.depth_bias.c * measured_m)
        for one in (before, now)
    )
    sigmas_m = np.hypot(_depth_sigmas_m(before), _depth_sigmas_m(now))
    columns = (DEPTHS_M, old_m.tolist(), new_m.tolist(), sigmas_m.tolist())
    return [DepthChange(*row) for row in zip(*columns, strict=True)]


def _depth_sigmas_m(calibration: RgbdCalibration) -> FloatArray:
    """Return how sure the correction in the image's middle is at `DEPTHS_M`; NaN where unknown."""
    is_known = calibration.covariance is not None and any(
        name.startswith("depth_bias.") for name in calibration.parameter_names
    )
    if calibration.depth is None or not is_known:
        return np.full(len(DEPTHS_M), math.nan)
    k = calibration.depth.intrinsics
    middle = np.tile([k.cx, k.cy], (len(DEPTHS_M), 1))
    return depth_sd_m(calibration, middle, np.array(DEPTHS_M))


def _changes(before: RgbdCalibration, now: RgbdCalibration) -> list[ParameterChange]:
    if before.color is None or now.color is None:
        return []
    old, new = _values(before.color), _values(now.color)
    return [
        ParameterChange(
            name, old[name], new[name], math.hypot(_sigma(before, name), _sigma(now, name))
        )
        for name in new
    ]


def _values(camera: CameraCalibration) -> dict[str, float]:
    k = camera.intrinsics
    return {"color.fx": k.fx, "color.fy": k.fy, "color.cx": k.cx, "color.cy": k.cy}


def _sigma(calibration: RgbdCalibration, name: str) -> float:
    if calibration.covariance is None or name not in calibration.parameter_names:
        return math.nan
    index = calibration.parameter_names.index(name)
    return math.sqrt(calibration.covariance[index, index])


def _largest_change_m(before: CameraCalibration, now: CameraCalibration) -> float:
    """Measure what the same pixels give with both cameras, at the same depth."""
    columns = np.linspace(0, before.width - 1, GRID)
    rows = np.linspace(0, before.height - 1, GRID)
    pixels = np.stack(np.meshgrid(columns, rows), axis=-1).reshape(-1, 2)
    old, new = _at_distance_m(pixels, before), _at_distance_m(pixels, now)
    starts, ends = np.triu_indices(len(pixels), 1)
    old_m = np.linalg.norm(old[ends] - old[starts], axis=-1)
    new_m = np.linalg.norm(new[ends] - new[starts], axis=-1)
    is_such_a_length = (old_m > LENGTH_M / 2) & (old_m < 2 * LENGTH_M) & ~np.isnan(new_m)
    found = np.abs(new_m[is_such_a_length] / old_m[is_such_a_length] - 1.0) * LENGTH_M
    return float(found.max()) if found.size else math.nan


def _at_distance_m(pixels: FloatArray, camera: CameraCalibration) -> FloatArray:
    """Return the (N, 2) points in the plane at `DISTANCE_M`; NaN beyond the lens model's fold."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", FoldWarning)  # NaN is the answer there
        rays = undistort_pixels(pixels, camera.intrinsics, camera.distortion)
    return rays * DISTANCE_M
