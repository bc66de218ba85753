"""The demo may be shown as often as one likes: the store keeps one session of it."""

import pytest

from adibas.data.corrections import CorrectionHistory, MarkerCorrection
from adibas.markers.led import LedParams
from adibas.pipeline import demo_session
from adibas.pipeline.demo_session import take_demo_session
from adibas.sessions.demo_patient import demo_patient
from tests.unit.store_samples import marker, new_capture, open_sample, picture


@pytest.fixture
def store(tmp_path, monkeypatch):
    """A store whose captures come without a sensor."""

    def take(store, request, _progress, _clock):
        store.captures.add(request.session_id, new_capture(request.view), picture())

    monkeypatch.setattr(demo_session, "_take", take)
    with open_sample(tmp_path / "store") as opened:
        yield opened


def show_demo(store):
    return take_demo_session(store, LedParams(), 1, lambda *_: None)


def kept(store):
    sessions = store.sessions.of_patient(demo_patient(store).pseudonym, with_deleted=True)
    return {session.session_id for session in sessions}


def test_a_demo_takes_the_place_of_the_one_before(store):
    show_demo(store)
    session = show_demo(store)
    assert kept(store) == {session.session_id}
    assert len(session.capture_ids) == 4


@pytest.mark.parametrize("work", ["note", "correction"])
def test_a_demo_that_somebody_has_worked_on_stays(store, work):
    first = show_demo(store)
    if work == "note":
        store.sessions.change(first.session_id, notes="tried with Ana")
    else:
        added = CorrectionHistory().after(MarkerCorrection(None, marker("m09")))
        store.captures.correct(first.capture_ids[2], added)
    second = show_demo(store)
    assert kept(store) == {first.session_id, second.session_id}
