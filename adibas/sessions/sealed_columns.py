"""Columns whose contents are sealed before they leave this computer, where a server keeps them.

Each is bound to the name of its column, so that none opens in the place of another one. In a file,
which is encrypted as a whole, they are as they are.
"""

import base64
import binascii
from typing import Any

from sqlalchemy import Dialect, LargeBinary, String
from sqlalchemy.types import TypeDecorator

from adibas.errors import StoreError
from adibas.recordings.seal import SealError
from adibas.sessions.sealing import AesSeal, key_for

SCOPE = "adibas-columns-1"
_SEAL = "adibas_seal"


def seal_columns(dialect: Dialect, key: bytes) -> None:
    """Let everything that goes through `dialect` be sealed under a key made of the store's."""
    setattr(dialect, _SEAL, AesSeal(key_for(SCOPE, key), SCOPE))


class SealedText(TypeDecorator[str]):
    """A text; on a server the base64 of what is sealed.

    Parameters
    ----------
    name : str
        Of the column.
    """

    impl = String
    cache_ok = True

    def __init__(self, name: str) -> None:
        super().__init__()
        self.name = name

    def process_bind_param(self, value: str | None, dialect: Dialect) -> str | None:
        """Seal what is written."""
        seal = _seal_of(dialect)
        if value is None or seal is None:
            return value
        return base64.b64encode(seal.seal(self.name, value.encode())).decode()

    def process_result_value(self, value: Any, dialect: Dialect) -> str | None:
        """Open what is read."""
        seal = _seal_of(dialect)
        if value is None or seal is None:
            return None if value is None else str(value)
        try:
            return _opened(seal, self.name, base64.b64decode(value, validate=True)).decode()
        except binascii.Error as error:
            raise _changed() from error


class SealedBytes(TypeDecorator[bytes]):
    """Bytes, such as the key of a file; see `SealedText`."""

    impl = LargeBinary
    cache_ok = True

    def __init__(self, name: str) -> None:
        super().__init__()
        self.name = name

    def process_bind_param(self, value: bytes | None, dialect: Dialect) -> bytes | None:
        """Seal what is written."""
        seal = _seal_of(dialect)
        return value if value is None or seal is None else seal.seal(self.name, value)

    def process_result_value(self, value: Any, dialect: Dialect) -> bytes | None:
        """Open what is read."""
        seal = _seal_of(dialect)
        if value is None or seal is None:
            return None if value is None else bytes(value)
        return _opened(seal, self.name, bytes(value))


def _seal_of(dialect: Dialect) -> AesSeal | None:
    return getattr(dialect, _SEAL, None)


def _opened(seal: AesSeal, name: str, sealed: bytes) -> bytes:
    try:
        return seal.open(name, sealed)
    except SealError as error:
        raise _changed() from error


def _changed() -> StoreError:
    return StoreError(
        "The database on the server holds something that was changed or damaged there, or that "
        "belongs to another patient store. Nothing was changed here. Ask whoever looks after the "
        "server to restore the database from a backup."
    )
