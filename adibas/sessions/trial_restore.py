"""A backup is tried out: restored for a moment beside the store, checked, and removed again.

Never in the system's folder for temporary files: others may look into it, it may be another disk,
and what a crash leaves there nobody knows to remove.
"""

from pathlib import Path
from typing import TYPE_CHECKING

from adibas.clock import utc_now
from adibas.errors import StoreError
from adibas.files import is_there
from adibas.progress import Progress
from adibas.sessions.audit import AuditLog
from adibas.sessions.database import Database
from adibas.sessions.places import (
    CODINGS_FOLDER,
    IN_THE_MAKING,
    PICTURES_FOLDER,
    RECORDINGS_FOLDER,
)
from adibas.sessions.sealed_files import SealedFiles
from adibas.sessions.sqlite_file import SqliteFile

if TYPE_CHECKING:
    from adibas.sessions.backup_format import BackupHeader
    from adibas.sessions.verification import VerifyReport

TRIAL = "trial"


def verify_backup(
    path: Path,
    passphrase: str | None,
    progress: Progress | None = None,
    *,
    room: Path,
    key: bytes | None = None,
) -> "tuple[BackupHeader, VerifyReport]":
    """Restore a backup into a folder of its own, check that store, and remove it.

    Parameters
    ----------
    progress : callable, optional
        Called with (steps done, steps in all); what it raises ends the trial, and nothing is left.
    room : Path
        A folder that is there, such as the store's, with room for all of the backup. What lies in
        it for a while is sealed as in the store; what a kill leaves the next trial removes.
    key : bytes, optional
        Of the store; in place of the passphrase.

    Raises
    ------
    PassphraseError
        The passphrase is missing or wrong.
    StoreError
        The backup is damaged, another trial is under way there, or there is no room.
    FileError
        The backup cannot be read.
    """
    from adibas.sessions.backup_format import BackupReader
    from adibas.sessions.restoring import check_room, extract, making_of

    with BackupReader(path) as backup:
        key = key if key is not None and backup.is_of(key) else backup.key(passphrase)
        _check_there(room)
        with making_of(room / TRIAL) as folder:
            check_room(folder, backup.header.n_bytes)
            extract(backup, key, folder, progress=progress)
            return backup.header, _verified(folder, key, progress)


def remove_trial(room: Path) -> None:
    """Remove what a trial left that was killed.

    Raises
    ------
    StoreError
        It is still under way in another program, or the disk refuses.
    """
    if not is_there(room / f"{IN_THE_MAKING}{TRIAL}"):
        return
    from adibas.sessions.restoring import making_of

    with making_of(room / TRIAL):
        pass


def _check_there(room: Path) -> None:
    if not room.is_dir():
        raise StoreError(
            "There is no folder {folder} to try the backup out in. Name one with room for all of "
            "it.",
            folder=str(room),
        )


def _verified(folder: Path, key: bytes, progress: Progress | None) -> "VerifyReport":
    """Check a restored store as `verify` checks one in use."""
    from adibas.sessions.restoring import make_present
    from adibas.sessions.sealed_recordings import SealedRecordings
    from adibas.sessions.stored_recordings import Recordings
    from adibas.sessions.verification import Verification

    make_present(folder, key)
    database = Database(SqliteFile(folder, key), is_read_only=True)
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
