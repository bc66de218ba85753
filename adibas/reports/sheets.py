"""How a worksheet looks and prints: tables, pairs of name and value, page set-up."""

from collections.abc import Sequence
from dataclasses import dataclass

from openpyxl.cell.cell import Cell
from openpyxl.styles import Alignment, Border, Font, PatternFill, Side
from openpyxl.utils import get_column_letter
from openpyxl.worksheet.header_footer import HeaderFooterItem, _HeaderFooterPart
from openpyxl.worksheet.properties import PageSetupProperties
from openpyxl.worksheet.worksheet import Worksheet

from adibas.reports.cells import neutralised

Value = str | float | None

HEADER_FONT = Font(bold=True, color="FFFFFF")
HEADER_FILL = PatternFill("solid", fgColor="1F4E79")
TITLE_FONT = Font(bold=True, size=16, color="1F4E79")
NAME_FONT = Font(bold=True)
LINE = Border(bottom=Side(style="hair", color="A6A6A6"))
NAME_WIDTH = 44
VALUE_WIDTH = 84
MOST_PORTRAIT_COLUMNS = 8
HEADER_HEIGHT = 32
"""Points: two lines."""


@dataclass(frozen=True, slots=True)
class Column:
    """One column of a table; without a number format it holds text."""

    title: str
    width: float
    number_format: str = "General"


def add_table(sheet: Worksheet, columns: Sequence[Column], rows: Sequence[Sequence[Value]]) -> None:
    """Fill an empty sheet with a table: frozen header, filter, header repeated on every page."""
    for index, column in enumerate(columns, 1):
        cell = _put(sheet, 1, index, column.title)
        cell.font, cell.fill = HEADER_FONT, HEADER_FILL
        cell.alignment = Alignment(wrap_text=True, vertical="center")
        sheet.column_dimensions[get_column_letter(index)].width = column.width
    sheet.row_dimensions[1].height = HEADER_HEIGHT
    for row_number, row in enumerate(rows, 2):
        for index, (column, value) in enumerate(zip(columns, row, strict=True), 1):
            _put(sheet, row_number, index, value).number_format = column.number_format
    sheet.freeze_panes = "A2"
    sheet.auto_filter.ref = f"A1:{get_column_letter(len(columns))}{len(rows) + 1}"
    sheet.print_title_rows = "1:1"


def add_pairs(sheet: Worksheet, title: str, pairs: Sequence[tuple[str, Value]]) -> None:
    """Fill an empty sheet with a title and one line for each name and value."""
    _put(sheet, 1, 1, title).font = TITLE_FONT
    for row_number, (name, value) in enumerate(pairs, 3):
        name_cell = _put(sheet, row_number, 1, name)
        value_cell = _put(sheet, row_number, 2, value)
        name_cell.font = NAME_FONT
        name_cell.alignment = Alignment(vertical="top")
        value_cell.alignment = Alignment(wrap_text=True, horizontal="left", vertical="top")
        name_cell.border = value_cell.border = LINE
    sheet.column_dimensions["A"].width = NAME_WIDTH
    sheet.column_dimensions["B"].width = VALUE_WIDTH
    sheet.freeze_panes = "A3"


def prepare_page(sheet: Worksheet, footer: str) -> None:
    """Print on A4, as wide as the page, with page numbers."""
    sheet.page_setup.paperSize = sheet.PAPERSIZE_A4
    is_wide = sheet.max_column > MOST_PORTRAIT_COLUMNS
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


def _put(sheet: Worksheet, row: int, column: int, value: Value) -> Cell:
    """Set a value and return its cell; text is always text, never a formula."""
    cell = sheet.cell(row, column)
    if not isinstance(cell, Cell):
        raise TypeError("reports merge no cells")
    if isinstance(value, str):
        cell.value = neutralised(value)
        cell.data_type = "s"
    else:
        cell.value = value
    return cell
