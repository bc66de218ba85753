"""Events as BORIS exports them into tables: one row an event (START, STOP, POINT), or aggregated.

Columns are found by their names, so that tables of versions 7 to 9 are read alike.
"""

import csv
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from adibas.data.coding import MS_PER_S, Coding
from adibas.errors import BehaviourError
from adibas.files import whole_letters, written_whole
from adibas.recordings.boris_writing import NOBODY, NOT_TOLD
from adibas.recordings.coding_table import POINT, SESSION, STATE, Row
from adibas.recordings.coding_times import milliseconds, seconds_text

Lines = Sequence[tuple[int, Sequence[str]]]

N_MODIFIERS = 20
FIRST_COLUMNS = (
    *("Observation id", "Observation date", "Description", "Observation type", "Source"),
    *("Time offset (s)", "Coding duration", "Media duration (s)", "FPS (frame/s)"),
)
WHO = ("Subject", "Observation duration by subject by observation", "Behavior")
LAST_COLUMNS = (
    *("Behavior type", "Start (s)", "Stop (s)", "Duration (s)", "Media file name"),
    *("Image index start", "Image index stop", "Image file path start", "Image file path stop"),
    *("Comment start", "Comment stop"),
)
LENGTHS = ("Observation duration", "Coding duration", "Media duration (s)", "Total length")


def boris_rows(file: str, lines: Lines) -> list[Row]:
    """Return rows of `COLUMNS` of what BORIS exported.

    Raises
    ------
    BehaviourError
        There is no line with the names of the columns, or a state does not end.
    """
    at = next((k for k, (_, cells) in enumerate(lines) if _is_header(cells)), None)
    if at is None:
        raise BehaviourError(
            "{file} is no table of events: its first line must name recording, label, begin_s "
            "and end_s, or the columns that BORIS exports.",
            file=file,
        )
    header = [cell.strip() for cell in lines[at][1]]
    named = {cells[0].strip(): cells[1] for _, cells in lines[:at] if len(cells) > 1}
    told = [
        (line, {**named, **dict(zip(header, cells, strict=False))})
        for line, cells in lines[at + 1 :]
        if any(cell.strip() for cell in cells)
    ]
    try:
        rows = _aggregated(told) if "Start (s)" in header else _paired(file, told)
        return [*_sessions(told), *rows]
    except (KeyError, ValueError) as error:
        raise BehaviourError(
            "{file} is damaged: a time or a column of the BORIS table is missing. Export it again.",
            file=file,
        ) from error


def write_boris_table(path: Path, codings: Sequence[Coding]) -> None:
    """Write aggregated events as BORIS exports them (TSV); the ethogram is not in it.

    Raises
    ------
    FileError
        The file cannot be written.
    """
    n_modifiers = max(
        (len(one.modifiers) for coding in codings for one in coding.ethogram.behaviours), default=0
    )
    modifiers = [f"Modifier #{number + 1}" for number in range(n_modifiers)]
    columns = [*FIRST_COLUMNS, *WHO, "Behavioral category", *modifiers, *LAST_COLUMNS]
    with (
        written_whole(path) as unfinished,
        unfinished.open("w", newline="", encoding="utf-8") as file,
    ):
        # Lines end in CRLF: else the writer does not quote a carriage return.
        writer = csv.DictWriter(file, columns, restval="", delimiter="\t")
        writer.writeheader()
        for coding in codings:
            writer.writerows(
                {name: whole_letters(cell) for name, cell in row.items()}
                for row in _told(coding, modifiers)
            )


def _told(coding: Coding, modifiers: Sequence[str]) -> Iterator[dict[str, str]]:
    length = seconds_text(coding.duration_ms)
    for one in coding.occurrences:
        behaviour = coding.ethogram.behaviour(one.behaviour)
        is_point = behaviour is not None and behaviour.kind == "point"
        yield {
            "Observation id": coding.name,
            "Observation date": coding.date,
            "Description": coding.description,
            "Observation type": "Media file(s)" if coding.media else "Live",
            "Source": ";".join(coding.media),
            "Time offset (s)": "0.0",
            "Coding duration": length,
            "Media duration (s)": length,
            "Subject": one.subject or NOBODY,
            "Observation duration by subject by observation": length,
            "Behavior": one.behaviour,
            "Behavioral category": "" if behaviour is None else behaviour.category,
            **dict(zip(modifiers, one.modifiers, strict=False)),
            "Behavior type": "POINT" if is_point else "STATE",
            "Start (s)": seconds_text(one.begin_ms),
            "Stop (s)": seconds_text(one.end_ms),
            "Duration (s)": "" if is_point else f"{one.duration_ms / MS_PER_S:.3f}",
            "Comment start": one.comment,
            "Comment stop": one.end_comment,
        }


def _is_header(cells: Sequence[str]) -> bool:
    names = {cell.strip() for cell in cells}
    return "Behavior" in names and bool(names & {"Time", "Start (s)"})


def _sessions(told: Sequence[Row]) -> list[Row]:
    """Return how long each observation was, where that is told."""
    found: dict[str, Row] = {}
    for line, cells in told:
        name = _name(cells)
        length = next((cells[key] for key in LENGTHS if _is_number(cells.get(key, ""))), "")
        stop = cells.get("Stop (s)") or cells.get("Time") or "0"
        last = max(milliseconds(length or 0), milliseconds(stop if _is_number(stop) else 0))
        before = found[name][1]["end_s"] if name in found else "0"
        end_s = seconds_text(max(last, milliseconds(before)))
        session = {"recording": name, "label": "", "begin_s": "0", "end_s": end_s, "kind": SESSION}
        found[name] = (line, session)
    return list(found.values())


def _aggregated(told: Sequence[Row]) -> list[Row]:
    rows: list[Row] = []
    for line, cells in told:
        is_point = cells["Behavior type"].strip() == "POINT"
        stop = cells["Start (s)"] if is_point else cells["Stop (s)"]
        rows.append((line, _row(cells, cells["Start (s)"], stop, cells, is_point=is_point)))
    return rows


def _paired(file: str, told: Sequence[Row]) -> list[Row]:
    rows: list[Row] = []
    begun: dict[tuple[str, ...], Row] = {}
    for line, cells in told:
        kind = (cells.get("Behavior type") or cells["Status"]).strip()
        key = (_name(cells), cells["Subject"], cells["Behavior"], _modifiers(cells))
        if kind == "START":
            if key in begun:
                raise _unpaired(file, *begun[key])
            begun[key] = (line, cells)
            continue
        if kind == "STOP" and key not in begun:
            raise _unpaired(file, line, cells)
        first_line, first = begun.pop(key) if kind == "STOP" else (line, cells)
        is_point = kind == "POINT"
        rows.append(
            (first_line, _row(first, first["Time"], cells["Time"], cells, is_point=is_point))
        )
    for line, cells in begun.values():
        raise _unpaired(file, line, cells)
    return rows


def _unpaired(file: str, line: int, cells: Mapping[str, str]) -> BehaviourError:
    return BehaviourError(
        "{file}, line {line}: {behaviour} at {at} s is only half of a state. Add its other end, "
        "or remove it.",
        file=file,
        line=line,
        behaviour=cells["Behavior"],
        at=cells["Time"],
    )


def _row(
    cells: Mapping[str, str], start: str, stop: str, last: Mapping[str, str], *, is_point: bool
) -> dict[str, str]:
    subject = cells["Subject"].strip()
    comment = cells.get("Comment start", cells.get("Comment", ""))
    return {
        "recording": _name(cells),
        "label": cells["Behavior"].strip(),
        "begin_s": start,
        "end_s": stop,
        "subject": "" if subject == NOBODY else subject,
        "kind": POINT if is_point else STATE,
        "modifiers": _modifiers(cells),
        "comment": comment,
        "end_comment": "" if is_point else last.get("Comment stop", last.get("Comment", "")),
    }


def _modifiers(cells: Mapping[str, str]) -> str:
    if "Modifiers" in cells:
        return cells["Modifiers"]
    told = [cells.get(f"Modifier #{number + 1}", "") for number in range(N_MODIFIERS)]
    while told and not told[-1]:
        told.pop()
    return "|".join(one or NOT_TOLD for one in told)


def _name(cells: Mapping[str, str]) -> str:
    return cells.get("Observation id", "").strip() or "observation"


def _is_number(text: str) -> bool:
    try:
        milliseconds(text)
    except ValueError:
        return False
    return True
