"""Sealed files and their keys in step: no crash leaves a file that nobody knows.

A file's key is in the database, marked as pending, before the file is written; the change that
uses the file ends that. A purge destroys the key and notes the file as a leftover in one change,
and removes the file then. What a crash leaves pending or left over goes at the next opening.
"""

import secrets
import uuid
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress

from sqlalchemy import delete, select

from adibas.errors import StoreError
from adibas.files import is_there
from adibas.sessions.database import Database
from adibas.sessions.left_files import Left
from adibas.sessions.rows import Transaction, add_row, change_row
from adibas.sessions.schema import FILES, LEFTOVERS
from adibas.sessions.sealed_files import SealedFiles
from adibas.sessions.sealed_folder import SealedFolder
from adibas.sessions.sealing import KEY_SIZE


class KeptFiles:
    """Pictures and surfaces of the captures."""

    def __init__(self, database: Database, files: SealedFiles) -> None:
        self._database = database
        self._files = files

    @contextmanager
    def written(self, payloads: Sequence[bytes]) -> Iterator[list[str]]:
        """Seal each payload in a file and give their ids; the block keeps them, or they go.

        Raises
        ------
        StoreError
            The store is read-only, or the disk is full; then no file is left.
        """
        made = [(uuid.uuid4().hex, secrets.token_bytes(KEY_SIZE)) for _ in payloads]
        with self._database.changing() as transaction:
            for file_id, key in made:
                add_row(transaction, FILES, file_id=file_id, key=key, sha256=None)
        ids = [file_id for file_id, _ in made]
        with ExitStack() as if_that_fails:
            if_that_fails.callback(self._give_up, ids)
            for (file_id, key), payload in zip(made, payloads, strict=True):
                self._files.write(file_id, key, payload)
            yield ids
            if_that_fails.pop_all()

    def keep(self, transaction: Transaction, ids: Sequence[str]) -> None:
        """Mark files as kept, with the change that uses them."""
        for file_id in ids:
            change_row(transaction, FILES, file_id, sha256=self._files.sha256(file_id))

    def read(self, file_id: str) -> bytes:
        """Return the content of a file.

        Raises
        ------
        StoreError
            It is missing or damaged.
        """
        with self._database.reading() as transaction:
            key = transaction.scalars(select(FILES.c.key).where(FILES.c.file_id == file_id)).one()
        return self._files.read(file_id, key)

    def _give_up(self, ids: Sequence[str]) -> None:
        """Remove pending files; those that stay go at the next opening."""
        with suppress(StoreError):
            self._remove(ids)

    def _remove(self, ids: Sequence[str]) -> None:
        """Remove pending files, and then their keys."""
        for file_id in ids:
            self._files.delete(file_id)
        with self._database.changing() as transaction:
            transaction.execute(delete(FILES).where(FILES.c.file_id.in_(ids)))

    def finish(self, left: Left = set) -> None:
        """Remove what a crash left pending; without any, the folder is not even looked at.

        Parameters
        ----------
        left : callable
            Tells files that a crash left from those that somebody is writing. Where one is being
            written all stay: a capture has several, and the next may not have begun.
        """
        pending = select(FILES.c.file_id).where(FILES.c.sha256.is_(None))
        with self._database.reading() as transaction:
            ids = list(transaction.scalars(pending))
        if not ids:
            return
        paths = [self._files.path_of(file_id) for file_id in ids]
        written = {path for path in paths if is_there(path)} | set(self._files.unfinished())
        if left(written) == written:
            # Before the keys go: they tell that one may be there.
            self._files.remove_unfinished(written.intersection)
            self._remove(ids)


def remove_leftovers(database: Database, folders: Callable[[], tuple[SealedFolder, ...]]) -> None:
    """Remove purged files from the disk.

    Parameters
    ----------
    folders : callable
        Gives the folders of the files, and is asked only where a file is left.

    Raises
    ------
    StoreError
        One of them cannot be removed, or the disk is full. The others are gone; it stays noted.
    """
    with database.reading() as transaction:
        left = list(transaction.execute(select(LEFTOVERS)))
    if not left:
        return
    by_name = {folder.folder.name: folder for folder in folders()}
    gone, failure = [], None
    for leftover in left:
        try:
            by_name[leftover.folder].delete(leftover.file_id)
        except StoreError as error:  # another program may have it open
            failure = error
        else:
            gone.append(leftover.file_id)
    with database.changing() as transaction:
        transaction.execute(delete(LEFTOVERS).where(LEFTOVERS.c.file_id.in_(gone)))
    if failure is not None:
        raise failure
