"""The store's key: where it is kept, and what is said when it cannot be had."""

import base64
import json

import keyring.errors
import pytest
from keyring.backends import fail, null

from adibas.errors import PassphraseError, StoreError
from adibas.sessions import KeyState, change_passphrase, key_state, open_store
from adibas.sessions.key_wrapping import Argon2Params, unwrap_key, wrap_key
from tests.unit.store_samples import (
    CHEAP,
    IDENTITY,
    PASSPHRASE,
    MemoryKeyring,
    all_bytes,
    open_sample,
    use_keyring,
)


@pytest.fixture
def folder(tmp_path):
    return tmp_path / "store"


@pytest.fixture
def memory(monkeypatch):
    return use_keyring(monkeypatch, MemoryKeyring())


@pytest.fixture
def locked(folder):
    """A store behind a passphrase, with one patient; gives the pseudonym."""
    with open_sample(folder) as store:
        return store.patients.add(IDENTITY).pseudonym


def edit_key_file(folder, **changes):
    path = folder / "key.json"
    path.write_text(json.dumps(json.loads(path.read_text()) | changes))


def test_a_new_store_keeps_its_key_in_the_keyring_and_opens_by_it(folder, memory):
    assert key_state(folder) is KeyState.NEW_KEYRING
    with open_store(folder) as store:
        pseudonym = store.patients.add(IDENTITY).pseudonym
    assert key_state(folder) is KeyState.KEYRING
    (key,) = memory.entries.values()
    assert len(base64.b64decode(key)) == 32
    assert key.encode() not in b"".join(all_bytes(folder).values())
    with open_store(folder) as store:
        assert store.patients.get(pseudonym).identity == IDENTITY


def test_two_stores_have_keys_of_their_own(tmp_path, memory):
    for name in ("a", "b"):
        open_store(tmp_path / name).close()
    assert len(set(memory.entries.values())) == 2


@pytest.mark.parametrize("backend", [fail.Keyring(), null.Keyring()])
def test_without_a_keyring_a_passphrase_is_asked_for_and_nothing_is_made(
    folder, monkeypatch, backend
):
    use_keyring(monkeypatch, backend)
    assert key_state(folder) is KeyState.NEW_PASSPHRASE
    with pytest.raises(PassphraseError, match="no keyring"):
        open_store(folder)
    assert key_state(folder) is KeyState.NEW_PASSPHRASE
    assert not (folder / "adibas.db").exists()


@pytest.mark.usefixtures("memory")
def test_a_keyring_that_does_not_open_counts_as_none_for_a_new_store(folder, monkeypatch):
    def refuse(*_arguments):
        raise keyring.errors.KeyringLocked

    monkeypatch.setattr(keyring, "get_password", refuse)
    assert key_state(folder) is KeyState.NEW_PASSPHRASE


@pytest.mark.usefixtures("memory")
def test_a_keyring_that_keeps_nothing_is_told_at_once(folder, monkeypatch):
    monkeypatch.setattr(keyring, "set_password", lambda *_: None)
    with pytest.raises(StoreError, match="keyring does not open"):
        open_store(folder)
    assert not (folder / "key.json").exists()


def test_a_key_that_the_keyring_lost_is_said_in_words(folder, memory):
    open_store(folder).close()
    before = all_bytes(folder)
    memory.entries.clear()
    assert key_state(folder) is KeyState.LOST
    with pytest.raises(StoreError, match="has lost the key"):
        open_store(folder)
    assert all_bytes(folder) == before


@pytest.mark.usefixtures("memory")
def test_a_keyring_that_is_locked_is_not_called_lost(folder, monkeypatch):
    open_store(folder).close()

    def refuse(*_arguments):
        raise keyring.errors.KeyringLocked

    monkeypatch.setattr(keyring, "get_password", refuse)
    assert key_state(folder) is KeyState.LOST
    with pytest.raises(StoreError, match="Unlock it"):
        open_store(folder)


def test_the_key_of_another_store_is_refused(folder, memory):
    open_store(folder).close()
    (entry,) = memory.entries
    memory.entries[entry] = base64.b64encode(bytes(32)).decode()
    with pytest.raises(StoreError, match="another patient store"):
        open_store(folder)


@pytest.mark.usefixtures("memory")
def test_a_passphrase_for_a_store_of_the_keyring_is_refused(folder):
    open_store(folder).close()
    with pytest.raises(PassphraseError, match="keyring and not"):
        open_store(folder, PASSPHRASE)


def test_a_passphrase_opens_and_another_one_changes_nothing(folder, locked):
    assert key_state(folder) is KeyState.PASSPHRASE
    before = all_bytes(folder)
    for passphrase, words in (("correct horse Battery", "is wrong"), (None, "is locked")):
        with pytest.raises(PassphraseError, match=words):
            open_store(folder, passphrase)
    assert all_bytes(folder) == before
    with open_sample(folder) as store:
        assert store.patients.get(locked).identity == IDENTITY


def test_accents_may_be_typed_composed_or_not(folder):
    open_store(folder, "caf\u00e9 con leche", key_params=CHEAP).close()
    with open_store(folder, "cafe\u0301 con leche") as store:
        assert not store.is_read_only


@pytest.mark.parametrize("passphrase", ["", "seven77"])
def test_a_short_passphrase_is_refused_for_a_new_store(folder, passphrase):
    with pytest.raises(PassphraseError, match="8 characters"):
        open_store(folder, passphrase)
    assert not (folder / "key.json").exists()


def test_a_new_passphrase_takes_the_place_of_the_old_one(folder, locked):
    change_passphrase(folder, PASSPHRASE, "another sentence", CHEAP)
    with pytest.raises(PassphraseError, match="is wrong"):
        open_store(folder, PASSPHRASE)
    with open_store(folder, "another sentence") as store:
        assert store.patients.get(locked).identity == IDENTITY


@pytest.mark.usefixtures("locked")
def test_the_passphrase_is_not_changed_by_who_does_not_know_it(folder):
    before = all_bytes(folder)
    with pytest.raises(PassphraseError, match="is wrong"):
        change_passphrase(folder, "a wrong guess", "another sentence", CHEAP)
    with pytest.raises(PassphraseError, match="8 characters"):
        change_passphrase(folder, PASSPHRASE, "short", CHEAP)
    assert all_bytes(folder) == before


def test_a_key_leaves_the_keyring_for_a_passphrase(folder, memory):
    open_store(folder).close()
    change_passphrase(folder, None, PASSPHRASE, CHEAP)
    assert key_state(folder) is KeyState.PASSPHRASE
    assert memory.entries == {}
    with open_store(folder, PASSPHRASE) as store:
        assert not store.is_read_only


@pytest.mark.usefixtures("locked")
def test_a_missing_key_file_is_told_and_no_new_key_is_made(folder):
    (folder / "key.json").unlink()
    before = all_bytes(folder)
    with pytest.raises(StoreError, match=r"lost its key\.json"):
        open_store(folder, PASSPHRASE)
    assert all_bytes(folder) == before


@pytest.mark.parametrize(
    "text",
    [
        "",
        "{",
        "[" * 100_000,
        "[]",
        "{}",
        '{"format": "adibas-key", "version": 1}',
        '{"format": "adibas-key", "version": 1, "place": "cloud", "wrapped": {}}',
    ],
)
@pytest.mark.usefixtures("locked")
def test_a_damaged_key_file_is_one_sentence(folder, text):
    (folder / "key.json").write_text(text)
    for action in (key_state, lambda folder: open_store(folder, PASSPHRASE)):
        with pytest.raises(StoreError, match=r"key\.json of the patient store is damaged"):
            action(folder)


@pytest.mark.usefixtures("locked")
def test_a_key_file_that_is_no_text_is_one_sentence(folder):
    (folder / "key.json").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(StoreError, match="it is no text"):
        key_state(folder)


@pytest.mark.parametrize(
    "wrapped",
    [
        {},
        {"argon2id": {}},
        {"argon2id": {"iterations": 1, "lanes": 1, "memory_kib": 2**40}},
        {"argon2id": {"iterations": 10**9, "lanes": 1, "memory_kib": 8}},
        {"argon2id": {"iterations": 1, "lanes": 1, "memory_kib": 8}},
        {"argon2id": {"iterations": 1, "lanes": 1, "memory_kib": 8}, "salt": "?"},
        {
            "argon2id": {"iterations": 1, "lanes": 1, "memory_kib": 8},
            "salt": "AAAA",
            "nonce": "AAAA",
            "sealed_key": "AAAA",
        },
    ],
)
@pytest.mark.usefixtures("locked")
def test_a_damaged_wrapping_is_one_sentence_and_never_a_costly_one(folder, wrapped):
    edit_key_file(folder, wrapped=wrapped)
    with pytest.raises(StoreError, match="is damaged"):
        open_store(folder, PASSPHRASE)


@pytest.mark.usefixtures("locked")
def test_a_key_file_of_a_later_version_is_refused(folder):
    edit_key_file(folder, version=2)
    with pytest.raises(StoreError, match="later version"):
        open_store(folder, PASSPHRASE)


def test_a_wrapped_key_opens_for_its_own_store_only():
    wrapped = wrap_key(bytes(range(32)), PASSPHRASE, "a", CHEAP)
    assert unwrap_key(wrapped, PASSPHRASE, "a") == bytes(range(32))
    assert unwrap_key(wrapped, PASSPHRASE, "b") is None


def test_a_guess_costs_what_the_standard_recommends():
    assert Argon2Params() == Argon2Params(iterations=3, lanes=4, memory_kib=65536)
    with pytest.raises(ValueError, match="no use"):
        Argon2Params(iterations=0)


def test_the_folder_is_for_its_user_alone(folder):
    open_sample(folder).close()
    assert folder.stat().st_mode & 0o077 == 0
