"""A slow turn on the capture screen, without Qt, over a real store."""

from types import SimpleNamespace
from unittest.mock import create_autospec

import pytest

from adibas.data.frames import SourceInfo
from adibas.data.patients import Identity
from adibas.data.sessions import SessionSetup
from adibas.errors import SensorError
from adibas.pipeline.capturing import LOST_FRAMES
from adibas.pipeline.live import SensorState
from adibas.pipeline.turn_taking import TakenTurn
from tests.ui.test_capture_presenter import LIVE, LateJobs, be, count_down, readiness
from tests.unit.store_samples import add_patient
from ui.behaviour.sources import plain_title, stored_choices
from ui.capture import turn_presenter
from ui.capture.ports import CaptureView
from ui.capture.presenter import CapturePresenter
from ui.capture.sources import usual_sources
from ui.view_names import TURN


@pytest.fixture
def screen(workspace, store):
    """Show the capture screen to a patient and a live simulator, the turn chosen."""
    clock, view = [], create_autospec(CaptureView, instance=True)
    view.call_later.side_effect = lambda ms, call: clock.append((ms, call))
    presenter = CapturePresenter(view, workspace, look=usual_sources)
    workspace.choose_patient(add_patient(store, Identity("Ana Ruiz")))
    presenter.enter()
    presenter.choose_view(TURN)
    be(workspace, LIVE)
    return SimpleNamespace(clock=clock, view=view, presenter=presenter)


@pytest.fixture
def taking(monkeypatch):
    """Turns that come at once, with these notices; whose they are."""
    sessions, notices = [], []

    def take(store, _live, session_id, progress):
        progress(0, 600)
        sessions.append(session_id)
        with store.recordings.create(session_id, SourceInfo()) as writer:
            pass
        return TakenTurn(session_id, writer.recording_id, 600, tuple(notices))

    monkeypatch.setattr(turn_presenter, "take_turn", take)
    return SimpleNamespace(sessions=sessions, notices=notices)


def press(screen):
    screen.presenter.capture()
    count_down(screen.clock)


def are_capturing(screen):
    return screen.view.show_capturing.call_args.kwargs["is_capturing"]


def shown_views(screen):
    return screen.view.show_views.call_args.args


def test_the_screen_says_how_to_turn(screen, workspace):
    sentence, is_ready = readiness(screen.view)
    assert is_ready
    assert "with the back to the sensor" in sentence
    assert workspace.live.opened[0] == "simulator:turn"


def test_the_demo_sensor_lies_on_its_side_for_the_turn_and_the_picture_stands(screen, workspace):
    setups = [call.args[0].rotation_deg for call in screen.view.show_setup.call_args_list]
    assert (setups[0], setups[-1], workspace.live.rotation_deg) == (0, 90, 90)
    screen.presenter.choose_view("posterior")
    assert workspace.live.rotation_deg == 0
    screen.presenter.choose_view(TURN)
    screen.presenter.sources.choose_source("openni2")
    assert workspace.live.rotation_deg == 0
    assert screen.presenter.sources.setup.rotation_deg == 0


def test_no_landmarks_of_a_view_are_named_in_a_turn(screen, workspace, store):
    setup = SessionSetup(protocol="sapo-1")
    workspace.choose_session(store.sessions.start(workspace.patient.pseudonym, setup))
    screen.presenter.choose_view("anterior")
    assert workspace.live.naming is not None
    screen.presenter.choose_view(TURN)
    assert workspace.live.naming is None


def test_the_simulated_patient_begins_to_turn_with_the_recording(
    screen, workspace, taking, store, told
):
    n_orders = len(workspace.live.orders)
    press(screen)
    assert [source for source, _ in workspace.live.orders[n_orders:]] == ["simulator:turn"]
    assert taking.sessions == []
    assert are_capturing(screen)
    be(workspace, SensorState("opening"))
    assert taking.sessions == []
    be(workspace, LIVE)
    session = workspace.session
    assert taking.sessions == [session.session_id]
    assert store.recordings.facts(session.setup.turn).session_id == session.session_id
    assert told == [("good", "The turn is recorded. Under Compare, it becomes the whole body.")]
    assert not are_capturing(screen)
    assert shown_views(screen) == ("anterior", {TURN: None})


def test_a_sensor_goes_on_and_is_not_opened_anew(screen, workspace, taking):
    screen.presenter.sources.choose_source("openni2")
    n_orders = len(workspace.live.orders)
    press(screen)
    assert len(taking.sessions) == 1
    assert workspace.live.orders[n_orders:] == []


def test_what_is_amiss_with_a_turn_is_told(screen, workspace, taking, told):
    taking.notices.append(LOST_FRAMES)
    press(screen)
    be(workspace, LIVE)
    ((kind, sentence),) = told
    assert kind == "warning"
    assert sentence.endswith("becomes the whole body. The sensor lost frames inside the burst.")


def test_a_second_press_gives_the_turn_up_before_it_begins(screen, workspace, taking):
    press(screen)
    screen.presenter.capture()
    assert not are_capturing(screen)
    be(workspace, LIVE)
    assert taking.sessions == []


def test_leaving_the_screen_gives_a_turn_up_that_has_not_begun(screen, workspace, taking):
    press(screen)
    be(workspace, SensorState("opening"))
    screen.presenter.leave()
    assert not are_capturing(screen)
    be(workspace, LIVE)  # another screen shows the sensor
    assert taking.sessions == []
    be(workspace, SensorState("closed"))
    n_orders = len(workspace.live.orders)
    screen.presenter.enter()
    assert len(workspace.live.orders) == n_orders + 1, "it is free to open the source again"


def test_leaving_the_screen_lets_a_turn_that_is_recorded_go_on(screen, workspace, taking):
    workspace.jobs = LateJobs()
    press(screen)
    be(workspace, LIVE)
    screen.presenter.leave()
    workspace.jobs.started[0].run()
    assert taking.sessions == [workspace.session.session_id]


def test_another_patient_gives_a_turn_up_that_has_not_begun(screen, workspace, taking, store):
    press(screen)
    be(workspace, SensorState("opening"))
    workspace.choose_patient(add_patient(store, Identity("Bernat")))
    assert not are_capturing(screen)
    be(workspace, LIVE)
    assert taking.sessions == []


def test_a_source_that_is_closed_before_the_turn_begins_gives_it_up(screen, workspace, taking):
    press(screen)
    be(workspace, SensorState("closed"))  # the source before, which makes place
    assert are_capturing(screen)
    be(workspace, SensorState("opening"))
    be(workspace, SensorState("closed"))
    assert not are_capturing(screen)
    be(workspace, LIVE)
    assert taking.sessions == []


def test_a_second_press_gives_the_turn_up_while_it_is_recorded(screen, workspace, taking):
    workspace.jobs = LateJobs()
    press(screen)
    be(workspace, LIVE)
    (job,) = workspace.jobs.started
    assert are_capturing(screen)
    screen.presenter.capture()
    job.run()
    assert not are_capturing(screen)
    assert taking.sessions == []
    assert workspace.session.setup.turn == ""


def test_a_source_that_does_not_begin_anew_is_told(screen, workspace, taking, told):
    press(screen)
    be(workspace, SensorState("lost", SensorError("The recording is gone.")))
    assert told == [("bad", "The recording is gone.")]
    assert not are_capturing(screen)
    assert taking.sessions == []


def test_a_turn_belongs_to_the_session_it_was_taken_in(screen, workspace, taking, store):
    workspace.jobs = LateJobs()
    press(screen)
    be(workspace, LIVE)
    taken_in = workspace.session
    other = store.sessions.start(workspace.patient.pseudonym, SessionSetup())
    workspace.choose_session(other)
    workspace.jobs.started[0].run()
    assert taking.sessions == [taken_in.session_id]
    assert workspace.session.session_id == other.session_id
    assert workspace.session.setup.turn == ""
    assert store.sessions.get(taken_in.session_id).setup.turn


def test_a_turn_is_looked_at_under_compare(screen, workspace):
    shown = []
    workspace.screen_wanted.subscribe(shown.append)
    screen.presenter.review(TURN)
    assert shown == ["comparison"]


def test_the_recording_of_a_turn_is_called_so_where_behaviour_is_watched(screen, workspace, taking):
    press(screen)
    be(workspace, LIVE)
    assert len(taking.sessions) == 1
    (choice,) = stored_choices(workspace)
    assert plain_title(choice).endswith(", Slow turn")
