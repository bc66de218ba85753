"""The audit log as a CSV table, a line a row."""

import csv
import json
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING

from adibas.files import written_whole
from adibas.reports.cells import neutralised

if TYPE_CHECKING:  # it brings the database
    from adibas.sessions.audit import AuditEntry

HEADER = ("sequence", "time_utc", "operator", "action", "patient", "subject", "detail")


def write_audit_csv(entries: "Iterable[AuditEntry]", path: Path) -> None:
    """Write lines of the audit log in their order; it holds pseudonyms and ids, no patient's name.

    Raises
    ------
    FileError
        The disk is full, or the folder cannot be written.
    """
    with (
        written_whole(path) as unfinished,
        unfinished.open("w", newline="", encoding="utf-8") as file,
    ):
        writer = csv.writer(file)
        writer.writerow(HEADER)
        for entry in entries:
            detail = json.dumps(entry.detail, ensure_ascii=False) if entry.detail else ""
            texts = (entry.operator, entry.action, entry.patient, entry.subject, detail)
            row = (entry.sequence, entry.time_utc.isoformat(), *map(neutralised, texts))
            writer.writerow(row)
