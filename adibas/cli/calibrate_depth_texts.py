"""What `adibas calibrate --depth` says of the depth camera, as lines and as a JSON document."""

import math
from collections.abc import Iterator
from pathlib import Path

from adibas.calibration.drift import Drift
from adibas.calibration.registration_check import RegistrationCheck
from adibas.calibration.vertical import Vertical
from adibas.data.calibration_verdict import Verdict
from adibas.pipeline.calibrating_depth import DepthOutcome
from adibas.pipeline.calibration_report import report_of_depth_outcome
from adibas.reports.calibration_depth_rows import bias_rows, depth_parameter_rows, shot_rows
from adibas.reports.calibration_rows import SURE
from adibas.texts import SpokenNumber, translate_plural
from adibas.texts import translate as _

MILLIMETRES = 1000.0
STATED_M = (1.0, 2.0, 3.0)
"""Distances at which the terminal shows the correction; the document has them all."""


def describe_depth(outcome: DepthOutcome) -> Iterator[str]:
    """Give the lines for a reader: what was seen, what it gave, what was checked."""
    report = report_of_depth_outcome(outcome)
    n_boards = sum(not (shot.is_wall or shot.is_outlier) for shot in report.shots)
    n_walls = sum(shot.is_wall for shot in report.shots)
    yield _("Depth camera: {boards} and {walls} took part, of {moments}.").format(
        boards=translate_plural("{n} board", "{n} boards", n_boards).format(n=n_boards),
        walls=translate_plural("{n} wall", "{n} walls", n_walls).format(n=n_walls),
        moments=translate_plural("{n} still moment", "{n} still moments", outcome.n_still).format(
            n=outcome.n_still
        ),
    )
    for row in depth_parameter_rows(report):
        if row.high is not None:
            half = row.high - row.value
            yield f"  {row.name:26} {row.value:12.6g} ± {half:.2g} {row.unit}".rstrip()
    for correction in bias_rows(report):
        if correction.measured_m in STATED_M and correction.high_mm is not None:
            yield _("Depth of {distance:g} m is corrected by {added:+.1f} ± {half:.1f} mm.").format(
                distance=SpokenNumber(correction.measured_m),
                added=SpokenNumber(correction.added_mm),
                half=SpokenNumber(correction.high_mm - correction.added_mm),
            )
    yield from _checks(outcome)


def _checks(outcome: DepthOutcome) -> Iterator[str]:
    if outcome.scale is not None and not outcome.scale.is_wrong:
        yield outcome.scale.sentence.text
    if outcome.registration is not None:
        yield outcome.registration.sentence.text
    vertical = outcome.vertical
    if vertical is None:
        yield _("No floor is seen, so that the calibration does not know which way is down.")
    else:
        yield _(
            "By the floor, down is known within {half:.2f} degrees; the floor is flat within "
            "{flatness:.1f} mm."
        ).format(
            half=SpokenNumber(math.degrees(SURE * vertical.sd_rad)),
            flatness=SpokenNumber(MILLIMETRES * vertical.flatness_m),
        )


def depth_document(outcome: DepthOutcome, verdict: Verdict, out: Path | None) -> dict[str, object]:
    """Return everything as plain values; `verdict` is that of the whole sensor."""
    report = report_of_depth_outcome(outcome)
    scale = outcome.scale
    return {
        "out": None if out is None else str(out),
        "verdict": {"grade": verdict.grade.value, "sentences": list(verdict.sentences())},
        "n_still_moments": outcome.n_still,
        "parameters": {
            row.name: {"value": row.value, "ci95": [row.low, row.high], "unit": row.unit}
            for row in depth_parameter_rows(report)
        },
        "correction": [
            {
                "measured_m": row.measured_m,
                "added_mm": row.added_mm,
                "ci95_mm": [row.low_mm, row.high_mm],
            }
            for row in bias_rows(report)
        ],
        "shots": [
            {
                "name": row.name,
                "is_wall": shot.is_wall,
                "distance_m": row.distance_m,
                "error_mm": row.error_mm,
                "rms_mm": row.rms_mm,
                "is_outlier": row.is_outlier,
            }
            for row, shot in zip(shot_rows(report), report.shots, strict=True)
        ],
        "scale": None
        if scale is None
        else {"factor": scale.factor, "ci95": list(scale.interval), "is_wrong": scale.is_wrong},
        "registration": _registration(outcome.registration),
        "vertical": _vertical(outcome.vertical),
        "drift": _drift(outcome.drift),
    }


def _registration(check: RegistrationCheck | None) -> dict[str, object] | None:
    if check is None:
        return None
    return {
        "result": check.result.value,
        "shift_px": [_finite(value) for value in check.shift_px.tolist()],
        "standard_error_px": [_finite(value) for value in check.standard_error_px.tolist()],
    }


def _vertical(vertical: Vertical | None) -> dict[str, object] | None:
    if vertical is None:
        return None
    return {
        "gravity": vertical.gravity.tolist(),
        "ci95_deg": math.degrees(SURE * vertical.sd_rad),
        "flatness_mm": _finite(MILLIMETRES * vertical.flatness_m),
    }


def _drift(drift: Drift | None) -> dict[str, object] | None:
    if drift is None:
        return None
    return {
        "rate_per_m_s": drift.rate_per_m_s,
        "ci95_per_m_s": list(drift.interval_per_m_s),
        "span_s": drift.span_s,
    }


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
