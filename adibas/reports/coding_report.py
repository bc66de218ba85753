"""What is counted in codings: totals, time bins, transitions, events."""

import csv
from collections.abc import Sequence
from pathlib import Path

from openpyxl import Workbook

from adibas.data.coding import Coding
from adibas.files import whole_letters, written_whole
from adibas.recordings.coding_table import shielded
from adibas.reports import behaviour_tables as tables
from adibas.reports.behaviour_excel import add_coding_sheets
from adibas.reports.memory_workbook import write_in_memory
from adibas.texts import speaking

CODING_REPORT_KINDS = (".xlsx", ".csv")


def write_coding_report(codings: Sequence[Coding], bin_ms: int, path: Path, language: str) -> None:
    """Write the format that the file's ending, one of `CODING_REPORT_KINDS`, names.

    A CSV holds the totals over each session and under each condition.

    Raises
    ------
    ValueError
        Another ending.
    FileError
        The disk is full, or the folder cannot be written.
    """
    match path.suffix.lower():
        case ".xlsx":

            def add(workbook: Workbook) -> None:
                add_coding_sheets(workbook, codings, bin_ms)

            write_in_memory(path, language, add)
        case ".csv":
            with speaking(language):
                _write_totals(codings, path)
        case suffix:
            raise ValueError(f"no report of codings ends in {suffix!r}")


def _write_totals(codings: Sequence[Coding], path: Path) -> None:
    with (
        written_whole(path) as unfinished,
        unfinished.open("w", newline="", encoding="utf-8") as file,
    ):
        writer = csv.writer(file)  # lines end in CRLF: else it does not quote a carriage return
        writer.writerow([column.title for column in tables.budget_columns()])
        for row in tables.budget_rows(codings):
            writer.writerow([_cell(cell) if isinstance(cell, str) else cell for cell in row])


def _cell(text: str) -> str:
    return shielded(whole_letters(text))
