"""The store of patients and sessions: opened once, used from any thread.

Its parts are imported when they are first used: patients are listed before anybody needs the rest.
"""

import logging
import threading
from collections.abc import Callable
from functools import cached_property, partial
from pathlib import Path
from typing import TYPE_CHECKING, Self

from sqlalchemy import select

from adibas.errors import StoreError
from adibas.files import unfinished_in
from adibas.progress import Progress
from adibas.sessions.audit import AuditLog
from adibas.sessions.database import Database
from adibas.sessions.kept_files import KeptFiles, remove_leftovers
from adibas.sessions.left_files import Left, files_at_rest
from adibas.sessions.lock import cannot_use
from adibas.sessions.merged_files import finish_merge
from adibas.sessions.patients import Patients
from adibas.sessions.person_keys import Person
from adibas.sessions.places import CODINGS_FOLDER, PICTURES_FOLDER, RECORDINGS_FOLDER
from adibas.sessions.roles import Permission, Role, may
from adibas.sessions.schema import RECORDINGS
from adibas.sessions.sealed_files import SealedFiles
from adibas.sessions.sealing import AesSeal, key_for
from adibas.sessions.trial_restore import remove_trial

if TYPE_CHECKING:
    from adibas.sessions.backing_up import Backups
    from adibas.sessions.captures import Captures
    from adibas.sessions.disk_use import DiskForecast
    from adibas.sessions.finding_holdings import FindHoldings
    from adibas.sessions.people import People
    from adibas.sessions.purging import Purge
    from adibas.sessions.recovery import Recovery
    from adibas.sessions.retention import Retention
    from adibas.sessions.sealed_folder import SealedFolder
    from adibas.sessions.stored_recordings import Recordings
    from adibas.sessions.verification import VerifyReport
    from adibas.sessions.visits import Sessions

logger = logging.getLogger(__name__)

DRAFTS = "adibas-drafts-1"
STORE_AS_SUBJECT = "store"
"""The audit log's word for the whole store."""


class SessionStore:
    """Everything that is kept of the patients; made by `open_store` in `opening.py`.

    Calls are made one after the other, from whatever thread. As a context manager it is closed at
    the end.

    Attributes
    ----------
    folder : Path
        Where it is.
    is_read_only : bool
        True while another process or window holds it: every change raises StoreError.
    server : str
        Where its database is, which others may change, too; empty where it is a file.
    patients, sessions, recordings, captures
        See `Patients`, `Sessions`, `Recordings`, `Captures`.
    audit : AuditLog
        Who did what.
    drafts : AesSeal
        Seals what has to outlive the open store; only this store, opened again, reads it.
    """

    def __init__(
        self,
        folder: Path,
        database: Database,
        let_go: Callable[[], None],
        audit: AuditLog,
        key: bytes,
    ) -> None:
        self.folder = folder
        self.drafts = AesSeal(key_for(DRAFTS, key), DRAFTS)
        self._key = key
        self.is_read_only = database.is_read_only
        self.server = database.server
        self.audit = audit
        self._database = database
        self._let_go = let_go
        self._pictures = SealedFiles(folder / PICTURES_FOLDER)
        self._files = KeptFiles(database, self._pictures)
        self.patients = Patients(database, audit, lambda one: self._purge().patient(one))
        self._recordings: Recordings | None = None
        self._making_recordings = threading.Lock()

    @cached_property
    def sessions(self) -> "Sessions":
        """The sessions of the patients."""
        from adibas.sessions.visits import Sessions

        return Sessions(self._database, self.audit, lambda one: self._purge().session(one))

    @cached_property
    def captures(self) -> "Captures":
        """The captures of the sessions."""
        from adibas.sessions.captures import Captures

        return Captures(self._database, self.audit, self._files)

    @property
    def recordings(self) -> "Recordings":
        """The recordings of the sessions."""
        from adibas.sessions.sealed_recordings import SealedRecordings
        from adibas.sessions.stored_recordings import Recordings

        with self._making_recordings:  # only one may know which recordings are being made
            if self._recordings is None:
                sealed = SealedRecordings(self.folder / RECORDINGS_FOLDER)
                codings = SealedFiles(self.folder / CODINGS_FOLDER)
                self._recordings = Recordings(self._database, self.audit, sealed, codings)
            return self._recordings

    @cached_property
    def backups(self) -> "Backups":
        """The making of backups."""
        from adibas.sessions.backing_up import Backups

        recordings = self.recordings
        folders = (self._pictures, recordings.sealed, recordings.codings)
        making = recordings.in_the_making
        return Backups(self._database, self.audit, self._key, folders, making)

    @cached_property
    def people(self) -> "People":
        """Who may open the store."""
        from adibas.sessions.people import People

        return People(self.folder, self._database, self.audit, self._key)

    @cached_property
    def recovery(self) -> "Recovery":
        """The recovery key: since when there is one, and the making of another."""
        from adibas.sessions.recovery import Recovery

        return Recovery(self.folder, self._database, self.audit, self._key)

    @property
    def person(self) -> Person | None:
        """Whose passphrase opened the store; None in a store without people."""
        return self.audit.person

    @property
    def role(self) -> Role:
        """What whoever has it open may; in a store without people everything."""
        return self.audit.role

    def may(self, permission: Permission) -> bool:
        """Say whether whoever has it open may do something; nothing is noted."""
        return may(self.role, permission)

    def require(self, permission: Permission, subject: str = STORE_AS_SUBJECT) -> None:
        """See that whoever has it open may do something; a refusal is noted in the audit log.

        Raises
        ------
        NotAllowedError
            It is for another role; nothing was done.
        """
        self.audit.require(permission, subject)

    @cached_property
    def retention(self) -> "Retention":
        """The patients whose time is over."""
        from adibas.sessions.retention import Retention

        return Retention(self._database, self.audit, self._purge)

    @cached_property
    def holdings(self) -> "FindHoldings":
        """Everything that is held of a patient."""
        from adibas.sessions.finding_holdings import FindHoldings

        return FindHoldings(self._database, self.audit, self._pictures, self.recordings)

    def forecast_disk(self) -> "DiskForecast":
        """Say when the disk will be full at the rate of the last 90 days.

        Raises
        ------
        StoreError
            The disk cannot be asked.
        """
        from adibas.sessions.disk_use import forecast_disk

        return forecast_disk(self.folder, self._database, self._pictures, self.audit.now_utc())

    def _purge(self) -> "Purge":
        from adibas.sessions.purging import Purge

        return Purge(self._database, self.audit, self._pictures, self.recordings)

    def tidy(self) -> None:
        """Finish what a crash interrupted; for the one opener that may write."""
        left: Left = files_at_rest if self._database.is_shared else set
        try:
            for path in left(unfinished_in(self.folder)):
                path.unlink(missing_ok=True)
        except OSError as error:
            raise cannot_use(self.folder, error) from error
        codings = SealedFiles(self.folder / CODINGS_FOLDER)
        for remove in (
            partial(self._files.finish, left),
            partial(codings.remove_unfinished, left),
            partial(finish_merge, self._database),
            partial(remove_trial, self.folder),
            partial(remove_leftovers, self._database, self._sealed_folders),
        ):
            try:
                remove()
            except StoreError as error:
                # What stays has no use and no reader; the next opening tries again.
                logger.warning("a file that is not needed any more is not removed: %s", error)
        unfinished = select(RECORDINGS.c.recording_id).where(RECORDINGS.c.is_closed.is_(False))
        with self._database.reading() as transaction:
            has_unfinished = transaction.execute(unfinished.limit(1)).first() is not None
        if has_unfinished:
            self.recordings.recover(left)

    def _sealed_folders(self) -> "tuple[SealedFolder, ...]":
        return self._pictures, self.recordings.sealed, self.recordings.codings

    def verify(self, progress: Progress | None = None) -> "VerifyReport":
        """Check the database, the chain of the audit log, and every file against its checksum.

        Parameters
        ----------
        progress : callable, optional
            Called with (things checked, things in all).
        """
        from adibas.sessions.verification import Verification

        parts = (self._database, self.audit, self._pictures, self.recordings)
        return Verification(*parts).run(progress)

    @property
    def operator(self) -> str:
        """Who works: stands in new sessions and in the audit log; where it has people, one."""
        return self.audit.operator

    @operator.setter
    def operator(self, name: str) -> None:
        self.audit.operator = name

    def note_export(self, kind: str, *ids: str, receiver: str = "") -> None:
        """Write into the audit log that something left the store.

        Parameters
        ----------
        kind : str
            Of what, such as ``excel`` or ``recording``.
        ids : str
            Of whom: pseudonyms or ids.
        receiver : str
            Who gets it; no name of a file, which may be a patient's.

        Raises
        ------
        NotAllowedError
            Whoever has the store open may not export; nothing may leave then.
        """
        told = {"kind": kind} | ({"receiver": receiver} if receiver else {})
        for subject in ids:
            self.require(Permission.EXPORT, subject)
        for subject in ids:
            self.audit.append("export", subject, **told)

    def close(self) -> None:
        """Let go of the store; closing twice does no harm."""
        self._database.close()
        self._let_go()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_error: object) -> None:
        self.close()
