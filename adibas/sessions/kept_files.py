"""Sealed files and their keys in step: no crash leaves a file that nobody knows.

A file's key is in the database, marked as pending, before the file is written; the change that
uses the file marks it as kept. A file that shall go is marked first. What a crash leaves pending or
going is removed at the next opening.
"""

import secrets
import uuid
from collections.abc import Sequence

from sqlalchemy import delete, select
from sqlalchemy.orm import Session as Transaction

from adibas.sessions.database import Database
from adibas.sessions.schema import FileRecord
from adibas.sessions.sealed_files import SealedFiles
from adibas.sessions.sealing import KEY_SIZE

PENDING, KEPT, GOING = "pending", "kept", "going"


class KeptFiles:
    """Pictures and surfaces of the captures."""

    def __init__(self, database: Database, files: SealedFiles) -> None:
        self._database = database
        self._files = files

    def write(self, payloads: Sequence[bytes]) -> list[str]:
        """Seal each payload in a file, pending until `keep`; return their ids.

        Raises
        ------
        StoreError
            The store is read-only, or the disk is full; then no file is left.
        """
        made = [(uuid.uuid4().hex, secrets.token_bytes(KEY_SIZE)) for _ in payloads]
        with self._database.changing() as transaction:
            for file_id, key in made:
                transaction.add(FileRecord(file_id=file_id, state=PENDING, key=key, sha256=""))
        ids = [file_id for file_id, _ in made]
        try:
            for (file_id, key), payload in zip(made, payloads, strict=True):
                self._files.write(file_id, key, payload)
        except BaseException:
            self.remove(ids)
            raise
        return ids

    def keep(self, transaction: Transaction, ids: Sequence[str]) -> None:
        """Mark files as kept, with the change that uses them."""
        for file_id in ids:
            record = transaction.get_one(FileRecord, file_id)
            record.state, record.sha256 = KEPT, self._files.sha256(file_id)

    def read(self, file_id: str) -> bytes:
        """Return the content of a file.

        Raises
        ------
        StoreError
            It is missing or damaged.
        """
        with self._database.reading() as transaction:
            key = transaction.get_one(FileRecord, file_id).key
        return self._files.read(file_id, key)

    def remove(self, ids: Sequence[str]) -> None:
        """Remove files that nothing uses any more, and then their keys."""
        for file_id in ids:
            self._files.delete(file_id)
        with self._database.changing() as transaction:
            transaction.execute(delete(FileRecord).where(FileRecord.file_id.in_(ids)))

    def finish(self) -> None:
        """Remove what a crash left pending or going."""
        left = select(FileRecord.file_id).where(FileRecord.state != KEPT)
        with self._database.reading() as transaction:
            ids = list(transaction.scalars(left))
        if ids:
            self.remove(ids)
        self._files.remove_unfinished()
