"""Nothing of a patient is captured without a standing consent for it, whoever asks the store."""

from datetime import UTC, datetime

import pytest

from adibas.data.patients import Consent, allow_capture
from adibas.data.sessions import SessionSetup
from adibas.errors import ConsentError, StoreError
from adibas.sessions.demo_patient import demo_patient
from tests.unit.recorded_frames import INFO, make_frames
from tests.unit.store_samples import (
    IDENTITY,
    NAME,
    add_capture,
    add_session,
    all_bytes,
    consent,
    minutes_clock,
    new_capture,
    open_sample,
    picture,
)

LATER = datetime(2027, 1, 7, tzinfo=UTC)


@pytest.fixture
def store(tmp_path):
    with open_sample(tmp_path / "store") as opened:
        yield opened


def refused(store):
    return [(one.subject, one.detail) for one in store.audit.entries() if one.action == "refuse"]


def withdraw_all(store, pseudonym):
    for index in range(len(store.patients.get(pseudonym).consents)):
        store.patients.withdraw_consent(pseudonym, index)


@pytest.mark.parametrize("given", [(), ("research",), ("teaching",), ("research", "teaching")])
def test_no_session_starts_without_a_consent_for_treatment(store, given):
    pseudonym = store.patients.add(IDENTITY).pseudonym
    if given:
        store.patients.give_consent(pseudonym, consent(*given))
    with pytest.raises(ConsentError) as told:
        store.sessions.start(pseudonym, SessionSetup())
    assert isinstance(told.value, StoreError)
    sentence = str(told.value)
    assert "no consent for treatment" in sentence
    assert "record it under Patients" in sentence
    assert not set(NAME.split()) & set(sentence.split())
    assert store.sessions.of_patient(pseudonym, with_deleted=True) == ()
    assert refused(store) == [(pseudonym, {"lacks": "consent"})]


@pytest.mark.parametrize("purposes", [("treatment",), ("teaching", "treatment")])
def test_with_a_consent_for_treatment_it_starts(store, purposes):
    pseudonym = store.patients.add(IDENTITY).pseudonym
    store.patients.give_consent(pseudonym, consent(*purposes))
    assert store.sessions.start(pseudonym, SessionSetup()).patient == pseudonym
    assert refused(store) == []


def test_another_patients_consent_is_none_for_this_one(store):
    add_session(store)
    pseudonym = store.patients.add(IDENTITY).pseudonym
    with pytest.raises(ConsentError):
        store.sessions.start(pseudonym, SessionSetup())


def test_a_consent_that_is_withdrawn_in_an_open_session_ends_every_capture_in_it(store):
    session = add_session(store)
    add_capture(store, session)
    with store.recordings.create(session.session_id, INFO) as writer:
        writer.write(make_frames(1)[0])
    withdraw_all(store, session.patient)
    before = set(all_bytes(store.folder))
    with pytest.raises(ConsentError):
        store.recordings.create(session.session_id, INFO)
    with pytest.raises(ConsentError):
        store.captures.add(session.session_id, new_capture(), picture())
    with pytest.raises(ConsentError):
        store.sessions.start(session.patient, SessionSetup())
    assert set(all_bytes(store.folder)) == before, "no file is left of what was refused"
    assert [one for one, _detail in refused(store)] == [
        session.patient,
        session.session_id,
        session.session_id,
    ]
    assert len(store.captures.of_session(session.session_id)) == 1
    assert len(store.recordings.of_session(session.session_id)) == 1
    assert store.verify().is_sound


def test_a_new_consent_lets_the_same_session_go_on(store):
    session = add_session(store)
    withdraw_all(store, session.patient)
    store.patients.give_consent(session.patient, consent(given_utc=LATER))
    assert add_capture(store, session).session_id == session.session_id


def test_what_runs_when_the_consent_ends_is_finished_and_listed(store):
    session = add_session(store)
    with store.recordings.create(session.session_id, INFO) as writer:
        writer.write(make_frames(1)[0])
        withdraw_all(store, session.patient)
    (facts,) = store.recordings.of_session(session.session_id)
    assert facts.n_frames == 1


def test_what_was_measured_stays_readable_correctable_and_in_backups(store, tmp_path):
    session = add_session(store)
    capture = add_capture(store, session)
    withdraw_all(store, session.patient)
    assert store.captures.picture(capture.capture_id).shape == (96, 64, 3)
    store.captures.correct(capture.capture_id, capture.history)
    store.sessions.change(session.session_id, notes="asked to stop")
    backup = tmp_path / "a.adibas-backup"
    store.backups.write(backup)
    with open_sample(tmp_path / "other", clock=minutes_clock(LATER)) as other:
        other.backups.restore(backup, "correct horse battery")
        assert len(other.captures.of_session(session.session_id)) == 1
        with pytest.raises(ConsentError):
            add_capture(other, session)


def test_the_demo_patient_consents_once_as_a_patient_would(store):
    first = demo_patient(store)
    assert [one.purposes for one in first.consents] == [("treatment",)]
    assert demo_patient(store) == first
    store.patients.withdraw_consent(first.pseudonym, 0)
    assert not allow_capture(demo_patient(store).consents)


@pytest.mark.parametrize(
    ("consents", "is_allowed"),
    [
        ((), False),
        ((consent("treatment"),), True),
        ((consent("teaching"),), False),
        ((Consent(("treatment",), "A", False, LATER, LATER),), False),
        ((Consent(("treatment",), "A", False, LATER, LATER), consent("treatment")), True),
        ((Consent(("treatment",), "A", False, LATER, LATER), consent("research")), False),
    ],
)
def test_a_consent_allows_a_capture_while_it_stands_and_is_for_treatment(consents, is_allowed):
    assert allow_capture(consents) is is_allowed
