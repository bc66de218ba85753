"""The undo stack of a capture in the tables; corrections that left it stay readable there."""

from collections.abc import Collection
from dataclasses import dataclass
from datetime import datetime
from itertools import takewhile

from sqlalchemy import select

from adibas.data.corrections import Correction, CorrectionHistory, MarkerCorrection
from adibas.data.markers import Marker
from adibas.sessions.audit import AuditLog, last_change
from adibas.sessions.conflicts import Conflict, Decision, settle
from adibas.sessions.documents import (
    correction_from_json,
    correction_to_json,
    setup_from_json,
)
from adibas.sessions.merged_corrections import HistoryMerge
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
    rotation_deg : int
        How far the session's pictures are turned clockwise to be upright.
    """

    capture_id: str
    session_id: str
    patient: str
    protocol: str
    view: str
    corrected_utc: datetime
    rotation_deg: int


def corrected_captures(transaction: Transaction) -> tuple[CorrectedCapture, ...]:
    """Return the captures with a corrected marker, oldest first, without anything hidden."""
    corrected_utc = _last_corrections(transaction)
    wanted = (
        select(
            CAPTURES.c.capture_id,
            CAPTURES.c.session_id,
            CAPTURES.c.view,
            SESSIONS.c.pseudonym,
            SESSIONS.c.setup,
        )
        .join(SESSIONS, SESSIONS.c.session_id == CAPTURES.c.session_id)
        .join(PATIENTS, PATIENTS.c.pseudonym == SESSIONS.c.pseudonym)
        .where(*(table.c.is_deleted.is_(False) for table in (CAPTURES, SESSIONS, PATIENTS)))
        .order_by(CAPTURES.c.captured_utc, CAPTURES.c.capture_id)
    )
    return tuple(
        _corrected(row, corrected_utc[row.capture_id])
        for row in transaction.execute(wanted)
        if row.capture_id in corrected_utc
    )


def _corrected(row: Row, corrected_utc: str) -> CorrectedCapture:
    setup = setup_from_json(row.setup)
    return CorrectedCapture(
        row.capture_id,
        row.session_id,
        row.pseudonym,
        setup.protocol,
        row.view,
        datetime.fromisoformat(corrected_utc),
        setup.rotation_deg,
    )


def _last_corrections(transaction: Transaction) -> dict[str, str]:
    """Return when a hand last corrected a marker, in what is in force, by capture."""
    in_force = (
        select(CORRECTIONS.c.capture_id, CORRECTIONS.c.made_utc, CORRECTIONS.c.content)
        .join(CAPTURES, CAPTURES.c.capture_id == CORRECTIONS.c.capture_id)
        .where(CORRECTIONS.c.position < CAPTURES.c.n_done)
        .order_by(CORRECTIONS.c.made_utc)
    )
    return {
        row.capture_id: row.made_utc
        for row in transaction.execute(in_force)
        if _is_by_hand(correction_from_json(row.content))
    }


def _is_by_hand(correction: Correction) -> bool:
    """Say whether somebody corrected a marker: no model learns from names that a model gave."""
    return isinstance(correction, MarkerCorrection) and not correction.is_by_program


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


@dataclass(frozen=True, slots=True, eq=False)
class HistoryChange:
    """What was detected, the undo stack that somebody saw, and what he made of it."""

    detected: tuple[Marker, ...]
    seen: CorrectionHistory
    mine: CorrectionHistory


def bring_together(
    transaction: Transaction,
    audit: AuditLog,
    capture: Row,
    change: HistoryChange,
    decisions: Collection[Decision],
) -> None:
    """Save a change of the undo stack together with what others corrected meanwhile.

    Raises
    ------
    ConflictError
        Both corrected the same marker in different ways, and nobody decided.
    """
    theirs = history_of(transaction, capture)
    if _content(theirs) == _content(change.seen):
        save_history(transaction, audit, capture, change.mine)
        return
    merge = HistoryMerge(change.detected, change.seen, theirs, change.mine)
    conflicts = [
        Conflict(one.name, one.theirs, one.mine, *_author(transaction, capture, one.name))
        for one in merge.clashes
    ]
    taken = {name: one == "mine" for name, one in settle(conflicts, decisions).items()}
    save_history(transaction, audit, capture, merge.history(taken))
    for lost in merge.lost(taken):  # readable in the table, as what was replaced is
        number = _add_correction(transaction, audit, capture, None, correction_to_json(lost))
        audit.write(
            transaction, "change", capture.capture_id, correction="set aside", number=number
        )


def _content(history: CorrectionHistory) -> tuple[list[str], int]:
    return [correction_to_json(one) for one in history.corrections], history.n_done


def _author(transaction: Transaction, capture: Row, name: str) -> tuple[str, datetime]:
    """Return who corrected a marker last, and when."""
    newest = (
        select(CORRECTIONS)
        .where(CORRECTIONS.c.capture_id == capture.capture_id, CORRECTIONS.c.position.is_not(None))
        .order_by(CORRECTIONS.c.position.desc())
    )
    for row in transaction.execute(newest):
        one = correction_from_json(row.content)
        if isinstance(one, MarkerCorrection) and name in (
            marker.label for marker in (one.before, one.after) if marker is not None
        ):
            return row.operator, datetime.fromisoformat(row.made_utc)
    return last_change(transaction, capture.capture_id)


def _add_correction(
    transaction: Transaction, audit: AuditLog, capture: Row, position: int | None, content: str
) -> int:
    return add_numbered_row(
        transaction,
        CORRECTIONS,
        capture_id=capture.capture_id,
        position=position,
        content=content,
        made_utc=audit.now(),
        operator=audit.operator,
    )


class _Changes:
    """Makes one change of the stack after the other, each with its line in the log."""

    def __init__(
        self, transaction: Transaction, audit: AuditLog, capture: Row, stack: list[Row]
    ) -> None:
        self._transaction = transaction
        self._audit = audit
        self._capture = capture
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
        position = len(self._numbers)
        number = _add_correction(self._transaction, self._audit, self._capture, position, content)
        self._numbers.append(number)
        self._n_done += 1
        self._log(number, kind)

    def _log(self, number: int, what: str) -> None:
        subject = self._capture.capture_id
        self._audit.write(self._transaction, "change", subject, correction=what, number=number)


def _stack(transaction: Transaction, capture_id: str) -> list[Row]:
    columns = CORRECTIONS.c
    in_order = (
        select(CORRECTIONS)
        .where(columns.capture_id == capture_id, columns.position.is_not(None))
        .order_by(columns.position)
    )
    return list(transaction.execute(in_order))
