"""Backups become stores again: in a new folder, to be tried out, or to be merged into a used one.

Nothing of a backup is seen under its own name before all of it is on the disk.
"""

import errno
import os
import re
import shutil
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import BinaryIO

from adibas.errors import StoreError
from adibas.files import flush_folder
from adibas.progress import Progress
from adibas.sessions.backup_format import DATA, FILE, BackupHeader, BackupReader
from adibas.sessions.database import DATABASE_FILE, Database
from adibas.sessions.key_file import write_key_file
from adibas.sessions.lock import LOCK_FILE, StoreLock, cannot_use
from adibas.sessions.migrating import bring_up_to_date
from adibas.sessions.places import IN_THE_MAKING, PICTURES_FOLDER, RECORDINGS_FOLDER
from adibas.sessions.sealed_folder import SealedFolder, cannot_save
from adibas.sessions.sqlite_file import SqliteFile

_NAME = re.compile(r"(pictures|recordings|codings)/([0-9a-f]{2}[0-9a-f-]{6,62})")
UNFINISHED = ".part"

Wanted = Callable[[str], bool]


def restore_into(
    path: Path, folder: Path, passphrase: str | None, progress: Progress | None = None
) -> BackupHeader:
    """Make a store in `folder` of a backup; it opens with the backup's passphrase.

    Parameters
    ----------
    folder : Path
        It is missing, or empty.
    progress : callable, optional
        Called with (bytes done, bytes in all); what it raises ends the restore, and nothing is
        left.

    Raises
    ------
    PassphraseError
        The passphrase is missing or wrong.
    StoreError
        The backup is damaged, or the folder holds something. Nothing is left there.
    FileError
        The backup cannot be read.
    """
    with BackupReader(path) as backup:
        key = backup.key(passphrase)
        _check_empty(folder)
        with making_of(folder.resolve()) as making:
            check_room(making, backup.header.n_bytes)
            extract(backup, key, making, progress=progress)
            write_key_file(making, backup.header.key_file)
            make_present(making, key)
            _give_name(making, folder.resolve())
        return backup.header


def extract(
    backup: BackupReader,
    key: bytes,
    folder: Path,
    *,
    wanted: Wanted | None = None,
    progress: Progress | None = None,
) -> None:
    """Write the files of a backup below `folder`, each of them on the disk when this returns.

    A file is under its name when it is whole, also after a kill.

    Parameters
    ----------
    wanted : callable, optional
        Says of a file's name whether it is needed; everything is if not given.

    Raises
    ------
    StoreError
        The backup is damaged, holds what only a later version knows, or the disk is full.
    """
    done, n_bytes = 0, backup.header.n_bytes
    with ExitStack() as after_a_file:
        file: BinaryIO | None = None
        for kind, content in backup.pieces(key):
            if kind == FILE:
                after_a_file.close()
                name = content.decode(errors="replace")  # then it is no name
                path = _path_of(folder, name)
                if path is None:
                    raise backup.of_later_version()
                is_wanted = wanted is None or wanted(name)
                file = after_a_file.enter_context(_saved(path)) if is_wanted else None
            elif kind == DATA:
                if file is not None:
                    file.write(content)
                done += len(content)
                if progress is not None:
                    progress(min(done, n_bytes), n_bytes)


def check_room(folder: Path, n_bytes: int) -> None:
    """See, before long work, that `n_bytes` can be written into a folder.

    Raises
    ------
    StoreError
        The disk is full, or cannot be asked.
    """
    try:
        is_short = shutil.disk_usage(folder).free < n_bytes
    except OSError as error:
        raise cannot_save(error) from error
    if is_short:
        raise cannot_save(OSError(errno.ENOSPC, ""))


def _path_of(folder: Path, name: str) -> Path | None:
    """Return where a file of a backup belongs; None of what is no name in a store."""
    if name == DATABASE_FILE:
        return folder / name
    part = _NAME.fullmatch(name)
    return None if part is None else SealedFolder(folder / part[1]).path_of(part[2])


@contextmanager
def _saved(path: Path) -> Iterator[BinaryIO]:
    """Give a file that gets its name when all of it is on the disk."""
    unfinished = path.with_suffix(UNFINISHED)
    try:
        is_new_folder = not path.parent.exists()
        path.parent.mkdir(parents=True, exist_ok=True)
        with unfinished.open("xb") as file:
            yield file
            file.flush()
            os.fsync(file.fileno())
        unfinished.replace(path)
        flush_folder(path.parent)
        if is_new_folder:
            flush_folder(path.parent.parent)
    except OSError as error:
        raise cannot_save(error) from error


def make_present(folder: Path, key: bytes) -> None:
    """See that a restored database opens; one of an older version becomes a present one.

    Raises
    ------
    StoreError
        It does not open, or is of a later version.
    """
    database = Database(SqliteFile(folder, key), is_read_only=False)
    try:
        bring_up_to_date(database, key)
    finally:
        database.close()


def _check_empty(folder: Path) -> None:
    try:
        is_taken = folder.exists() and (not folder.is_dir() or any(folder.iterdir()))
    except OSError as error:
        raise cannot_use(folder, error) from error
    if is_taken:
        raise StoreError(
            "{folder} is not empty, and nothing in it is replaced. Choose an empty or a new "
            "folder, or restore without --into to add what is missing to the store in use.",
            folder=folder.name or str(folder),
        )


@contextmanager
def making_of(folder: Path) -> Iterator[Path]:
    """Give an empty folder in the place of `folder`, and remove it in the end, if it is there.

    What a restore left that was killed is removed before.

    The lock lies beside it: who waits for the lock finds it free only when all is over, and a
    folder with an open file cannot be renamed everywhere.
    """
    room = folder.parent / f"{IN_THE_MAKING}{folder.name}"
    making = room / "store"
    try:
        room.mkdir(mode=0o700, parents=True, exist_ok=True)
    except OSError as error:
        raise cannot_use(room.parent, error) from error
    lock = StoreLock(room)
    if not lock.is_held:
        lock.release()
        raise StoreError(
            "Another program is just restoring into that folder. Wait until it is done."
        )
    try:
        if making.exists():
            shutil.rmtree(making)
        making.mkdir(mode=0o700)
        yield making
    except OSError as error:
        raise cannot_use(room, error) from error
    finally:
        shutil.rmtree(making, ignore_errors=True)
        lock.release()
        with suppress(OSError):  # the next one has taken it already
            (room / LOCK_FILE).unlink(missing_ok=True)
            room.rmdir()


def _give_name(making: Path, folder: Path) -> None:
    try:
        for name in (PICTURES_FOLDER, RECORDINGS_FOLDER):
            (making / name).mkdir(exist_ok=True)
        with suppress(FileNotFoundError):
            folder.rmdir()
        making.rename(folder)
        flush_folder(folder.parent)
    except OSError as error:
        raise cannot_use(folder, error) from error
