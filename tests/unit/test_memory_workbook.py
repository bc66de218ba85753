"""A workbook is put together in memory: what a crash could leave of a patient is never written."""

import tempfile

import numpy as np
import openpyxl
import pytest

from adibas.errors import FileError
from adibas.reports.memory_workbook import write_in_memory
from adibas.reports.sheets import Column, Part, add_parts, add_table

ROWS = [(f"m{number:02d}", 1.5 * number) for number in range(40)]


def add_all(workbook):
    columns = (Column("Marker", 20), Column("Distance (mm)", 20, "0.0"))
    picture = np.full((60, 40, 3), (200, 20, 20), np.uint8)
    add_parts(workbook, "Summary", "Report", [Part("One", [("Age", 41.0)], picture)], "footer")
    add_table(workbook, "Distances", columns, ROWS, "footer")
    workbook.create_sheet("Empty")


def test_what_is_added_is_read_back(tmp_path):
    write_in_memory(tmp_path / "report.xlsx", "en", add_all)
    read = openpyxl.load_workbook(tmp_path / "report.xlsx")
    assert read.sheetnames == ["Summary", "Distances", "Empty"]
    assert list(read["Distances"].values)[1:] == ROWS
    assert read["Distances"].auto_filter.ref == "A1:B41"
    assert len(read["Summary"]._images) == 1


def test_no_temporary_file_is_made(tmp_path, monkeypatch):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "nowhere"))
    write_in_memory(tmp_path / "report.xlsx", "en", add_all)
    assert [path.name for path in tmp_path.iterdir()] == ["report.xlsx"]


@pytest.mark.parametrize("n_sheets", [0, 1, 2])
def test_what_fails_in_the_middle_leaves_the_older_file(tmp_path, n_sheets):
    place = tmp_path / "report.xlsx"
    place.write_text("older")

    def fail(workbook):
        for _number in range(n_sheets):
            workbook.create_sheet().append([1.0])
        workbook.create_sheet()
        raise FileError("no")

    with pytest.raises(FileError):
        write_in_memory(place, "en", fail)
    assert [path.name for path in tmp_path.iterdir()] == ["report.xlsx"]
    assert place.read_text() == "older"
