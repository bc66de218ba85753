"""The pages of one view in the PDF report."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from reportlab.lib.units import mm
from reportlab.platypus import Flowable, Spacer, Table, TableStyle

from adibas.arrays import UInt8Array
from adibas.data.landmark_texts import landmark_text
from adibas.data.protocol_measures import INSTRUMENT_ONLY
from adibas.data.report import CaptureReport
from adibas.reports.pdf_layout import (
    SMALL_TEXT,
    WIDTH,
    note,
    number_table,
    paragraph,
    picture,
    text_width,
    title,
)
from adibas.reports.plots import marker_plot
from adibas.reports.rows import (
    MarkerRow,
    NumberRow,
    distance_rows,
    free_rows,
    marker_rows,
    measure_rows,
    names_line,
)
from adibas.texts import decimal_text, translate_plural
from adibas.texts import translate as _

DASH = "\N{EN DASH}"
MOST_PAIRS = 435
"""Of 30 markers; more would fill page after page."""
MOST_MEASURES = 60
MOST_LINES_BESIDE = 26
"""That the tables beside the picture have room for."""
LABEL_SHARE_BESIDE = 0.2
PICTURE_HEIGHT = 114 * mm
LEAST_PLOT_HEIGHT = 46 * mm
MOST_PICTURE_SHARE = 0.46
NUMBER_WIDTH, INTERVAL_WIDTH = 36, 78
GAP = 8
MOST_BLOCKS = 3


@dataclass(frozen=True, slots=True, eq=False)
class ViewPage:
    """One view.

    Attributes
    ----------
    name : str
    capture : CaptureReport
    picture_rgb : (H, W, 3) uint8 array
        Upright, with the markers drawn.
    rotation_deg : int
        How far the camera's picture was turned clockwise for it.
    """

    name: str
    capture: CaptureReport
    picture_rgb: UInt8Array
    rotation_deg: int


def view_flowables(page: ViewPage) -> Iterator[Flowable]:
    """Yield what stands on the pages of a view, in its order."""
    rows = list(marker_rows(page.capture.analysis))
    n_lines = len(rows) + len(page.capture.measures)
    yield title(page.name)
    if n_lines <= MOST_LINES_BESIDE and _label_width(rows) < LABEL_SHARE_BESIDE * WIDTH:
        yield _side_by_side(page, rows)
    else:
        yield picture(page.picture_rgb, WIDTH, PICTURE_HEIGHT)
        yield Spacer(1, GAP)
        yield from _markers(page.capture, rows, WIDTH)
        yield from _free_measures(page.capture, WIDTH)
    names = names_line(page.capture.analysis)
    if names:
        yield note(names)
    yield from _measures(page.capture)
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
    right = WIDTH - left
    style = [
        ("VALIGN", (0, 0), (-1, -1), "TOP"),
        ("LEFTPADDING", (0, 0), (-1, -1), 0),
        ("RIGHTPADDING", (0, 0), (-1, -1), 0),
        ("TOPPADDING", (0, 0), (-1, -1), 4),
    ]
    tables = [*_markers(page.capture, rows, right), *_free_measures(page.capture, right)]
    used = sum(table.wrap(right, PICTURE_HEIGHT)[1] for table in tables)
    room = PICTURE_HEIGHT - used - GAP
    plot = None
    if room >= LEAST_PLOT_HEIGHT:
        plot = marker_plot(page.capture, right, room, page.rotation_deg)
    if plot is not None:
        tables.append(picture(plot, right, room))
    return Table([[shown, tables]], [left, right], style=TableStyle(style), hAlign="LEFT")


def _label_width(rows: list[MarkerRow]) -> float:
    names = [_("Marker"), *(f"{landmark_text(row.label)} *" for row in rows)]
    return max(text_width(name) for name in names) + 10


def _markers(capture: CaptureReport, rows: list[MarkerRow], width: float) -> Iterator[Flowable]:
    missing = [DASH] * 3
    cells = []
    for row in rows:
        mark = " *" if row.label in capture.placed_by_hand else ""
        place = [decimal_text(value, 1) for value in row.position_mm or ()] or missing
        deviation = [decimal_text(value, 1) for value in row.deviation_mm or ()] or missing
        cells.append([f"{landmark_text(row.label)}{mark}", *place, *deviation])
    header = [_("Marker"), "x [mm]", "y [mm]", "z [mm]"]
    header += [_("sd {axis} [mm]").format(axis=axis) for axis in "xyz"]
    name_width = max(_label_width(rows), 0.16 * width)
    widths = [name_width, *[(width - name_width) / 6] * 6]
    yield number_table(header, cells, widths, text_columns=(0,))
    if capture.placed_by_hand:
        yield note(_("* corrected by hand"))
    if any(row.position_mm is None for row in rows):
        yield note(_("Where no position stands, the depth gives none (orange ring)."))


def _free_measures(capture: CaptureReport, width: float) -> Iterator[Flowable]:
    if not capture.measures:
        return
    yield title(_("Free measures"), level=2)
    cells = []
    for row in free_rows(capture):
        name = f" {DASH} ".join(landmark_text(one) for one in (row.a, row.vertex, row.c) if one)
        value, interval = _numbers(row.value, row.low, row.high)
        unit = _("deg") if row.vertex else "mm"
        cells.append([paragraph(name, SMALL_TEXT), f"{value} {unit}", interval])
    header = [_("Measure"), _("Value"), _("95 %, instrument only")]
    widths = [0.42 * width, 0.2 * width, 0.38 * width]
    yield number_table(header, cells, widths, text_columns=(0,))


def _measures(capture: CaptureReport) -> Iterator[Flowable]:
    """Yield the table of the protocol's measures, and who found the values of others."""
    rows = list(measure_rows(capture.analysis))
    if not rows or capture.analysis.measures is None:
        return
    protocol = capture.analysis.measures.protocol
    yield title(_("Measures of {protocol}").format(protocol=protocol.title.text), level=2)
    yield note(_(INSTRUMENT_ONLY))
    shown = rows[:MOST_MEASURES]
    cells: list[list[str | Flowable]] = []
    for row in shown:
        name = f"{row.name} ({row.measure_id})"
        told = "; ".join(text for text in (row.main and row.positive, row.remark) if text)
        value, interval = measured(row.main, row.unit)
        other = row.projected if row.main is row.spatial else row.spatial
        beside, _interval = measured(other, row.unit)
        cells.append(
            [paragraph(name, SMALL_TEXT), value, interval, beside, paragraph(told, SMALL_TEXT)]
        )
    is_spatial = all(one.definition.is_spatial for one in capture.analysis.measures.results)
    other_name = _("In the plane") if is_spatial else _("In space")
    header = [_("Measure"), _("Value"), _("95 %"), other_name, _("Positive means")]
    widths = [share * WIDTH for share in (0.36, 0.11, 0.15, 0.11, 0.27)]
    yield number_table(header, cells, widths, text_columns=(0, 4))
    ids_of: dict[str, list[str]] = {}
    for row in shown:
        if row.reference:
            ids_of.setdefault(row.reference, []).append(row.measure_id)
    for reference, ids in ids_of.items():
        yield note(f"{', '.join(ids)}: {reference}")
    yield from shown_of(rows)


def shown_of(rows: Sequence[object]) -> Iterator[Flowable]:
    """Say of a table how many of its rows are shown, where they are too many."""
    if len(rows) > MOST_MEASURES:
        yield note(
            _("The first {shown} of {total} measures; all are in the Excel report.").format(
                shown=MOST_MEASURES, total=len(rows)
            )
        )


def measured(row: NumberRow | None, unit: str) -> tuple[str, str]:
    """Return a value with its unit, and its interval; dashes where there is none."""
    if row is None:
        return DASH, DASH
    value, interval = _numbers(row.value, row.low, row.high)
    return f"{value} {_(unit)}", interval


def _numbers(value: float | None, low: float | None, high: float | None) -> tuple[str, str]:
    if value is None or low is None or high is None:
        return DASH, DASH
    return decimal_text(value, 1), f"{decimal_text(low, 1)} {DASH} {decimal_text(high, 1)}"


def _distances(capture: CaptureReport) -> Iterator[Flowable]:
    """Yield the table of all pairs, several of them in a line."""
    rows = list(distance_rows(capture.analysis.distances))
    yield title(_("Distances [mm], with the interval of 95 %, instrument only"), level=2)
    if not rows:
        yield note(_("No two markers have a position."))
        return
    shown = rows[:MOST_PAIRS]
    names = [f"{landmark_text(row.a)} {DASH} {landmark_text(row.b)}" for row in shown]
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
    name_width = WIDTH / n_blocks - NUMBER_WIDTH - INTERVAL_WIDTH
    widths = [name_width, NUMBER_WIDTH, INTERVAL_WIDTH] * n_blocks
    header = [_("Pair"), "mm", _("95 %")] * n_blocks
    yield number_table(header, cells, widths, text_columns=range(0, 3 * n_blocks, 3))
    if len(rows) > len(shown):
        yield note(
            _("The first {shown} of {total} distances; all are in the Excel report.").format(
                shown=len(shown), total=len(rows)
            )
        )
