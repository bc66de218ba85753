"""Brings a backup into a store in use: rows in one change, files before or after any crash.

The files wait in a folder of the store. The change of the database decides which of them belong to
it; those get their places afterwards, and what a crash leaves waiting is dealt with in the same way
at the next opening.
"""

import errno
import shutil
from pathlib import Path
from typing import TYPE_CHECKING

from sqlalchemy import select

from adibas.errors import StoreError
from adibas.files import flush_folder
from adibas.progress import Progress
from adibas.sessions.audit import AuditLog
from adibas.sessions.backup_format import BackupReader
from adibas.sessions.database import DATABASE_FILE, Database
from adibas.sessions.places import (
    CODINGS_FOLDER,
    ID_LENGTH,
    PICTURES_FOLDER,
    RECORDINGS_FOLDER,
)
from adibas.sessions.schema import FILES, RECORDINGS
from adibas.sessions.sealed_folder import SealedFolder, cannot_save

if TYPE_CHECKING:
    from adibas.sessions.merging import MergeSummary

WAITING = "restoring"
"""In the store's folder; there during a restore only."""


def restore_merged(
    path: Path,
    passphrase: str | None,
    store: tuple[Database, AuditLog, bytes],
    making: set[str],
    progress: Progress | None = None,
) -> "MergeSummary":
    """Add to a store in use what a backup has and it has not; see `merge`.

    Parameters
    ----------
    passphrase : str or None
        Of the backup; not needed for a backup of this very store.
    store : (Database, AuditLog, bytes)
        With its key.
    making : set of str
        Recordings that are being made.

    Raises
    ------
    PassphraseError
        The passphrase is missing or wrong.
    StoreError
        The backup is damaged, the store is read-only, or the disk is full. Nothing was changed.
    FileError
        The backup cannot be read.
    """
    from adibas.sessions.merging import merge
    from adibas.sessions.restoring import extract, make_present

    database, audit, own_key = store
    with BackupReader(path) as backup:
        key = own_key if backup.is_of(own_key) else backup.key(passphrase)
        database.check_writable()
        folder = database.path.parent
        waiting = _new_folder(folder / WAITING)
        try:
            _check_room(folder, path)
            kept = _Kept(database)
            extract(backup, key, waiting, wanted=kept.wants, progress=progress)
            make_present(waiting, key)
            source = Database(waiting, key, is_read_only=True)
            try:
                summary = merge(source, database, audit, making)
            finally:
                source.close()
            summary.other_codings += kept.other_codings(waiting)
        finally:
            finish_merge(database)
    return summary


def finish_merge(database: Database) -> None:
    """Give waiting files that the database knows their places, and remove the others.

    Raises
    ------
    StoreError
        The disk refuses; the next opening tries again.
    """
    folder = database.path.parent
    waiting = folder / WAITING
    if not waiting.exists():
        return
    kept = _Kept(database)
    try:
        for name in (PICTURES_FOLDER, RECORDINGS_FOLDER, CODINGS_FOLDER):
            there, here = SealedFolder(waiting / name), SealedFolder(folder / name)
            for file_id in there.ids():
                if kept.knows(name, file_id) and kept.lacks(f"{name}/{file_id}"):
                    _move(there.path_of(file_id), here.path_of(file_id))
        shutil.rmtree(waiting)
    except OSError as error:
        raise cannot_save(error) from error


class _Kept:
    """Which files the store has as they were saved."""

    def __init__(self, database: Database) -> None:
        self._folder = database.path.parent
        with database.reading() as transaction:
            files = transaction.execute(select(FILES.c.file_id, FILES.c.sha256)).all()
            recordings = transaction.execute(
                select(RECORDINGS.c.recording_id, RECORDINGS.c.sha256).where(RECORDINGS.c.is_closed)
            ).all()
        self._sums = {
            PICTURES_FOLDER: {row.file_id: row.sha256 for row in files},
            RECORDINGS_FOLDER: {row.recording_id: row.sha256 for row in recordings},
        }

    def knows(self, folder: str, file_id: str) -> bool:
        """Say whether a file belongs to something in the database."""
        if folder == CODINGS_FOLDER:
            return file_id[:ID_LENGTH] in self._sums[RECORDINGS_FOLDER]
        return file_id in self._sums[folder]

    def wants(self, name: str) -> bool:
        """Say whether a file is needed: what is lacking, and codings, which may be others."""
        return name.startswith(f"{CODINGS_FOLDER}/") or self.lacks(name)

    def other_codings(self, waiting: Path) -> list[str]:
        """Return the recordings of which something else was coded here than in the backup."""
        there = SealedFolder(waiting / CODINGS_FOLDER)
        here = SealedFolder(self._folder / CODINGS_FOLDER)
        both = [one for one in there.ids() if not self.lacks(f"{CODINGS_FOLDER}/{one}")]
        others = (one for one in both if here.sha256(one) != there.sha256(one))
        return sorted({one[:ID_LENGTH] for one in others})

    def lacks(self, name: str) -> bool:
        """Say whether the store lacks a file, or has it damaged."""
        if name == DATABASE_FILE:
            return True
        folder, _, file_id = name.partition("/")
        sealed = SealedFolder(self._folder / folder)
        try:
            if not sealed.path_of(file_id).exists():
                return True
            sums = self._sums.get(folder)
            return sums is not None and sealed.sha256(file_id) != sums.get(file_id)
        except StoreError:  # it cannot be read any more
            return True


def _new_folder(waiting: Path) -> Path:
    try:
        shutil.rmtree(waiting, ignore_errors=True)
        waiting.mkdir(mode=0o700)
    except OSError as error:
        raise cannot_save(error) from error
    return waiting


def _check_room(folder: Path, backup: Path) -> None:
    try:
        is_short = shutil.disk_usage(folder).free < backup.stat().st_size
    except OSError as error:
        raise cannot_save(error) from error
    if is_short:
        raise cannot_save(OSError(errno.ENOSPC, ""))


def _move(there: Path, here: Path) -> None:
    here.parent.mkdir(parents=True, exist_ok=True)
    there.replace(here)
    flush_folder(here.parent)
