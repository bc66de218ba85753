"""The PDF report of a movement: ranges and symmetry, and a page each of angles and speeds."""

from collections.abc import Iterator
from pathlib import Path

from reportlab.platypus import Flowable, PageBreak

from adibas.data.movement import Movement
from adibas.reports.facts import intended_use
from adibas.reports.movement_facts import general_facts, movement_facts
from adibas.reports.movement_plots import SPEED, movement_figure
from adibas.reports.movement_rows import RangeRow, range_rows, symmetry_rows
from adibas.reports.pdf_document import write_document
from adibas.reports.pdf_layout import WIDTH, facts_table, note, number_table, title
from adibas.reports.vector_figures import FigureFlowable
from adibas.texts import decimal_text, message
from adibas.texts import translate as _

HEADING = message("Movement report")
NOISE = message(
    "Fastest: no value where it is not told from noise, which alone would show as much in more "
    "than 1 of 100 recordings of this length."
)
PLOTS_HEIGHT = 620.0
NAME_WIDTH = 190.0


def write_movement_pdf(movement: Movement, path: Path, language: str) -> None:
    """Write facts, ranges, symmetry and plots.

    Raises
    ------
    FileError
        The disk is full, or the folder cannot be written.
    """
    version = movement.provenance.version
    write_document(
        path,
        language,
        version,
        HEADING,
        lambda: (_story(movement), (intended_use(), f"ADiBAS {version}")),
    )


def _story(movement: Movement) -> Iterator[Flowable]:
    yield title(_(HEADING))
    yield facts_table([*movement_facts(movement), *general_facts(movement)])
    yield title(_("Ranges of movement"), level=2)
    yield _ranges(movement)
    if any(found.is_speed_noise for found in movement.ranges):
        yield note(_(NOISE))
    if movement.symmetries:
        yield title(_("Symmetry"), level=2)
        yield _symmetry(movement)
        yield note(
            _(
                "Symmetry index: right minus left over their mean (Robinson, Herzog & Nigg 1987); "
                "no value where neither side moved enough to compare."
            )
        )
    yield PageBreak()
    yield title(_("Angles over time"), level=2)
    yield FigureFlowable(movement_figure(movement, WIDTH, PLOTS_HEIGHT))
    yield PageBreak()
    yield title(_("Speeds over time"), level=2)
    yield FigureFlowable(movement_figure(movement, WIDTH, PLOTS_HEIGHT, SPEED))
    yield note(_("Grey: as fast as noise alone shows in 1 of 100 recordings of this length."))


def _ranges(movement: Movement) -> Flowable:
    header = [
        _("Joint angle"),
        _("Least [°]"),
        _("Greatest [°]"),
        _("Range [°]"),
        "± [°]",
        _("Fastest [°/s]"),
        _("Seen [%]"),
    ]
    rows = [
        [
            row.angle,
            decimal_text(row.least_deg, 1),
            decimal_text(row.greatest_deg, 1),
            decimal_text(row.range_deg, 1),
            _text(row.sure_deg, 2),
            _fastest(row),
            decimal_text(row.seen_percent, 0),
        ]
        for row in range_rows(movement)
    ]
    return _table(header, rows)


def _symmetry(movement: Movement) -> Flowable:
    header = [
        _("Joint angle"),
        _("Range left [°]"),
        _("Range right [°]"),
        _("Right minus left [°]"),
        _("Symmetry index [%]"),
    ]
    rows = [
        [
            row.motion,
            decimal_text(row.left_deg, 1),
            decimal_text(row.right_deg, 1),
            decimal_text(row.difference_deg, 1),
            _text(row.index_percent, 0),
        ]
        for row in symmetry_rows(movement)
    ]
    return _table(header, rows)


def _table(header: list[str], rows: list[list[str]]) -> Flowable:
    width = (WIDTH - NAME_WIDTH) / (len(header) - 1)
    widths = [NAME_WIDTH, *[width] * (len(header) - 1)]
    return number_table(header, rows, widths, text_columns=(0,))


def _fastest(row: RangeRow) -> str:
    known = [_text(value, 0) for value in (row.fastest_deg_s, row.sure_deg_s) if value is not None]
    return "" if row.fastest_deg_s is None else " ± ".join(known)


def _text(value: float | None, n_decimals: int) -> str:
    return "" if value is None else decimal_text(value, n_decimals)
