"""How a worksheet looks and prints: tables, pairs of name and value, pictures, page set-up.

The workbook is write-only, which takes two thirds of the time: what stands at the top of a sheet's
file is said before its first row.
"""

import io
import math
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias

from openpyxl import Workbook
from openpyxl.cell import WriteOnlyCell
from openpyxl.cell.cell import Cell
from openpyxl.drawing.image import Image
from openpyxl.formatting.rule import ColorScale, FormatObject, Rule
from openpyxl.styles import Alignment, Border, Color, Font, PatternFill, Side
from openpyxl.utils import get_column_letter
from openpyxl.worksheet.header_footer import HeaderFooterItem, _HeaderFooterPart
from openpyxl.worksheet.pagebreak import Break
from openpyxl.worksheet.properties import PageSetupProperties
from PIL import Image as PillowImage

from adibas.arrays import UInt8Array
from adibas.reports.cells import neutralised

Value: TypeAlias = str | float | None
Sheet: TypeAlias = Any
"""A WriteOnlyWorksheet; the published types lack most of what it takes."""

BLUE, WHITE = "1F4E79", "FFFFFF"
SHADE, NEGATIVE_SHADE = "8DB4DC", "F2B97F"
HEADER_FONT = Font(bold=True, color="FFFFFF")
HEADER_FILL = PatternFill("solid", fgColor=BLUE)
TITLE_FONT = Font(bold=True, size=16, color=BLUE)
PART_FONT = Font(bold=True, size=13, color=BLUE)
NAME_FONT = Font(bold=True)
LINE = Border(bottom=Side(style="hair", color="A6A6A6"))
TOP = Alignment(wrap_text=True, vertical="top")
WRAPPED = Alignment(wrap_text=True, horizontal="left", vertical="top")
PAIR_WIDTHS = (44, 84)
MOST_PORTRAIT_COLUMNS = 8
MOST_ROWS = 1_048_575
"""Below the header of one sheet; Excel has one row more."""
TEXT_FORMAT = "General"

HEADER_HEIGHT = 32
"""Points: two lines."""
LINE_HEIGHT = 15
"""Points: one line. Not every program makes a row as high as its text needs."""
LETTER_WIDTH = 1.05
"""Of a letter on average, in widths of a column, with room for wide fonts."""
ROW_PX = 20
"""Height of a row that nothing has changed."""
JPEG_QUALITY = 90


@dataclass(frozen=True, slots=True)
class Column:
    """One column of a table; without a number format it holds text."""

    title: str
    width: float
    number_format: str = TEXT_FORMAT


@dataclass(frozen=True, slots=True, eq=False)
class Part:
    """Lines of name and value under a heading, and a picture under them."""

    heading: str
    pairs: Sequence[tuple[str, Value]]
    picture_rgb: UInt8Array | None = None
    number_format: str = "General"
    """Of values with a fraction."""


@dataclass(frozen=True, slots=True, eq=False)
class Block:
    """One of several tables of a sheet; the cells of a map are coloured by their value.

    The first column of a map holds the names of its rows. In a signed map 0 is white.
    """

    heading: str
    columns: Sequence[Column]
    rows: Sequence[Sequence[Value]]
    is_map: bool = False
    is_signed: bool = False


def add_table(
    workbook: Workbook,
    title: str,
    columns: Sequence[Column],
    rows: Sequence[Sequence[Value]],
    footer: str,
) -> None:
    """Add a sheet with a table: frozen header, filter, header repeated on every page.

    What exceeds the rows of a sheet goes on in a second one.
    """
    for number, first in enumerate(range(0, max(len(rows), 1), MOST_ROWS), 1):
        name = title if number == 1 else f"{title} ({number})"
        some = rows[first : first + MOST_ROWS]
        sheet = _new_sheet(workbook, name, [column.width for column in columns], footer)
        sheet.row_dimensions[1].height = HEADER_HEIGHT
        sheet.freeze_panes = "A2"
        sheet.auto_filter.ref = f"A1:{get_column_letter(len(columns))}{len(some) + 1}"
        sheet.print_title_rows = "1:1"
        sheet.append([_header_cell(sheet, column) for column in columns])
        # A cell is written at once: one for each column serves all rows.
        cells = [WriteOnlyCell(sheet) for _column in columns]
        for cell, column in zip(cells, columns, strict=True):
            cell.number_format = column.number_format
        for row in some:
            sheet.append([_filled(cell, value) for cell, value in zip(cells, row, strict=True)])


def add_parts(
    workbook: Workbook, sheet_title: str, title: str, parts: Sequence[Part], footer: str
) -> None:
    """Add a sheet with a title and the parts below each other.

    A part without heading follows the title at once; later pictures begin new pages.
    """
    sheet = _new_sheet(workbook, sheet_title, PAIR_WIDTHS, footer)
    sheet.freeze_panes = "A3"
    sheet.append([_styled(sheet, title, TITLE_FONT)])
    sheet.append([])
    n_rows = 2
    has_picture = False
    for part in parts:
        if part.heading:
            if has_picture:
                sheet.row_breaks.append(Break(id=n_rows))
            sheet.append([_styled(sheet, part.heading, PART_FONT)])
            n_rows += 1
        for row, (name, value) in enumerate(part.pairs, n_rows + 1):
            n_lines = _lines_of(name, value)
            if n_lines > 1:
                sheet.row_dimensions[row].height = LINE_HEIGHT * n_lines
            sheet.append(_pair(sheet, name, value, part.number_format))
        sheet.append([])
        n_rows += len(part.pairs) + 1
        if part.picture_rgb is not None:
            sheet.add_image(_image(part.picture_rgb), f"A{n_rows + 1}")
            reserved = -(-part.picture_rgb.shape[0] // ROW_PX) + 1
            for _row in range(reserved):
                sheet.append([])
            n_rows += reserved
            has_picture = True


def add_blocks(
    workbook: Workbook, sheet_title: str, title: str, blocks: Sequence[Block], footer: str
) -> None:
    """Add a sheet with a title and tables below each other."""
    n_columns = max(len(block.columns) for block in blocks)
    widths = [
        max(block.columns[at].width for block in blocks if at < len(block.columns))
        for at in range(n_columns)
    ]
    sheet = _new_sheet(workbook, sheet_title, widths, footer)
    sheet.freeze_panes = "A3"
    sheet.append([_styled(sheet, title, TITLE_FONT)])
    sheet.append([])
    n_rows = 2
    for block in blocks:
        sheet.append([_styled(sheet, block.heading, PART_FONT)])
        if not block.is_map:
            sheet.row_dimensions[n_rows + 2].height = HEADER_HEIGHT
        sheet.append([_header_cell(sheet, column) for column in block.columns])
        for row in block.rows:
            sheet.append(_block_row(sheet, block, row))
        if block.is_map and block.rows:
            last = f"{get_column_letter(len(block.columns))}{n_rows + 2 + len(block.rows)}"
            sheet.conditional_formatting.add(
                f"B{n_rows + 3}:{last}", _shades(is_signed=block.is_signed)
            )
        sheet.append([])
        n_rows += len(block.rows) + 3


def _lines_of(name: str, value: Value) -> int:
    """Return how many lines a pair needs."""
    texts = (name, value if isinstance(value, str) else "")
    return max(
        sum(max(1, math.ceil(LETTER_WIDTH * len(line) / width)) for line in text.splitlines())
        for text, width in zip(texts, PAIR_WIDTHS, strict=True)
    )


def discard_unsaved(workbook: Workbook) -> None:
    """Leave nothing of a workbook whose writing failed; one that is saved has nothing left.

    openpyxl keeps each sheet in a temporary file, and would complain of a full disk once more
    when it forgets the sheet.
    """
    sheets: Sequence[Sheet] = workbook.worksheets
    for sheet in sheets:
        writer = getattr(sheet, "_writer", None)
        if writer is not None:
            for unfinished in (sheet._rows, writer.xf):  # noqa: SLF001  (nothing public)
                with suppress(OSError, AttributeError):  # disk full; no row was written
                    unfinished.close()
            Path(writer.out).unlink(missing_ok=True)


def _new_sheet(workbook: Workbook, title: str, widths: Sequence[float], footer: str) -> Sheet:
    """Add a sheet that prints on A4, as wide as the page, with page numbers."""
    sheet: Sheet = workbook.create_sheet(title)
    for index, width in enumerate(widths, 1):
        sheet.column_dimensions[get_column_letter(index)].width = width
    sheet.page_setup.paperSize = 9  # A4
    is_wide = len(widths) > MOST_PORTRAIT_COLUMNS
    sheet.page_setup.orientation = "landscape" if is_wide else "portrait"
    sheet.page_setup.fitToWidth = 1
    sheet.page_setup.fitToHeight = 0
    sheet.sheet_properties.pageSetUpPr = PageSetupProperties(fitToPage=True)
    sheet.print_options.horizontalCentered = True
    sheet.HeaderFooter.oddFooter = HeaderFooterItem(
        left=_HeaderFooterPart(f"ADiBAS. {footer}"),
        center=_HeaderFooterPart(),
        right=_HeaderFooterPart("&P / &N"),
    )
    return sheet


def _filled(cell: Cell, value: Value) -> Cell | str | None:
    """Return a cell with the value, or the value alone where that is quicker and the same."""
    if value is None:
        return None
    if isinstance(value, str) and not value.startswith("#"):  # such as #N/A: an error value
        return neutralised(value)
    _fill(cell, value)
    return cell


def _fill(cell: Cell, value: Value) -> None:
    """Set a value; text is always text, never a formula or an error."""
    if isinstance(value, str):
        cell.value = neutralised(value)
        cell.data_type = "s"
    else:
        cell.value = value


def _styled(sheet: Sheet, value: Value, font: Font | None = None) -> Cell:
    cell: Cell = WriteOnlyCell(sheet)
    _fill(cell, value)
    if font is not None:
        cell.font = font
    return cell


def _header_cell(sheet: Sheet, column: Column) -> Cell:
    """Return the title of a column, on the side on which its values stand."""
    cell = _styled(sheet, column.title, HEADER_FONT)
    cell.fill = HEADER_FILL
    side = "left" if column.number_format == TEXT_FORMAT else "right"
    cell.alignment = Alignment(wrap_text=True, horizontal=side, vertical="center")
    return cell


def _pair(sheet: Sheet, name: str, value: Value, number_format: str) -> list[Cell]:
    name_cell, value_cell = _styled(sheet, name, NAME_FONT), _styled(sheet, value)
    if isinstance(value, float):
        value_cell.number_format = number_format
    name_cell.alignment, value_cell.alignment = TOP, WRAPPED
    name_cell.border = value_cell.border = LINE
    return [name_cell, value_cell]


def _block_row(sheet: Sheet, block: Block, row: Sequence[Value]) -> list[Cell]:
    cells = [_styled(sheet, value) for value in row]
    for cell, column in zip(cells, block.columns, strict=True):
        cell.number_format = column.number_format
        cell.border = LINE
    if block.is_map:
        cells[0].font = NAME_FONT
    return cells


def _shades(*, is_signed: bool) -> Rule:
    """Return white for the least value, or for 0, and more colour the farther from that."""
    limits = [FormatObject(type="min"), FormatObject(type="max")]
    colors = [WHITE, SHADE]
    if is_signed:
        limits.insert(1, FormatObject(type="num", val=0))
        colors.insert(0, NEGATIVE_SHADE)
    scale = ColorScale(cfvo=limits, color=[Color(rgb=f"FF{color}") for color in colors])
    return Rule(type="colorScale", colorScale=scale)


def _image(picture_rgb: UInt8Array) -> Image:
    encoded = io.BytesIO()
    picture = PillowImage.fromarray(picture_rgb)
    picture.save(encoded, format="JPEG", quality=JPEG_QUALITY, subsampling=0)
    return Image(encoded)
