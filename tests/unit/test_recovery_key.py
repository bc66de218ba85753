"""The recovery key: how it is typed, what it opens, what it does not, and what is noted of it."""

import base64
import itertools
import json
import logging
import secrets
import tempfile

import pytest
from hypothesis import given
from hypothesis import strategies as st

from adibas.errors import (
    FileError,
    NotAllowedError,
    PassphraseError,
    RecoveryKeyTypedError,
    StoreError,
)
from adibas.sessions import KeyState, key_file, key_state, open_store
from adibas.sessions import people as people_module
from adibas.sessions import recovery as recovery_module
from adibas.sessions.key_file import read_key_file
from adibas.sessions.keys import change_passphrase
from adibas.sessions.recovering import RecoveryWish, administrators, recover_store
from adibas.sessions.recovery_key import (
    LETTERS,
    make_recovery_key,
    open_for_recovery,
    read_recovery_key,
    seal_for_recovery,
)
from adibas.sessions.restoring import restore_into
from adibas.sessions.roles import Role
from adibas.sessions.trial_restore import verify_backup
from tests.unit.store_samples import (
    CHEAP,
    IDENTITY,
    PASSPHRASE,
    MemoryKeyring,
    add_session,
    all_bytes,
    minutes_clock,
    open_sample,
    use_keyring,
)

ANNA, BORIS, NEW = "anna has a long one", "boris likes numbers 7", "a new one is chosen"
SECRET = bytes(range(32))
ID, MADE = "0" * 32, "2026-11-25T09:00:00.000000+00:00"


@pytest.fixture
def folder(tmp_path):
    return tmp_path / "store"


def held(store):
    """Give the store a recovery key and return it."""
    recovery_key = make_recovery_key()
    store.recovery.hold(recovery_key)
    return recovery_key


def recovered(folder, recovery_key, new=NEW, name=""):
    wish = RecoveryWish(recovery_key, new, name)
    return recover_store(folder, wish, clock=minutes_clock(), key_params=CHEAP)


def people_lines(store):
    return [
        one.detail["did"]
        for one in reversed(store.audit.entries())
        if (one.subject, one.action) == ("people", "change")
    ]


@pytest.fixture
def locked(folder):
    """A store behind a passphrase, with a patient; gives its pseudonym and its recovery key."""
    with open_sample(folder) as store:
        return add_session(store).patient, held(store)


@pytest.fixture
def in_keyring(folder, monkeypatch):
    """A store whose key the keyring has lost; gives its recovery key."""
    memory = use_keyring(monkeypatch, MemoryKeyring())
    with open_store(folder) as store:
        recovery_key = held(store)
    memory.entries.clear()
    return recovery_key


@pytest.fixture
def with_people(folder):
    """A store of an administrator and an operator; gives its recovery key."""
    with open_sample(folder) as store:
        store.people.add("Anna", Role.ADMINISTRATOR, ANNA, CHEAP)
        store.people.add("Boris", Role.OPERATOR, BORIS, CHEAP)
        return held(store)


# What is typed


def test_a_key_has_130_random_bits_in_seven_groups_of_four(monkeypatch):
    drawn = []
    draw = secrets.randbelow
    monkeypatch.setattr(secrets, "randbelow", lambda most: drawn.append(most) or draw(most))
    groups = make_recovery_key().split("-")
    assert [len(group) for group in groups] == [4] * 7
    assert set("".join(groups)) <= set("0123456789ABCDEFGHJKMNPQRSTVWXYZ")
    assert drawn == [32] * 26
    assert len({make_recovery_key() for _key in range(50)}) == 50


def test_it_is_read_however_it_is_written_down():
    recovery_key = make_recovery_key()
    for typed in (
        recovery_key.lower(),
        recovery_key.replace("-", " "),
        recovery_key.replace("-", ""),
        f"  {recovery_key}\n",
        recovery_key.replace("0", "O").replace("1", "I"),
        recovery_key.replace("0", "o").replace("1", "l"),
        recovery_key.replace("-", "\N{EN DASH}"),
    ):
        assert read_recovery_key(typed) == recovery_key


def test_every_single_wrong_letter_and_every_exchange_of_two_is_noticed():
    right = make_recovery_key().replace("-", "")
    wrong = {
        right[:place] + letter + right[place + 1 :]
        for place in range(28)
        for letter in LETTERS
        if letter != right[place]
    }
    for one, other in itertools.combinations(range(28), 2):
        letters = list(right)
        letters[one], letters[other] = letters[other], letters[one]
        wrong.add("".join(letters))
    wrong.discard(right)
    for typed in wrong:
        with pytest.raises(RecoveryKeyTypedError, match="do not belong together"):
            read_recovery_key(typed)


@given(st.data())
def test_two_wrong_letters_are_noticed(data):
    right = list(make_recovery_key().replace("-", ""))
    places = data.draw(st.lists(st.integers(0, 27), min_size=2, max_size=2, unique=True))
    typed = right.copy()
    for place in places:
        typed[place] = data.draw(st.sampled_from([one for one in LETTERS if one != right[place]]))
    with pytest.raises(RecoveryKeyTypedError):
        read_recovery_key("".join(typed))


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (lambda key: key[:-1], "28 letters and digits, and 27"),
        (lambda key: key + "7", "28 letters and digits, and 29"),
        (lambda _key: "", "and 0 were given"),
        (lambda key: "U" + key[1:], "a letter that none has: U"),
        (lambda key: "\N{GREEK CAPITAL LETTER OMEGA}" + key[1:], "a letter that none has"),
    ],
)
def test_what_is_missing_too_much_or_no_letter_is_told(change, told):
    with pytest.raises(RecoveryKeyTypedError, match=told):
        read_recovery_key(change(make_recovery_key()))


# The sealed copy


def test_the_copy_opens_by_its_key_for_its_store_and_date_alone():
    recovery_key = make_recovery_key()
    sealed = seal_for_recovery(SECRET, recovery_key, ID, MADE)
    assert open_for_recovery(sealed, recovery_key, ID) == SECRET
    assert open_for_recovery(sealed, make_recovery_key(), ID) is None
    assert open_for_recovery(sealed, recovery_key, "1" * 32) is None
    later = {**sealed, "made_utc": MADE.replace("2026", "2027")}
    assert open_for_recovery(later, recovery_key, ID) is None


def test_a_changed_bit_anywhere_in_the_copy_opens_nothing():
    recovery_key = make_recovery_key()
    sealed = seal_for_recovery(SECRET, recovery_key, ID, MADE)
    for name in ("salt", "nonce", "sealed_key"):
        data = bytearray(base64.b64decode(sealed[name]))
        for place in range(len(data)):
            data[place] ^= 1
            changed = {**sealed, name: base64.b64encode(data).decode()}
            assert open_for_recovery(changed, recovery_key, ID) is None
            data[place] ^= 1


@pytest.mark.parametrize("changes", [{"salt": "AAAA"}, {"nonce": None}, {"sealed_key": "?"}])
def test_a_damaged_copy_is_one_sentence_and_the_passphrase_still_opens(folder, locked, changes):
    document = json.loads((folder / "key.json").read_text())
    document["recovery"] |= changes
    (folder / "key.json").write_text(json.dumps(document))
    with pytest.raises(StoreError, match="is damaged"):
        recovered(folder, locked[1])
    open_sample(folder).close()


# The three places of the key


def test_behind_a_passphrase_the_new_one_takes_the_place_of_the_lost_one(folder, locked):
    pseudonym, recovery_key = locked
    assert administrators(folder, recovery_key) == ()
    with recovered(folder, recovery_key.lower()) as store:
        assert store.patients.get(pseudonym).identity == IDENTITY
    with pytest.raises(PassphraseError, match="is wrong"):
        open_store(folder, PASSPHRASE)
    with open_store(folder, NEW) as store:
        assert store.patients.get(pseudonym).identity == IDENTITY
        assert people_lines(store) == ["recovery key made", "recovery key used"]
    with recovered(folder, recovery_key, "still another one"):  # it is not used up
        pass


def test_a_key_that_the_keyring_lost_is_behind_the_new_passphrase_afterwards(folder, in_keyring):
    assert key_state(folder) is KeyState.LOST
    with pytest.raises(StoreError, match=r"has lost the key.*recovery key opens the store"):
        open_store(folder)
    recovered(folder, in_keyring).close()
    assert key_state(folder) is KeyState.PASSPHRASE
    with open_store(folder, NEW) as store:
        assert people_lines(store) == ["recovery key made", "recovery key used"]


def test_a_key_that_is_in_the_keyring_still_leaves_it(folder, monkeypatch):
    memory = use_keyring(monkeypatch, MemoryKeyring())
    with open_store(folder) as store:
        recovery_key = held(store)
    recovered(folder, recovery_key).close()
    assert memory.entries == {}


def test_of_people_the_only_administrator_gets_the_new_passphrase(folder, with_people):
    assert administrators(folder, with_people) == ("Anna",)
    with recovered(folder, with_people) as store:
        assert store.person.name == "Anna"
        assert store.role is Role.ADMINISTRATOR
    with pytest.raises(PassphraseError):
        open_store(folder, ANNA)
    with open_store(folder, BORIS) as store:
        assert store.role is Role.OPERATOR
    with open_store(folder, NEW) as store:
        used = next(one for one in store.audit.entries() if one.action == "change")
        assert used.detail["did"] == "recovery key used"
        assert (used.operator, used.detail["person"]) == ("Anna", "Anna")
        assert "found otherwise" not in people_lines(store)


def test_of_several_administrators_one_is_chosen(folder, with_people):
    with open_store(folder, ANNA) as store:
        store.people.add("Carla", Role.ADMINISTRATOR, "carla, still another", CHEAP)
    before = all_bytes(folder)["key.json"]
    for name in ("", "Boris", "Nobody"):
        with pytest.raises(StoreError, match=r"which administrator.*Anna, Carla"):
            recovered(folder, with_people, name=name)
    assert all_bytes(folder)["key.json"] == before
    with recovered(folder, with_people, name="carla") as store:
        assert store.person.name == "Carla"
    open_store(folder, ANNA).close()


def test_nobody_gets_the_passphrase_of_somebody_else_and_none_is_short(folder, with_people):
    before = all_bytes(folder)["key.json"]
    with pytest.raises(PassphraseError, match="cannot be used"):
        recovered(folder, with_people, new=BORIS)
    with pytest.raises(PassphraseError, match="8 characters"):
        recovered(folder, with_people, new="short")
    assert all_bytes(folder)["key.json"] == before
    with open_store(folder, ANNA) as store:  # and nobody holds it open
        assert not store.is_read_only


# What does not open


def test_another_stores_key_and_a_mistyped_one_are_told_apart_and_change_nothing(
    folder, tmp_path, locked
):
    with open_sample(tmp_path / "other") as other:
        of_other = held(other)
    before = all_bytes(folder)
    with pytest.raises(PassphraseError, match="belongs to another store") as told:
        recovered(folder, of_other)
    assert not isinstance(told.value, RecoveryKeyTypedError)
    mistyped = ("2" if locked[1][0] != "2" else "3") + locked[1][1:]
    with pytest.raises(RecoveryKeyTypedError, match="mistyped"):
        recovered(folder, mistyped)
    assert all_bytes(folder) == before


def test_a_copy_put_in_from_another_store_opens_nothing(folder, tmp_path, locked):
    assert locked
    with open_sample(tmp_path / "other") as other:
        of_other = held(other)
    document, foreign = (
        json.loads((one / "key.json").read_text()) for one in (folder, tmp_path / "other")
    )
    (folder / "key.json").write_text(json.dumps(document | {"recovery": foreign["recovery"]}))
    with pytest.raises(PassphraseError, match="another store"):
        recovered(folder, of_other)


def test_a_key_that_was_replaced_opens_no_more(folder, locked):
    with open_sample(folder) as store:
        second = held(store)
        assert people_lines(store) == ["recovery key made", "recovery key replaced"]
    with pytest.raises(PassphraseError, match="newer one took its place"):
        recovered(folder, locked[1])
    recovered(folder, second).close()


def test_a_store_without_one_says_so(folder):
    open_sample(folder).close()
    with pytest.raises(StoreError, match="has no recovery key"):
        recovered(folder, make_recovery_key())
    with open_sample(folder) as store:
        assert store.recovery.made_utc() is None


def test_a_missing_database_is_told_and_none_is_made(folder, locked):
    (folder / "adibas.db").unlink()
    with pytest.raises(StoreError, match=r"adibas\.db of the patient store is missing"):
        recovered(folder, locked[1])
    assert not (folder / "adibas.db").exists()


def test_while_another_window_has_the_store_open_nothing_is_replaced(folder, locked):
    before = (folder / "key.json").read_bytes()
    with open_sample(folder), pytest.raises(StoreError):
        recovered(folder, locked[1])
    assert (folder / "key.json").read_bytes() == before


def test_who_is_no_administrator_makes_none(folder, with_people):
    before = (folder / "key.json").read_bytes()
    with open_store(folder, BORIS) as store, pytest.raises(NotAllowedError, match="administrators"):
        held(store)
    assert (folder / "key.json").read_bytes() == before
    with open_store(folder, ANNA) as store:
        assert [one.operator for one in store.audit.entries() if one.action == "refuse"] == [
            "Boris"
        ]
    assert administrators(folder, with_people) == ("Anna",)


def test_what_is_no_recovery_key_is_not_held(folder):
    with open_sample(folder) as store:
        with pytest.raises(RecoveryKeyTypedError):
            store.recovery.hold("not one")
        assert store.recovery.made_utc() is None


# It stays where it belongs


def test_it_outlives_new_passphrases_people_and_their_changes(folder, locked):
    with open_sample(folder) as store:
        store.people.change_passphrase(PASSPHRASE, ANNA, CHEAP)
    change_passphrase(folder, ANNA, BORIS, CHEAP)
    with open_store(folder, BORIS) as store:
        store.people.add("Anna", Role.ADMINISTRATOR, ANNA, CHEAP)
        store.people.change("Anna", passphrase=PASSPHRASE, params=CHEAP)
    with recovered(folder, locked[1]) as store:
        assert store.person.name == "Anna"
        assert "found otherwise" not in people_lines(store)


def test_since_when_there_is_one_is_told(folder, locked):
    assert locked
    with open_sample(folder) as store:
        made_utc = store.recovery.made_utc()
        (line,) = [one for one in store.audit.entries() if one.subject == "people"]
        assert made_utc <= line.time_utc
        assert (line.time_utc - made_utc).total_seconds() <= 600


def test_a_key_file_from_before_the_key_was_replaced_is_noticed(folder, locked):
    old = (folder / "key.json").read_bytes()
    with open_sample(folder) as store:
        held(store)
    (folder / "key.json").write_bytes(old)
    with recovered(folder, locked[1]) as store:
        assert people_lines(store)[-2:] == ["found otherwise", "recovery key used"]


def test_a_copy_that_was_taken_out_is_noticed(folder, locked):
    assert locked
    document = json.loads((folder / "key.json").read_text())
    del document["recovery"]
    (folder / "key.json").write_text(json.dumps(document))
    for _opening in range(2):
        with open_sample(folder) as store:
            assert people_lines(store) == ["recovery key made", "found otherwise"]


class KilledError(Exception):
    """The program is killed here."""


def _kill(*_arguments, **_more):
    raise KilledError


@pytest.mark.parametrize("place", ["before the file", "after the file"])
@pytest.mark.parametrize("step", ["make", "use"])
def test_a_kill_between_the_steps_leaves_the_old_or_the_new_state(
    folder, locked, monkeypatch, place, step
):
    """What a kill leaves: the file before or after its renaming, never the line without it."""
    old, new = locked[1], make_recovery_key()
    module = recovery_module if step == "make" else people_module
    write = module.write_key_file

    def killed(*arguments):
        if place == "after the file":
            write(*arguments)
        raise KilledError

    store = open_sample(folder) if step == "make" else None
    monkeypatch.setattr(module, "write_key_file", killed)
    with pytest.raises(KilledError):
        if store is not None:
            store.recovery.hold(new)
        else:
            recovered(folder, old)
    monkeypatch.undo()
    if store is not None:
        store.close()
    is_new = place == "after the file"
    holding = new if step == "make" and is_new else old
    opening = NEW if step == "use" and is_new else PASSPHRASE
    with open_store(folder, opening) as store:
        found = ["found otherwise"] if step == "make" and is_new else []
        assert people_lines(store) == ["recovery key made", *found]
        assert store.verify().is_sound
    recovered(folder, holding, "and it opens").close()


def test_a_full_disk_leaves_the_key_of_before(folder, locked, monkeypatch):
    before = (folder / "key.json").read_bytes()

    def full(_path):
        raise FileError("the disk is full")

    monkeypatch.setattr(key_file, "written_whole", full)
    with open_sample(folder) as store, pytest.raises(FileError):
        held(store)
    assert (folder / "key.json").read_bytes() == before
    monkeypatch.undo()
    recovered(folder, locked[1]).close()


def test_the_key_itself_is_in_no_file_log_or_error(folder, tmp_path, monkeypatch, caplog):
    caplog.set_level(logging.DEBUG)
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    with open_sample(folder) as store:
        recovery_key = held(store)
        detail = json.dumps([dict(one.detail) for one in store.audit.entries()])
    with pytest.raises(PassphraseError) as told:
        recovered(folder, make_recovery_key())
    recovered(folder, recovery_key).close()
    written = b"".join(all_bytes(tmp_path).values())
    said = detail + caplog.text + str(told.value) + repr(RecoveryWish(recovery_key, NEW))
    for one in (recovery_key, recovery_key.replace("-", ""), NEW):
        assert one.encode() not in written
        assert one not in said


# Backups


@pytest.fixture(params=["passphrase", "own passphrase", "keyring", "people"])
def backup(request, folder, tmp_path, monkeypatch):
    """A backup of a store with a recovery key, and that key; the store's own is replaced since."""
    path = tmp_path / "one.adibas-backup"
    if request.param == "keyring":
        use_keyring(monkeypatch, MemoryKeyring())
        store = open_store(folder)
    else:
        store = open_sample(folder)
    with store:
        add_session(store)
        if request.param == "people":
            store.people.add("Anna", Role.ADMINISTRATOR, ANNA, CHEAP)
        recovery_key = held(store)
        own = ANNA if request.param in ("own passphrase", "keyring") else None
        store.backups.write(path, own, params=CHEAP)
        held(store)
    return path, recovery_key


def test_a_backup_opens_with_the_recovery_key_of_then(backup, tmp_path):
    path, recovery_key = backup
    typed = recovery_key.lower().replace("-", " ")
    assert verify_backup(path, typed, room=tmp_path)[1].is_sound
    restore_into(path, tmp_path / "restored", typed)
    with recovered(tmp_path / "restored", recovery_key) as store:
        assert len(store.patients.search("")) == 1


def test_a_backup_opens_with_no_other_recovery_key(backup, tmp_path):
    path, _recovery_key = backup
    with pytest.raises(PassphraseError, match="neither the passphrase nor the recovery key"):
        restore_into(path, tmp_path / "restored", make_recovery_key())
    assert not (tmp_path / "restored").exists()


def test_a_backup_of_a_store_without_one_is_as_it_was(folder, tmp_path):
    path = tmp_path / "one.adibas-backup"
    with open_sample(folder) as store:
        store.backups.write(path)
    assert b"recovery" not in path.read_bytes()[:2000]
    with pytest.raises(PassphraseError, match="not the passphrase of"):
        restore_into(path, tmp_path / "restored", make_recovery_key())
    restore_into(path, tmp_path / "restored", PASSPHRASE)
    assert read_key_file(tmp_path / "restored").recovery is None


def test_a_backup_is_merged_by_its_recovery_key(backup, tmp_path):
    path, recovery_key = backup
    with open_sample(tmp_path / "third") as store:
        with pytest.raises(PassphraseError):
            store.backups.restore(path, make_recovery_key())
        store.backups.restore(path, recovery_key)
        assert len(store.patients.search("")) == 1
