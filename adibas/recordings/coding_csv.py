"""Codings as CSV files: what `events.csv` holds, and the rest of a coding in more columns."""

import csv
import io
import json
import re
from collections.abc import Iterator, Sequence
from pathlib import Path

from adibas.data.coding import Coding
from adibas.data.ethogram import Ethogram
from adibas.errors import BehaviourError
from adibas.files import DAMAGED_JSON, whole_letters, written_whole
from adibas.recordings.boris_tables import boris_rows
from adibas.recordings.boris_writing import check_one_scheme
from adibas.recordings.coding_table import (
    COLUMNS,
    NEEDED,
    SESSION,
    Row,
    codings_of_rows,
    rows_of,
    shielded,
    unshielded,
)
from adibas.recordings.ethogram_json import ethogram_document, ethogram_of_text

LARGEST_FILE_BYTES = 200_000_000
LONGEST_CELL = 10_000_000
LONE_RETURN = re.compile("\r(?!\n)")
HIDDEN_RETURN = "\udc0d"
"""Stands for a carriage return while a table is split; no file of UTF-8 holds it."""


def read_coding_csv(path: Path, ethogram: Ethogram | None = None) -> tuple[Coding, ...]:
    """Read codings from a table of ours, or one that BORIS exported (CSV or TSV).

    Parameters
    ----------
    path : Path
    ethogram : Ethogram, optional
        In place of the file's own; a table without one has what occurs in it.

    Raises
    ------
    BehaviourError
        The file is missing or no such table, or a row does not fit; its line is told.
    """
    return codings_of_csv(_text(path), path.name, ethogram)


def codings_of_csv(text: str, file: str, ethogram: Ethogram | None = None) -> tuple[Coding, ...]:
    """Return the codings in `text`, the content of the file named `file`; see `read_coding_csv`."""
    try:
        lines = list(_lines(text))
    except csv.Error as error:
        raise _unreadable(file, str(error)) from error
    header = [cell.strip() for cell in lines[0][1]] if lines else []
    if not set(NEEDED) <= set(header):
        return codings_of_rows(file, boris_rows(file, lines), ethogram)
    rows = [
        (line, dict(zip(header, map(unshielded, cells), strict=False)))
        for line, cells in lines[1:]
        if cells
    ]
    return codings_of_rows(file, rows, ethogram or _own_ethogram(file, rows))


def write_coding_csv(path: Path, codings: Sequence[Coding]) -> None:
    """Write codings of one ethogram.

    Raises
    ------
    BehaviourError
        They are of different ethograms, or two have the same name.
    FileError
        The file cannot be written.
    """
    text = coding_csv_text(codings)
    with written_whole(path) as unfinished:
        unfinished.write_text(text, encoding="utf-8", newline="")


def coding_csv_text(codings: Sequence[Coding]) -> str:
    """Return the table of codings of one ethogram.

    Raises
    ------
    BehaviourError
        They are of different ethograms, or two have the same name.
    """
    check_one_scheme(codings)
    rows = list(rows_of(codings))
    details = json.loads(rows[0]["details"])
    details["ethogram"] = ethogram_document(codings[0].ethogram)
    rows[0]["details"] = json.dumps(details, ensure_ascii=False)
    table = io.StringIO(newline="")
    # Lines end in CRLF, the writer's own choice: it quotes a carriage return where lines have one.
    writer = csv.DictWriter(table, COLUMNS, restval="")
    writer.writeheader()
    writer.writerows({name: shielded(cell) for name, cell in row.items()} for row in rows)
    return whole_letters(table.getvalue())


def _lines(text: str) -> Iterator[tuple[int, list[str]]]:
    """Yield the cells of each row, with the number of its last line.

    Lines end as the first one does: where that is no carriage return alone, such a one is part of a
    cell. Python's writer left it bare, and its reader would end the row there.
    """
    first = text.partition("\n")[0]
    if "\r" not in first.removesuffix("\r"):
        text = LONE_RETURN.sub(HIDDEN_RETURN, text)
    csv.field_size_limit(LONGEST_CELL)
    delimiter = "\t" if "\t" in first else ","
    reader = csv.reader(io.StringIO(text, newline=""), delimiter=delimiter)
    for cells in reader:
        yield reader.line_num, [cell.replace(HIDDEN_RETURN, "\r") for cell in cells]


def _text(path: Path) -> str:
    try:
        if path.stat().st_size > LARGEST_FILE_BYTES:
            raise BehaviourError("{file} is larger than any table of events.", file=path.name)
        return path.read_bytes().decode("utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        raise _unreadable(path.name, getattr(error, "strerror", None) or str(error)) from error


def _unreadable(file: str, reason: str) -> BehaviourError:
    return BehaviourError(
        "{file} cannot be read: {reason}. Check that it is a table of events (CSV).",
        file=file,
        reason=reason,
    )


def _own_ethogram(file: str, rows: Sequence[Row]) -> Ethogram | None:
    for _line, row in rows:
        if row.get("kind") == SESSION and row.get("details"):
            try:
                details = json.loads(row["details"])
            except DAMAGED_JSON:
                return None  # told with its line when the row is read
            if isinstance(details, dict) and "ethogram" in details:
                return ethogram_of_text(json.dumps(details["ethogram"]), file)
    return None
