"""Tables of numbers in PDF reports: the names of columns stay within their columns."""

import io
import itertools

import pytest
from pypdf import PdfReader
from reportlab.platypus import SimpleDocTemplate

from adibas.reports.fonts import BOLD
from adibas.reports.pdf_layout import (
    LEFT_PADDING,
    RIGHT_PADDING,
    SMALL,
    number_table,
    prepare_fonts,
    text_width,
)
from adibas.texts import LANGUAGES, speaking
from adibas.texts import translate as _


def lines_of(header, widths):
    """Write the table; return the lines of its header with their columns."""
    prepare_fonts()
    table = number_table(header, [["1"] * len(header)], widths, text_columns=(0,))
    out = io.BytesIO()
    SimpleDocTemplate(out).build([table])
    assert PdfReader(io.BytesIO(out.getvalue())).pages[0].extract_text()
    return [
        (line, column)
        for column, name in enumerate(table._cellvalues[0])
        for line in name.split("\n")
    ]


@pytest.mark.parametrize("language", LANGUAGES)
def test_names_of_columns_do_not_run_into_one_another(language):
    with speaking(language):
        header = ["Marker", "z [mm]", *(_("sd {axis} [mm]").format(axis=axis) for axis in "xyz")]
    widths = [90.0, *[29.0] * (len(header) - 1)]
    for line, column in lines_of(header, widths):
        room = widths[column] - LEFT_PADDING - RIGHT_PADDING
        assert text_width(line, SMALL, BOLD) <= room or " " not in line


def test_a_name_that_fits_is_one_line_and_none_loses_a_word():
    header, widths = ["Pair", "a name of many words", "mm"], [60.0, 40.0, 20.0]
    lines = lines_of(header, widths)
    by_column = itertools.groupby(lines, key=lambda one: one[1])
    assert [" ".join(line for line, _column in some) for _column, some in by_column] == header
    assert sum(column == 1 for _line, column in lines) > 1
    assert sum(column == 0 for _line, column in lines) == 1
