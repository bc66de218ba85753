"""Purging: data that must be gone, keys first, with one line in the log without identity."""

from collections.abc import Callable, Sequence

from sqlalchemy import delete, insert, select

from adibas.errors import StoreError
from adibas.sessions.audit import AuditLog
from adibas.sessions.database import Database
from adibas.sessions.kept_files import remove_leftovers
from adibas.sessions.migrating import copies
from adibas.sessions.patients import found_patient
from adibas.sessions.places import ID_LENGTH
from adibas.sessions.rows import Transaction, remove_row
from adibas.sessions.schema import CAPTURES, FILES, LEFTOVERS, PATIENTS, RECORDINGS, SESSIONS
from adibas.sessions.sealed_files import SealedFiles
from adibas.sessions.sealed_folder import cannot_save
from adibas.sessions.stored_recordings import Recordings
from adibas.sessions.visits import found_session


class Purge:
    """Removes patients and sessions for good."""

    def __init__(
        self, database: Database, audit: AuditLog, pictures: SealedFiles, recordings: Recordings
    ) -> None:
        self._database = database
        self._audit = audit
        self._pictures = pictures
        self._recordings = recordings

    def patient(
        self, pseudonym: str, *, still: Callable[[Transaction], bool] | None = None
    ) -> bool:
        """Remove a patient with everything that belongs to it.

        Parameters
        ----------
        still : callable, optional
            Says within the same change whether the patient is to go, who may have come back.

        Returns
        -------
        is_gone : bool
            False where `still` says no; nothing was changed then.

        Raises
        ------
        StoreError
            There is no such patient, a recording is being made, or the store is read-only.
        """
        theirs = select(SESSIONS.c.session_id).where(SESSIONS.c.pseudonym == pseudonym)
        with self._database.changing() as transaction:
            if still is not None and not still(transaction):
                return False
            found_patient(transaction, pseudonym)
            sessions = list(transaction.scalars(theirs))
            self._let_go(transaction, sessions)
            remove_row(transaction, PATIENTS, pseudonym)
            self._audit.write(transaction, "purge", pseudonym, sessions=len(sessions))
        self._clean()
        return True

    def session(self, session_id: str) -> None:
        """Remove a session with its captures and recordings.

        Raises
        ------
        StoreError
            There is no such session, a recording is being made, or the store is read-only.
        """
        with self._database.changing() as transaction:
            found_session(transaction, session_id)
            self._let_go(transaction, [session_id])
            remove_row(transaction, SESSIONS, session_id)
            self._audit.write(transaction, "purge", session_id)
        self._clean()

    def _let_go(self, transaction: Transaction, sessions: Sequence[str]) -> None:
        """Destroy the keys of all files of `sessions`, and remember to remove the files."""
        captures = CAPTURES.c.session_id.in_(sessions)
        recordings = RECORDINGS.c.session_id.in_(sessions)
        recording_ids = list(
            transaction.scalars(select(RECORDINGS.c.recording_id).where(recordings))
        )
        if self._in_the_making(transaction).intersection(recording_ids):
            raise StoreError(
                "A recording of this patient is being made. Stop it first, then purge."
            )
        pairs = transaction.execute(
            select(CAPTURES.c.picture_id, CAPTURES.c.surface_id).where(captures)
        )
        file_ids = [file_id for pair in pairs for file_id in pair if file_id is not None]
        transaction.execute(delete(CAPTURES).where(captures))
        transaction.execute(delete(FILES).where(FILES.c.file_id.in_(file_ids)))
        transaction.execute(delete(RECORDINGS).where(recordings))
        codings = self._recordings.codings
        coding_ids = [one for one in codings.ids() if one[:ID_LENGTH] in recording_ids]
        left = [
            {"file_id": file_id, "folder": folder.name}
            for folder, ids in (
                (self._pictures.folder, file_ids),
                (self._recordings.sealed.folder, recording_ids),
                (codings.folder, coding_ids),
            )
            for file_id in ids
        ]
        if left:
            transaction.execute(insert(LEFTOVERS), left)

    def _in_the_making(self, transaction: Transaction) -> set[str]:
        """Return what is being recorded: here, and on other workstations."""
        if not self._database.is_shared:
            return self._recordings.in_the_making
        unfinished = select(RECORDINGS.c.recording_id).where(RECORDINGS.c.is_closed.is_(False))
        return set(transaction.scalars(unfinished))

    def _clean(self) -> None:
        """Remove the files, and the data from the journal and from copies of the database."""
        recordings = self._recordings
        remove_leftovers(
            self._database, lambda: (self._pictures, recordings.sealed, recordings.codings)
        )
        self._database.empty_journal()
        try:
            for copy in copies(self._database.folder):
                copy.unlink(missing_ok=True)
        except OSError as error:
            raise cannot_save(error) from error
