"""What screens share: who is looked at, and how it is found again after a lock."""

from adibas.data.patients import Identity
from adibas.data.sessions import SessionSetup
from adibas.errors import SensorError
from adibas.markers.led import LedParams
from tests.ui.conftest import NoSensor
from tests.unit.store_samples import add_patient
from ui.events import Event
from ui.workspace import Place, Workspace


def test_who_listens_no_more_is_told_no_more():
    event, told = Event(), []
    end = event.subscribe(told.append)
    event.emit(1)
    end()
    end()
    event.emit(2)
    assert told == [1]


def test_another_patient_leaves_the_session_and_its_capture(workspace, store):
    ana, eva = (add_patient(store, Identity(name)) for name in ("Ana", "Eva"))
    session = store.sessions.start(ana.pseudonym, SessionSetup())
    workspace.choose_patient(ana)
    workspace.choose_session(session)
    workspace.choose_capture("c")
    workspace.choose_session(session)
    assert workspace.capture_id == "c"
    workspace.choose_patient(ana)
    assert workspace.session == session
    workspace.choose_patient(eva)
    assert (workspace.session, workspace.capture_id) == (None, None)


def test_what_was_told_of_a_capture_goes_with_its_patient_or_session(workspace, store):
    withdrawn = []
    workspace.notice_withdrawn.subscribe(withdrawn.append)
    ana, eva = (add_patient(store, Identity(name)) for name in ("Ana", "Eva"))
    first, second = (store.sessions.start(ana.pseudonym, SessionSetup()) for _number in range(2))
    workspace.choose_patient(ana)
    workspace.choose_session(first)
    workspace.tell_here("warning", "Front: 0 markers found.")
    workspace.choose_patient(ana)
    workspace.choose_session(first)
    assert withdrawn == []
    workspace.choose_session(second)
    assert withdrawn == ["Front: 0 markers found."]
    workspace.tell_here("warning", "Back: 0 markers found.")
    workspace.choose_patient(eva)
    workspace.choose_patient(ana)
    assert withdrawn[1:] == ["Back: 0 markers found."]


def test_the_same_place_is_found_again_and_names_nobody(workspace, store, inline_jobs, preferences):
    ana = add_patient(store, Identity("Ana Ruiz"))
    session = store.sessions.start(ana.pseudonym, SessionSetup())
    workspace.choose_patient(ana)
    workspace.choose_session(session)
    workspace.choose_capture("c")
    workspace.set_target(LedParams())
    place = workspace.place
    assert "Ruiz" not in repr(place)
    later = Workspace(store, inline_jobs, preferences, NoSensor())
    later.return_to(place)
    assert (later.patient, later.session, later.capture_id) == (ana, session, "c")
    assert later.target == LedParams()
    assert later.live.target == LedParams()


def test_without_anybody_there_is_nothing_to_find_again(workspace):
    workspace.return_to(workspace.place)
    assert workspace.patient is None
    assert workspace.place == Place(None, None, None, None)


def test_a_patient_who_is_gone_meanwhile_is_told(workspace):
    told = []
    workspace.noticed.subscribe(lambda *notice: told.append(notice))
    workspace.return_to(Place("P-GONE", None, None, None))
    ((kind, sentence),) = told
    assert kind == "bad"
    assert sentence


def test_a_failure_is_told_and_does_not_pass(workspace):
    told, wanted = [], []
    workspace.noticed.subscribe(lambda *notice: told.append(notice))
    workspace.screen_wanted.subscribe(wanted.append)

    def fail():
        raise SensorError("No {thing}.", thing="sensor")

    assert not workspace.attempt(fail)
    assert workspace.attempt(lambda: None)
    workspace.show_screen("review")
    assert told == [("bad", "No sensor.")]
    assert wanted == ["review"]
