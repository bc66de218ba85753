"""The PDF report of a calibration: a page of words and numbers, and a page of plots."""

from collections.abc import Iterator
from pathlib import Path

from matplotlib.figure import Figure
from reportlab.lib.colors import Color, HexColor
from reportlab.platypus import Flowable, PageBreak, Spacer, Table, TableStyle

from adibas.data.calibration_report import CalibrationReport
from adibas.data.calibration_verdict import GRADES, Grade
from adibas.data.camera_fit import CameraFit
from adibas.reports.calibration_depth_plots import bias_figure, shots_figure
from adibas.reports.calibration_facts import camera_facts, figures, general_facts, next_step
from adibas.reports.calibration_pdf_tables import (
    GAP,
    HALF,
    depth_tables,
    figure_table,
    image_tables,
    parameter_table,
    uncertainty_table,
)
from adibas.reports.calibration_plots import (
    coverage_figure,
    image_error_figure,
    q_figure,
    residual_map_figure,
    residual_scatter_figure,
    tilt_figure,
    uncertainty_figure,
)
from adibas.reports.facts import intended_use
from adibas.reports.pdf_document import write_document
from adibas.reports.pdf_layout import HEADING, TEXT, WIDTH, facts_table, paragraph, title
from adibas.reports.vector_figures import FigureFlowable
from adibas.texts import message
from adibas.texts import translate as _

DOCUMENT = message("Calibration report")
COLORS: dict[Grade, Color] = {
    Grade.GOOD: HexColor(0x2E7D4F),
    Grade.USABLE: HexColor(0xC77800),
    Grade.REPEAT: HexColor(0xB3261E),
}
MAP_HEIGHT, BAR_HEIGHT, SCATTER_HEIGHT = 198.0, 110.0, 158.0


def write_calibration_pdf(report: CalibrationReport, path: Path) -> None:
    """Write verdict, parameters, images and plots; the corners are in the Excel report.

    Raises
    ------
    FileError
        The disk is full, or the folder cannot be written.
    """
    told = [f"ADiBAS {report.version}", report.sensor]
    line = " · ".join(part for part in told if part)
    write_document(
        path,
        report.language,
        report.version,
        DOCUMENT,
        lambda: (_story(report), (intended_use(), line)),
    )


def _story(report: CalibrationReport) -> Iterator[Flowable]:
    yield title(_(DOCUMENT))
    yield _verdict(report)
    yield Spacer(1, GAP)
    yield facts_table([*camera_facts(report), *general_facts(report)])
    if report.fit is None:
        yield title(_("Results"), level=2)
        yield facts_table([(figure.name, figure.text) for figure in figures(report)])
    else:
        left = [*parameter_table(report), *uncertainty_table(report.fit)]
        yield _columns([left, list(figure_table(report))])
    yield from image_tables(report)
    if report.fit is not None:
        yield PageBreak()
        yield from _plots(report, report.fit)
    if report.depth is not None:
        yield PageBreak()
        yield from depth_tables(report, report.depth)
        if report.depth.shots:
            drawn = [bias_figure(report.depth, HALF, MAP_HEIGHT)]
            if any(not shot.is_wall for shot in report.depth.shots):
                drawn.append(shots_figure(report.depth, HALF, MAP_HEIGHT))
            yield _row(*drawn)


def _verdict(report: CalibrationReport) -> Flowable:
    """Return the verdict, its reasons and what to do, in a frame of its colour."""
    verdict = report.verdict
    color = COLORS[verdict.grade]
    head = paragraph(_(GRADES[verdict.grade]), HEADING.clone("verdict", textColor=color))
    texts = [finding.text for finding in verdict.findings]
    if report.fit is not None and verdict.grade is not Grade.REPEAT:
        texts.append(next_step(report))
    cells = [[head], *([paragraph(text, TEXT)] for text in texts)]
    style = [
        ("LINEBEFORE", (0, 0), (0, -1), 4, color),
        ("LEFTPADDING", (0, 0), (-1, -1), 10),
        ("TOPPADDING", (0, 0), (-1, -1), 1),
        ("BOTTOMPADDING", (0, 0), (-1, -1), 2),
    ]
    return Table(cells, [WIDTH], style=TableStyle(style))


def _plots(report: CalibrationReport, fit: CameraFit) -> Iterator[Flowable]:
    yield _row(
        coverage_figure(fit, HALF, MAP_HEIGHT),
        residual_map_figure(fit, HALF, MAP_HEIGHT),
    )
    yield _row(
        uncertainty_figure(fit, HALF, MAP_HEIGHT),
        tilt_figure(report, HALF, MAP_HEIGHT),
    )
    yield _row(image_error_figure(report, WIDTH, BAR_HEIGHT))
    yield _row(
        residual_scatter_figure(fit, HALF, SCATTER_HEIGHT),
        q_figure(report, HALF, SCATTER_HEIGHT),
    )


def _row(*drawn: Figure) -> Flowable:
    return _columns([[FigureFlowable(figure)] for figure in drawn])


def _columns(columns: list[list[Flowable]]) -> Flowable:
    widths = [WIDTH] if len(columns) == 1 else [HALF + GAP, HALF]
    style = [
        ("VALIGN", (0, 0), (-1, -1), "TOP"),
        ("LEFTPADDING", (0, 0), (-1, -1), 0),
        ("RIGHTPADDING", (0, 0), (-1, -1), 0),
        ("TOPPADDING", (0, 0), (-1, -1), 2),
        ("BOTTOMPADDING", (0, 0), (-1, -1), 2),
    ]
    return Table([columns], widths, style=TableStyle(style), hAlign="LEFT")
