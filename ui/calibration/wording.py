"""What the calibration screen says of pictures and results. Knows nothing of Qt."""

import html
import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from adibas.calibration.comparison import LENGTH_M, Comparison
from adibas.calibration.extrinsics import ShotFit
from adibas.calibration.guidance import LEANS, PLACES, Guidance, GuidanceParams, Lean
from adibas.calibration.quality import tilts_rad
from adibas.data.calibration_report import DepthReport
from adibas.data.calibration_verdict import Grade
from adibas.data.camera_fit import CameraFit
from adibas.pipeline.sensor_calibration import SensorOutcome
from adibas.reports.calibration_depth_rows import bias_rows
from adibas.reports.calibration_facts import change_facts, depth_facts, signed_text
from adibas.texts import decimal_text, message
from adibas.texts import translate as _

CERTAIN = 1.959964
USUAL_DECIMALS, MOST_DECIMALS = 4, 7
SHOWN_EVERY_M = 0.5
"""Of the correction of the depth; the report has it finer."""
LEAN_NAMES: dict[Lean, str] = {
    "left": message("Turned to the left"),
    "right": message("Turned to the right"),
    "up": message("Leaned back"),
    "down": message("Leaned forward"),
}
KINDS = {Grade.GOOD: "good", Grade.USABLE: "warning", Grade.REPEAT: "bad"}
"""What a label that says the grade looks like."""

Row = tuple[str, ...]


def progress_of(guidance: Guidance) -> tuple[tuple[str, bool], ...]:
    """Return what the pictures should have, in words, and whether they have it."""
    least = GuidanceParams().least_pictures
    leans = tuple((_(LEAN_NAMES[lean]), lean in guidance.leans) for lean in LEANS)
    number = _("{n} of {least} pictures").format(n=guidance.n_pictures, least=least)
    share = round(100 * float(guidance.covered.mean()))
    has_places = not any(text in PLACES.values() for text in guidance.lacking)
    ticks = (
        *leans,
        (_("Near"), guidance.has_near),
        (_("Far away"), guidance.has_far),
        (_("{percent} % of the picture").format(percent=share), has_places),
        (number, guidance.n_pictures >= least),
    )
    if guidance.n_depths is None:
        return ticks
    least = GuidanceParams().least_depths
    depths = _("{n} of {least} with depth").format(n=guidance.n_depths, least=least)
    return (
        *ticks,
        (_("As far as patients"), guidance.has_distant),
        (depths, guidance.n_depths >= least),
    )


def result_html(outcome: SensorOutcome) -> str:
    """Return everything that a result says but the verdict's first sentence."""
    fit = outcome.camera.fit
    _grade, *findings = outcome.camera.verdict.sentences()
    parts = [_list(findings)]
    if outcome.previous is not None and outcome.comparison is not None:
        parts.append(f"<p>{html.escape(_compared(outcome))}</p>")
    if fit is not None and fit.is_settled:
        parts += [
            _heading(_("Colour camera")),
            _table(_parameter_rows(fit, outcome.comparison)),
            *_depth_parts(outcome),
            _heading(_("Pictures")),
            f"<p>{html.escape(_mean_error(fit))}</p>",
            _table(_picture_rows(outcome, fit)),
        ]
    return "".join(parts)


def _depth_parts(outcome: SensorOutcome) -> list[str]:
    depth = outcome.depth_report()
    if depth is None:
        return []
    checks = depth_facts(replace(depth, left_open=()))  # the verdict says what is left open
    return [
        _heading(_("Depth camera")),
        _list([f"{name}: {text}" for name, text in checks]),
        _table(_bias_table(depth)),
        *_depth_changes(outcome.comparison),
    ]


def _depth_changes(comparison: Comparison | None) -> list[str]:
    changes = change_facts(comparison)
    if not changes:
        return []
    told = _("Against the calibration before (95 %):")
    return [f"<p>{html.escape(told)}</p>", _list([f"{name}: {text}" for name, text in changes])]


def _bias_table(depth: DepthReport) -> list[Row]:
    rows: list[Row] = [(_("Depth [m]"), _("Added [mm]"), _("95 % interval"))]
    for row in bias_rows(depth):
        if row.low_mm is not None and row.measured_m % SHOWN_EVERY_M == 0:
            half = f"± {decimal_text(row.added_mm - row.low_mm, 1)}"
            rows.append((decimal_text(row.measured_m, 1), signed_text(row.added_mm, 1), half))
    return rows


def _heading(text: str) -> str:
    return f"<h3>{html.escape(text)}</h3>"


def _compared(outcome: SensorOutcome) -> str:
    comparison, previous = outcome.comparison, outcome.previous
    if comparison is None or previous is None:
        return ""
    return _(
        "Against the calibration of {day}, a length of {length} mm at 2 m changes by {change} mm "
        "at most."
    ).format(
        day=previous.made_utc.astimezone().date().isoformat(),
        length=decimal_text(1000 * LENGTH_M, 0),
        change=decimal_text(1000 * comparison.largest_change_m, 1),
    )


def _mean_error(fit: CameraFit) -> str:
    return _("The corners are {rms} pixels off (root mean square over points).").format(
        rms=decimal_text(fit.rms_px, 3)
    )


def _parameter_rows(fit: CameraFit, comparison: Comparison | None) -> list[Row]:
    changes = {} if comparison is None else {one.name: one for one in comparison.parameters}
    title: Row = (_("Parameter"), _("Value"), _("95 % interval"), _("Before"), _("Change"))
    rows = [title if changes else title[:3]]
    for name, value, sd in zip(
        fit.parameter_names, fit.values, fit.standard_deviations, strict=True
    ):
        half_width = CERTAIN * float(sd)
        n_decimals = _decimals(half_width)
        half = f"± {decimal_text(half_width, n_decimals)}"
        row: Row = (name, decimal_text(float(value), n_decimals), half)
        change = changes.get(f"color.{name}")
        if change is not None:
            moved = change.now - change.before
            row += (decimal_text(change.before, n_decimals), signed_text(moved, n_decimals))
        elif changes:
            row += ("", "")
        rows.append(row)
    return rows


def _picture_rows(outcome: SensorOutcome, fit: CameraFit) -> list[Row]:
    """Return what is left in each picture, and in its depth where there is one."""
    shots = {} if outcome.depth is None else {one.name: one for one in outcome.depth.fit.shots}
    title: Row = (_("Picture"), _("Error [px]"), _("Distance [m]"), _("Tilt [°]"))
    rows = [(*title, *((_("Depth error [mm]"),) if shots else ()), "")]
    tilts = iter(tilts_rad(fit).tolist())
    middle_m = fit.board.points_m().mean(axis=0)
    for view in fit.views:
        tilt = "" if view.is_outlier else decimal_text(math.degrees(next(tilts)), 0)
        distance_m = float(np.linalg.norm(view.camera_from_board.apply(middle_m)))
        shot = shots.get(view.image)
        is_out = view.is_outlier or (shot is not None and shot.is_outlier)
        row: Row = (view.image, decimal_text(view.rms_px, 3), decimal_text(distance_m, 2), tilt)
        if shots:
            row += ("" if shot is None else signed_text(_depth_error_mm(shot), 1),)
        rows.append((*row, _("left out: it contradicts the others") if is_out else ""))
    return rows


def _depth_error_mm(shot: ShotFit) -> float:
    """Return by how much the depth is too far; more of 1/z is nearer."""
    return -1000.0 * shot.distance_m**2 * shot.error_per_m


def _decimals(half_width: float) -> int:
    """Return how many decimals show two digits of an interval."""
    if not 0 < half_width < math.inf:
        return USUAL_DECIMALS
    return min(max(1 - math.floor(math.log10(half_width)), 0), MOST_DECIMALS)


def _list(sentences: Sequence[str]) -> str:
    items = "".join(f"<li>{html.escape(sentence)}</li>" for sentence in sentences)
    return f"<ul>{items}</ul>" if items else ""


def _table(rows: Sequence[Row]) -> str:
    """Return rows as a table; the first is its head; numbers stand right, words left."""
    lines = []
    n_right = len(rows[0]) if rows[0][-1] else len(rows[0]) - 1
    for number, row in enumerate(rows):
        tag = "td" if number else "th"
        sides = ["left", *("right" for _cell in row[1:n_right]), *("left" for _c in row[n_right:])]
        cells = "".join(
            f'<{tag} align="{side}">{html.escape(cell)}&nbsp;&nbsp;&nbsp;</{tag}>'
            for side, cell in zip(sides, row, strict=True)
        )
        lines.append(f"<tr>{cells}</tr>")
    return f'<table cellpadding="3">{"".join(lines)}</table>'
