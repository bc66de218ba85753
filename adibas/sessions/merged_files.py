"""Brings a backup into a store in use: rows in one change, files before or after any crash.

The files wait in a folder of the store. The change of the database decides which of them belong to
it; those get their places afterwards, and what a crash leaves waiting is dealt with in the same way
at the next opening.
"""

import shutil
import uuid
from pathlib import Path
from typing import TYPE_CHECKING

from sqlalchemy import select, true

from adibas.errors import StoreError
from adibas.files import flush_folder, is_there
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
"""In the store's folder, with one folder a restore; there during a restore only."""
FOLDERS = (PICTURES_FOLDER, RECORDINGS_FOLDER, CODINGS_FOLDER)


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
        The backup is damaged, the store is read-only, another workstation is restoring into it, or
        the disk is full. Nothing was changed.
    FileError
        The backup cannot be read.
    """
    database, _audit, own_key = store
    with BackupReader(path) as backup:
        key = own_key if backup.is_of(own_key) else backup.key(passphrase)
        database.check_writable()
        with database.one_restore():
            finish_merge(database)  # what an earlier one left may be all that there is of something
            try:
                return _merged(backup, key, store, making, progress)
            finally:
                finish_merge(database)


def _merged(
    backup: BackupReader,
    key: bytes,
    store: tuple[Database, AuditLog, bytes],
    making: set[str],
    progress: Progress | None,
) -> "MergeSummary":
    """Merge the rows; the files wait."""
    from adibas.sessions.merging import merge
    from adibas.sessions.restoring import check_room, extract, make_present
    from adibas.sessions.sqlite_file import SqliteFile

    database, audit, own_key = store
    kept = _Kept(database)
    n_bytes = backup.header.n_bytes - (kept.n_bytes() if backup.is_of(own_key) else 0)
    check_room(database.folder, n_bytes)
    waiting = _new_folder(database.folder)
    extract(backup, key, waiting, wanted=kept.wants, progress=progress)
    make_present(waiting, key)
    source = Database(SqliteFile(waiting, key), is_read_only=True)
    try:
        summary = merge(source, database, audit, making)
    finally:
        source.close()
    summary.other_codings += kept.other_codings(waiting)
    return summary


def finish_merge(database: Database) -> None:
    """Give waiting files that the database knows their places, and remove the others.

    Raises
    ------
    StoreError
        Another workstation is restoring, or the disk refuses; the next opening tries again.
    """
    root = database.folder / WAITING
    if not is_there(root):
        return
    with database.one_restore():  # else the files of one who is just restoring would go
        kept = _Kept(database)
        try:
            for waiting in (root, *root.iterdir()):  # earlier programs had no folder for each
                _give_places(waiting, database.folder, kept)
            shutil.rmtree(root)
        except OSError as error:
            raise cannot_save(error) from error


def _give_places(waiting: Path, folder: Path, kept: "_Kept") -> None:
    for name in FOLDERS:
        there, here = SealedFolder(waiting / name), SealedFolder(folder / name)
        for file_id in there.ids():
            if kept.has_use_for(waiting, f"{name}/{file_id}"):
                _move(there.path_of(file_id), here.path_of(file_id))


class _Kept:
    """Which files the store has as they were saved; they are named as in a backup."""

    def __init__(self, database: Database) -> None:
        self._folder = database.folder
        self._sums: dict[str, str | None] = {}
        with database.reading() as transaction:
            for name, columns, kept in (
                (PICTURES_FOLDER, (FILES.c.file_id, FILES.c.sha256), true()),
                (
                    RECORDINGS_FOLDER,
                    (RECORDINGS.c.recording_id, RECORDINGS.c.sha256),
                    RECORDINGS.c.is_closed,
                ),
            ):
                for file_id, sha256 in transaction.execute(select(*columns).where(kept)):
                    self._sums[f"{name}/{file_id}"] = sha256

    def n_bytes(self) -> int:
        """Return what all files take."""
        folders = [SealedFolder(self._folder / name) for name in FOLDERS]
        return sum(folder.size(file_id) for folder in folders for file_id in folder.ids())

    def wants(self, name: str) -> bool:
        """Say whether a file is needed: what is lacking, and codings, which may be others."""
        return name.startswith(f"{CODINGS_FOLDER}/") or self.lacks(name)

    def lacks(self, name: str) -> bool:
        """Say whether the store lacks a file, or has it damaged."""
        if name == DATABASE_FILE:
            return True
        sealed, file_id = _place_of(self._folder, name)
        try:
            if not is_there(sealed.path_of(file_id)):
                return True
            has_sum = sealed.folder.name != CODINGS_FOLDER
            return has_sum and sealed.sha256(file_id) != self._sums.get(name)
        except StoreError:  # it cannot be read any more
            return True

    def has_use_for(self, waiting: Path, name: str) -> bool:
        """Say whether the database knows a waiting file, and it is better than what is here."""
        folder, _, file_id = name.partition("/")
        owner = f"{RECORDINGS_FOLDER}/{file_id[:ID_LENGTH]}" if folder == CODINGS_FOLDER else name
        if owner not in self._sums or not self.lacks(name):
            return False
        sealed, file_id = _place_of(self._folder, name)
        if not is_there(sealed.path_of(file_id)):
            return True
        there, file_id = _place_of(waiting, name)
        return there.sha256(file_id) == self._sums[name]  # of two damaged ones this one stays

    def other_codings(self, waiting: Path) -> list[str]:
        """Return the recordings of which something else was coded here than in the backup."""
        there = SealedFolder(waiting / CODINGS_FOLDER)
        here = SealedFolder(self._folder / CODINGS_FOLDER)
        others = (one for one in there.ids() & here.ids() if here.sha256(one) != there.sha256(one))
        return sorted({one[:ID_LENGTH] for one in others})


def _place_of(root: Path, name: str) -> tuple[SealedFolder, str]:
    folder, _, file_id = name.partition("/")
    return SealedFolder(root / folder), file_id


def _new_folder(folder: Path) -> Path:
    """Make one that no other restore writes into, also where one goes on that has lost its lock."""
    root = folder / WAITING
    waiting = root / uuid.uuid4().hex
    try:
        root.mkdir(mode=0o700, exist_ok=True)
        waiting.mkdir(mode=0o700)
    except OSError as error:
        raise cannot_save(error) from error
    return waiting


def _move(there: Path, here: Path) -> None:
    is_new_folder = not here.parent.exists()
    here.parent.mkdir(parents=True, exist_ok=True)
    there.replace(here)
    flush_folder(here.parent)
    if is_new_folder:
        flush_folder(here.parent.parent)
