"""Events as a table: `events.csv`, one row an event."""

import csv
from collections.abc import Iterable, Mapping
from pathlib import Path

from adibas.data.events import TimedEvent
from adibas.errors import RecordingError
from adibas.files import whole_letters, written_whole

NEEDED = ("recording", "label", "begin_s", "end_s")
COLUMNS = (*NEEDED, "subject", "person", "kind", "cost")


def read_events_csv(path: Path) -> tuple[TimedEvent, ...]:
    """Read events in the order of the file.

    Raises
    ------
    RecordingError
        The file is missing, or a row of it is no event.
    """
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            reader = csv.DictReader(file)
            if not set(NEEDED) <= set(reader.fieldnames or ()):
                raise RecordingError(
                    "{file} is no table of events: its first line must name recording, label, "
                    "begin_s and end_s.",
                    file=path.name,
                )
            return tuple(_event(path, row, reader.line_num) for row in reader)
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise RecordingError(
            "{file} cannot be read: {reason}. Check that it is a table of events (CSV).",
            file=path.name,
            reason=getattr(error, "strerror", None) or str(error),
        ) from error


def write_events_csv(path: Path, events: Iterable[TimedEvent]) -> None:
    """Write events as they come.

    Raises
    ------
    FileError
        The file cannot be written.
    """
    with (
        written_whole(path) as unfinished,
        unfinished.open("w", newline="", encoding="utf-8") as file,
    ):
        writer = csv.writer(file)  # lines end in CRLF: else it does not quote a carriage return
        writer.writerow(COLUMNS)
        for event in events:
            writer.writerow(
                (
                    whole_letters(event.recording),
                    whole_letters(event.label),
                    f"{event.begin_s:.6f}",
                    f"{event.end_s:.6f}",
                    whole_letters(event.subject),
                    event.person,
                    whole_letters(event.kind),
                    "" if event.cost is None else f"{event.cost:.6g}",
                )
            )


def _event(path: Path, row: Mapping[str, str | None], line: int) -> TimedEvent:
    try:
        cost = row.get("cost")
        return TimedEvent(
            recording=_text(row, "recording"),
            label=_text(row, "label"),
            begin_s=float(row["begin_s"] or "nan"),
            end_s=float(row["end_s"] or "nan"),
            subject=(row.get("subject") or "").strip(),
            person=int(row.get("person") or 1),
            kind=(row.get("kind") or "state").strip(),
            cost=float(cost) if cost else None,
        )
    except ValueError as error:
        raise RecordingError(
            "{file}, line {line} is no event: it needs a recording, a label, and begin_s no later "
            "than end_s.",
            file=path.name,
            line=line,
        ) from error


def _text(row: Mapping[str, str | None], name: str) -> str:
    text = (row[name] or "").strip()
    if not text:
        raise ValueError(name)
    return text
