"""`key.json`: where a store's key is kept, and how to know that it is the right one."""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from adibas.errors import StoreError
from adibas.files import written_whole
from adibas.sessions.lock import cannot_use

KEY_FILE = "key.json"
FORMAT = "adibas-key"
VERSION = 1
VERSION_WITH_PEOPLE = 2
"""A program that knows no people refuses such a store: it would let everybody do everything."""
ID_LENGTH = 32

KeyPlace = Literal["keyring", "passphrase", "people"]


@dataclass(frozen=True, slots=True)
class KeyFile:
    """What `key.json` says.

    Attributes
    ----------
    store_id : str
        Random; names the entry in the keyring.
    place : "keyring", "passphrase" or "people"
        Where the key is: in the keyring, behind the store's passphrase, or behind one passphrase a
        person.
    fingerprint : str
        Of the key; tells another store's key from this one's and gives nothing of it away.
    wrapped : Mapping
        See `wrap_key`, for people `person_keys`; empty for a keyring.
    recovery : Mapping or None
        See `seal_for_recovery`; None where there is no recovery key.
    """

    store_id: str
    place: KeyPlace
    fingerprint: str
    wrapped: Mapping[str, object]
    recovery: Mapping[str, object] | None = None


def fingerprint_of(key: bytes) -> str:
    """Return what identifies `key`; nothing can be learned from it of 256 random bits."""
    return hashlib.sha256(b"adibas store key " + key).hexdigest()


def read_key_file(folder: Path) -> KeyFile | None:
    """Return what `key.json` in `folder` says; None where there is none.

    Raises
    ------
    StoreError
        The folder cannot be used, or the file is damaged or of a later version.
    """
    try:
        text = (folder / KEY_FILE).read_text(encoding="utf-8")
    except FileNotFoundError:
        return None
    except OSError as error:
        raise cannot_use(folder, error) from error
    except UnicodeDecodeError as error:
        raise damaged("it is no text") from error
    try:
        return _from_document(json.loads(text))
    except (ValueError, RecursionError) as error:
        raise damaged(str(error)) from error


def write_key_file(folder: Path, file: KeyFile) -> None:
    """Write `key.json`, whole or not at all.

    Raises
    ------
    FileError
        The disk is full, or the folder cannot be written.
    """
    document: dict[str, object] = {
        "format": FORMAT,
        "version": version_of(file.place),
        "store_id": file.store_id,
        "place": file.place,
        "fingerprint": file.fingerprint,
        "wrapped": dict(file.wrapped),
    }
    if file.recovery is not None:
        document["recovery"] = dict(file.recovery)
    with written_whole(folder / KEY_FILE) as path:
        path.write_text(json.dumps(document, indent=2) + "\n", encoding="utf-8")


def version_of(place: object) -> int:
    """Return the version of a file whose key is at `place`."""
    return VERSION_WITH_PEOPLE if place == "people" else VERSION


def damaged(reason: str) -> StoreError:
    """Say that `key.json` cannot be used."""
    return StoreError(
        "{file} of the patient store is damaged ({reason}). Restore it from a backup; without it "
        "the store cannot be opened.",
        file=KEY_FILE,
        reason=reason,
    )


def _from_document(document: object) -> KeyFile:
    if not isinstance(document, dict) or document.get("format") != FORMAT:
        raise ValueError("it is no key file of ADiBAS")
    place, wrapped = document.get("place"), document.get("wrapped")
    if document.get("version") != version_of(place):
        raise StoreError(
            "{file} of the patient store was made by a later version of ADiBAS. Update the "
            "program.",
            file=KEY_FILE,
        )
    store_id, fingerprint = document.get("store_id"), document.get("fingerprint")
    if place not in ("keyring", "passphrase", "people") or not isinstance(wrapped, dict):
        raise ValueError("the place of the key is missing")
    if not (isinstance(store_id, str) and len(store_id) == ID_LENGTH):
        raise ValueError("the number of the store is missing")
    if not isinstance(fingerprint, str):
        raise ValueError("the fingerprint is missing")  # noqa: TRY004  (the file's fault)
    return KeyFile(store_id, place, fingerprint, wrapped, recovery_in(document))


def recovery_in(document: Mapping[str, object]) -> Mapping[str, object] | None:
    """Return the copy for the recovery key, if there is one; one that is damaged opens nothing."""
    recovery = document.get("recovery")
    return recovery if isinstance(recovery, dict) else None
