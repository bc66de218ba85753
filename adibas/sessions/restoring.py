"""Backups become stores again: in a new folder, to be checked, or to be merged into a used store.

Nothing of a backup is seen under its own name before all of it is on the disk.
"""

import errno
import os
import re
import shutil
import tempfile
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import BinaryIO

from adibas.clock import utc_now
from adibas.errors import StoreError
from adibas.files import flush_folder
from adibas.progress import Progress
from adibas.sessions.audit import AuditLog
from adibas.sessions.backup_format import DATA, FILE, BackupHeader, BackupReader
from adibas.sessions.database import DATABASE_FILE, Database
from adibas.sessions.key_file import KeyFile, write_key_file
from adibas.sessions.lock import LOCK_FILE, StoreLock, cannot_use
from adibas.sessions.migrating import bring_up_to_date
from adibas.sessions.places import CODINGS_FOLDER, PICTURES_FOLDER, RECORDINGS_FOLDER
from adibas.sessions.sealed_files import SealedFiles
from adibas.sessions.sealed_folder import SealedFolder, cannot_save
from adibas.sessions.sealed_recordings import SealedRecordings
from adibas.sessions.stored_recordings import Recordings
from adibas.sessions.verification import Verification, VerifyReport

_NAME = re.compile(r"(pictures|recordings|codings)/([0-9a-f]{2}[0-9a-f-]{6,62})")
IN_THE_MAKING = ".restoring-"

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
        making = folder.absolute().parent / f"{IN_THE_MAKING}{folder.name}"
        with _making_of(making):
            extract(backup, key, making, progress=progress)
            write_key_file(making, _key_file(backup.header))
            make_present(making, key)
            (making / LOCK_FILE).unlink(missing_ok=True)
            _give_name(making, folder)
        return backup.header


def verify_backup(
    path: Path,
    passphrase: str | None,
    progress: Progress | None = None,
    *,
    key: bytes | None = None,
    temporary: Path | None = None,
) -> tuple[BackupHeader, VerifyReport]:
    """Restore a backup into a temporary folder, check that store, and remove it.

    Parameters
    ----------
    key : bytes, optional
        Of the store; in place of the passphrase.
    temporary : Path, optional
        Where there is room for it; the system's folder for such things if not given. What lies
        there for a while is sealed as in the store.

    Raises
    ------
    PassphraseError
        The passphrase is missing or wrong.
    StoreError
        The backup is damaged, or there is no room.
    """
    with ExitStack() as at_the_end, BackupReader(path) as backup:
        key = key if key is not None and backup.is_of(key) else backup.key(passphrase)
        try:
            named = at_the_end.enter_context(tempfile.TemporaryDirectory(dir=temporary))
        except OSError as error:
            raise cannot_save(error) from error
        folder = Path(named)
        extract(backup, key, folder, progress=progress)
        return backup.header, _verified(folder, key, progress)


def extract(
    backup: BackupReader,
    key: bytes,
    folder: Path,
    *,
    wanted: Wanted | None = None,
    progress: Progress | None = None,
) -> None:
    """Write the files of a backup below `folder`, each of them on the disk when this returns.

    Parameters
    ----------
    wanted : callable, optional
        Says of a file's name whether it is needed; everything is if not given.

    Raises
    ------
    StoreError
        The backup is damaged, or the disk is full.
    """
    done, n_bytes = 0, backup.header.n_bytes
    with _Files(folder) as files:
        files.check_room(n_bytes if wanted is None else 0)
        for kind, content in backup.pieces(key):
            if kind == FILE:
                name = content.decode()
                files.begin(name if wanted is None or wanted(name) else None)
            elif kind == DATA:
                files.write(content)
                done += len(content)
                if progress is not None:
                    progress(min(done, n_bytes), n_bytes)


class _Files:
    """Writes one file after the other."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._file: BinaryIO | None = None

    def check_room(self, n_bytes: int) -> None:
        if shutil.disk_usage(self._folder).free < n_bytes:
            raise cannot_save(OSError(errno.ENOSPC, ""))

    def begin(self, name: str | None) -> None:
        """Go on with another file; None: with none."""
        self._end()
        if name is None:
            return
        path = self._folder / DATABASE_FILE
        if name != DATABASE_FILE:
            part = _NAME.fullmatch(name)
            if part is None:
                raise ValueError(f"no name of a file in a store: {name!r}")
            path = SealedFolder(self._folder / part[1]).path_of(part[2])
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            self._file = path.open("xb")
        except OSError as error:
            raise cannot_save(error) from error

    def write(self, block: bytes) -> None:
        if self._file is None:
            return
        try:
            self._file.write(block)
        except OSError as error:
            raise cannot_save(error) from error

    def _end(self) -> None:
        file, self._file = self._file, None
        if file is None:
            return
        try:
            with file:
                file.flush()
                os.fsync(file.fileno())
            flush_folder(Path(file.name).parent)
        except OSError as error:
            raise cannot_save(error) from error

    def __enter__(self) -> "_Files":
        return self

    def __exit__(self, kind: object, *_error: object) -> None:
        if kind is None:
            self._end()
        elif self._file is not None:
            with suppress(OSError):  # the first error is the one to tell
                self._file.close()


def _verified(folder: Path, key: bytes, progress: Progress | None) -> VerifyReport:
    """Check a restored store as `verify` checks one in use."""
    make_present(folder, key)
    database = Database(folder, key, is_read_only=True)
    try:
        audit = AuditLog(database, utc_now, "")
        recordings = Recordings(
            database,
            audit,
            SealedRecordings(folder / RECORDINGS_FOLDER),
            SealedFiles(folder / CODINGS_FOLDER),
        )
        pictures = SealedFiles(folder / PICTURES_FOLDER)
        return Verification(database, audit, pictures, recordings).run(progress)
    finally:
        database.close()


def make_present(folder: Path, key: bytes) -> None:
    """See that a restored database opens; one of an older version becomes a present one.

    Raises
    ------
    StoreError
        It does not open, or is of a later version.
    """
    database = Database(folder, key, is_read_only=False)
    try:
        bring_up_to_date(database, key)
    finally:
        database.close()


def _key_file(header: BackupHeader) -> KeyFile:
    return KeyFile(header.store_id, "passphrase", header.fingerprint, header.wrapped)


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
def _making_of(making: Path) -> Iterator[None]:
    """Give an empty folder, after what a killed restore left is gone; nothing of it stays."""
    try:
        making.mkdir(mode=0o700, parents=True, exist_ok=True)
    except OSError as error:
        raise cannot_use(making.parent, error) from error
    lock = StoreLock(making)
    try:
        if not lock.is_held:
            raise StoreError(
                "Another program is just restoring into that folder. Wait until it is done."
            )
        try:
            _empty(making)
        except OSError as error:
            raise cannot_use(making, error) from error
        yield
    finally:
        was_held = lock.is_held
        lock.release()
        if was_held:
            shutil.rmtree(making, ignore_errors=True)


def _empty(making: Path) -> None:
    for path in making.iterdir():
        if path.is_dir():
            shutil.rmtree(path)
        elif path.name != LOCK_FILE:
            path.unlink()


def _give_name(making: Path, folder: Path) -> None:
    try:
        for name in (PICTURES_FOLDER, RECORDINGS_FOLDER):
            (making / name).mkdir(exist_ok=True)
        with suppress(FileNotFoundError):
            folder.rmdir()
        making.rename(folder)
        flush_folder(folder.absolute().parent)
    except OSError as error:
        raise cannot_use(folder, error) from error
