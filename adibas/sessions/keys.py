"""The store's key: made once, and kept in the desktop's keyring or behind a passphrase."""

import base64
import binascii
import enum
import secrets
import uuid
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

import keyring
from keyring.backends import fail, null
from keyring.errors import KeyringError

from adibas.errors import PassphraseError, StoreError
from adibas.sessions.key_file import (
    KeyFile,
    damaged,
    fingerprint_of,
    read_key_file,
    write_key_file,
)
from adibas.sessions.key_wrapping import (
    KEY_BYTES,
    Argon2Params,
    unwrap_key,
    wrap_key,
)
from adibas.sessions.person_keys import Unlocked, check_length, unlock
from adibas.sessions.recovery_key import open_for_recovery

SERVICE = "ADiBAS patient store"


class KeyState(enum.Enum):
    """What opening a store will need.

    `NEW_...`: there is no store yet, and its key will go into the desktop's keyring, or needs a
    passphrase because there is no keyring. `PEOPLE`: the passphrase of one of the store's people.
    `LOST`: the keyring does not give the key.
    """

    NEW_KEYRING = enum.auto()
    NEW_PASSPHRASE = enum.auto()
    KEYRING = enum.auto()
    PASSPHRASE = enum.auto()
    PEOPLE = enum.auto()
    LOST = enum.auto()


BEHIND_PASSPHRASE = (KeyState.PASSPHRASE, KeyState.PEOPLE)
"""The states in which somebody has to type a passphrase."""


def key_state(folder: Path) -> KeyState:
    """Say what opening the store in `folder` will need; nothing is changed.

    Raises
    ------
    StoreError
        `key.json` is damaged or of a later version.
    """
    file = read_key_file(folder)
    if file is None:
        return KeyState.NEW_KEYRING if _has_keyring() else KeyState.NEW_PASSPHRASE
    if file.place == "people":
        return KeyState.PEOPLE
    if file.place == "passphrase":
        return KeyState.PASSPHRASE
    try:
        return KeyState.KEYRING if _from_keyring(file) else KeyState.LOST
    except StoreError:
        return KeyState.LOST


def make_key(folder: Path, passphrase: str | None, params: Argon2Params) -> bytes:
    """Make the key of a new store and keep it; return it.

    Raises
    ------
    PassphraseError
        There is no keyring and no passphrase, or it is too short.
    StoreError
        The keyring does not keep the key.
    FileError
        `key.json` cannot be written.
    """
    key, store_id = secrets.token_bytes(KEY_BYTES), uuid.uuid4().hex
    if passphrase is None:
        if not _has_keyring():
            raise PassphraseError(
                "This computer has no keyring for the key of the patient store. Choose a "
                "passphrase, and keep it safe: without it and without a recovery key nobody can "
                "read the patients."
            )
        _to_keyring(store_id, key)
        file = KeyFile(store_id, "keyring", fingerprint_of(key), {})
    else:
        file = behind_passphrase(store_id, key, passphrase, params)
    write_key_file(folder, file)
    return key


def load_key(folder: Path, passphrase: str | None) -> bytes:
    """Return the key of an existing store; see `open_key`."""
    return open_key(folder, passphrase).key


def open_key(folder: Path, passphrase: str | None) -> Unlocked:
    """Return the key of an existing store, and whose passphrase it was; nothing is changed.

    Raises
    ------
    PassphraseError
        The passphrase is missing or wrong.
    StoreError
        The keyring has lost the key, or `key.json` is missing or damaged.
    """
    file = read_key_file(folder)
    if file is None:
        raise StoreError(
            "The patient store has lost its key.json. Restore that file from a backup; without it "
            "the patients cannot be read."
        )
    if file.place == "people":
        return _of_person(file, passphrase)
    key = _unwrapped(file, passphrase) if file.place == "passphrase" else _kept(file, passphrase)
    if fingerprint_of(key) != file.fingerprint:
        raise StoreError(
            "The key that was found belongs to another patient store. Restore key.json and the "
            "database from the same backup."
        )
    return Unlocked(key, None)


def change_passphrase(
    folder: Path, old: str | None, new: str, params: Argon2Params | None = None
) -> None:
    """Keep the key behind the passphrase `new` from now on; the data stay as they are.

    For a store without people; a person changes their own by `People.change_passphrase`.

    Parameters
    ----------
    old : str or None
        The passphrase until now; None where the key is in the keyring.

    Raises
    ------
    PassphraseError
        `old` is wrong, or `new` too short.
    StoreError
        The key is lost.
    """
    key = load_key(folder, old)
    file = read_key_file(folder)
    if file is None:
        raise StoreError("The patient store has lost its key.json. Restore it from a backup.")
    if file.place == "people":
        raise ValueError("each person has a passphrase of their own")
    write_key_file(folder, moved_behind(file, key, new, params or Argon2Params()))
    leave_keyring(file)


def moved_behind(file: KeyFile, key: bytes, passphrase: str, params: Argon2Params) -> KeyFile:
    """Return `file` with its key behind a passphrase; the recovery key stays.

    Raises
    ------
    PassphraseError
        It is too short.
    """
    moved = behind_passphrase(file.store_id, key, passphrase, params)
    return replace(moved, recovery=file.recovery)


def key_by_recovery(file: KeyFile, recovery_key: str) -> bytes | None:
    """Return the key that a recovery key opens; None where it is another one.

    Raises
    ------
    StoreError
        The file is damaged.
    """
    if file.recovery is None:
        return None
    try:
        return open_for_recovery(file.recovery, recovery_key, file.store_id)
    except ValueError as error:
        raise damaged(str(error)) from error


def leave_keyring(file: KeyFile) -> None:
    """Take the key out of the keyring, where `file` says that it is there."""
    if file.place == "keyring":
        with suppress(KeyringError):  # then the keyring keeps a second way in
            keyring.delete_password(SERVICE, file.store_id)


def behind_passphrase(store_id: str, key: bytes, passphrase: str, params: Argon2Params) -> KeyFile:
    """Return what `key.json` says of a key behind a passphrase.

    Raises
    ------
    PassphraseError
        It is too short.
    """
    check_length(passphrase)
    wrapped = wrap_key(key, passphrase, store_id, params)
    return KeyFile(store_id, "passphrase", fingerprint_of(key), wrapped)


def key_behind(file: KeyFile, passphrase: str) -> bytes | None:
    """Return the key behind a passphrase, the store's or a person's; None where it is another one.

    Raises
    ------
    StoreError
        The file is damaged.
    """
    if file.place == "people":
        found = unlock(file, passphrase)
        return None if found is None else found.key
    try:
        return unwrap_key(file.wrapped, passphrase, file.store_id)
    except ValueError as error:
        raise damaged(str(error)) from error


def _unwrapped(file: KeyFile, passphrase: str | None) -> bytes:
    if passphrase is None:
        raise _locked()
    key = key_behind(file, passphrase)
    if key is None:
        raise wrong_passphrase(file)
    return key


def _of_person(file: KeyFile, passphrase: str | None) -> Unlocked:
    if passphrase is None:
        raise _locked()
    found = unlock(file, passphrase)
    if found is None:
        raise wrong_passphrase(file)
    return found


def _locked() -> PassphraseError:
    return PassphraseError("The patient store is locked. Give its passphrase.")


def wrong_passphrase(file: KeyFile) -> PassphraseError:
    """Say that a passphrase opens nothing, and what helps where it is forgotten."""
    if file.recovery is not None:
        return PassphraseError(
            "The passphrase is wrong. Nothing was changed; check Caps Lock and the keyboard's "
            "language, and try again. Where it is forgotten, the recovery key opens the store."
        )
    return PassphraseError(
        "The passphrase is wrong. Nothing was changed; check Caps Lock and the keyboard's "
        "language, and try again."
    )


def _kept(file: KeyFile, passphrase: str | None) -> bytes:
    if passphrase is not None:
        raise PassphraseError(
            "The key of this patient store is in the desktop's keyring and not behind a "
            "passphrase. Open it without a passphrase."
        )
    key = _from_keyring(file)
    if key is None and file.recovery is not None:
        raise StoreError(
            "The desktop's keyring has lost the key of the patient store. The recovery key opens "
            "the store and gives it a new passphrase."
        )
    if key is None:
        raise StoreError(
            "The desktop's keyring has lost the key of the patient store. Restore the keyring of "
            "this user from a backup; without the key nobody can read the patients."
        )
    return key


def _has_keyring() -> bool:
    try:
        if isinstance(keyring.get_keyring(), fail.Keyring | null.Keyring):
            return False
        keyring.get_password(SERVICE, "probe")
    except KeyringError:
        return False
    return True


def _to_keyring(store_id: str, key: bytes) -> None:
    text = base64.b64encode(key).decode()
    try:
        keyring.set_password(SERVICE, store_id, text)
        is_kept = keyring.get_password(SERVICE, store_id) == text
    except KeyringError as error:
        raise _closed_keyring() from error
    if not is_kept:
        raise _closed_keyring()


def _from_keyring(file: KeyFile) -> bytes | None:
    try:
        text = keyring.get_password(SERVICE, file.store_id)
    except KeyringError as error:
        raise _closed_keyring(file) from error
    if text is None:
        return None
    try:
        return base64.b64decode(text, validate=True)
    except binascii.Error:
        return None


def _closed_keyring(file: KeyFile | None = None) -> StoreError:
    if file is not None and file.recovery is not None:
        return StoreError(
            "The desktop's keyring does not open. Unlock it, or log in to the desktop on which the "
            "patient store was made, and try again. Where it is lost, the recovery key opens the "
            "store."
        )
    return StoreError(
        "The desktop's keyring does not open. Unlock it, or log in to the desktop on which the "
        "patient store was made, and try again."
    )
