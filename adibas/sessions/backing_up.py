"""Backs the whole store up into one sealed file, while it is in use."""

import errno
import hashlib
import shutil
import threading
import time
import uuid
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from sqlalchemy import select

from adibas.errors import FileError, PassphraseError
from adibas.files import UNFINISHED, cannot_read, cannot_write, check_place, written_whole
from adibas.progress import Progress
from adibas.sessions.audit import AuditLog
from adibas.sessions.backup_format import (
    PIECE_BYTES,
    BackupWriter,
    header_of,
)
from adibas.sessions.database import DATABASE_FILE, Database
from adibas.sessions.defaults import BACKUP_ENDING
from adibas.sessions.key_file import KeyFile, fingerprint_of, read_key_file
from adibas.sessions.key_wrapping import Argon2Params
from adibas.sessions.keys import moved_behind
from adibas.sessions.places import ID_LENGTH
from adibas.sessions.roles import Permission, may
from adibas.sessions.schema import FILES, RECORDINGS
from adibas.sessions.sealed_files import SealedFiles
from adibas.sessions.sealed_folder import SealedFolder
from adibas.sessions.sqlite_file import SqliteFile

if TYPE_CHECKING:
    from adibas.sessions.backup_format import BackupHeader
    from adibas.sessions.backup_schedule import BackupPlan, KeptBackup
    from adibas.sessions.merging import MergeSummary
    from adibas.sessions.verification import VerifyReport

SECONDS_UNTIL_LITTER = 86_400.0
"""An unfinished file that is older than a day is written by nobody any more."""


@dataclass(frozen=True, slots=True)
class BackupSummary:
    """What was written.

    Attributes
    ----------
    n_files, n_bytes : int
        Inside, the database included.
    damaged : tuple of str
        Files of the store that are missing or not as they were saved; the rest is backed up.
    """

    n_files: int
    n_bytes: int
    damaged: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class _Member:
    """A file of the store: its name in the backup, its place, its checksum where one is known."""

    name: str
    path: Path
    sha256: str | None


class Backups:
    """Makes backups of an open store.

    Parameters
    ----------
    folder : Path
        The store.
    key : bytes
        Of the store.
    folders : tuple of SealedFolder
        Pictures, recordings, codings.
    making : set of str
        Recordings that are being made.
    """

    def __init__(
        self,
        database: Database,
        audit: AuditLog,
        key: bytes,
        folders: tuple[SealedFolder, SealedFolder, SealedFiles],
        making: set[str],
    ) -> None:
        self._database = database
        self._audit = audit
        self._key = key
        self._folders = folders
        self._making = making
        self._folder = database.folder
        self._one_restore = threading.Lock()

    def write(
        self,
        path: Path,
        passphrase: str | None = None,
        *,
        params: Argon2Params | None = None,
        progress: Progress | None = None,
    ) -> BackupSummary:
        """Write everything that is saved now to `path`; the log gets its line before.

        Parameters
        ----------
        passphrase : str, optional
            With which the backup opens; without it, the one of the store, or those of its people,
            who have their roles in what is restored from it, too.
        progress : callable, optional
            Called with (bytes done, bytes in all); what it raises ends the backup, and no file is
            left.

        Raises
        ------
        PassphraseError
            The store has none, or the given one is too short.
        FileError
            The disk is full, `path` cannot be written, or lies within the store. What stood there
            is untouched.
        StoreError
            The database cannot be copied; no file is left either.
        """
        self._audit.require(Permission.BACK_UP)
        return self._write(path, passphrase, params, progress)

    def _write(
        self,
        path: Path,
        passphrase: str | None,
        params: Argon2Params | None,
        progress: Progress | None,
    ) -> BackupSummary:
        key_file = self._key_behind(passphrase, params)
        _check_outside(path, self._folder)
        check_place(path)
        with written_whole(path) as unfinished:
            _remove_litter(path.parent, unfinished)
            self._audit.append("backup", "store")
            log_end = self._audit.end()  # before the copy, so that the line is in it
            with self._snapshot(unfinished) as members, unfinished.open("wb") as file:
                n_bytes = sum(_size(member.path) for member in members)
                _check_room(path, n_bytes)
                header = header_of(key_file, self._audit.now(), n_bytes, log_end)
                writer = BackupWriter(file, header, self._key)
                summary = _write_all(writer, members, n_bytes, progress)
        return summary

    def kept(self, folder: Path) -> "tuple[KeptBackup, ...]":
        """Return the backups of this store in a folder, newest first.

        Those of a copy of it that went on otherwise are none: they hold what is not here, and not
        what is.

        Raises
        ------
        FileError
            The folder cannot be read.
        """
        from adibas.sessions.backup_schedule import backups_in

        file = read_key_file(self._folder)
        if file is None:
            return ()
        found = backups_in(folder, file.store_id, self._audit.now_utc())
        return tuple(one for one in found if one.log_end is None or self._audit.has(one.log_end))

    def days_since(self, folder: Path) -> float | None:
        """Return how old the newest backup in a folder is; None without any."""
        from adibas.sessions.backup_schedule import days_since

        return days_since(self.kept(folder), self._audit.now_utc())

    def write_planned(
        self,
        plan: "BackupPlan",
        passphrase: str | None = None,
        *,
        params: Argon2Params | None = None,
        progress: Progress | None = None,
    ) -> "tuple[Path, BackupSummary] | None":
        """Make a backup where one is due, and remove older ones than the plan keeps.

        None is removed while the store lacks files: an older one may be the last that has them.
        Whoever works may let one be made behind the passphrases that open the store; older ones
        are removed where an administrator works.

        Returns
        -------
        made : (Path, BackupSummary) or None
            None where none is due.

        Raises
        ------
        PassphraseError, FileError
            See `write`; the older ones are untouched then.
        """
        from adibas.sessions.backup_schedule import is_due, name_at, remove_older

        if passphrase is not None:
            self._audit.require(Permission.BACK_UP)
        now_utc = self._audit.now_utc()
        if not is_due(self.kept(plan.folder), now_utc, plan.every_days):
            return None
        path = plan.folder / name_at(now_utc, self._own_key_file().store_id, self._audit.end())
        summary = self._write(path, passphrase, params, progress)
        if not summary.damaged and may(self._audit.role, Permission.BACK_UP):
            remove_older(self.kept(plan.folder), plan.keep)
        return path, summary

    def restore(
        self, path: Path, passphrase: str | None = None, progress: Progress | None = None
    ) -> "MergeSummary":
        """Add what a backup has and the store has not; nothing that is here is lost.

        Parameters
        ----------
        passphrase : str, optional
            Of the backup; not needed for one of this very store.

        Raises
        ------
        PassphraseError
            The passphrase is missing or wrong.
        StoreError
            The backup is damaged, the store is read-only, or the disk is full. Nothing was changed.
        FileError
            The backup cannot be read.
        """
        from adibas.sessions.merged_files import restore_merged

        self._audit.require(Permission.BACK_UP)
        store = (self._database, self._audit, self._key)
        with self._one_restore:
            return restore_merged(path, passphrase, store, self._making, progress)

    def verify(
        self, path: Path, passphrase: str | None = None, progress: Progress | None = None
    ) -> "tuple[BackupHeader, VerifyReport]":
        """Check a backup in the store's folder; one of this very store needs no passphrase.

        See `verify_backup`.
        """
        from adibas.sessions.trial_restore import verify_backup

        self._audit.require(Permission.BACK_UP)
        return verify_backup(path, passphrase, progress, room=self._folder, key=self._key)

    def _own_key_file(self) -> KeyFile:
        file = read_key_file(self._folder)
        if file is None or fingerprint_of(self._key) != file.fingerprint:
            raise PassphraseError(
                "The patient store has lost its key.json. Restore that file from a backup."
            )
        return file

    def _key_behind(self, passphrase: str | None, params: Argon2Params | None) -> KeyFile:
        """Return the store's key behind a passphrase; None: what opens the store itself."""
        file = self._own_key_file()
        if passphrase is not None:
            params = params or Argon2Params()
            return moved_behind(file, self._key, passphrase, params)
        if file.place == "keyring":
            raise PassphraseError(
                "The key of this patient store is in the desktop's keyring, which a backup does "
                "not have. Choose a passphrase for the backup, and keep it safe."
            )
        return file

    @contextmanager
    def _snapshot(self, beside: Path) -> Iterator[list[_Member]]:
        """Give what belongs to one state of the database, that state itself first."""
        copy = beside.with_name(f".{uuid.uuid4().hex}.db")
        with ExitStack() as at_the_end:
            for ending in ("", "-wal", "-shm"):
                at_the_end.callback(Path(f"{copy}{ending}").unlink, missing_ok=True)
            self._database.copy_to(copy, self._key)
            file = SqliteFile(copy.parent, self._key, copy.name)
            snapshot = Database(file, is_read_only=True)
            try:
                members = self._members(snapshot)
            finally:
                snapshot.close()
            yield [_Member(DATABASE_FILE, copy, None), *members]

    def _members(self, snapshot: Database) -> list[_Member]:
        pictures, recordings, codings = self._folders
        with snapshot.reading() as transaction:
            files = transaction.execute(
                select(FILES.c.file_id, FILES.c.sha256).where(FILES.c.sha256.is_not(None))
            ).all()
            closed = transaction.execute(
                select(RECORDINGS.c.recording_id, RECORDINGS.c.sha256).where(RECORDINGS.c.is_closed)
            ).all()
        known = {recording_id for recording_id, _sha256 in closed}
        coded = [(one, None) for one in sorted(codings.ids()) if one[:ID_LENGTH] in known]
        return [
            _Member(f"{folder.folder.name}/{file_id}", folder.path_of(file_id), sha256)
            for folder, rows in ((pictures, files), (recordings, closed), (codings, coded))
            for file_id, sha256 in rows
        ]


def _write_all(
    writer: BackupWriter, members: list[_Member], n_bytes: int, progress: Progress | None
) -> BackupSummary:
    def tell() -> None:
        if progress is not None:
            progress(min(writer.n_bytes, n_bytes), n_bytes)

    damaged = [member.name for member in members if not _is_written(writer, member, tell)]
    writer.finish()
    return BackupSummary(writer.n_files, writer.n_bytes, tuple(damaged))


def _is_written(writer: BackupWriter, member: _Member, tell: Callable[[], None]) -> bool:
    """Append a file, and say whether it is as it was saved."""
    digest = hashlib.sha256()
    try:
        for number, block in enumerate(_blocks(member.path)):
            if number == 0:
                writer.begin_file(member.name)
            digest.update(block)
            writer.write(block)
            tell()
    except FileError:
        if member.name == DATABASE_FILE:  # without it there is nothing to restore
            raise
        return False
    return member.sha256 in (None, digest.hexdigest())


def _blocks(path: Path) -> Iterator[bytes]:
    """Give the content in one block at least.

    Raises
    ------
    FileError
        It cannot be opened, or not be read up to its end.
    """
    try:
        with path.open("rb") as file:
            yield file.read(PIECE_BYTES)
            while block := file.read(PIECE_BYTES):
                yield block
    except OSError as error:
        raise cannot_read(path, error) from error


def _size(path: Path) -> int:
    try:
        return path.stat().st_size
    except OSError:
        return 0


def _check_room(path: Path, n_bytes: int) -> None:
    if shutil.disk_usage(path.parent).free < n_bytes:
        raise cannot_write(path, OSError(errno.ENOSPC, ""))


def _check_outside(path: Path, folder: Path) -> None:
    """Keep files of the store from being replaced, and backups from being lost with it."""
    if path.resolve().is_relative_to(folder.resolve()):
        raise FileError(
            "{file} would lie in the folder of the store. Choose a place outside of it, best on "
            "another disk.",
            file=path.name,
        )


def _remove_litter(folder: Path, mine: Path) -> None:
    """Remove what backups that were killed left in `folder`, as far as it can be removed."""
    for path in folder.iterdir():
        is_ours = UNFINISHED.fullmatch(path.name) and path.suffix.startswith((BACKUP_ENDING, ".db"))
        if not is_ours or path == mine:
            continue
        with suppress(OSError):  # another backup may just end, or its owner be somebody else
            if time.time() - path.stat().st_mtime > SECONDS_UNTIL_LITTER:
                path.unlink()
