"""Codings from Excel workbooks that `adibas.reports.coding_excel` wrote."""

import warnings
import zipfile
from pathlib import Path
from xml.etree.ElementTree import ParseError

from adibas.data.coding import Coding
from adibas.data.ethogram import Ethogram
from adibas.errors import BehaviourError
from adibas.files import DAMAGED_ARCHIVE
from adibas.recordings.coding_table import NEEDED, codings_of_rows, unshielded
from adibas.recordings.ethogram_json import ethogram_of_text

EVENTS_SHEET, SCHEME_SHEET = "Coding", "Scheme"
LARGEST_SHEET_BYTES = 400_000_000
MOST_ROWS = 1_048_576
NO_WORKBOOK = (KeyError, ValueError, TypeError, IndexError, ParseError)
"""What openpyxl raises of a whole archive that is no workbook: a part, an attribute or a shared
text is missing or unknown, or is no number or XML."""


def read_coding_excel(path: Path, ethogram: Ethogram | None = None) -> tuple[Coding, ...]:
    """Read the sheets Coding and, where no ethogram is given, Scheme.

    Raises
    ------
    BehaviourError
        The file is missing or no such workbook, or a row does not fit; its line is told.
    """
    try:
        _check_archive(path)
        sheets = _sheets(path)
    except (OSError, *DAMAGED_ARCHIVE, *NO_WORKBOOK) as error:
        raise BehaviourError(
            "{file} cannot be read: {reason}. Give a workbook that `adibas coding convert` wrote.",
            file=path.name,
            reason=getattr(error, "strerror", None) or str(error),
        ) from error
    events = sheets.get(EVENTS_SHEET, [])
    header = events[0] if events else []
    if not set(NEEDED) <= set(header):
        raise BehaviourError(
            "{file} holds no coding: it has no sheet Coding with the columns of one. Give a "
            "workbook that `adibas coding convert` wrote.",
            file=path.name,
        )
    scheme = "".join(row[0] for row in sheets.get(SCHEME_SHEET, []) if row)
    if ethogram is None and scheme:
        ethogram = ethogram_of_text(scheme, path.name)
    rows = [
        (line, dict(zip(header, row, strict=False)))
        for line, row in enumerate(events[1:], 2)
        if any(row)
    ]
    return codings_of_rows(path.name, rows, ethogram)


def _check_archive(path: Path) -> None:
    """See that all parts are whole, so that openpyxl gets what somebody wrote."""
    with zipfile.ZipFile(path) as archive:
        if sum(part.file_size for part in archive.infolist()) > LARGEST_SHEET_BYTES:
            raise ValueError("the sheets are larger than those of any session")
        damaged = archive.testzip()
        if damaged is not None:
            raise zipfile.BadZipFile(f"{damaged} is damaged")


def _sheets(path: Path) -> dict[str, list[list[str]]]:
    """Return the texts of all cells, by sheet."""
    from openpyxl import load_workbook

    # Of a damaged file openpyxl lets go only by and by, and what it makes of it it tells on stderr.
    with warnings.catch_warnings(), path.open("rb") as file:
        warnings.simplefilter("ignore")
        workbook = load_workbook(file, read_only=True, data_only=True)
        return {
            name: [
                [_text(cell) for cell in row]
                for row in workbook[name].iter_rows(max_row=MOST_ROWS, values_only=True)
            ]
            for name in (EVENTS_SHEET, SCHEME_SHEET)
            if name in workbook.sheetnames
        }


def _text(cell: object) -> str:
    return "" if cell is None else unshielded(str(cell))
