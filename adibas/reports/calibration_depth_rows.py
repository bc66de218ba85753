"""The numbers of the depth camera in a calibration's report, the same for every format."""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from adibas.arrays import FloatArray
from adibas.data.calibration_report import DepthReport
from adibas.geometry.rigid import rotation_vector
from adibas.reports.calibration_rows import MM_PER_M, SURE, known
from adibas.texts import translate as _

CURVE_M = tuple(round(0.5 + 0.25 * step, 2) for step in range(15))
"""From where structured light begins to measure to the far end of the working volume."""


@dataclass(frozen=True, slots=True)
class DepthParameterRow:
    """One parameter with its 95 % interval; None where it was not estimated."""

    name: str
    unit: str
    value: float
    low: float | None
    high: float | None


@dataclass(frozen=True, slots=True)
class BiasRow:
    """What is added to a measured depth in the image's middle, and the 95 % interval of that."""

    measured_m: float
    added_mm: float
    low_mm: float | None
    high_mm: float | None


@dataclass(frozen=True, slots=True)
class ShotRow:
    """One board or wall, after the correction; None where nothing is known."""

    name: str
    kind: str
    minutes: float
    distance_m: float
    error_mm: float | None
    noise_mm: float | None
    rms_mm: float | None
    is_outlier: bool


def depth_parameter_rows(depth: DepthReport) -> Iterator[DepthParameterRow]:
    """Yield the pose of the depth camera, its focal lengths and middle, and its own error."""
    turn_deg = np.degrees(rotation_vector(depth.color_from_depth.rotation))
    shift_mm = MM_PER_M * depth.color_from_depth.translation_m
    for axis, value in zip("xyz", turn_deg.tolist(), strict=True):
        name = f"color_from_depth.r{axis}"
        yield _row(depth, name, _("deg"), value, math.degrees(1.0))
    for axis, value in zip("xyz", shift_mm.tolist(), strict=True):
        yield _row(depth, f"color_from_depth.t{axis}", "mm", value, MM_PER_M)
    k = depth.camera.intrinsics
    for name, value in (("fx", k.fx), ("fy", k.fy), ("cx", k.cx), ("cy", k.cy)):
        yield _row(depth, f"depth.{name}", "px", value, 1.0)
    yield _row(depth, "depth_bias.a", "mm", MM_PER_M * depth.bias.a, MM_PER_M)
    yield _row(depth, "depth_bias.b", "", depth.bias.b, 1.0)
    yield _row(depth, "depth_bias.c", "1/m", depth.bias.c, 1.0)
    for number, value in enumerate(depth.bias.image_term):
        yield _row(depth, f"depth_bias.image_term.{number}", "1/m", value, 1.0)


def bias_rows(depth: DepthReport) -> Iterator[BiasRow]:
    """Yield the correction over the working volume, from near to far."""
    slopes = np.array([[1.0, z, z * z] for z in CURVE_M])
    added_m = slopes @ np.array([depth.bias.a, depth.bias.b - 1.0, depth.bias.c])
    half_m = SURE * np.sqrt(np.einsum("ni,ij,nj->n", slopes, _curve_covariance(depth), slopes))
    is_known = "depth_bias.a" in depth.parameter_names
    for measured_m, added, half in zip(CURVE_M, added_m.tolist(), half_m.tolist(), strict=True):
        yield BiasRow(
            measured_m,
            MM_PER_M * added,
            MM_PER_M * (added - half) if is_known else None,
            MM_PER_M * (added + half) if is_known else None,
        )


def shot_rows(depth: DepthReport) -> Iterator[ShotRow]:
    """Yield boards and walls in the order in which they were taken."""
    begun_s = min((shot.time_s for shot in depth.shots), default=0.0)
    for shot in depth.shots:
        yield ShotRow(
            name=shot.name,
            kind=_("wall") if shot.is_wall else _("board"),
            minutes=(shot.time_s - begun_s) / 60.0,
            distance_m=shot.distance_m,
            error_mm=known(MM_PER_M * shot.error_m),
            noise_mm=known(MM_PER_M * shot.sigma_m),
            rms_mm=known(MM_PER_M * shot.rms_m),
            is_outlier=shot.is_outlier,
        )


def rms_of_shots_mm(depth: DepthReport) -> float | None:
    """Return the error that is left of the boards' mean depth, over those that took part."""
    errors = [
        row.error_mm for row in shot_rows(depth) if row.error_mm is not None and not row.is_outlier
    ]
    return float(np.sqrt(np.mean(np.square(errors)))) if errors else None


def _row(
    depth: DepthReport, name: str, unit: str, value: float, factor: float
) -> DepthParameterRow:
    half = factor * SURE * depth.sd(name)
    return DepthParameterRow(name, unit, value, known(value - half), known(value + half))


def _curve_covariance(depth: DepthReport) -> FloatArray:
    """Return the (3, 3) covariance of a, b and c; 0 for those that were not estimated."""
    names = [f"depth_bias.{name}" for name in "abc"]
    found = [depth.parameter_names.index(n) if n in depth.parameter_names else -1 for n in names]
    padded = np.pad(depth.covariance, (0, 1))  # the last, -1, is of nothing
    return np.asarray(padded[np.ix_(found, found)])
