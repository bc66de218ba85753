"""What a calibration's report says in lines of name and value, the same for every format."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from datetime import datetime, timedelta

import numpy as np

from adibas.calibration.comparison import Comparison, DepthChange
from adibas.calibration.kept import REMIND_AFTER
from adibas.calibration.quality import board_errors, map_residuals, mean_board_error_m, tilts_rad
from adibas.calibration.verdict import VerdictParams
from adibas.data.calibration_report import (
    CalibrationReport,
    DepthReport,
    ReportedDrift,
    ReportedVertical,
)
from adibas.data.calibration_verdict import GRADES, Grade
from adibas.data.camera_fit import CameraFit
from adibas.reports.calibration_depth_rows import rms_of_shots_mm
from adibas.reports.calibration_rows import (
    MM_PER_M,
    SURE,
    ImageRow,
    known,
    largest_change_mm,
    length_interval_mm,
)
from adibas.reports.facts import intended_use
from adibas.texts import SpokenNumber, decimal_text, message, translate_plural
from adibas.texts import translate as _

Pairs = list[tuple[str, str]]

SECONDS_PER_MINUTE = 60.0

DEFINITIONS = {
    "edges": message("where the middles of the edges cross"),
    "gradient": message("where the edges are steepest, as OpenCV's cornerSubPix places them"),
}
"""Of a corner, by `RgbdCalibration.corner_method`."""


@dataclass(frozen=True, slots=True)
class Figure:
    """A number with its name; None where it is not known."""

    name: str
    value: float | None
    n_decimals: int

    @property
    def text(self) -> str:
        """The number as the language in use writes it."""
        return "\N{EN DASH}" if self.value is None else decimal_text(self.value, self.n_decimals)


def verdict_facts(report: CalibrationReport) -> Pairs:
    """Return the verdict, each reason with what to do, and what to do next."""
    verdict = report.verdict
    facts = [(_("Verdict"), _(GRADES[verdict.grade]))]
    facts += [(_("Reason, and what to do"), finding.text) for finding in verdict.findings]
    if report.fit is not None and verdict.grade is not Grade.REPEAT:
        facts.append((_("What to do next"), next_step(report)))
    return facts


def next_step(report: CalibrationReport) -> str:
    """Return until when the calibration serves."""
    made = made_utc(report) or report.written_utc
    return _(
        "Calibrate again after {date}, and sooner where the sensor fell, was opened, or measures "
        "a known length wrongly."
    ).format(date=(made + REMIND_AFTER).date().isoformat())


def camera_facts(report: CalibrationReport) -> Pairs:
    """Return what was calibrated, with what, and when."""
    board = report.board
    made, age = made_utc(report), age_days(report)
    facts = [
        (_("Sensor"), report.sensor or _("not told")),
        (
            _("Calibrated (UTC)"),
            _("not known") if made is None else made.isoformat(timespec="seconds"),
        ),
        (
            _("Age of the calibration"),
            _("not known")
            if age is None
            else translate_plural("{n} day", "{n} days", age).format(n=age),
        ),
    ]
    if board is not None:
        told = _("{columns} x {rows} inner corners, squares of {side} mm").format(
            columns=board.columns,
            rows=board.rows,
            side=plain_number(MM_PER_M * board.square_m),
        )
        facts.append((_("Board"), told))
    fit = report.fit
    if fit is not None:
        size = _("{width} x {height} pixels").format(
            width=fit.camera.width, height=fit.camera.height
        )
        terms = _("no lens distortion") if fit.model == "none" else fit.model
        facts += [(_("Image"), size), (_("Lens model"), terms)]
    method = "" if report.calibration is None else report.calibration.corner_method
    if method in DEFINITIONS:
        facts.append((_("Corners"), _(DEFINITIONS[method])))
    return facts


def general_facts(report: CalibrationReport) -> Pairs:
    """Return what the reader must know about every report of a calibration."""
    return [
        (_("Software version"), report.version),
        (_("Intended use"), intended_use()),
        (
            _("Intervals"),
            _(
                "95 %, from the noise of the corners and from what the images contradict one "
                "another. Distances rest on the size of the squares, which images alone do not "
                "show: measure one with a ruler."
            ),
        ),
    ]


def figures(report: CalibrationReport) -> Iterator[Figure]:
    """Yield the numbers that sum the calibration up."""
    if report.images:
        yield Figure(_("Images given"), len(report.images), 0)
        with_board = sum(image.n_corners > 0 for image in report.images)
        yield Figure(_("Images with the board"), with_board, 0)
    if report.fit is not None:
        yield from _fit_figures(report.fit)
    change_mm = largest_change_mm(report)
    if change_mm is not None:
        yield Figure(
            _("Change of 0.5 m at 2 m against the calibration before, at most [mm]"), change_mm, 2
        )
    if report.depth is not None:
        yield from _depth_figures(report.depth)


def depth_facts(depth: DepthReport) -> Pairs:
    """Return what was checked of the depth, in words."""
    facts = []
    if depth.registration is not None:
        facts.append((_("Registration on a real edge"), depth.registration.text))
    if depth.vertical is not None:
        facts.append((_("Vertical"), _vertical_text(depth.vertical)))
    if depth.drift is not None:
        facts.append((_("Warm-up"), _drift_text(depth.drift)))
    return facts + [(_("Left open"), sentence.text) for sentence in depth.left_open]


def change_facts(comparison: Comparison | None) -> Pairs:
    """Return what became of the depth since the calibration before; nothing without a depth."""
    if comparison is None or not comparison.depths:
        return []
    facts = [
        (
            _("Depth at {distance} m").format(distance=decimal_text(one.measured_m, 0)),
            _depth_change_text(one),
        )
        for one in comparison.depths
    ]
    pose = _("{shift} mm and {turn} degrees").format(
        shift=decimal_text(MM_PER_M * comparison.shift_m, 1),
        turn=decimal_text(math.degrees(comparison.turn_rad), 2),
    )
    return [*facts, (_("Place of the depth camera, moved by"), pose)]


def _depth_change_text(change: DepthChange) -> str:
    moved_mm = MM_PER_M * (change.now_m - change.before_m)
    text = f"{signed_text(moved_mm, 1)} mm"
    if math.isnan(change.sigma_m):
        return text
    return f"{text} (± {decimal_text(MM_PER_M * SURE * change.sigma_m, 1)})"


def signed_text(value: float, n_decimals: int) -> str:
    """Return a change in the language in use; one that is rounded away has no sign."""
    text = decimal_text(abs(value), n_decimals)
    if round(value, n_decimals) == 0:
        return text
    return ("+" if value > 0 else "\N{MINUS SIGN}") + text


def remark(row: ImageRow) -> str | None:
    """Return what the reader must know about an image."""
    if row.image.problem is not None:
        return row.image.problem_text
    return _("contradicts the others and took no part") if row.is_outlier else None


def made_utc(report: CalibrationReport) -> datetime | None:
    """Return when the calibration was made; None where it does not say."""
    try:
        made = datetime.fromisoformat(report.calibration.created_utc if report.calibration else "")
    except ValueError:
        return None
    return made if made.tzinfo is not None else made.replace(tzinfo=report.written_utc.tzinfo)


def age_days(report: CalibrationReport) -> int | None:
    """Return how old the calibration was when the report was written; None where not known."""
    made = made_utc(report)
    return None if made is None else max((report.written_utc - made) // timedelta(days=1), 0)


def plain_number(value: float) -> str:
    """Return a number as short as it can be, in the language in use."""
    return f"{SpokenNumber(value):.6g}"


def _fit_figures(fit: CameraFit) -> Iterator[Figure]:
    limits = VerdictParams()
    used = fit.used_views
    yield Figure(_("Images that took part"), len(used), 0)
    n_corners = sum(int(np.count_nonzero(view.is_used)) for view in used)
    yield Figure(_("Corners that took part"), n_corners, 0)
    n_outliers = sum(len(view.outlier_corners) for view in used)
    yield Figure(_("Corners that contradict the rest and took no part"), n_outliers, 0)
    yield Figure(_("Error, rms over points [px]"), known(fit.rms_px), 3)
    yield Figure(_("Noise of a corner's coordinate [px]"), known(fit.sigma_px), 3)
    ratio = math.sqrt(fit.birge_ratio) if fit.birge_ratio >= 0 else math.nan
    yield Figure(_("Contradiction between images, in units of that noise"), known(ratio), 2)
    q_mm = MM_PER_M * mean_board_error_m(board_errors(fit))
    yield Figure(_("Mean error on the board, Q [mm]"), known(q_mm), 3)
    covered = 100.0 * map_residuals(fit).covered_share
    yield Figure(_("Part of the image with corners [%]"), covered, 0)
    greatest_deg = float(np.degrees(tilts_rad(fit)).max(initial=0.0))
    yield Figure(_("Greatest tilt of the board [deg]"), greatest_deg, 1)
    half_mm = length_interval_mm(fit, limits.distance_m, limits.length_m)
    name = _("95 % of a length of {length} m at {distance} m, plus or minus [mm]").format(
        length=decimal_text(limits.length_m, 0), distance=decimal_text(limits.distance_m, 1)
    )
    yield Figure(name, half_mm, 2)
    yield Figure(_("Skew that the images would ask for [px]"), known(fit.skew_px), 3)
    yield Figure(_("95 % of the skew, plus or minus [px]"), known(SURE * fit.skew_sd_px), 3)


def _depth_figures(depth: DepthReport) -> Iterator[Figure]:
    if not depth.shots:
        return
    n_shots = sum(not shot.is_outlier for shot in depth.shots)
    yield Figure(_("Boards and walls seen in depth that took part"), n_shots, 0)
    left_mm = rms_of_shots_mm(depth)
    yield Figure(_("Error of the boards' depth that is left, rms [mm]"), left_mm, 2)


def _vertical_text(vertical: ReportedVertical) -> str:
    source = _("the floor") if vertical.is_of_floor else _("an accelerometer")
    text = _(
        "By {source}: the camera looks {lean} degrees down and is turned {roll} degrees clockwise, "
        "plus or minus {sure} degrees (95 %)."
    ).format(
        source=source,
        lean=decimal_text(math.degrees(vertical.lean_rad), 2),
        roll=decimal_text(math.degrees(vertical.roll_rad), 2),
        sure=decimal_text(math.degrees(SURE * vertical.sd_rad), 2),
    )
    if math.isnan(vertical.flatness_m):
        return text
    residual = _("The floor lies within {residual} mm (rms) of its plane.").format(
        residual=decimal_text(MM_PER_M * vertical.flatness_m, 1)
    )
    return f"{text} {residual}"


def _drift_text(drift: ReportedDrift) -> str:
    if drift.notice is not None:
        return drift.notice.text
    low_mm, high_mm = (SECONDS_PER_MINUTE * MM_PER_M * rate_m_s for rate_m_s in drift.interval_m_s)
    return _(
        "No drift that matters in {minutes} minutes: {low} to {high} mm a minute at {distance} m "
        "(95 %)."
    ).format(
        minutes=decimal_text(drift.span_s / SECONDS_PER_MINUTE, 1),
        low=decimal_text(low_mm, 2),
        high=decimal_text(high_mm, 2),
        distance=decimal_text(drift.distance_m, 0),
    )
