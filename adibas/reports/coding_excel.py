"""Codings as Excel workbooks that can be read again."""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from openpyxl import Workbook

from adibas.data.coding import Coding
from adibas.errors import BehaviourError
from adibas.files import printable
from adibas.recordings.boris_writing import check_one_scheme
from adibas.recordings.coding_excel import EVENTS_SHEET, SCHEME_SHEET
from adibas.recordings.coding_table import COLUMNS, rows_of, shielded
from adibas.recordings.ethogram_json import ethogram_document
from adibas.reports.memory_workbook import write_in_memory
from adibas.reports.sheets import Column, Value, add_table
from adibas.texts import translate as _

LONGEST_CELL = 32_767
SCHEME_PIECE = 1000
TIMES, SECONDS = ("begin_s", "end_s"), "0.000"
DETAILS = "details"
WIDTHS = dict.fromkeys(COLUMNS, 14.0) | {"label": 24.0, "comment": 32.0, "details": 40.0}


def write_coding_excel(path: Path, codings: Sequence[Coding], language: str) -> None:
    """Write the sheets Coding, Ethogram and Scheme; the last is for programs.

    Raises
    ------
    BehaviourError
        The codings do not fit in one file, or a text is longer than a cell may be.
    FileError
        The file cannot be written.
    """
    check_one_scheme(codings)
    write_in_memory(path, language, lambda workbook: _add_sheets(workbook, codings))


def _add_sheets(workbook: Workbook, codings: Sequence[Coding]) -> None:
    footer = _("For research, education and documentation")
    rows = [tuple(_value(name, row.get(name, "")) for name in COLUMNS) for row in rows_of(codings)]
    columns = [
        Column(name, WIDTHS[name], SECONDS if name in TIMES else "General") for name in COLUMNS
    ]
    add_table(workbook, EVENTS_SHEET, columns, rows, footer)
    ethogram = codings[0].ethogram
    behaviours = [
        tuple(
            map(
                _cell,
                (
                    one.name,
                    one.kind,
                    one.key,
                    one.category,
                    one.description,
                    "; ".join(modifier.name for modifier in one.modifiers),
                    "; ".join(one.excludes),
                    "; ".join(one.sources),
                ),
            )
        )
        for one in ethogram.behaviours
    ]
    titles = (
        (_("Behaviour"), 24.0),
        (_("Kind"), 8.0),
        (_("Key"), 6.0),
        (_("Category"), 16.0),
        (_("Description"), 50.0),
        (_("Modifiers"), 16.0),
        (_("Excludes"), 24.0),
        (_("Sources"), 50.0),
    )
    add_table(workbook, _("Ethogram"), [Column(*title) for title in titles], behaviours, footer)
    text = json.dumps(_printable(ethogram_document(ethogram)))
    pieces = [text[at : at + SCHEME_PIECE] for at in range(0, len(text), SCHEME_PIECE)]
    sheet = workbook.create_sheet(SCHEME_SHEET)
    for piece in pieces:
        sheet.append([shielded(piece)])


def _printable(document: Any) -> Any:
    """Write names as the cells have them: else no event would be of this ethogram any more."""
    match document:
        case str():
            return printable(document)
        case list():
            return [_printable(one) for one in document]
        case dict():
            return {key: _printable(one) for key, one in document.items()}
    return document


def _value(name: str, text: str) -> Value:
    if name in TIMES:
        return float(text)
    if name == DETAILS and text:
        text = json.dumps(_printable(json.loads(text)), ensure_ascii=False)
    return _cell(text)


def _cell(text: str) -> str:
    if len(text) >= LONGEST_CELL:
        raise BehaviourError(
            "A text of the coding is longer than a cell of Excel may be. Shorten it, or choose "
            "another format."
        )
    return shielded(printable(text))
