"""Tables of the comparison: one column takes what is left."""

import pytest

from ui.widgets.row_table import RowTable
from ui.widgets.rows import Row

LONG = "Horizontal alignment of the anterior superior iliac spines, standing"


@pytest.fixture
def shown(qtbot):
    """Return a function that shows a table in a window of some width."""

    def show(width, *, is_plain):
        table = RowTable(range(1, 3), 0, is_plain=is_plain)
        qtbot.addWidget(table)
        cells = (LONG, "1.3", "-4.0 to -3.5")
        table.show_rows(("Measure", "Value", "95 % interval"), (Row(("a", "b"), cells, cells),))
        table.resize(width, 300)
        table.show()
        return table

    return show


def widths(table):
    header = table.table.horizontalHeader()
    return [header.sectionSize(column) for column in range(3)]


@pytest.mark.parametrize("is_plain", [False, True])
def test_a_table_that_becomes_wide_again_uses_its_whole_width(shown, qtbot, is_plain):
    table = shown(180, is_plain=is_plain)
    qtbot.wait(10)
    assert sum(widths(table)) > table.table.viewport().width(), "it scrolls sideways"
    table.resize(1200, 300)
    qtbot.waitUntil(lambda: sum(widths(table)) == table.table.viewport().width())


def test_names_of_a_long_list_are_cut_before_it_scrolls_and_lines_of_a_short_one_are_not(shown):
    of_list, of_lines = (widths(shown(350, is_plain=one))[0] for one in (False, True))
    needed_px = shown(350, is_plain=True).table.sizeHintForColumn(0)
    assert of_list < needed_px <= of_lines
