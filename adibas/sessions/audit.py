"""The audit log: who did what to which thing and when, in lines chained by their hashes."""

import hashlib
import json
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from datetime import datetime, timedelta
from itertools import islice
from typing import Literal, NamedTuple

from sqlalchemy import select

from adibas.clock import Clock, to_text
from adibas.sessions.database import Database
from adibas.sessions.person_keys import Person
from adibas.sessions.roles import Permission, Role, may, refusal
from adibas.sessions.rows import Transaction, add_row, change_row, row_of
from adibas.sessions.schema import AUDIT, AUDIT_HEAD

Action = Literal[
    "create",
    "view",
    "change",
    "export",
    "delete",
    "restore",
    "purge",
    "open",
    "recover",
    "backup",
    "merge",
    "refuse",
]

BEGINNING = "0" * 64
"""What the first line has for the hash before it."""

SAME_VIEW = timedelta(minutes=1)
"""A thing that one operator looks at again within this time is one look."""

THE_HEAD = 1


@dataclass(frozen=True, slots=True)
class AuditEntry:
    """One line.

    Attributes
    ----------
    sequence : int
        Counts from 1 without gaps; it decides the order, whatever the clock did.
    time_utc : datetime
        Never before the line before.
    operator : str
        Who.
    action : str
        One of `Action`.
    subject : str
        A pseudonym or an id, never a name.
    detail : Mapping
        What more there is to know, such as the fields that were changed; no contents.
    patient : str
        Pseudonym of whom the subject is or belongs to, also after a purge; else empty.
    """

    sequence: int
    time_utc: datetime
    operator: str
    action: str
    subject: str
    detail: Mapping[str, object]
    patient: str


class AuditLine(NamedTuple):
    """A line as the table has it, in the order of its columns; see `AuditEntry`."""

    sequence: int
    time_utc: str
    operator: str
    action: str
    subject: str
    detail: str
    previous_hash: str
    hash: str = ""


class AuditLog:
    """Writes lines; every change and its line are one transaction. Refuses what a role may not.

    Parameters
    ----------
    operator : str
        Who works; may change, but not where `person` says it.
    person : Person, optional
        Whose passphrase opened the store; None in a store without people.
    """

    def __init__(
        self, database: Database, clock: Clock, operator: str, person: Person | None = None
    ) -> None:
        self.person = person
        self._operator = operator
        self._database = database
        self._clock = clock
        self._last_views: dict[tuple[str, str], datetime] = {}

    @property
    def operator(self) -> str:
        """Who works."""
        return self._operator if self.person is None else self.person.name

    @operator.setter
    def operator(self, name: str) -> None:
        self._operator = name

    @property
    def role(self) -> Role:
        """What whoever works may; in a store without people everything."""
        return Role.ADMINISTRATOR if self.person is None else self.person.role

    def become(self, person: Person) -> None:
        """Let `person` be who works from now on."""
        self.person = person

    def require(self, permission: Permission, subject: str = "store") -> None:
        """See that whoever works may do something; a refusal is a line.

        Parameters
        ----------
        subject : str
            To what it would be done.

        Raises
        ------
        NotAllowedError
            It is for another role; nothing was done.
        """
        if not may(self.role, permission):
            told = {"permission": permission.value, "role": self.role.value}
            self.append("refuse", subject, **told)
            raise refusal(self.role, permission)

    def now_utc(self) -> datetime:
        """Return the time of day."""
        return self._clock()

    def now(self) -> str:
        """Return the time of day as the tables keep it."""
        return to_text(self._clock())

    def write(
        self, transaction: Transaction, action: Action, subject: str, **detail: object
    ) -> None:
        """Append a line within `transaction`."""
        head = row_of(transaction, AUDIT_HEAD, THE_HEAD)
        last = None if head is None else row_of(transaction, AUDIT, head.sequence)
        line = AuditLine(
            sequence=1 if head is None else head.sequence + 1,
            time_utc=self.now() if last is None else max(self.now(), last.time_utc),
            operator=self.operator,
            action=action,
            subject=subject,
            detail=json.dumps(detail, sort_keys=True, ensure_ascii=False),
            previous_hash=BEGINNING if head is None else head.hash,
        )
        line = line._replace(hash=hash_of(line))
        add_row(transaction, AUDIT, **line._asdict())
        now_last = {"sequence": line.sequence, "hash": line.hash}
        if head is None:
            add_row(transaction, AUDIT_HEAD, only=THE_HEAD, **now_last)
        else:
            change_row(transaction, AUDIT_HEAD, THE_HEAD, **now_last)

    def saw(self, subject: str) -> None:
        """Append a line that `subject` was looked at, unless it was a moment ago."""
        now = self._clock()
        last = self._last_views.get((self.operator, subject))
        if last is not None and timedelta(0) <= now - last < SAME_VIEW:
            return
        with self._database.logging() as transaction:
            self.write(transaction, "view", subject)
        self._last_views[self.operator, subject] = now

    def append(self, action: Action, subject: str, **detail: object) -> None:
        """Append a line in a transaction of its own."""
        with self._database.logging() as transaction:
            self.write(transaction, action, subject, **detail)

    def end(self) -> str:
        """Return the hash of the last line: it stands for all lines up to it."""
        with self._database.reading() as transaction:
            head = row_of(transaction, AUDIT_HEAD, THE_HEAD)
        return BEGINNING if head is None else str(head.hash)

    def has(self, line_hash: str) -> bool:
        """Say whether a line with this hash is in this log, and so all lines before it."""
        wanted = select(AUDIT.c.sequence).where(AUDIT.c.hash == line_hash)
        with self._database.reading() as transaction:
            return transaction.execute(wanted).first() is not None

    def entries(
        self, limit: int = 1000, *, patients: Collection[str] | None = None
    ) -> tuple[AuditEntry, ...]:
        """Return the last lines, newest first.

        Parameters
        ----------
        limit : int
            At most so many.
        patients : collection of str, optional
            Pseudonyms: lines on these patients, their sessions, captures and recordings alone.
        """
        self.require(Permission.READ_LOG)
        with self._database.reading() as transaction:
            wanted = (
                entry
                for entry in every_entry(transaction)
                if patients is None or (entry.patient or entry.subject) in patients
            )
            return tuple(islice(wanted, limit))


def every_entry(transaction: Transaction) -> Iterator[AuditEntry]:
    """Give all lines, newest first, each with whose it is."""
    owners = _owners(transaction)
    newest = select(AUDIT).order_by(AUDIT.c.sequence.desc())
    for row in transaction.execute(newest):
        yield _entry(AuditLine(*row), owners)


def last_change(transaction: Transaction, subject: str, group: str = "") -> tuple[str, datetime]:
    """Return who changed something last, and when, as the audit log says.

    Parameters
    ----------
    group : str
        Of fields, as the log names them; where no line names it the last change counts.
    """
    lines = (
        select(AUDIT.c.operator, AUDIT.c.time_utc, AUDIT.c.detail)
        .where(AUDIT.c.subject == subject, AUDIT.c.action.in_(("create", "change", "merge")))
        .order_by(AUDIT.c.sequence.desc())
    )
    rows = transaction.execute(lines).all()
    of_it = (row for row in rows if group in json.loads(row.detail).get("fields", ()))
    row = next(of_it, rows[0])
    return row.operator, datetime.fromisoformat(row.time_utc)


def hash_of(line: AuditLine) -> str:
    """Return the SHA-256 over the hash before and the canonical content of a line."""
    content = json.dumps(
        [line.sequence, line.time_utc, line.operator, line.action, line.subject, line.detail],
        ensure_ascii=False,
        separators=(",", ":"),
    )
    return hashlib.sha256(f"{line.previous_hash}\n{content}".encode()).hexdigest()


def _owners(transaction: Transaction) -> dict[str, str]:
    """Return the patient of every session, capture and recording, as the log's own lines say.

    What was purged is in no other table any more.
    """
    telling = (
        select(AUDIT.c.subject, AUDIT.c.detail)
        .where(AUDIT.c.action.in_(("create", "recover", "merge")))
        .order_by(AUDIT.c.sequence)
    )
    owners: dict[str, str] = {}
    for subject, detail in transaction.execute(telling):
        told = json.loads(detail)
        if not told:
            owners[subject] = subject  # a patient
        elif "patient" in told:
            owners[subject] = told["patient"]
        elif told.get("session") in owners:
            owners[subject] = owners[told["session"]]
    return owners


def _entry(line: AuditLine, owners: Mapping[str, str]) -> AuditEntry:
    return AuditEntry(
        sequence=line.sequence,
        time_utc=datetime.fromisoformat(line.time_utc),
        operator=line.operator,
        action=line.action,
        subject=line.subject,
        detail=json.loads(line.detail),
        patient=owners.get(line.subject, ""),
    )
