"""The tables in the PDF report of a calibration."""

import math
from collections.abc import Iterator

from reportlab.platypus import Flowable

from adibas.data.calibration_report import CalibrationReport, DepthReport
from adibas.data.camera_fit import CameraFit
from adibas.reports.calibration_depth_rows import depth_parameter_rows
from adibas.reports.calibration_facts import change_facts, depth_facts, figures, remark
from adibas.reports.calibration_rows import (
    LENGTH_M,
    comparison_of,
    image_rows,
    parameter_rows,
    uncertainty_rows,
)
from adibas.reports.pdf_layout import (
    SMALL_TEXT,
    WIDTH,
    facts_table,
    note,
    number_table,
    paragraph,
    title,
)
from adibas.texts import decimal_text
from adibas.texts import translate as _

GAP = 8.0
HALF = (WIDTH - GAP) / 2
DASH = "\N{EN DASH}"
MOST_DECIMALS = 8
UNSURE_DIGITS = 100.0
"""A value without an interval has four digits: two more than the interval would have."""
MOST_IMAGES = 60
"""That the table lists; all are in the Excel report."""

LONGEST_NAME = 24


def parameter_table(report: CalibrationReport) -> Iterator[Flowable]:
    """Yield the parameters with as many digits as their intervals bear."""
    yield title(_("Parameters of the camera"), level=2)
    rows = list(parameter_rows(report))
    header = [_("Parameter"), _("Value"), _("95 %"), _("Unit")]
    cells = []
    for row in rows:
        n = n_decimals(0.5 * (row.high - row.low))
        interval = f"{decimal_text(row.low, n)} {DASH} {decimal_text(row.high, n)}"
        cells.append([row.name, decimal_text(row.value, n), interval, row.unit])
    shares = [0.2, 0.25, 0.42, 0.13]
    if any(row.before is not None for row in rows):
        header.insert(3, _("before"))
        for cell, row in zip(cells, rows, strict=True):
            n = n_decimals(0.5 * (row.high - row.low))
            cell.insert(3, DASH if row.before is None else decimal_text(row.before, n))
        shares = [0.16, 0.2, 0.36, 0.18, 0.1]
    widths = [share * HALF for share in shares]
    yield number_table(header, cells, widths, text_columns=(0, len(header) - 1))


def uncertainty_table(fit: CameraFit) -> Iterator[Flowable]:
    """Yield what the calibration makes uncertain at each distance."""
    yield title(_("What the calibration makes uncertain: 95 %, plus or minus"), level=2)
    length = _("{length} m long [mm]").format(length=decimal_text(LENGTH_M, 0))
    header = [_("At [m]"), _("worst place [px]"), _("worst place [mm]"), length]
    header = [text.replace(" [", "\n[") for text in header]  # longer in other languages
    cells = [
        [
            decimal_text(row.distance_m, 0),
            _text(row.worst_px, 2),
            _text(row.worst_mm, 2),
            _text(row.length_mm, 2),
        ]
        for row in uncertainty_rows(fit)
    ]
    yield number_table(
        header, cells, [share * HALF for share in (0.14, 0.28, 0.3, 0.28)], text_columns=()
    )


def figure_table(report: CalibrationReport) -> Iterator[Flowable]:
    """Yield the numbers that sum the calibration up."""
    yield title(_("Results"), level=2)
    cells = [[paragraph(one.name, SMALL_TEXT), one.text] for one in figures(report)]
    yield number_table(
        [_("Result"), _("Value")], cells, [0.78 * HALF, 0.22 * HALF], text_columns=(0,)
    )


def image_tables(report: CalibrationReport) -> Iterator[Flowable]:
    """Yield the table of the images in two blocks side by side, then those without a board."""
    rows = list(image_rows(report))
    measured = [row for row in rows if row.rms_px is not None]
    shown = measured[:MOST_IMAGES]
    if shown:
        yield title(_("Images"), level=2)
        cells = [
            [
                str(row.number),
                _short(row.image.name) + (" *" if row.is_outlier else ""),
                str(row.n_used),
                _text(row.rms_px, 3),
                _text(row.max_px, 2),
                _text(row.tilt_deg, 0),
                _text(row.distance_m, 2),
                _text(row.q_mm, 3),
            ]
            for row in shown
        ]
        half = -(-len(cells) // 2)
        cells += [[""] * len(cells[0])] * (2 * half - len(cells))
        header = [_("No."), _("Image"), "n", "rms", "max", "°", "m", "Q_k"]
        lines = [left + right for left, right in zip(cells[:half], cells[half:], strict=True)]
        shares = [0.1, 0.34, 0.08, 0.11, 0.1, 0.07, 0.1, 0.1]
        yield number_table(
            header * 2, lines, [share * WIDTH / 2 for share in shares] * 2, text_columns=(1, 9)
        )
    yield from _notes(report, n_more=len(measured) - len(shown))


def _notes(report: CalibrationReport, n_more: int) -> Iterator[Flowable]:
    rows = list(image_rows(report))
    if any(row.is_outlier for row in rows):
        yield note(_("* contradicts the others and took no part"))
    for row in [row for row in rows if row.image.problem is not None][:MOST_IMAGES]:
        yield note(f"{row.number} {_short(row.image.name)}: {remark(row)}")
    if n_more > 0:
        yield note(_("{n} more images are in the Excel report.").format(n=n_more))
    if report.fit is not None:
        yield note(
            _(
                "n: corners that took part; rms and max: their error [px]; °: tilt; m: distance; "
                "Q_k: mean error [mm] on the board of every other corner, with the board's pose "
                "from the rest. Every such corner (pixel, real and computed place, error) is in "
                "the Excel report."
            )
        )


def depth_tables(report: CalibrationReport, depth: DepthReport) -> Iterator[Flowable]:
    """Yield pose and own error of the depth camera, what was checked, and what changed."""
    yield title(_("Depth"), level=2)
    cells = []
    for row in depth_parameter_rows(depth):
        interval, n = DASH, n_decimals(abs(row.value) / UNSURE_DIGITS)
        if row.low is not None and row.high is not None:
            n = n_decimals(0.5 * (row.high - row.low))
            interval = f"{decimal_text(row.low, n)} {DASH} {decimal_text(row.high, n)}"
        cells.append([row.name, decimal_text(row.value, n), interval, row.unit])
    header = [_("Parameter"), _("Value"), _("95 %"), _("Unit")]
    widths = [share * WIDTH for share in (0.34, 0.2, 0.34, 0.12)]
    yield number_table(header, cells, widths, text_columns=(0, 3))
    checks = depth_facts(depth)
    if checks:
        yield title(_("Checks"), level=2)
        yield facts_table(checks)
    changes = change_facts(comparison_of(report))
    if changes:
        yield title(_("Depth against the calibration before (95 %)"), level=2)
        yield facts_table(changes)


def n_decimals(half_interval: float) -> int:
    """Return how many decimals show two digits of an interval's half."""
    if not 0 < half_interval < math.inf:
        return 3
    return min(max(1 - math.floor(math.log10(half_interval)), 0), MOST_DECIMALS)


def _text(value: float | None, n: int) -> str:
    """Return a number, or a dash where there is none."""
    return DASH if value is None else decimal_text(value, n)


def _short(name: str) -> str:
    return (
        name if len(name) <= LONGEST_NAME else f"{name[: LONGEST_NAME - 1]}\N{HORIZONTAL ELLIPSIS}"
    )
