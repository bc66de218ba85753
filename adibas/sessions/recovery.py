"""The recovery key of an open store: since when there is one, and the making of another."""

from dataclasses import replace
from datetime import datetime
from pathlib import Path

from adibas.errors import StoreError
from adibas.sessions.audit import AuditLog
from adibas.sessions.database import Database
from adibas.sessions.key_file import KeyFile, read_key_file, write_key_file
from adibas.sessions.people_state import PEOPLE_AS_SUBJECT, state_of
from adibas.sessions.recovery_key import read_recovery_key, seal_for_recovery
from adibas.sessions.roles import Permission


class Recovery:
    """Holds the copy of the store's key that its recovery key opens; the key itself is not kept."""

    def __init__(self, folder: Path, database: Database, audit: AuditLog, key: bytes) -> None:
        self._folder = folder
        self._database = database
        self._audit = audit
        self._key = key

    @property
    def store_id(self) -> str:
        """The number of the store, which stands on the paper."""
        return self._file().store_id

    def made_utc(self) -> datetime | None:
        """Return since when there is a recovery key; None without one.

        Raises
        ------
        StoreError
            `key.json` is missing or damaged.
        """
        return made_utc_of(self._file())

    def hold(self, recovery_key: str) -> None:
        """Let `recovery_key` open the store from now on; the one of before opens it no more.

        Raises
        ------
        NotAllowedError
            Only administrators may.
        RecoveryKeyTypedError
            It is none.
        StoreError
            The store is read-only, or `key.json` is damaged.
        FileError
            The disk is full. The key of before, if any, still opens the store.
        """
        self._audit.require(Permission.PROTECT, PEOPLE_AS_SUBJECT)
        recovery_key = read_recovery_key(recovery_key)
        with self._database.changing() as transaction:
            before = self._file()
            made_utc = self._audit.now()
            sealed = seal_for_recovery(self._key, recovery_key, before.store_id, made_utc)
            file = replace(before, recovery=sealed)
            write_key_file(self._folder, file)
            did = "recovery key made" if before.recovery is None else "recovery key replaced"
            told = {"did": did, "state": state_of(file)}
            self._audit.write(transaction, "change", PEOPLE_AS_SUBJECT, **told)

    def _file(self) -> KeyFile:
        file = read_key_file(self._folder)
        if file is None:
            raise StoreError(
                "The patient store has lost its key.json. Restore that file from a backup; without "
                "it the patients cannot be read."
            )
        return file


def made_utc_of(file: KeyFile) -> datetime | None:
    """Return when the recovery key was made; None where there is none, or it is damaged."""
    try:
        return datetime.fromisoformat(str((file.recovery or {})["made_utc"]))
    except (KeyError, ValueError):
        return None
