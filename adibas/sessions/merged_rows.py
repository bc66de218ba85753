"""One thing that was changed in a backup and in the store: the newer one, and all of the other."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from typing import TypeVar

from sqlalchemy import select, update

from adibas.data.patients import Identity
from adibas.sessions.patient_search import identity_of
from adibas.sessions.patients import identity_columns
from adibas.sessions.rows import Row, Transaction, add_numbered_row, change_row, row_of, values_of
from adibas.sessions.schema import CAPTURES, CORRECTIONS, IDENTITIES, PATIENTS, SESSIONS
from adibas.texts import translate as _

Value = TypeVar("Value")

ALL_FIELDS = ""
"""What was changed, where the audit log names no field, as of corrections and of what is new."""


@dataclass(frozen=True, slots=True)
class Side:
    """The store, or the backup.

    Attributes
    ----------
    last_changes : Mapping
        When each field of each thing was changed last, as its audit log says, by id and field; the
        field is `ALL_FIELDS` where the log names none.
    is_right : bool
        It went on from the other one, so that it knows everything that the other one says.
    """

    transaction: Transaction
    last_changes: Mapping[tuple[str, str], str]
    is_right: bool = False

    def is_newer(self, other: "Side", subject: str, group: str = ALL_FIELDS) -> bool:
        """Say whether a field was changed here after it was changed there."""
        return self.last_change(subject, group) > other.last_change(subject, group)

    def last_change(self, subject: str, group: str) -> str:
        """Return when a field was changed last; empty where the log does not say."""
        return max(self.last_changes.get((subject, one), "") for one in (group, ALL_FIELDS))


def merge_patient(ours: Side, theirs: Side, pseudonym: str) -> tuple[str, ...] | None:
    """Bring both versions of a patient together; what does not hold goes into the notes.

    Returns
    -------
    fields : tuple of str or None
        What was changed here; empty where our side stays as it is, None where both are the same.
    """
    rows = [_patient_rows(side.transaction, pseudonym) for side in (ours, theirs)]
    (our_row, our_identity), (their_row, their_identity) = rows
    our_plain, their_plain = (our_row.sex, our_row.notes), (their_row.sex, their_row.notes)
    if (our_plain, our_identity) == (their_plain, their_identity):
        return None
    if ours.is_right:
        return ()
    newer_first = partial(_newer_first, ours, theirs, pseudonym)
    identity, old_identity = newer_first("identity", (our_identity, their_identity))
    (sex, old_sex), (newer_notes, old_notes) = (
        newer_first(name, (getattr(our_row, name), getattr(their_row, name)))
        for name in ("sex", "notes")
    )
    others = [
        *([_identity_line(old_identity)] if old_identity != identity else []),
        *([old_sex] if old_sex != sex else []),
        old_notes,
    ]
    notes = _both(newer_notes, others)
    fields = [
        name
        for name, new, now in (("sex", sex, our_row.sex), ("notes", notes, our_row.notes))
        if new != now
    ]
    if fields:
        change_row(ours.transaction, PATIENTS, pseudonym, sex=sex, notes=notes)
    if identity != our_identity:
        columns = identity_columns(pseudonym, identity)
        change_row(ours.transaction, IDENTITIES, pseudonym, **columns)
        fields += ["identity"]
    return tuple(fields)


def merge_session(ours: Side, theirs: Side, session_id: str) -> tuple[str, ...] | None:
    """Bring both versions of a session together; see `merge_patient`."""
    found = [row_of(side.transaction, SESSIONS, session_id) for side in (ours, theirs)]
    here, there = (row for row in found if row is not None)
    our_values = {"notes": here.notes, "setup": here.setup}
    if our_values == {"notes": there.notes, "setup": there.setup}:
        return None
    if ours.is_right:
        return ()
    newer_first = partial(_newer_first, ours, theirs, session_id)
    setup, old_setup = newer_first("setup", (here.setup, there.setup))
    notes, old_notes = newer_first("notes", (here.notes, there.notes))
    others = [*([old_setup] if old_setup != setup else []), old_notes]
    values = {"notes": _both(notes, others), "setup": setup}
    changed = tuple(name for name, value in values.items() if value != our_values[name])
    if changed:
        change_row(ours.transaction, SESSIONS, session_id, **values)
    return changed


def merge_corrections(ours: Side, theirs: Side, capture_id: str) -> tuple[str, ...] | None:
    """Bring both undo stacks of a capture together: the newer one holds, the other stays readable.

    What is not on the stack stays in the table of corrections, as what was replaced does.
    """
    here, there = (_corrections(side.transaction, capture_id) for side in (ours, theirs))
    n_done = [_n_done(side.transaction, capture_id) for side in (ours, theirs)]
    our_stack, their_stack = (_stack(rows) for rows in (here, there))
    if (our_stack, n_done[0]) == (their_stack, n_done[1]) and set(there) <= set(here):
        return None
    if ours.is_right:
        return ()
    missing = [key for key in there if key not in here]
    is_theirs_newer = theirs.is_newer(ours, capture_id)
    if not missing and not is_theirs_newer:
        return ()
    if is_theirs_newer:
        off = update(CORRECTIONS).where(CORRECTIONS.c.capture_id == capture_id)
        ours.transaction.execute(off.values(position=None))
        change_row(ours.transaction, CAPTURES, capture_id, n_done=n_done[1])
    for key, row in there.items():
        position = row.position if is_theirs_newer else None
        if key in missing:
            values = values_of(row, "correction_id") | {"position": position}
            add_numbered_row(ours.transaction, CORRECTIONS, **values)
        elif is_theirs_newer:
            number = here[key].correction_id
            change_row(ours.transaction, CORRECTIONS, number, position=position)
    return ("corrections",)


def _newer_first(
    ours: Side, theirs: Side, subject: str, group: str, both: tuple[Value, Value]
) -> tuple[Value, Value]:
    """Return our version of a field and theirs, the one first that was changed later."""
    mine, other = both
    return (other, mine) if theirs.is_newer(ours, subject, group) else (mine, other)


def _both(notes: str, others: list[str]) -> str:
    """Return notes with all that the other version says and they do not."""
    lines = f"\n{notes}\n"
    missing = [text for text in map(str.strip, others) if text and f"\n{text}\n" not in lines]
    if not missing:
        return notes
    head = _("From the other version, when a backup was restored:")
    return "\n".join([*([notes, ""] if notes else []), head, *missing])


def _identity_line(identity: Identity) -> str:
    born = "" if identity.birth_date is None else identity.birth_date.isoformat()
    return ", ".join(part for part in (identity.name, born, identity.record_number) if part)


def _patient_rows(transaction: Transaction, pseudonym: str) -> tuple[Row, Identity]:
    row = transaction.execute(select(PATIENTS).where(PATIENTS.c.pseudonym == pseudonym)).one()
    whose = select(IDENTITIES).where(IDENTITIES.c.pseudonym == pseudonym)
    return row, identity_of(transaction.execute(whose).one())


def _corrections(transaction: Transaction, capture_id: str) -> dict[tuple[str, str, str, int], Row]:
    """Return the corrections of a capture by what tells them apart."""
    theirs = (
        select(CORRECTIONS)
        .where(CORRECTIONS.c.capture_id == capture_id)
        .order_by(CORRECTIONS.c.correction_id)
    )
    found: dict[tuple[str, str, str, int], Row] = {}
    for row in transaction.execute(theirs):
        key = (row.content, row.made_utc, row.operator)
        again = sum(one[:3] == key for one in found)
        found[*key, again] = row
    return found


def _stack(rows: dict[tuple[str, str, str, int], Row]) -> list[str]:
    on_it = [row for row in rows.values() if row.position is not None]
    return [row.content for row in sorted(on_it, key=lambda row: int(row.position))]


def _n_done(transaction: Transaction, capture_id: str) -> int:
    of_it = select(CAPTURES.c.n_done).where(CAPTURES.c.capture_id == capture_id)
    return int(transaction.scalars(of_it).one())
