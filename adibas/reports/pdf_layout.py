"""How a PDF report looks: fonts, headings, tables, footer."""

import io
import textwrap
from collections.abc import Sequence
from functools import cache
from typing import Any
from xml.sax.saxutils import escape

from PIL import Image as PillowImage
from reportlab.lib.colors import HexColor, white
from reportlab.lib.enums import TA_CENTER
from reportlab.lib.pagesizes import A4
from reportlab.lib.styles import ParagraphStyle
from reportlab.lib.units import mm
from reportlab.pdfbase import pdfmetrics
from reportlab.pdfbase.ttfonts import TTFont
from reportlab.pdfgen.canvas import Canvas
from reportlab.platypus import Flowable, Image, Paragraph, Table, TableStyle

from adibas.arrays import UInt8Array
from adibas.files import printable
from adibas.reports.fonts import BOLD, REGULAR, font_path

MARGIN = 16 * mm
WIDTH = A4[0] - 2 * MARGIN
BLUE, GREY, PALE = HexColor(0x1F4E79), HexColor(0x5F6B76), HexColor(0xEEF2F6)
SMALL, NORMAL = 7.0, 8.5
LEFT_PADDING, RIGHT_PADDING = 3.0, 5.0
"""Of the cells of a table of numbers."""
NAME_SHARE = 0.3
ROW_HEIGHT_MM = 62
JPEG_QUALITY = 88
LONGEST_LINE, MOST_LINES = 400, 5
"""Characters and lines that a row of a table holds: half a page at most."""

TITLE = ParagraphStyle("title", fontName=BOLD, fontSize=18, leading=24, textColor=BLUE)
HEADING = ParagraphStyle(
    "heading", fontName=BOLD, fontSize=11, leading=15, textColor=BLUE, spaceBefore=8, spaceAfter=3
)
TEXT = ParagraphStyle("text", fontName=REGULAR, fontSize=NORMAL, leading=11.5)
NAME = ParagraphStyle("name", parent=TEXT, fontName=BOLD)
SMALL_TEXT = ParagraphStyle("small", parent=TEXT, fontSize=SMALL, leading=9)
SMALL_NAME = ParagraphStyle("small name", parent=SMALL_TEXT, fontName=BOLD, textColor=BLUE)
NOTE = ParagraphStyle("note", parent=TEXT, fontSize=7.5, leading=10, textColor=GREY, spaceBefore=5)
CAPTION = ParagraphStyle("caption", parent=NOTE, alignment=TA_CENTER, spaceBefore=0)


@cache
def prepare_fonts() -> None:
    """Make the two fonts known to reportlab."""
    for name in (REGULAR, BOLD):
        pdfmetrics.registerFont(TTFont(name, font_path(name)))


def text_width(text: str, size: float = SMALL, font: str = REGULAR) -> float:
    """Return the width of a line of text, points."""
    width: float = pdfmetrics.stringWidth(text, font, size)
    return width


def paragraph(text: str, style: ParagraphStyle) -> Flowable:
    """Return text that is broken into lines; it is no mark-up."""
    return Paragraph(escape(printable(text)).replace("\n", "<br/>"), style)


def title(text: str, level: int = 1) -> Flowable:
    """Return a heading of the first or second level."""
    return paragraph(text[:1].upper() + text[1:], TITLE if level == 1 else HEADING)


def note(text: str) -> Flowable:
    """Return a remark in small print."""
    return paragraph(text, NOTE)


def facts_table(pairs: Sequence[tuple[str, str | float]]) -> Flowable:
    """Return lines of name and value; a long value has several, so that pages can break it."""
    cells = [
        [paragraph("" if number else name, NAME), paragraph(piece, TEXT)]
        for name, value in pairs
        for number, piece in enumerate(_pieces(str(value)))
    ]
    style = [
        ("VALIGN", (0, 0), (-1, -1), "TOP"),
        ("LEFTPADDING", (0, 0), (-1, -1), 0),
        ("TOPPADDING", (0, 0), (-1, -1), 1.5),
        ("BOTTOMPADDING", (0, 0), (-1, -1), 1.5),
        ("LINEBELOW", (0, 0), (-1, -1), 0.25, PALE),
    ]
    return Table(cells, [NAME_SHARE * WIDTH, (1 - NAME_SHARE) * WIDTH], style=TableStyle(style))


def _pieces(text: str) -> list[str]:
    """Return the text in pieces of a few lines each: no row of a table is broken by a page."""
    lines = [
        part
        for line in text.split("\n")
        for part in textwrap.wrap(line, LONGEST_LINE, drop_whitespace=False) or [""]
    ]
    groups = range(0, len(lines), MOST_LINES)
    return ["\n".join(lines[first : first + MOST_LINES]) for first in groups]


def wrapped_table(header: Sequence[str], rows: Sequence[Sequence[str]]) -> Flowable:
    """Return a table as wide as the page, whose cells are broken into lines."""
    cells = [[paragraph(name, SMALL_NAME) for name in header]]
    cells += [[paragraph(cell, SMALL_TEXT) for cell in row] for row in rows]
    style = [
        ("BACKGROUND", (0, 0), (-1, 0), PALE),
        ("VALIGN", (0, 0), (-1, -1), "TOP"),
        ("LINEBELOW", (0, 0), (-1, -1), 0.25, PALE),
        ("LEFTPADDING", (0, 0), (-1, -1), 3),
        ("RIGHTPADDING", (0, 0), (-1, -1), 3),
        ("TOPPADDING", (0, 0), (-1, -1), 2),
        ("BOTTOMPADDING", (0, 0), (-1, -1), 3),
    ]
    return Table(cells, [WIDTH / len(header)] * len(header), style=TableStyle(style), repeatRows=1)


def number_table(
    header: Sequence[str],
    rows: Sequence[Sequence[str | Flowable]],
    widths: Sequence[float],
    *,
    text_columns: Sequence[int],
) -> Flowable:
    """Return a table of small print; the columns that are no text are aligned as numbers.

    The header comes again where the table goes on on a new page; what is wider than its column is
    broken into lines.
    """
    named = [_broken(printable(name), width) for name, width in zip(header, widths, strict=True)]
    cells = [
        named,
        *([printable(cell) if isinstance(cell, str) else cell for cell in row] for row in rows),
    ]
    style: list[tuple[Any, ...]] = [
        ("FONT", (0, 0), (-1, -1), REGULAR, SMALL, SMALL + 1.5),
        ("FONT", (0, 0), (-1, 0), BOLD, SMALL, SMALL + 1.5),
        ("TEXTCOLOR", (0, 0), (-1, 0), white),
        ("BACKGROUND", (0, 0), (-1, 0), BLUE),
        ("ROWBACKGROUNDS", (0, 1), (-1, -1), (white, PALE)),
        ("ALIGN", (0, 0), (-1, -1), "RIGHT"),
        *(("ALIGN", (column, 0), (column, -1), "LEFT") for column in text_columns),
        ("VALIGN", (0, 0), (-1, -1), "MIDDLE"),
        ("TOPPADDING", (0, 0), (-1, -1), 1),
        ("BOTTOMPADDING", (0, 0), (-1, -1), 2),
        ("LEFTPADDING", (0, 0), (-1, -1), LEFT_PADDING),
        ("RIGHTPADDING", (0, 0), (-1, -1), RIGHT_PADDING),
    ]
    return Table(cells, widths, style=TableStyle(style), repeatRows=1, hAlign="LEFT")


def _broken(name: str, width: float) -> str:
    """Return the name of a column in lines that fit it; words are not parted."""
    room = width - LEFT_PADDING - RIGHT_PADDING
    lines: list[str] = []
    for word in name.split(" "):
        longer = f"{lines[-1]} {word}" if lines else word
        if lines and text_width(longer, SMALL, BOLD) <= room:
            lines[-1] = longer
        else:
            lines.append(word)
    return "\n".join(lines)


def picture(pixels_rgb: UInt8Array, width: float, height: float) -> Flowable:
    """Return a picture as large as the box (points) allows."""
    encoded = io.BytesIO()
    PillowImage.fromarray(pixels_rgb).save(encoded, format="JPEG", quality=JPEG_QUALITY)
    rows, columns = pixels_rgb.shape[:2]
    scale = min(width / columns, height / rows)
    return Image(encoded, columns * scale, rows * scale)


def picture_row(pictures: Sequence[tuple[str, UInt8Array]]) -> Flowable:
    """Return small pictures side by side, four in a row, each with its name."""
    n_columns = min(len(pictures), 4)
    width = WIDTH / n_columns
    cells: list[list[Flowable]] = []
    for first in range(0, len(pictures), n_columns):
        some = pictures[first : first + n_columns]
        padding = [""] * (n_columns - len(some))
        row = [picture(pixels, width - 6, ROW_HEIGHT_MM * mm) for _name, pixels in some]
        cells += [[*row, *padding], [*(paragraph(name, CAPTION) for name, _p in some), *padding]]
    style = [("ALIGN", (0, 0), (-1, -1), "CENTER"), ("VALIGN", (0, 0), (-1, -1), "BOTTOM")]
    return Table(cells, [width] * n_columns, style=TableStyle(style))


class FooterCanvas(Canvas):  # type: ignore[misc]  # reportlab has no types
    """Writes a footer under every page once their number is known."""

    def __init__(self, *args: Any, lines: tuple[str, str], page_text: str, **options: Any) -> None:
        super().__init__(*args, **options)
        self._lines = lines
        self._page_text = page_text
        self._finished_pages: list[dict[str, Any]] = []

    def showPage(self) -> None:  # noqa: N802  (reportlab's name)
        """Keep the page until the last one is known."""
        self._finished_pages.append(dict(self.__dict__))
        self._startPage()

    def save(self) -> None:
        """Write all pages with their footers."""
        total = len(self._finished_pages)
        for number, state in enumerate(self._finished_pages, 1):
            self.__dict__.update(state)
            self._draw_footer(self._page_text.format(page=number, total=total))
            super().showPage()
        super().save()

    def _draw_footer(self, page: str) -> None:
        self.setStrokeColor(PALE)
        self.line(MARGIN, MARGIN + 22, MARGIN + WIDTH, MARGIN + 22)
        self.setFillColor(GREY)
        self.setFont(REGULAR, SMALL)
        for line, height in zip(self._lines, (11, 0), strict=True):
            self.drawString(MARGIN, MARGIN + height, printable(line))
        self.drawRightString(MARGIN + WIDTH, MARGIN + 11, page)
