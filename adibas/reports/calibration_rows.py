"""The numbers of a calibration's report: one place, so that every format shows the same."""

import math
import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from adibas.arrays import FloatArray
from adibas.calibration.comparison import Comparison, ParameterChange, compare
from adibas.calibration.projection_uncertainty import (
    UncertaintyMap,
    distance_uncertainty,
    map_uncertainty,
)
from adibas.calibration.quality import BoardError, board_errors, tilt_directions_rad, tilts_rad
from adibas.data.calibration_report import CalibrationReport, ReportedImage
from adibas.data.camera_fit import CameraFit, ViewFit
from adibas.geometry.distortion import FoldWarning
from adibas.pipeline.calibrating import parameter_intervals

MM_PER_M = 1000.0
SURE = 1.959964
"""Standard deviations to each side of 95 %."""

DISTANCES_M = (1.0, 2.0, 3.0, 4.0)
"""The working volume."""

LENGTH_M = 1.0
MAP_CELLS = (13, 17)
IN_PIXELS = ("fx", "fy", "cx", "cy")


@dataclass(frozen=True, slots=True)
class ParameterRow:
    """One parameter of the colour camera with its 95 % interval; the unit is '' or 'px'.

    `before` is what the calibration before had; None where there is none.
    """

    name: str
    unit: str
    value: float
    low: float
    high: float
    before: float | None


@dataclass(frozen=True, slots=True)
class ImageRow:
    """One image; None where it gave no such number."""

    number: int
    image: ReportedImage
    n_used: int
    rms_px: float | None
    max_px: float | None
    tilt_deg: float | None
    lean_deg: float | None
    """Direction in the image to which the board leans away: 0 right, 90 down."""
    distance_m: float | None
    q_mm: float | None
    is_outlier: bool


@dataclass(frozen=True, slots=True)
class CornerLine:
    """A line of the thesis' table 8.1: pixel, real and computed place, and error."""

    image: str
    u_px: float
    v_px: float
    real_mm: tuple[float, float]
    computed_mm: tuple[float, float]
    error_mm: tuple[float, float]
    off_mm: float
    q_mm: float


@dataclass(frozen=True, slots=True)
class UncertaintyRow:
    """What the calibration makes uncertain at one distance, as halves of 95 % intervals.

    `median_px`, `worst_px` and `worst_mm` are over the image; `length_mm` is that of a length of
    `LENGTH_M` across the axis. None where the lens model gives no direction.
    """

    distance_m: float
    median_px: float | None
    worst_px: float | None
    worst_mm: float | None
    length_mm: float | None


def parameter_rows(report: CalibrationReport) -> Iterator[ParameterRow]:
    """Yield the parameters in their order."""
    if report.fit is None:
        return
    before = {change.name: change.before for change in parameter_changes(report)}
    intervals = parameter_intervals(report.fit).tolist()
    values = report.fit.values.tolist()
    for name, value, (low, high) in zip(report.fit.parameter_names, values, intervals, strict=True):
        unit = "px" if name in IN_PIXELS else ""
        yield ParameterRow(name, unit, value, low, high, before.get(f"color.{name}"))


def parameter_changes(report: CalibrationReport) -> tuple[ParameterChange, ...]:
    """Return what the calibration changed against the one before; none where none compares."""
    comparison = comparison_of(report)
    return () if comparison is None else comparison.parameters


def comparison_of(report: CalibrationReport) -> Comparison | None:
    """Return the comparison with the calibration before; None where none compares."""
    if report.previous is None or report.calibration is None:
        return None
    return compare(report.previous, report.calibration)


def largest_change_mm(report: CalibrationReport) -> float | None:
    """Return by how much 0.5 m at 2 m changes at most against the calibration before."""
    comparison = comparison_of(report)
    return None if comparison is None else known(MM_PER_M * comparison.largest_change_m)


def image_rows(report: CalibrationReport) -> Iterator[ImageRow]:
    """Yield all images, those without a board too, numbered from 1."""
    fit = report.fit
    views = {view.image: view for view in fit.views} if fit is not None else {}
    errors = {error.image: error for error in board_errors(fit)} if fit is not None else {}
    leans = _leans(fit)
    for number, image in enumerate(report.images, 1):
        view = views.get(image.name)
        tilt_deg, lean_deg = leans.get(image.name, (None, None))
        error = errors.get(image.name)
        yield ImageRow(
            number=number,
            image=image,
            n_used=_n_used(view),
            rms_px=None if view is None else known(view.rms_px),
            max_px=None if view is None else _max_px(view),
            tilt_deg=tilt_deg,
            lean_deg=lean_deg,
            distance_m=_distance_m(fit, view, error),
            q_mm=None if error is None else MM_PER_M * error.q_m,
            is_outlier=view is not None and view.is_outlier,
        )


def corner_lines(report: CalibrationReport) -> Iterator[CornerLine]:
    """Yield every corner that had no part in its board's pose, image by image."""
    for error in board_errors(report.fit) if report.fit is not None else ():
        for row in error.rows:
            dx_m, dy_m = row.error_m
            yield CornerLine(
                image=row.image,
                u_px=row.u_px,
                v_px=row.v_px,
                real_mm=(MM_PER_M * row.x_m, MM_PER_M * row.y_m),
                computed_mm=(MM_PER_M * row.computed_x_m, MM_PER_M * row.computed_y_m),
                error_mm=(MM_PER_M * dx_m, MM_PER_M * dy_m),
                off_mm=MM_PER_M * math.hypot(dx_m, dy_m),
                q_mm=MM_PER_M * error.q_m,
            )


def uncertainty_rows(fit: CameraFit) -> Iterator[UncertaintyRow]:
    """Yield the working volume, from near to far."""
    for distance_m in DISTANCES_M:
        found = uncertainty_map(fit, distance_m)
        yield UncertaintyRow(
            distance_m=distance_m,
            median_px=_over(np.median, SURE * found.sd_px),
            worst_px=_over(np.max, SURE * found.sd_px),
            worst_mm=_over(np.max, MM_PER_M * SURE * found.sd_m),
            length_mm=length_interval_mm(fit, distance_m, LENGTH_M),
        )


def length_interval_mm(fit: CameraFit, distance_m: float, length_m: float) -> float | None:
    """Return half of the 95 % interval of a length across the axis, whose depth is known."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", FoldWarning)  # None is the answer there
        return known(MM_PER_M * SURE * distance_uncertainty(fit, distance_m, length_m))


def uncertainty_map(
    fit: CameraFit, distance_m: float, cells: tuple[int, int] = MAP_CELLS
) -> UncertaintyMap:
    """Return the uncertainty over the image; NaN beyond the lens model's fold."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", FoldWarning)
        return map_uncertainty(fit, distance_m, cells)


def known(value: float) -> float | None:
    """Return a number that a cell can hold; None for NaN and infinity."""
    return value if math.isfinite(value) else None


def _over(summary: Callable[[FloatArray], object], values: FloatArray) -> float | None:
    finite = values[np.isfinite(values)]
    return float(np.asarray(summary(finite))) if finite.size else None


def _n_used(view: ViewFit | None) -> int:
    if view is None or view.is_outlier:
        return 0
    return int(np.count_nonzero(view.is_used))


def _max_px(view: ViewFit) -> float | None:
    lengths = np.hypot(*view.residuals_px.T)
    seen = lengths[~np.isnan(lengths)]
    return float(seen.max()) if seen.size else None


def _leans(fit: CameraFit | None) -> dict[str, tuple[float, float]]:
    if fit is None:
        return {}
    names = [view.image for view in fit.used_views]
    tilts, leans = np.degrees(tilts_rad(fit)), np.degrees(tilt_directions_rad(fit))
    return dict(zip(names, zip(tilts.tolist(), leans.tolist(), strict=True), strict=True))


def _distance_m(
    fit: CameraFit | None, view: ViewFit | None, error: BoardError | None
) -> float | None:
    if error is not None:
        return error.distance_m
    if fit is None or view is None:
        return None
    middle_m = view.camera_from_board.apply(fit.board.points_m().mean(axis=0))
    return known(float(np.linalg.norm(middle_m)))
