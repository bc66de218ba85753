"""Which state of `key.json` the audit log knows of, so that another one put back is noticed.

People and the recovery key make the state; what a passphrase is does not.
"""

import hashlib
import json
from pathlib import Path

from sqlalchemy import select

from adibas.sessions.audit import AuditLog
from adibas.sessions.database import Database
from adibas.sessions.key_file import KeyFile, read_key_file
from adibas.sessions.schema import AUDIT

PEOPLE_AS_SUBJECT = "people"
"""The audit log's word for who may open the store."""
STATE = 16
"""Letters of a hash."""


def note_other_people(folder: Path, database: Database, audit: AuditLog) -> None:
    """Write a line where `key.json` is not as this program saved it last.

    Somebody put an older one back, or a kill came between the file and its line.
    """
    file = read_key_file(folder)
    if file is None or database.is_read_only:
        return
    changes = (AUDIT.c.subject == PEOPLE_AS_SUBJECT) & (AUDIT.c.action == "change")
    last = select(AUDIT.c.detail).where(changes).order_by(AUDIT.c.sequence.desc()).limit(1)
    with database.reading() as transaction:
        detail = transaction.scalars(last).one_or_none()
    expected = "" if detail is None else json.loads(detail)["state"]
    if state_of(file) != expected:
        audit.append("change", PEOPLE_AS_SUBJECT, did="found otherwise", state=state_of(file))


def state_of(file: KeyFile) -> str:
    """Return what tells one state of people and recovery key from another; empty without both."""
    people = file.wrapped if file.place == "people" else None
    if people is None and file.recovery is None:
        return ""
    told = people if file.recovery is None else [people, file.recovery]
    return hashlib.sha256(json.dumps(told, sort_keys=True).encode()).hexdigest()[:STATE]
