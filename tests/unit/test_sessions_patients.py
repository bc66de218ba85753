"""Patients and sessions of the store: saved, found, changed, hidden."""

import re
from datetime import UTC, date, datetime

import pytest
from hypothesis import given
from hypothesis import strategies as st

from adibas.data.patients import Consent, Identity
from adibas.data.sessions import SessionSetup
from adibas.errors import StoreError
from adibas.sessions.patients import LETTERS, LIST_OF_PATIENTS
from adibas.sessions.search_text import patterns, searchable, simplified
from tests.unit.store_samples import (
    IDENTITY,
    NAME,
    add_patient,
    add_session,
    open_sample,
    raw_connection,
)

GIVEN = datetime(2026, 11, 20, 8, 30, tzinfo=UTC)
CONSENT = Consent(("treatment", "research"), "Rosa Quetzal", is_guardian=True, given_utc=GIVEN)
NO_SUCH = "P-999999"


@pytest.fixture
def folder(tmp_path):
    return tmp_path / "store"


@pytest.fixture
def store(folder):
    with open_sample(folder) as opened:
        yield opened


def pseudonyms(rows):
    return [row.pseudonym for row in rows]


def test_a_patient_comes_back_as_it_was_saved(folder):
    with open_sample(folder) as store:
        added = store.patients.add(IDENTITY, sex="female", notes="left knee\nñ")
        store.patients.give_consent(added.pseudonym, CONSENT)
    with open_sample(folder) as store:
        patient = store.patients.get(added.pseudonym)
    assert (patient.identity, patient.sex, patient.notes) == (IDENTITY, "female", "left knee\nñ")
    assert patient.created_utc == added.created_utc
    assert patient.consents == (CONSENT,)
    assert not patient.is_deleted


def test_pseudonyms_are_random_and_easy_to_read(store):
    found = {store.patients.add(Identity(f"A {i}")).pseudonym for i in range(50)}
    assert len(found) == 50
    assert all(name[:2] == "P-" and set(name[2:]) <= set(LETTERS) for name in found)
    assert all(len(name) == 8 for name in found)


def test_names_are_told_of_all_patients_the_hidden_ones_too_and_that_is_noted(store):
    assert store.patients.names() == {}
    first, second = (store.patients.add(Identity(name)).pseudonym for name in ("Zoë", "Ana"))
    store.patients.delete(second)
    assert store.audit.entries()[0].action != "view"
    assert store.patients.names() == {first: "Zoë", second: "Ana"}
    entry = store.audit.entries()[0]
    assert (entry.action, entry.subject) == ("view", LIST_OF_PATIENTS)


def test_only_what_is_given_changes(store):
    pseudonym = store.patients.add(IDENTITY, sex="female", notes="a").pseudonym
    changed = store.patients.change(pseudonym, notes="b")
    assert (changed.identity, changed.sex, changed.notes) == (IDENTITY, "female", "b")
    renamed = store.patients.change(pseudonym, identity=Identity("Zoë"), sex="")
    assert (renamed.identity, renamed.sex, renamed.notes) == (Identity("Zoë"), "", "b")
    assert pseudonyms(store.patients.search("zoe")) == [pseudonym]
    assert store.patients.search("quetzal") == ()


@pytest.mark.parametrize(
    "action",
    [
        lambda store: store.patients.get(NO_SUCH),
        lambda store: store.patients.change(NO_SUCH, notes="x"),
        lambda store: store.patients.delete(NO_SUCH),
        lambda store: store.patients.restore(NO_SUCH),
        lambda store: store.patients.purge(NO_SUCH),
        lambda store: store.patients.give_consent(NO_SUCH, CONSENT),
        lambda store: store.sessions.start(NO_SUCH, SessionSetup()),
        lambda store: store.sessions.get(NO_SUCH),
        lambda store: store.sessions.change(NO_SUCH, notes="x"),
        lambda store: store.sessions.delete(NO_SUCH),
        lambda store: store.sessions.purge(NO_SUCH),
    ],
)
def test_what_is_not_there_is_said_by_its_pseudonym(store, action):
    with pytest.raises(StoreError, match=NO_SUCH):
        action(store)


def test_a_consent_is_withdrawn_once(store):
    pseudonym = store.patients.add(IDENTITY).pseudonym
    store.patients.give_consent(pseudonym, CONSENT)
    store.patients.give_consent(pseudonym, CONSENT)
    first = store.patients.withdraw_consent(pseudonym, 1).consents
    again = store.patients.withdraw_consent(pseudonym, 1).consents
    assert first[0].withdrawn_utc is None
    assert first[1].withdrawn_utc is not None
    assert again == first
    with pytest.raises(ValueError, match="consent 2 of 2"):
        store.patients.withdraw_consent(pseudonym, 2)


def test_identity_stands_apart_from_everything_else(folder):
    with open_sample(folder) as store:
        session = add_session(store)
        store.patients.give_consent(session.patient, CONSENT)
    connection = raw_connection(folder)
    found = connection.execute("SELECT name FROM sqlite_master WHERE type = 'table'")
    tables = [name for (name,) in found]
    with_identity = set()
    for table in tables:
        text = repr(connection.execute(f'SELECT * FROM "{table}"').fetchall()).lower()
        if any(part in text for part in ("quetzal", "004711", "2014-03-27", "rosa")):
            with_identity.add(table)
    connection.close()
    assert with_identity == {"identities", "signers"}


def test_people_are_found_by_any_part_in_any_order(store):
    them = store.patients.add(IDENTITY).pseudonym
    store.patients.add(Identity("Bernat Puig", date(1980, 1, 2), "HC-1"))
    texts = [
        "ximena", "XIMENA", "nandu", "ñandú", "quet xim", "004711", "hc-0047", "2014-03",
        "27/03/2014", "27.03.2014", them, them.lower(), them[2:5], "  ximena   2014 ",
    ]  # fmt: skip
    for text in texts:
        assert pseudonyms(store.patients.search(text)) == [them], text
    assert store.patients.search("ximena puig") == ()


@pytest.mark.parametrize("text", ["%", "_", "\\", "'", '"', "50% \\_ "])
def test_signs_of_the_query_language_are_searched_for_as_they_are(store, text):
    store.patients.add(Identity("Bernat Puig"))
    odd = store.patients.add(Identity(f"Odd {text}")).pseudonym
    assert pseudonyms(store.patients.search(text)) == [odd]


@given(
    name=st.text(st.characters(exclude_categories=("Cs", "Cc")), min_size=1, max_size=20).filter(
        lambda name: name.strip()
    ),
    data=st.data(),
)
def test_every_part_of_a_simplified_name_is_in_the_searched_text(name, data):
    text = searchable(Identity(name), "P-222222")
    words = simplified(name).split()
    if words:
        word = data.draw(st.sampled_from(words))
        begin = data.draw(st.integers(0, len(word) - 1))
        (pattern,) = patterns(word[begin:])
        assert re.sub(r"\\(.)", r"\1", pattern[1:-1]) in text
    assert simplified(simplified(name)) == simplified(name)


def test_the_list_is_sorted_by_name_and_limited(store):
    for name in ("Öscar", "anna", "Zoë", "Álvaro"):
        store.patients.add(Identity(name))
    names = [row.identity.name for row in store.patients.search("")]
    assert names == ["Álvaro", "anna", "Öscar", "Zoë"]
    assert len(store.patients.search("", limit=2)) == 2


def test_a_row_tells_the_visits_that_are_not_hidden(store):
    session = add_session(store)
    later = store.sessions.start(session.patient, SessionSetup())
    (row,) = store.patients.search("")
    assert (row.n_sessions, row.last_session_utc) == (2, later.started_utc)
    store.sessions.delete(later.session_id)
    (row,) = store.patients.search("")
    assert (row.n_sessions, row.last_session_utc) == (1, session.started_utc)
    assert row.identity.name == NAME


def test_a_hidden_patient_comes_back(store):
    pseudonym = store.patients.add(IDENTITY).pseudonym
    store.patients.delete(pseudonym)
    assert store.patients.search("") == ()
    assert store.patients.get(pseudonym).is_deleted
    (row,) = store.patients.search("", with_deleted=True)
    assert row.is_deleted
    store.patients.restore(pseudonym)
    assert pseudonyms(store.patients.search("")) == [pseudonym]


def test_a_session_keeps_how_it_was_taken(folder):
    setup = SessionSetup(
        "openni2",
        (640, 480),
        {"format": "adibas-leds", "n": [1, 2.5]},
        90,
        "plumb line",
        {"format": "adibas-wand", "interval_m": [0.499, 0.503]},
    )
    with open_sample(folder, operator="Berta") as store:
        patient = add_patient(store)
        started = store.sessions.start(patient.pseudonym, setup)
        store.sessions.change(started.session_id, notes="tired")
    with open_sample(folder) as store:
        session = store.sessions.get(started.session_id)
        assert (session.setup, session.notes, session.operator) == (setup, "tired", "Berta")
        assert session.started_utc == started.started_utc
        assert store.sessions.change(session.session_id, setup=SessionSetup()).notes == "tired"
        assert store.sessions.get(session.session_id).setup == SessionSetup()


def test_a_new_session_repeats_none_until_that_is_said_of_it(store):
    first = add_session(store)
    second = store.sessions.start(first.patient, SessionSetup(is_repeat=True))
    assert not second.setup.is_repeat
    changed = store.sessions.change(second.session_id, setup=SessionSetup(is_repeat=True))
    assert changed.setup.is_repeat
    assert not store.sessions.start(first.patient, changed.setup).setup.is_repeat


def test_sessions_come_newest_first_and_without_hidden_ones(store):
    first = add_session(store)
    second = store.sessions.start(first.patient, SessionSetup())
    other = add_session(store)

    def ids(sessions):
        return [session.session_id for session in sessions]

    assert ids(store.sessions.of_patient(first.patient)) == [second.session_id, first.session_id]
    assert ids(store.sessions.recent(2)) == [other.session_id, second.session_id]
    store.sessions.delete(second.session_id)
    store.patients.delete(other.patient)
    assert ids(store.sessions.recent()) == [first.session_id]
    assert ids(store.sessions.of_patient(first.patient, with_deleted=True)) == [
        second.session_id,
        first.session_id,
    ]
    store.sessions.restore(second.session_id)
    assert ids(store.sessions.recent()) == [second.session_id, first.session_id]


def test_an_operators_sessions_come_patient_by_patient_and_without_hidden_ones(folder):
    with open_sample(folder, operator="Berta") as store:
        first = add_session(store)
        other, hidden, gone = (add_session(store) for _ in range(3))
        last = store.sessions.start(first.patient, SessionSetup())
        store.sessions.delete(hidden.session_id)
        store.patients.delete(gone.patient)
    with open_sample(folder, operator="Anna") as store:
        hers = store.sessions.start(first.patient, SessionSetup())
        found = store.sessions.of_operator("Berta")
        assert store.sessions.of_operator("Anna") == (hers,)
        assert store.sessions.of_operator("") == ()
    ids = [session.session_id for session in found]
    assert sorted(ids) == sorted((first.session_id, last.session_id, other.session_id))
    assert ids.index(last.session_id) == ids.index(first.session_id) + 1
