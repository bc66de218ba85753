"""No capture without a consent: what is asked before anything of a patient is recorded."""

from collections.abc import Iterator
from contextlib import contextmanager

from sqlalchemy import select

from adibas.data.patients import PURPOSE_OF_CAPTURE
from adibas.errors import ConsentError
from adibas.sessions.audit import AuditLog
from adibas.sessions.database import Database
from adibas.sessions.json_line import from_json
from adibas.sessions.rows import Transaction
from adibas.sessions.schema import CONSENTS

LACKING = "consent"
"""What a refusal lacks, in the audit log."""


def no_consent() -> ConsentError:
    """Say that nothing of a patient may be captured, why, and what to do."""
    return ConsentError(
        "Nothing can be captured of this patient: no consent for treatment stands on record. Ask "
        "for it, and record it under Patients, Consent."
    )


def require_consent(transaction: Transaction, pseudonym: str) -> None:
    """See within a change that the patient's consent to being measured stands.

    Raises
    ------
    ConsentError
        None stands: there is none, it was withdrawn, or it is for something else alone.
    """
    standing = select(CONSENTS.c.purposes).where(
        CONSENTS.c.pseudonym == pseudonym, CONSENTS.c.withdrawn_utc.is_(None)
    )
    found = transaction.scalars(standing)
    if not any(PURPOSE_OF_CAPTURE in from_json(purposes) for purposes in found):
        raise no_consent()


@contextmanager
def changing_with_consent(
    database: Database, audit: AuditLog, subject: str
) -> Iterator[Transaction]:
    """Give a transaction in which a consent is asked for; that it lacks is a line of the log.

    Parameters
    ----------
    subject : str
        To what something would be added.

    Raises
    ------
    ConsentError
        As `require_consent` says within the block; nothing was changed then.
    StoreError
        The store is read-only, or the disk is full.
    """
    try:
        with database.changing() as transaction:
            yield transaction
    except ConsentError:
        audit.append("refuse", subject, lacks=LACKING)
        raise
