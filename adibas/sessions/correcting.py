"""The undo stack of a capture in the tables; corrections that left it stay readable there."""

from itertools import takewhile

from sqlalchemy import select
from sqlalchemy.orm import Session as Transaction

from adibas.data.corrections import CorrectionHistory
from adibas.sessions.audit import AuditLog
from adibas.sessions.documents import correction_from_json, correction_to_json
from adibas.sessions.schema import CaptureRecord, CorrectionRecord


def history_of(transaction: Transaction, capture: CaptureRecord) -> CorrectionHistory:
    """Return the undo stack of a capture."""
    stack = _stack(transaction, capture.capture_id)
    return CorrectionHistory(
        tuple(correction_from_json(record.content) for record in stack), capture.n_done
    )


def save_history(
    transaction: Transaction, audit: AuditLog, capture: CaptureRecord, history: CorrectionHistory
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
    transaction.flush()


class _Changes:
    """Makes one change of the stack after the other, each with its line in the log."""

    def __init__(
        self,
        transaction: Transaction,
        audit: AuditLog,
        capture: CaptureRecord,
        stack: list[CorrectionRecord],
    ) -> None:
        self._transaction = transaction
        self._audit = audit
        self._capture = capture
        self._stack = stack

    def move_to(self, n_done: int) -> None:
        """Undo or do again until `n_done` corrections are in force."""
        for undone in reversed(self._stack[n_done : self._capture.n_done]):
            self._log(undone, "undo")
        for redone in self._stack[self._capture.n_done : n_done]:
            self._log(redone, "redo")
        self._capture.n_done = n_done

    def forget_from(self, position: int) -> None:
        """Take corrections off the stack; they stay in the table."""
        for left in self._stack[position:]:
            left.position = None
        del self._stack[position:]

    def add(self, kind: str, content: str) -> None:
        """Put a correction on the stack."""
        made = CorrectionRecord(
            capture_id=self._capture.capture_id,
            position=len(self._stack),
            content=content,
            made_utc=self._audit.now(),
            operator=self._audit.operator,
        )
        self._transaction.add(made)
        self._transaction.flush()
        self._stack.append(made)
        self._capture.n_done += 1
        self._log(made, kind)

    def _log(self, record: CorrectionRecord, what: str) -> None:
        self._audit.write(
            self._transaction,
            "change",
            record.capture_id,
            correction=what,
            number=record.correction_id,
        )


def _stack(transaction: Transaction, capture_id: str) -> list[CorrectionRecord]:
    in_order = (
        select(CorrectionRecord)
        .where(CorrectionRecord.capture_id == capture_id, CorrectionRecord.position.is_not(None))
        .order_by(CorrectionRecord.position)
    )
    return list(transaction.scalars(in_order))
