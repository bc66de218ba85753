"""The pages of one view in the PDF report."""

from collections.abc import Iterator
from dataclasses import dataclass

from reportlab.lib.units import mm
from reportlab.platypus import Flowable, Table, TableStyle

from adibas.arrays import UInt8Array
from adibas.data.report import CaptureReport
from adibas.reports.pdf_layout import (
    WIDTH,
    note,
    number_table,
    picture,
    text_width,
    title,
)
from adibas.reports.rows import MarkerRow, distance_rows, free_rows, marker_rows
from adibas.texts import translate as _
from adibas.texts import translate_plural

DASH = "\N{EN DASH}"
MOST_PAIRS = 435
"""Of 30 markers; more would fill page after page."""
MOST_MARKERS_BESIDE = 26
"""That a table beside the picture has room for."""
PICTURE_HEIGHT = 118 * mm
MOST_PICTURE_SHARE = 0.46
NUMBER_WIDTH, INTERVAL_WIDTH = 34, 66
GAP = 8
MOST_BLOCKS = 3


@dataclass(frozen=True, slots=True, eq=False)
class ViewPage:
    """One view: its name, the capture, and the (H, W, 3) picture with the markers drawn."""

    name: str
    capture: CaptureReport
    picture_rgb: UInt8Array


def view_flowables(page: ViewPage) -> Iterator[Flowable]:
    """Yield what stands on the pages of a view, in its order."""
    rows = list(marker_rows(page.capture.analysis))
    yield title(page.name)
    if len(rows) <= MOST_MARKERS_BESIDE and _label_width(rows) < 0.2 * WIDTH:
        yield _side_by_side(page, rows)
    else:
        yield picture(page.picture_rgb, WIDTH, PICTURE_HEIGHT)
        yield _marker_table(page.capture, rows)
    yield from _legend(page.capture, rows)
    yield from _free_measures(page.capture)
    yield from _distances(page.capture)
    n_angles = len(page.capture.analysis.angles)
    yield note(
        translate_plural(
            "The {n} angle of the triplets of markers is in the Excel report.",
            "The {n} angles of all triplets of markers are in the Excel report.",
            n_angles,
        ).format(n=n_angles)
    )


def _side_by_side(page: ViewPage, rows: list[MarkerRow]) -> Flowable:
    shown = picture(page.picture_rgb, MOST_PICTURE_SHARE * WIDTH, PICTURE_HEIGHT)
    left = shown.drawWidth + GAP
    style = [
        ("VALIGN", (0, 0), (-1, -1), "TOP"),
        ("LEFTPADDING", (0, 0), (-1, -1), 0),
        ("RIGHTPADDING", (0, 0), (-1, -1), 0),
        ("TOPPADDING", (0, 0), (-1, -1), 4),
    ]
    cells = [[shown, _marker_table(page.capture, rows)]]
    return Table(cells, [left, WIDTH - left], style=TableStyle(style), hAlign="LEFT")


def _label_width(rows: list[MarkerRow]) -> float:
    names = [_("Marker"), *(f"{row.label} *" for row in rows)]
    return max(text_width(name) for name in names) + 10


def _marker_table(capture: CaptureReport, rows: list[MarkerRow]) -> Flowable:
    cells = []
    for row in rows:
        mark = " *" if row.label in capture.placed_by_hand else ""
        place = [f"{value:.1f}" for value in row.position_mm or ()] or [DASH] * 3
        deviation = f"{row.deviation_mm[2]:.1f}" if row.deviation_mm else DASH
        cells.append([f"{row.label}{mark}", *place, deviation])
    header = [_("Marker"), "x [mm]", "y [mm]", "z [mm]", _("sd {axis} [mm]").format(axis="z")]
    widths = [_label_width(rows), *[NUMBER_WIDTH + 6.0] * 3, text_width(header[-1]) + 12]
    return number_table(header, cells, widths, text_columns=(0,))


def _legend(capture: CaptureReport, rows: list[MarkerRow]) -> Iterator[Flowable]:
    if capture.placed_by_hand:
        yield note(_("* corrected by hand"))
    if any(row.position_mm is None for row in rows):
        yield note(_("Where no position stands, the depth gives none (orange ring)."))


def _free_measures(capture: CaptureReport) -> Iterator[Flowable]:
    if not capture.measures:
        return
    yield title(_("Free measures"), level=2)
    cells = []
    for row in free_rows(capture):
        name = f" {DASH} ".join(label for label in (row.a, row.vertex, row.c) if label)
        cells.append([name, *_numbers(row.value, row.low, row.high), row.unit])
    header = [_("Measure"), _("Value"), _("95 %, instrument only"), _("Unit")]
    name_width = WIDTH - NUMBER_WIDTH - 130 - 40
    yield number_table(header, cells, [name_width, NUMBER_WIDTH + 10, 120, 40], text_columns=(0,))


def _numbers(value: float | None, low: float | None, high: float | None) -> tuple[str, str]:
    if value is None:
        return DASH, DASH
    return f"{value:.1f}", f"{low:.1f} {DASH} {high:.1f}"


def _distances(capture: CaptureReport) -> Iterator[Flowable]:
    """Yield the table of all pairs, several of them in a line."""
    rows = list(distance_rows(capture.analysis))
    yield title(_("Distances [mm], with the interval of 95 %, instrument only"), level=2)
    if not rows:
        yield note(_("No two markers have a position."))
        return
    shown = rows[:MOST_PAIRS]
    names = [f"{row.a} {DASH} {row.b}" for row in shown]
    name_width = max(text_width(name) for name in names) + 10
    block_width = name_width + NUMBER_WIDTH + INTERVAL_WIDTH
    n_blocks = min(max(int(WIDTH // block_width), 1), MOST_BLOCKS, len(shown))
    blocks = [
        (name, *_numbers(row.mm, row.low_mm, row.high_mm))
        for name, row in zip(names, shown, strict=True)
    ]
    blocks += [("", "", "")] * (-len(blocks) % n_blocks)
    cells = [
        [cell for block in blocks[first : first + n_blocks] for cell in block]
        for first in range(0, len(blocks), n_blocks)
    ]
    widths = [name_width, NUMBER_WIDTH, INTERVAL_WIDTH] * n_blocks
    header = [_("Pair"), "mm", _("95 %")] * n_blocks
    yield number_table(header, cells, widths, text_columns=range(0, 3 * n_blocks, 3))
    if len(rows) > len(shown):
        yield note(
            _("The first {shown} of {total} distances; all are in the Excel report.").format(
                shown=len(shown), total=len(rows)
            )
        )
