"""The file of a backup: a header in plain, then numbered sealed pieces, the last of them marked.

`docs/backup.md` describes it for those who want to read one without this program.
"""

import hashlib
import json
import secrets
import struct
from collections.abc import Iterator, Mapping
from contextlib import ExitStack
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, BinaryIO, Self

from adibas.errors import (
    BackupLockedError,
    PassphraseError,
    RecoveryKeyTypedError,
    StoreError,
)
from adibas.files import cannot_read
from adibas.recordings.seal import SealError
from adibas.sessions.key_file import (
    ID_LENGTH,
    KeyFile,
    KeyPlace,
    fingerprint_of,
    recovery_in,
    version_of,
)
from adibas.sessions.keys import key_behind, key_by_recovery
from adibas.sessions.recovery_key import read_recovery_key
from adibas.sessions.sealing import NONCE_SIZE, TAG_SIZE, AesSeal, key_for

MAGIC = b"\x8aADIBAK\x01"
"""Eight bytes; the last is the version."""
FORMAT, VERSION = "adibas-backup", 1
LENGTH = struct.Struct("<I")
PIECE_BYTES = 1 << 20
LONGEST_PIECE = PIECE_BYTES + 1 + NONCE_SIZE + TAG_SIZE
LONGEST_HEADER = 1 << 16
SALT_BYTES = 16
FILE, DATA, END = b"F", b"D", b"E"
"""A file begins (its name), more of its content, the whole is complete (number of files)."""


@dataclass(frozen=True, slots=True)
class BackupHeader:
    """What can be read of a backup without its passphrase; it names nobody.

    Attributes
    ----------
    store_id, fingerprint : str
        Of the store and of its key.
    created_utc : str
        ISO 8601.
    salt : str
        Random; every backup has its own key.
    n_bytes : int
        Of all files inside.
    wrapped : Mapping
        The store's key behind a passphrase, or behind those of its people; see `KeyFile`.
    recovery : Mapping or None
        The same key behind the recovery key of then, if there was one.
    log_end : str or None
        Hash of a line of the store's audit log, one of the last: copies of a store that both went
        on are told apart by it. None in backups of before.
    """

    store_id: str
    fingerprint: str
    created_utc: str
    salt: str
    n_bytes: int
    wrapped: Mapping[str, object]
    recovery: Mapping[str, object] | None = None
    log_end: str | None = None

    @property
    def key_file(self) -> KeyFile:
        """What `key.json` of the store says, made of this backup."""
        place: KeyPlace = "people" if "slots" in self.wrapped else "passphrase"
        return KeyFile(self.store_id, place, self.fingerprint, self.wrapped, self.recovery)


def header_of(
    file: KeyFile, created_utc: str, n_bytes: int, log_end: str | None = None
) -> BackupHeader:
    """Return the header of a backup to be, with a salt of its own."""
    salt = secrets.token_hex(SALT_BYTES)
    told = (file.store_id, file.fingerprint, created_utc, salt, n_bytes)
    return BackupHeader(*told, dict(file.wrapped), file.recovery, log_end)


class BackupWriter:
    """Appends files to a backup; memory holds one piece of 1 MiB.

    Attributes
    ----------
    n_files, n_bytes : int
        Begun, and of content, up to now.
    """

    def __init__(self, file: BinaryIO, header: BackupHeader, key: bytes) -> None:
        version = version_of(header.key_file.place)
        told = {name: value for name, value in asdict(header).items() if value is not None}
        line = json.dumps({"format": FORMAT, "version": version, **told}).encode()
        self._file = file
        self._seal = _seal(line, header, key)
        self._n_pieces = self.n_files = self.n_bytes = 0
        file.write(MAGIC + LENGTH.pack(len(line)) + line)

    def begin_file(self, name: str) -> None:
        """Say whose content follows."""
        self.n_files += 1
        self._write(FILE + name.encode())

    def write(self, block: bytes) -> None:
        """Append `PIECE_BYTES` of content at most."""
        self._write(DATA + block)
        self.n_bytes += len(block)

    def finish(self) -> None:
        """Mark the end, so that a cut is seen."""
        self._write(END + str(self.n_files).encode())

    def _write(self, plain: bytes) -> None:
        sealed = self._seal.seal(str(self._n_pieces), plain)
        self._n_pieces += 1
        self._file.write(LENGTH.pack(len(sealed)) + sealed)


class BackupReader:
    """A backup, opened; nothing is read into memory but one piece.

    Raises
    ------
    StoreError
        It is no backup, damaged, or of a later version.
    FileError
        It cannot be read.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        try:
            self._file: BinaryIO = path.open("rb")
        except OSError as error:
            raise cannot_read(path, error) from error
        with ExitStack() as if_that_fails:
            if_that_fails.callback(self._file.close)
            self._line = self._read_header()
            self.header = self._parsed(self._line)
            if_that_fails.pop_all()

    def key(self, passphrase: str | None) -> bytes:
        """Return the key of the store that was backed up.

        Parameters
        ----------
        passphrase : str or None
            One that held when the backup was made, or the recovery key of then.

        Raises
        ------
        PassphraseError
            The passphrase is missing or wrong.
        """
        if passphrase is None:
            raise BackupLockedError(
                "{file} is locked. Give the passphrase that held when it was made.",
                file=self._path.name,
            )
        try:
            key = _key_behind(self.header.key_file, passphrase)
        except StoreError as error:
            raise self._damaged() from error
        if key is None and self.header.recovery is not None:
            raise PassphraseError(
                "This is neither the passphrase nor the recovery key of {file}. Nothing was "
                "changed. Give one that held when the backup was made.",
                file=self._path.name,
            )
        if key is None:
            raise PassphraseError(
                "This is not the passphrase of {file}. Nothing was changed. Give the one that held "
                "when the backup was made.",
                file=self._path.name,
            )
        if not self.is_of(key):
            raise self._damaged()
        return key

    def is_of(self, key: bytes) -> bool:
        """Say whether this is a backup of the store with that key."""
        return self.header.fingerprint == fingerprint_of(key)

    def pieces(self, key: bytes) -> Iterator[tuple[bytes, bytes]]:
        """Give kind and content of each piece, up to the end; see `FILE`, `DATA`.

        Raises
        ------
        StoreError
            The file was cut, changed or damaged.
        """
        seal = _seal(self._line, self.header, key)
        number = n_files = 0
        while True:
            try:
                plain = seal.open(str(number), self._sealed_piece())
            except SealError as error:
                raise self._damaged() from error
            kind, content = plain[:1], plain[1:]
            if kind == END:
                break
            n_files += kind == FILE
            number += 1
            yield kind, content
        if content != str(n_files).encode() or self._take(1):
            raise self._damaged()

    def of_later_version(self) -> StoreError:
        """Say that something in it is not known to this version."""
        return StoreError(
            "{file} was made by a later version of ADiBAS. Update the program.",
            file=self._path.name,
        )

    def close(self) -> None:
        """Let go of the file."""
        self._file.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_error: object) -> None:
        self.close()

    def _sealed_piece(self) -> bytes:
        return self._whole(self._length(LONGEST_PIECE))

    def _length(self, most: int) -> int:
        (length,) = LENGTH.unpack(self._whole(LENGTH.size))
        if length > most:
            raise self._damaged()
        return int(length)

    def _whole(self, n_bytes: int) -> bytes:
        data = self._take(n_bytes)
        if len(data) < n_bytes:
            raise self._damaged()
        return data

    def _take(self, n_bytes: int) -> bytes:
        try:
            return self._file.read(n_bytes)
        except OSError as error:
            raise cannot_read(self._path, error) from error

    def _read_header(self) -> bytes:
        magic = self._take(len(MAGIC))
        if magic[:-1] == MAGIC[:-1] and magic[-1:] > MAGIC[-1:]:
            raise self.of_later_version()
        if magic != MAGIC:
            raise StoreError(
                "{file} is no backup of ADiBAS. Choose another file.", file=self._path.name
            )
        return self._whole(self._length(LONGEST_HEADER))

    def _parsed(self, line: bytes) -> BackupHeader:
        try:
            document = json.loads(line)
        except (ValueError, RecursionError) as error:
            raise self._damaged() from error
        if not isinstance(document, dict) or document.pop("format", None) != FORMAT:
            raise self._damaged()
        version, header = document.pop("version", None), _header_in(document)
        place = None if header is None else header.key_file.place
        if version != version_of(place):
            raise self.of_later_version()
        if header is None:
            raise self._damaged()
        return header

    def _damaged(self) -> StoreError:
        return StoreError(
            "{file} was cut off, changed or damaged, and nothing of it is used. Take another "
            "backup, or copy this one anew from where it came.",
            file=self._path.name,
        )


def _header_in(document: Mapping[str, Any]) -> BackupHeader | None:
    texts = ("store_id", "fingerprint", "created_utc", "salt")
    is_whole = (
        all(isinstance(document.get(name), str) for name in texts)
        and type(document.get("n_bytes")) is int
        and isinstance(document.get("wrapped"), dict)
        and len(document["store_id"]) == ID_LENGTH
    )
    if not is_whole:
        return None
    fields = (*texts, "n_bytes", "wrapped")
    header = {name: document[name] for name in fields}
    log_end = document.get("log_end")
    return BackupHeader(
        **header,
        recovery=recovery_in(document),
        log_end=log_end if isinstance(log_end, str) else None,
    )


def _key_behind(file: KeyFile, secret: str) -> bytes | None:
    """Return the key behind a recovery key or a passphrase; the first costs nothing to try."""
    try:
        key = key_by_recovery(file, read_recovery_key(secret))
    except RecoveryKeyTypedError:
        key = None  # then it is a passphrase
    return key if key is not None else key_behind(file, secret)


def _seal(line: bytes, header: BackupHeader, key: bytes) -> AesSeal:
    """Return the seal of the pieces; a changed header opens none of them."""
    own_key = key_for(f"{FORMAT}-{VERSION}/{header.salt}", key)
    return AesSeal(own_key, f"{FORMAT}-{VERSION}/{hashlib.sha256(line).hexdigest()}")
