"""The undo stack of a capture in the tables; corrections that left it stay readable there."""

from dataclasses import dataclass
from datetime import datetime
from itertools import takewhile

from sqlalchemy import func, select

from adibas.data.corrections import CorrectionHistory
from adibas.sessions.audit import AuditLog
from adibas.sessions.documents import (
    correction_from_json,
    correction_to_json,
    setup_from_json,
)
from adibas.sessions.rows import Row, Transaction, add_numbered_row, change_row
from adibas.sessions.schema import CAPTURES, CORRECTIONS, PATIENTS, SESSIONS


@dataclass(frozen=True, slots=True)
class CorrectedCapture:
    """A capture of which somebody corrected a marker.

    Attributes
    ----------
    capture_id, session_id, patient : str
        Random, and the patient's pseudonym.
    protocol, view : str
        Of session and capture; may be empty.
    corrected_utc : datetime
        When the last correction was made that is in force.
    """

    capture_id: str
    session_id: str
    patient: str
    protocol: str
    view: str
    corrected_utc: datetime


def corrected_captures(transaction: Transaction) -> tuple[CorrectedCapture, ...]:
    """Return the captures with a corrected marker, oldest first, without anything hidden."""
    in_force = (
        select(
            CORRECTIONS.c.capture_id,
            func.max(CORRECTIONS.c.made_utc).label("corrected_utc"),
        )
        .join(CAPTURES, CAPTURES.c.capture_id == CORRECTIONS.c.capture_id)
        .where(
            CORRECTIONS.c.position < CAPTURES.c.n_done,
            func.json_extract(CORRECTIONS.c.content, "$.of") == "marker",
        )
        .group_by(CORRECTIONS.c.capture_id)
        .subquery()
    )
    wanted = (
        select(
            CAPTURES.c.capture_id,
            CAPTURES.c.session_id,
            CAPTURES.c.view,
            SESSIONS.c.pseudonym,
            SESSIONS.c.setup,
            in_force.c.corrected_utc,
        )
        .join(in_force, in_force.c.capture_id == CAPTURES.c.capture_id)
        .join(SESSIONS, SESSIONS.c.session_id == CAPTURES.c.session_id)
        .join(PATIENTS, PATIENTS.c.pseudonym == SESSIONS.c.pseudonym)
        .where(*(table.c.is_deleted.is_(False) for table in (CAPTURES, SESSIONS, PATIENTS)))
        .order_by(CAPTURES.c.captured_utc, CAPTURES.c.capture_id)
    )
    return tuple(
        CorrectedCapture(
            row.capture_id,
            row.session_id,
            row.pseudonym,
            setup_from_json(row.setup).protocol,
            row.view,
            datetime.fromisoformat(row.corrected_utc),
        )
        for row in transaction.execute(wanted)
    )


def history_of(transaction: Transaction, capture: Row) -> CorrectionHistory:
    """Return the undo stack of a capture."""
    stack = _stack(transaction, capture.capture_id)
    return CorrectionHistory(
        tuple(correction_from_json(row.content) for row in stack), capture.n_done
    )


def save_history(
    transaction: Transaction, audit: AuditLog, capture: Row, history: CorrectionHistory
) -> None:
    """Save `history`, with a line in the audit log for everything undone, done anew or again."""
    stack = _stack(transaction, capture.capture_id)
    wanted = [correction_to_json(correction) for correction in history.corrections]
    pairs = zip(stack, wanted, strict=False)
    n_common = len(list(takewhile(lambda pair: pair[0].content == pair[1], pairs)))
    changes = _Changes(transaction, audit, capture, stack)
    if len(wanted) > n_common or capture.n_done > n_common:
        changes.move_to(n_common)
    changes.forget_from(n_common)
    for correction, content in zip(history.corrections[n_common:], wanted[n_common:], strict=True):
        changes.add(correction.kind, content)
    changes.move_to(history.n_done)
    change_row(transaction, CAPTURES, capture.capture_id, n_done=history.n_done)


class _Changes:
    """Makes one change of the stack after the other, each with its line in the log."""

    def __init__(
        self, transaction: Transaction, audit: AuditLog, capture: Row, stack: list[Row]
    ) -> None:
        self._transaction = transaction
        self._audit = audit
        self._capture_id = capture.capture_id
        self._n_done = capture.n_done
        self._numbers = [row.correction_id for row in stack]

    def move_to(self, n_done: int) -> None:
        """Undo or do again until `n_done` corrections are in force."""
        for undone in reversed(self._numbers[n_done : self._n_done]):
            self._log(undone, "undo")
        for redone in self._numbers[self._n_done : n_done]:
            self._log(redone, "redo")
        self._n_done = n_done

    def forget_from(self, position: int) -> None:
        """Take corrections off the stack; they stay in the table."""
        for left in self._numbers[position:]:
            change_row(self._transaction, CORRECTIONS, left, position=None)
        del self._numbers[position:]

    def add(self, kind: str, content: str) -> None:
        """Put a correction on the stack."""
        number = add_numbered_row(
            self._transaction,
            CORRECTIONS,
            capture_id=self._capture_id,
            position=len(self._numbers),
            content=content,
            made_utc=self._audit.now(),
            operator=self._audit.operator,
        )
        self._numbers.append(number)
        self._n_done += 1
        self._log(number, kind)

    def _log(self, number: int, what: str) -> None:
        self._audit.write(
            self._transaction, "change", self._capture_id, correction=what, number=number
        )


def _stack(transaction: Transaction, capture_id: str) -> list[Row]:
    columns = CORRECTIONS.c
    in_order = (
        select(CORRECTIONS)
        .where(columns.capture_id == capture_id, columns.position.is_not(None))
        .order_by(columns.position)
    )
    return list(transaction.execute(in_order))
