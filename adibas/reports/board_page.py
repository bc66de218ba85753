"""The calibration board as a PDF to print: exact squares, dots, and rulers that check the printer.

Lengths are millimetres from the page's lower left corner, turned into points for reportlab.
"""

import io
from dataclasses import dataclass
from pathlib import Path

from reportlab.lib.units import mm
from reportlab.pdfbase import pdfmetrics
from reportlab.pdfgen.canvas import Canvas

from adibas.data.board import MARK_RADIUS, Board
from adibas.data.printed_boards import PRINTED_BOARDS, PrintedBoard
from adibas.errors import ReportError
from adibas.files import written_whole
from adibas.reports.fonts import BOLD, REGULAR
from adibas.reports.pdf_layout import prepare_fonts
from adibas.texts import translate as _

QUIET_SQUARES = 0.5
"""White paper around the pattern, in squares; what is printed beside it stays farther away."""
UNPRINTABLE_MM = 5.0
"""Border that most printers leave white."""
WIDEST_STRIP_MM = 24.0
"""Space at the right and below for rulers and text; less where the paper has no more."""
RULER_MM, TICK_MM = 100, 10
LINE_MM = 0.2
SMALLEST_POINTS, LARGEST_POINTS = 5.5, 13.0


@dataclass(frozen=True, slots=True)
class PageLayout:
    """Where the parts of the page are, millimetres from its lower left corner.

    Attributes
    ----------
    width, height : float
        Of the page.
    square : float
        Side of a square.
    left, bottom : float
        Of the pattern, that is of its outer squares.
    strips : (right, below)
        What is free beyond the quiet zone and within what printers print.
    """

    width: float
    height: float
    square: float
    left: float
    bottom: float
    strips: tuple[float, float]


def write_board_pdf(path: Path, size_name: str) -> Board:
    """Write the board of that size as one page of vector graphics, and return it.

    Parameters
    ----------
    path : Path
        Of the PDF.
    size_name : str
        One of `PRINTED_BOARDS`, in any case.

    Raises
    ------
    ReportError
        There is no such size.
    FileError
        The disk is full, or the folder cannot be written.
    """
    printed = _printed_board(size_name)
    prepare_fonts()
    layout = page_layout(printed)
    encoded = io.BytesIO()
    canvas = Canvas(encoded, pagesize=(layout.width * mm, layout.height * mm), invariant=1)
    canvas.setTitle(_("Calibration board {size}").format(size=printed.name))
    canvas.setAuthor("ADiBAS")
    # Printing programs that obey this do not offer to fit the page to the paper.
    canvas.setViewerPreference("PrintScaling", "None")
    _draw_squares(canvas, printed.board, layout)
    _draw_rulers(canvas, layout)
    _write_caption(canvas, printed, layout)
    canvas.showPage()
    canvas.save()
    with written_whole(path) as unfinished:
        unfinished.write_bytes(encoded.getvalue())
    return printed.board


def page_layout(printed: PrintedBoard) -> PageLayout:
    """Return where the parts of the page are: the pattern in the middle of what strips leave."""
    width, height = (1000.0 * side_m for side_m in printed.page_m)
    square = 1000.0 * printed.board.square_m
    across, up = (square * (side + 1) for side in (printed.board.columns, printed.board.rows))
    quiet = QUIET_SQUARES * square
    free_x, free_y = width - across - 2 * quiet, height - up - 2 * quiet
    strip_x, strip_y = min(free_x, WIDEST_STRIP_MM), min(free_y, WIDEST_STRIP_MM)
    return PageLayout(
        width=width,
        height=height,
        square=square,
        left=quiet + 0.5 * (free_x - strip_x),
        bottom=quiet + strip_y + 0.5 * (free_y - strip_y),
        strips=(strip_x - UNPRINTABLE_MM, strip_y - UNPRINTABLE_MM),
    )


def _printed_board(size_name: str) -> PrintedBoard:
    known = {name.casefold(): printed for name, printed in PRINTED_BOARDS.items()}
    printed = known.get(size_name.strip().casefold())
    if printed is None:
        raise ReportError(
            "There is no board of size {size}. Choose one of: {sizes}.",
            size=size_name,
            sizes=", ".join(PRINTED_BOARDS),
        )
    return printed


def _draw_squares(canvas: Canvas, board: Board, layout: PageLayout) -> None:
    side = layout.square
    marked = board.marked_squares()
    for row in range(board.rows + 1):
        for column in range(board.columns + 1):
            left, bottom = layout.left + column * side, layout.bottom + (board.rows - row) * side
            is_dark = board.is_dark(row, column)
            if is_dark:
                canvas.setFillGray(0.0)
                canvas.rect(left * mm, bottom * mm, side * mm, side * mm, stroke=0, fill=1)
            if (row, column) in marked:
                canvas.setFillGray(1.0 if is_dark else 0.0)
                x, y = left + 0.5 * side, bottom + 0.5 * side
                canvas.circle(x * mm, y * mm, MARK_RADIUS * side * mm, stroke=0, fill=1)


def _draw_rulers(canvas: Canvas, layout: PageLayout) -> None:
    """Draw one ruler below and one at the right: a printer may stretch either way."""
    long_tick = min(4.0, 0.5 * layout.strips[1])
    canvas.setStrokeGray(0.0)
    canvas.setLineWidth(LINE_MM * mm)
    canvas.setFillGray(0.0)
    canvas.setFont(REGULAR, _points(layout))
    label = _("{length} mm").format(length=RULER_MM)
    canvas.saveState()
    canvas.translate(layout.left * mm, UNPRINTABLE_MM * mm)
    _draw_ruler(canvas, long_tick, label)
    canvas.restoreState()
    canvas.saveState()
    canvas.translate((layout.width - UNPRINTABLE_MM) * mm, layout.bottom * mm)
    canvas.rotate(90)
    _draw_ruler(canvas, long_tick, label)
    canvas.restoreState()


def _draw_ruler(canvas: Canvas, long_tick: float, label: str) -> None:
    """Draw a ruler from the origin along x, its ticks towards y."""
    canvas.line(0, 0, RULER_MM * mm, 0)
    for at in range(0, RULER_MM + 1, TICK_MM):
        is_long = at % (5 * TICK_MM) == 0
        canvas.line(at * mm, 0, at * mm, (long_tick if is_long else 0.6 * long_tick) * mm)
    canvas.drawString((RULER_MM + 2) * mm, 0, label)


def _write_caption(canvas: Canvas, printed: PrintedBoard, layout: PageLayout) -> None:
    board, points = printed.board, _points(layout)
    what = _(
        "ADiBAS calibration board {size}: {columns} x {rows} inner corners, squares of {side} mm"
    ).format(
        size=printed.name,
        columns=board.columns,
        rows=board.rows,
        side=f"{1000 * board.square_m:g}",
    )
    how = _(
        "Print at 100 % (actual size). Both rulers must measure {length} mm. Glue it to a flat, "
        "stiff plate."
    ).format(length=RULER_MM)
    label = _("{length} mm").format(length=RULER_MM)
    left = layout.left + RULER_MM + 2 + pdfmetrics.stringWidth(label, REGULAR, points) / mm + 6
    room = (layout.width - UNPRINTABLE_MM - 6 - left) * mm
    for text, font, line in ((how, REGULAR, 0), (what, BOLD, 1)):
        size = min(points, points * room / pdfmetrics.stringWidth(text, font, points))
        canvas.setFont(font, size)
        canvas.drawString(left * mm, UNPRINTABLE_MM * mm + 1.2 * line * points, text)


def _points(layout: PageLayout) -> float:
    """Return the size of the text: two lines of it fit into the strip below."""
    fitting = float(layout.strips[1] * mm / 2.4)
    return max(min(fitting, LARGEST_POINTS), SMALLEST_POINTS)
