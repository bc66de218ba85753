"""The people of a store: each opens it with a passphrase of their own, and nobody else does."""

import base64
import json

import pytest

from adibas.errors import FileError, NotAllowedError, PassphraseError, StoreError
from adibas.sessions import KeyState, key_file, key_state, key_wrapping, open_store
from adibas.sessions.keys import change_passphrase, load_key, open_key
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

ANNA, BORIS, CARLA = "anna has a long one", "boris likes numbers 7", "carla, still another"
PEOPLE = {
    "Anna Puig": (Role.ADMINISTRATOR, ANNA),
    "Boris Vila": (Role.CLINICIAN, BORIS),
    "Carla Roca": (Role.OPERATOR, CARLA),
}


@pytest.fixture
def folder(tmp_path):
    return tmp_path / "store"


@pytest.fixture
def pseudonym(folder):
    """A store with a patient, and three people who may open it."""
    with open_sample(folder) as store:
        pseudonym = add_session(store).patient
        for name, (role, passphrase) in PEOPLE.items():
            store.people.add(name, role, passphrase, CHEAP)
    return pseudonym


def opened(folder, passphrase):
    return open_store(folder, passphrase, operator="whoever", clock=minutes_clock())


def names(store):
    return [one.name for one in store.people.all()]


def lines(store, action):
    return [one for one in store.audit.entries() if one.action == action]


def test_a_store_without_people_is_as_it_was(folder):
    with open_sample(folder) as store:
        assert store.person is None
        assert store.role is Role.ADMINISTRATOR
        assert store.people.all() == ()
    assert json.loads((folder / "key.json").read_text())["version"] == 1


@pytest.mark.usefixtures("pseudonym")
def test_each_opens_the_store_with_their_own_passphrase_and_role(folder):
    for name, (role, passphrase) in PEOPLE.items():
        with opened(folder, passphrase) as store:
            assert (store.person.name, store.role) == (name, role)
    assert key_state(folder) is KeyState.PEOPLE


def test_all_of_them_read_the_same_patients(folder, pseudonym):
    for _role, passphrase in PEOPLE.values():
        with opened(folder, passphrase) as store:
            assert store.patients.get(pseudonym).identity == IDENTITY


@pytest.mark.usefixtures("pseudonym")
def test_a_passphrase_costs_one_derivation_however_many_people_there_are(folder, monkeypatch):
    derived = []
    derive = key_wrapping._derive

    def counted(*arguments):
        derived.append(arguments)
        return derive(*arguments)

    monkeypatch.setattr(key_wrapping, "_derive", counted)
    assert open_key(folder, CARLA).person.name == "Carla Roca"
    with pytest.raises(PassphraseError):
        open_key(folder, "a wrong guess")
    assert len(derived) == 2


@pytest.mark.usefixtures("pseudonym")
def test_the_passphrase_of_before_and_others_open_nothing_and_change_nothing(folder):
    before = all_bytes(folder)
    for passphrase in (PASSPHRASE, "a wrong guess", ANNA.upper()):
        with pytest.raises(PassphraseError, match="is wrong"):
            open_store(folder, passphrase)
    with pytest.raises(PassphraseError, match="is locked"):
        open_store(folder)
    assert all_bytes(folder) == before


def test_the_first_person_takes_the_place_of_the_keyring(folder, monkeypatch):
    memory = use_keyring(monkeypatch, MemoryKeyring())
    with open_store(folder) as store:
        store.people.add("Anna", Role.ADMINISTRATOR, ANNA, CHEAP)
        assert store.person.name == "Anna"
    assert memory.entries == {}
    with open_store(folder, ANNA) as store:
        assert names(store) == ["Anna"]


def test_the_first_person_is_an_administrator_or_nobody(folder):
    with open_sample(folder) as store:
        with pytest.raises(StoreError, match="first person"):
            store.people.add("Boris", Role.CLINICIAN, BORIS, CHEAP)
        assert store.people.all() == ()
    with open_sample(folder) as store:
        assert store.person is None


@pytest.mark.usefixtures("pseudonym")
def test_the_log_tells_who_it_was_whatever_the_computer_is_called(folder):
    with opened(folder, BORIS) as store:
        store.operator = "somebody else"
        session = add_session(store)
        assert session.operator == "Boris Vila"
    with opened(folder, ANNA) as store:
        (line,) = [one for one in store.audit.entries() if one.subject == session.session_id]
        assert line.operator == "Boris Vila"
        opening = next(one for one in lines(store, "open") if one.operator == "Boris Vila")
        assert opening.detail["role"] == "clinician"
        assert store.verify().is_sound


@pytest.mark.usefixtures("pseudonym")
def test_who_is_removed_opens_the_store_no_more_and_the_others_do(folder):
    with opened(folder, ANNA) as store:
        store.people.remove("boris vila")
        assert names(store) == ["Anna Puig", "Carla Roca"]
    with pytest.raises(PassphraseError):
        open_store(folder, BORIS)
    for passphrase in (ANNA, CARLA):
        opened(folder, passphrase).close()


@pytest.mark.usefixtures("pseudonym")
def test_the_last_administrator_stays_one(folder):
    with opened(folder, ANNA) as store:
        for change in (
            lambda: store.people.remove("Anna Puig"),
            lambda: store.people.change("Anna Puig", role=Role.CLINICIAN),
        ):
            with pytest.raises(StoreError, match="last administrator"):
                change()
        store.people.change("Boris Vila", role=Role.ADMINISTRATOR)
        store.people.remove("Anna Puig")
    with opened(folder, BORIS) as store:
        assert store.role is Role.ADMINISTRATOR


@pytest.mark.usefixtures("pseudonym")
def test_a_changed_role_holds_from_the_next_opening(folder):
    with opened(folder, ANNA) as store:
        store.people.change("Carla Roca", role=Role.CLINICIAN)
    with opened(folder, CARLA) as store:
        assert store.role is Role.CLINICIAN


@pytest.mark.usefixtures("pseudonym")
def test_a_passphrase_is_changed_by_its_owner_or_anew_by_an_administrator(folder):
    with opened(folder, CARLA) as store:
        with pytest.raises(PassphraseError, match="is wrong"):
            store.people.change_passphrase(BORIS, "carla has a new one", CHEAP)
        store.people.change_passphrase(CARLA, "carla has a new one", CHEAP)
    with pytest.raises(PassphraseError):
        open_store(folder, CARLA)
    with opened(folder, ANNA) as store:
        store.people.change("Boris Vila", passphrase="boris forgot his own", params=CHEAP)
        assert names(store) == list(PEOPLE)
    for name, passphrase in (
        ("Carla Roca", "carla has a new one"),
        ("Boris Vila", "boris forgot his own"),
    ):
        with opened(folder, passphrase) as store:
            assert store.person.name == name
    with pytest.raises(PassphraseError):
        open_store(folder, BORIS)


@pytest.mark.usefixtures("pseudonym")
@pytest.mark.parametrize("passphrase", ["short", BORIS])
def test_a_role_is_not_changed_where_the_passphrase_beside_it_cannot_be(folder, passphrase):
    before = (folder / "key.json").read_bytes()
    with opened(folder, ANNA) as store:
        with pytest.raises(PassphraseError):
            store.people.change(
                "Carla Roca", role=Role.ADMINISTRATOR, passphrase=passphrase, params=CHEAP
            )
        assert {one.name: one.role for one in store.people.all()}["Carla Roca"] is Role.OPERATOR
    assert (folder / "key.json").read_bytes() == before


@pytest.mark.usefixtures("pseudonym")
def test_a_role_and_a_passphrase_are_changed_at_once_and_are_one_line(folder):
    new = "carla has a new one"
    with opened(folder, ANNA) as store:
        n_before = len(lines(store, "change"))
        store.people.change("Carla Roca", role=Role.CLINICIAN, passphrase=new, params=CHEAP)
        store.people.change("Carla Roca")
        line, *others = lines(store, "change")
        assert (line.detail["did"], line.detail["role"]) == ("role and passphrase", "clinician")
        assert len(others) == n_before
    with opened(folder, new) as store:
        assert store.role is Role.CLINICIAN


@pytest.mark.usefixtures("pseudonym")
def test_two_people_never_have_the_same_passphrase(folder):
    with opened(folder, ANNA) as store:
        for change in (
            lambda: store.people.add("Dora", Role.OPERATOR, BORIS, CHEAP),
            lambda: store.people.change("Carla Roca", passphrase=ANNA, params=CHEAP),
            lambda: store.people.change_passphrase(ANNA, CARLA, CHEAP),
        ):
            with pytest.raises(PassphraseError, match="cannot be used"):
                change()
        assert names(store) == list(PEOPLE)


@pytest.mark.usefixtures("pseudonym")
@pytest.mark.parametrize(
    ("name", "words"),
    [("", "one letter"), ("x" * 81, "one letter"), ("a\x07b", "one letter"), ("anna puig", "two")],
)
def test_names_that_would_not_tell_people_apart_are_refused(folder, name, words):
    with opened(folder, ANNA) as store:
        with pytest.raises(StoreError, match=words):
            store.people.add(name, Role.OPERATOR, "quite another one", CHEAP)
        with pytest.raises(PassphraseError, match="8 characters"):
            store.people.add("Dora", Role.OPERATOR, "short", CHEAP)
        with pytest.raises(StoreError, match="Nobody called"):
            store.people.remove("Dora")
        assert names(store) == list(PEOPLE)


@pytest.mark.usefixtures("pseudonym")
@pytest.mark.parametrize("passphrase", [BORIS, CARLA])
def test_only_administrators_say_who_may_open_the_store(folder, passphrase):
    before = (folder / "key.json").read_bytes()
    with opened(folder, passphrase) as store:
        for change in (
            store.people.all,
            lambda: store.people.add("Dora", Role.ADMINISTRATOR, "dora wants it all", CHEAP),
            lambda: store.people.change("Carla Roca", role=Role.ADMINISTRATOR),
            lambda: store.people.remove("Anna Puig"),
            lambda: store.people.change("Anna Puig", passphrase="no longer hers", params=CHEAP),
        ):
            with pytest.raises(NotAllowedError, match="only for administrators"):
                change()
    assert (folder / "key.json").read_bytes() == before


@pytest.mark.usefixtures("pseudonym")
def test_every_change_and_every_refusal_is_a_line(folder):
    with opened(folder, BORIS) as store, pytest.raises(NotAllowedError):
        store.people.remove("Anna Puig")
    with opened(folder, ANNA) as store:
        store.people.change("Carla Roca", role=Role.CLINICIAN)
        (refused,) = lines(store, "refuse")
        assert (refused.operator, refused.subject) == ("Boris Vila", "people")
        assert refused.detail == {"permission": "manage-people", "role": "clinician"}
        changes = [one for one in lines(store, "change") if one.subject == "people"]
        told = [(one.operator, dict(one.detail)) for one in changes]
        for _who, detail in told:
            assert len(detail.pop("state")) == 16
    assert told[0] == (
        "Anna Puig",
        {"did": "role", "person": "Carla Roca", "role": "clinician"},
    )
    assert [detail["person"] for _who, detail in reversed(told[1:])] == list(PEOPLE)


def found_otherwise(folder, passphrase):
    with opened(folder, passphrase):
        pass
    with opened(folder, ANNA) as store:
        changes = [one for one in lines(store, "change") if one.subject == "people"]
        return [one for one in changes if one.detail["did"] == "found otherwise"]


@pytest.mark.parametrize("is_from_before_all_people", [False, True])
def test_an_older_file_that_is_put_back_is_told_once_in_the_log(folder, is_from_before_all_people):
    open_sample(folder).close()
    before = (folder / "key.json").read_bytes()
    with open_sample(folder) as store:
        store.people.add("Anna Puig", Role.ADMINISTRATOR, ANNA, CHEAP)
        store.people.add("Boris Vila", Role.CLINICIAN, BORIS, CHEAP)
        older = before if is_from_before_all_people else (folder / "key.json").read_bytes()
        store.people.remove("Boris Vila")
    newest = (folder / "key.json").read_bytes()
    assert found_otherwise(folder, ANNA) == []
    (folder / "key.json").write_bytes(older)
    passphrase = PASSPHRASE if is_from_before_all_people else BORIS
    for _time in range(2):
        opened(folder, passphrase).close()
    (folder / "key.json").write_bytes(newest)
    # Once when the older one was put back, and once when it was taken away.
    assert len(found_otherwise(folder, ANNA)) == 2


@pytest.mark.usefixtures("pseudonym")
def test_names_and_roles_are_not_read_without_a_passphrase(folder):
    text = (folder / "key.json").read_text()
    for word in ("Anna", "Boris", "administrator", "clinician"):
        assert word not in text
        assert base64.b64encode(word.encode()).decode().rstrip("=") not in text


def edited(folder, change):
    path = folder / "key.json"
    document = json.loads(path.read_text())
    change(document)
    path.write_text(json.dumps(document))


def test_who_edits_the_file_does_not_get_another_role(folder, tmp_path, pseudonym):
    """Two ways: the identity of an administrator, and the people of a store of one's own."""
    assert pseudonym
    good = (folder / "key.json").read_text()

    def take_place_of_first(document):
        slots = document["wrapped"]["slots"]
        slots[2]["person_id"], slots[0]["person_id"] = slots[0]["person_id"], slots[2]["person_id"]

    edited(folder, take_place_of_first)
    with pytest.raises(PassphraseError):
        open_store(folder, CARLA)
    with open_sample(tmp_path / "own") as own:
        own.people.add("Carla", Role.ADMINISTRATOR, CARLA, CHEAP)
    theirs = json.loads((tmp_path / "own" / "key.json").read_text())
    (folder / "key.json").write_text(good)
    edited(folder, lambda one: one["wrapped"].update(people=theirs["wrapped"]["people"]))
    with pytest.raises(StoreError, match="was changed"):
        open_store(folder, CARLA)


@pytest.mark.usefixtures("pseudonym")
@pytest.mark.parametrize(
    "change",
    [
        lambda wrapped: wrapped.update(slots=[]),
        lambda wrapped: wrapped.update(slots="all"),
        lambda wrapped: wrapped.update(slots=wrapped["slots"] * 40),
        lambda wrapped: wrapped["slots"][0].pop("person_id"),
        lambda wrapped: wrapped["slots"][0].update(salt="?"),
        lambda wrapped: wrapped.update(people="?"),
        lambda wrapped: wrapped.pop("people"),
        lambda wrapped: wrapped["slots"].pop(1),
    ],
)
def test_a_damaged_list_of_people_is_one_sentence(folder, change):
    edited(folder, lambda document: change(document["wrapped"]))
    with pytest.raises(StoreError, match=r"key\.json of the patient store is damaged"):
        open_store(folder, ANNA)


@pytest.mark.usefixtures("pseudonym")
def test_a_program_that_knows_no_people_refuses_the_store(folder):
    assert json.loads((folder / "key.json").read_text())["version"] == 2
    edited(folder, lambda document: document.update(version=1))
    with pytest.raises(StoreError, match="later version"):
        open_store(folder, ANNA)
    with pytest.raises(StoreError, match="later version"):
        change_passphrase(folder, ANNA, "another sentence")


@pytest.mark.usefixtures("pseudonym")
def test_a_write_that_fails_leaves_everybody_in_and_no_line(folder, monkeypatch):
    before = (folder / "key.json").read_bytes()
    with opened(folder, ANNA) as store:
        n_lines = len(store.audit.entries())

        def full(*_arguments, **_more):
            raise OSError(28, "No space left on device")

        monkeypatch.setattr(key_file.Path, "write_text", full)
        for change in (
            lambda: store.people.remove("Boris Vila"),
            lambda: store.people.add("Dora", Role.OPERATOR, "dora is new here", CHEAP),
        ):
            with pytest.raises(FileError, match="disk is full"):
                change()
        assert len(store.audit.entries()) == n_lines
    assert (folder / "key.json").read_bytes() == before


@pytest.mark.usefixtures("pseudonym")
def test_who_only_reads_changes_nobody(folder):
    with (
        opened(folder, BORIS),
        opened(folder, ANNA) as reader,
        pytest.raises(StoreError, match="only read"),
    ):
        reader.people.remove("Boris Vila")
    assert load_key(folder, BORIS) == load_key(folder, ANNA)


def test_a_backup_opens_for_its_people_and_gives_them_their_roles(folder, tmp_path, pseudonym):
    backup = tmp_path / "all.adibas-backup"
    with opened(folder, ANNA) as store:
        store.backups.write(backup)
        store.people.remove("Boris Vila")
    assert b"Anna" not in backup.read_bytes()
    with pytest.raises(PassphraseError):
        restore_into(backup, tmp_path / "new", PASSPHRASE)
    restore_into(backup, tmp_path / "new", CARLA)
    for name, (role, passphrase) in PEOPLE.items():  # what held when it was made
        with opened(tmp_path / "new", passphrase) as store:
            assert (store.person.name, store.role) == (name, role)
            assert store.patients.get(pseudonym).identity == IDENTITY
    assert verify_backup(backup, BORIS, room=tmp_path)[1].is_sound
    with pytest.raises(PassphraseError):
        open_key(folder, BORIS)


@pytest.mark.usefixtures("pseudonym")
def test_a_backup_with_a_passphrase_of_its_own_is_a_store_without_people(folder, tmp_path):
    backup = tmp_path / "all.adibas-backup"
    with opened(folder, ANNA) as store:
        store.backups.write(backup, "for the backup only", params=CHEAP)
    restore_into(backup, tmp_path / "new", "for the backup only")
    with opened(tmp_path / "new", "for the backup only") as store:
        assert store.person is None
