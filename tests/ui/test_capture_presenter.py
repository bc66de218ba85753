"""The capture screen's decisions, without Qt, over a real store."""

from datetime import UTC, datetime
from types import SimpleNamespace
from unittest.mock import create_autospec

import numpy as np
import pytest

from adibas.data.calibration import CameraCalibration, RgbdCalibration
from adibas.data.frames import SourceInfo
from adibas.data.markers import Marker
from adibas.data.patients import Identity
from adibas.data.posture import VIEWS, Provenance
from adibas.data.sessions import SessionSetup
from adibas.errors import ConsentError, SensorError
from adibas.geometry.pinhole import Intrinsics
from adibas.markers.color_model import ColorModel
from adibas.markers.led import LedParams
from adibas.pipeline.live import LiveFrame, SensorState
from adibas.pipeline.live_frames import Naming
from adibas.pipeline.targets import target_to_document
from adibas.sensors.ports import SensorDescription, SensorOptions, VideoMode
from adibas.sessions import NewCapture
from tests.ui.conftest import NoSensor
from tests.unit.store_samples import add_patient, consent
from ui.capture import disk_watch, presenter, sources
from ui.capture.live_overlays import overlays_of
from ui.capture.ports import CaptureView
from ui.capture.presenter import CapturePresenter
from ui.capture.source_presenter import MOST_RECENT
from ui.capture.sources import SIZES, SourceChoice, find_sources, usual_sources
from ui.ports import CancelledError
from ui.widgets.overlays import Line
from ui.workspace import Workspace

LARGE, SMALL = (1280, 1024), (640, 480)
GREEN = ColorModel(np.array([[60.0, -50.0, 40.0]]), 14.0)
XTION = SourceChoice("Xtion (OpenNI2)", "openni2", (SMALL,), is_sensor=True)
LIVE = SensorState("live", None, SourceInfo(frame_rate_hz=30.0))


class LateJobs:
    """Jobs that run when the test says so."""

    def __init__(self):
        self.started = []

    def start(self, label, work, done, failed=None, ended=None):
        job = LateJob(label, work, done, failed, ended)
        self.started.append(job)
        return job


class LateJob:
    def __init__(self, label, work, done, failed, ended):
        self.label, self._work, self._done, self._ended = label, work, done, ended
        assert failed is None, "the window tells what fails"
        self.is_running, self.is_cancelled = True, False

    def cancel(self):
        self.is_cancelled = True

    def progress(self, _done, _total):
        if self.is_cancelled:
            raise CancelledError

    def run(self):
        try:
            result = self._work(self)
        except CancelledError:
            self._end()
            return
        self._end()
        self._done(result)

    def _end(self):
        self.is_running = False
        if self._ended is not None:
            self._ended()


@pytest.fixture
def clock():
    """What is to be called later, with its milliseconds."""
    return []


@pytest.fixture
def view(clock):
    view = create_autospec(CaptureView, instance=True)
    view.call_later.side_effect = lambda ms, call: clock.append((ms, call))
    return view


@pytest.fixture
def ana(store):
    return add_patient(store, Identity("Ana Ruiz"))


@pytest.fixture
def shown(view, workspace):
    return CapturePresenter(view, workspace, look=usual_sources)


@pytest.fixture
def seen(shown, workspace, ana):
    """The presenter on a screen that is seen, with a patient and a live sensor."""
    workspace.choose_patient(ana)
    shown.enter()
    be(workspace, LIVE)
    return shown


@pytest.fixture
def taking(monkeypatch):
    """Captures that come at once, with so many markers; what was requested."""
    requests = []

    def take(store, _live, request, progress):
        progress(0, 2)
        requests.append(request)
        return add_capture(store, request.session_id, request.view, taking_markers[0])

    taking_markers = [2]
    monkeypatch.setattr(presenter, "take_capture", take)
    return SimpleNamespace(requests=requests, n_markers=taking_markers)


def be(workspace, state):
    workspace.live.state = state
    workspace.live.state_changed.emit(state)


def add_capture(store, session_id, view, n_markers=2, notices=()):
    camera = CameraCalibration(64, 48, Intrinsics(500.0, 500.0, 31.5, 23.5))
    markers = tuple(
        Marker(f"m{i:02d}", 4.0 * i, 5.0, 2.0, np.eye(2), np.ones(3), np.eye(3) * 1e-6)
        for i in range(1, n_markers + 1)
    )
    new = NewCapture(
        view,
        "",
        0,
        30,
        RgbdCalibration(color=camera),
        markers,
        (),
        Provenance("", "", "0.1.0", "2026", {}),
        datetime(2026, 5, 4, tzinfo=UTC),
        notices=notices,
    )
    return store.captures.add(session_id, new, np.full((48, 64, 3), 90, np.uint8))


def tick(clock):
    """Let what waits come to pass, but for the looks at the disk."""
    waiting = [call for ms, call in clock if ms != disk_watch.LOOK_MS]
    clock[:] = [one for one in clock if one[0] == disk_watch.LOOK_MS]
    for call in waiting:
        call()


def count_down(clock):
    for _ in range(3):
        tick(clock)


def readiness(view):
    call = view.show_readiness.call_args
    return call.args[0], call.kwargs["is_ready"]


def test_without_a_patient_the_screen_says_what_to_do(shown, view, workspace, told):
    shown.enter()
    be(workspace, LIVE)
    assert readiness(view) == ("Choose a patient first, under Patients.", False)
    shown.capture()
    assert told == [("warning", "Choose a patient first, under Patients.")]
    view.show_countdown.assert_not_called()


@pytest.mark.parametrize("kind", ["closed", "opening", "lost", "ended"])
def test_without_a_picture_a_capture_is_refused_in_words(kind, seen, view, workspace, told):
    be(workspace, SensorState(kind))
    sentence, is_ready = readiness(view)
    assert sentence
    assert not is_ready
    seen.capture()
    assert told == [("warning", sentence)]


def test_a_second_window_cannot_capture(read_only_store, view, inline_jobs, preferences, ana):
    workspace = Workspace(read_only_store, inline_jobs, preferences, NoSensor())
    shown = CapturePresenter(view, workspace, look=usual_sources)
    workspace.choose_patient(read_only_store.patients.get(ana.pseudonym))
    be(workspace, LIVE)
    assert "Another window" in readiness(view)[0]
    shown.enter()
    shown.sources.turn()
    assert workspace.live.rotation_deg == 90, "looking is free"


def test_the_countdown_counts_and_beeps_and_takes_the_view(seen, view, workspace, taking, clock):
    seen.capture()
    assert [call.args for call in view.show_countdown.call_args_list] == [(3,)]
    count_down(clock)
    assert [call.args[0] for call in view.show_countdown.call_args_list] == [3, 2, 1, None]
    assert view.beep.call_count == 4, "three seconds, and the capture"
    (request,) = taking.requests
    assert (request.view, request.n_frames, request.target) == ("anterior", 30, None)
    assert workspace.session.session_id == request.session_id
    assert workspace.capture_id in workspace.session.capture_ids


def test_sound_can_be_turned_off(seen, view, preferences, taking, clock):
    preferences.change(has_sound=False)
    seen.capture()
    count_down(clock)
    assert taking.requests
    view.beep.assert_not_called()


def test_four_captures_take_the_four_views_one_after_the_other(seen, view, taking, clock, told):
    for _ in VIEWS:
        seen.capture()
        count_down(clock)
    assert [request.view for request in taking.requests] == list(VIEWS)
    assert len({request.session_id for request in taking.requests}) == 1
    frames = {request.view: request.n_frames for request in taking.requests}
    assert frames.pop("posterior") == 60, "the shape of the back needs more"
    assert set(frames.values()) == {30}
    name, pictures = view.show_views.call_args.args
    assert (name, set(pictures)) == ("left_lateral", set(VIEWS))
    assert [kind for kind, _ in told] == ["good"] * 4
    assert told[0][1] == "Front: 2 markers found."


def test_the_demo_sensor_turns_with_the_view(seen, workspace, taking, clock):
    assert workspace.live.opened == ("simulator:anterior", SensorOptions(color_size=LARGE))
    seen.capture()
    count_down(clock)
    assert taking.requests
    assert workspace.live.opened[0] == "simulator:posterior"
    seen.choose_view("anterior")
    assert workspace.live.opened[0] == "simulator:anterior"


def test_right_after_a_capture_the_next_one_says_what_it_waits_for(
    seen, workspace, taking, clock, told
):
    seen.capture()
    count_down(clock)
    be(workspace, SensorState("opening"))  # the next view's source, as the live source tells it
    seen.capture()
    assert told[-1] == ("warning", "Wait for the picture of the sensor.")
    be(workspace, LIVE)
    seen.capture()
    count_down(clock)
    assert len(taking.requests) == 2


def test_a_second_press_gives_the_countdown_up(seen, view, taking, clock):
    seen.capture()
    tick(clock)
    seen.capture()
    assert view.show_countdown.call_args.args == (None,)
    count_down(clock)
    assert not taking.requests


def test_a_sensor_that_is_lost_in_the_countdown_ends_it_and_says_why(
    seen, view, workspace, taking, clock, told
):
    seen.capture()
    be(workspace, SensorState("lost", SensorError("The sensor was unplugged.")))
    assert told == [("bad", "The sensor was unplugged.")]
    assert view.show_countdown.call_args.args == (None,)
    count_down(clock)
    assert not taking.requests
    seen.enter()
    be(workspace, LIVE)
    seen.capture()
    be(workspace, SensorState("opening"))
    assert told[-1] == ("bad", "Wait for the picture of the sensor.")


def test_leaving_the_screen_gives_the_countdown_up(seen, taking, clock):
    seen.capture()
    seen.leave()
    count_down(clock)
    assert not taking.requests


NO_CONSENT = "no consent for treatment stands on record"


def offered(view):
    return view.offer_consent.call_args.kwargs["is_lacking"]


def test_without_a_consent_the_page_says_so_and_leads_to_it(shown, view, workspace, store, told):
    workspace.choose_patient(store.patients.add(Identity("Bernat")))
    wanted, asked = [], []
    workspace.screen_wanted.subscribe(wanted.append)
    workspace.consent_wanted.subscribe(asked.append)
    shown.enter()
    be(workspace, LIVE)
    sentence, is_ready = readiness(view)
    assert NO_CONSENT in sentence
    assert (is_ready, offered(view)) == (False, True)
    shown.capture()
    assert told == [("warning", sentence)]
    shown.record_consent()
    assert (wanted, asked) == (["patients"], ["capture"])
    given = store.patients.give_consent(workspace.patient.pseudonym, consent())
    workspace.choose_patient(given)
    assert (readiness(view)[1], offered(view)) == (True, False)


def test_the_store_refuses_in_the_words_of_the_page(seen, view, store, ana):
    store.patients.withdraw_consent(ana.pseudonym, 0)
    with pytest.raises(ConsentError) as refused:
        store.sessions.start(ana.pseudonym, SessionSetup())
    seen.enter()
    assert readiness(view) == (str(refused.value), False)


def withdraw(workspace):
    """Let the consent be withdrawn without this window knowing; return the patient as she is."""
    patients = workspace.store.patients
    return patients.withdraw_consent(workspace.patient.pseudonym, 0)


def test_a_consent_withdrawn_in_the_countdown_ends_it(seen, workspace, taking, clock, told):
    seen.capture()
    workspace.choose_patient(withdraw(workspace))
    count_down(clock)
    assert not taking.requests
    assert NO_CONSENT in told[-1][1]


def test_a_consent_withdrawn_at_another_workstation_is_noticed(seen, view, workspace, clock, told):
    assert not offered(view)
    withdraw(workspace)
    seen.capture()
    count_down(clock)
    assert NO_CONSENT in told[-1][1]
    assert offered(view)
    assert workspace.session is None


def test_what_lacks_at_the_end_of_the_countdown_is_told(seen, workspace, taking, clock, told):
    seen.capture()
    workspace.patient = None  # as if it had been deleted meanwhile
    count_down(clock)
    assert told == [("warning", "Choose a patient first, under Patients.")]
    assert not taking.requests


def test_a_session_that_cannot_be_started_is_told(seen, workspace, taking, clock, told, store):
    seen.capture()
    store.patients.delete(workspace.patient.pseudonym)
    store.patients.purge(workspace.patient.pseudonym)
    count_down(clock)
    assert [kind for kind, _ in told] == ["bad"]
    assert not taking.requests


def test_a_capture_without_markers_says_why(seen, workspace, taking, clock, told, monkeypatch):
    def take(store, _live, request, _progress):
        notices = ("No marker was found in the burst.",)
        return add_capture(store, request.session_id, request.view, 0, notices)

    monkeypatch.setattr(presenter, "take_capture", take)
    seen.capture()
    count_down(clock)
    assert told == [("warning", "Front: 0 markers found. No marker was found in the burst.")]
    assert not taking.requests
    assert workspace.session is not None


class TestWhileABurstIsTaken:
    @pytest.fixture
    def jobs(self, workspace, seen):  # noqa: ARG002  (it is seen before)
        workspace.jobs = LateJobs()
        return workspace.jobs

    @pytest.fixture
    def job(self, jobs, seen, taking, clock):  # noqa: ARG002  (captures come at once)
        seen.capture()
        count_down(clock)
        (job,) = jobs.started
        return job

    def test_the_screen_shows_it_until_it_ends(self, job, view):
        assert view.show_capturing.call_args.kwargs == {"is_capturing": True}
        job.run()
        assert view.show_capturing.call_args.kwargs == {"is_capturing": False}

    def test_a_second_press_stops_it_and_nothing_is_kept(self, job, seen, view, workspace, taking):
        seen.capture()
        assert job.is_cancelled
        job.run()
        assert view.show_capturing.call_args.kwargs == {"is_capturing": False}
        assert not taking.requests
        assert readiness(view)[1], "the next one can be taken"
        assert workspace.session.capture_ids == ()

    def test_the_window_s_cancel_button_frees_the_screen_too(self, job, view):
        job.cancel()
        job.run()
        assert view.show_capturing.call_args.kwargs == {"is_capturing": False}

    def test_view_and_source_stay_and_the_user_is_told(self, job, seen, workspace, told, tmp_path):
        orders = list(workspace.live.orders)
        seen.choose_view("posterior")
        seen.sources.choose_source("openni2")
        seen.sources.choose_size(SMALL)
        seen.sources.open_recording(tmp_path / "a.mcap")
        assert [kind for kind, _ in told] == ["warning"] * 4
        assert "is being captured" in told[0][1]
        assert workspace.live.orders == orders
        assert job.is_running

    def test_leaving_the_screen_lets_it_go_on(self, job, seen, taking, workspace):
        seen.leave()
        n_orders = len(workspace.live.orders)
        job.run()
        assert len(taking.requests) == 1
        assert len(workspace.live.orders) == n_orders, "nobody looks: nothing is opened"
        seen.enter()
        assert workspace.live.opened[0] == "simulator:posterior"

    def test_who_is_looked_at_meanwhile_stays(self, job, workspace, store, told):
        other = add_patient(store, Identity("Bernat"))
        workspace.choose_patient(other)
        job.run()
        assert workspace.patient == other
        assert workspace.session is None
        assert told[-1][1].startswith("Front")

    def test_closing_the_screen_gives_it_up(self, job, seen):
        seen.close()
        assert job.is_cancelled


def test_a_set_up_is_kept_with_the_session_and_opened_once(seen, workspace, store, ana):
    workspace.choose_session(store.sessions.start(ana.pseudonym, SessionSetup()))
    n_orders = len(workspace.live.orders)
    seen.sources.choose_size(SMALL)
    seen.sources.turn()
    setup = store.sessions.get(workspace.session.session_id).setup
    assert (tuple(setup.color_size), setup.rotation_deg) == (SMALL, 90)
    assert workspace.live.rotation_deg == 90
    assert workspace.live.orders[n_orders:] == [
        ("simulator:anterior", SensorOptions(color_size=SMALL))
    ]


def test_a_session_brings_its_own_set_up(seen, view, workspace, store, ana):  # noqa: ARG001
    setup = SessionSetup("openni2", SMALL, target_to_document(GREEN), 270)
    workspace.choose_session(store.sessions.start(ana.pseudonym, setup))
    assert workspace.live.opened == ("openni2", SensorOptions(color_size=SMALL))
    assert workspace.live.rotation_deg == 270
    np.testing.assert_array_equal(workspace.live.target.centroids_lab, GREEN.centroids_lab)
    assert view.show_setup.call_args.args[0].rotation_deg == 270
    plain = store.sessions.start(ana.pseudonym, SessionSetup())
    workspace.choose_session(plain)
    assert workspace.target is not None, "the same stickers all day"


def test_a_session_chosen_elsewhere_is_opened_when_the_screen_is_seen_again(
    seen, workspace, store, ana
):
    seen.leave()
    n_orders = len(workspace.live.orders)
    workspace.choose_session(store.sessions.start(ana.pseudonym, SessionSetup("openni2")))
    assert len(workspace.live.orders) == n_orders
    seen.enter()
    assert workspace.live.opened[0] == "openni2"


def test_damaged_markers_of_a_session_are_told(seen, workspace, store, ana, told):  # noqa: ARG001
    setup = SessionSetup(markers={"format": "?"})
    workspace.choose_session(store.sessions.start(ana.pseudonym, setup))
    assert "Learn their colour again" in told[-1][1]
    assert workspace.target is None


@pytest.fixture(params=["a session", "no session"])
def with_or_without_session(request, seen, workspace, store, ana):
    if request.param == "a session":
        workspace.choose_session(store.sessions.start(ana.pseudonym, SessionSetup()))
    return seen


def test_what_is_looked_for_is_kept_with_the_session(
    with_or_without_session, workspace, store, taking, clock
):
    workspace.set_target(LedParams(least_brightness=77.0))
    with_or_without_session.capture()
    count_down(clock)
    (request,) = taking.requests
    assert request.target is workspace.target
    kept = store.sessions.get(request.session_id).setup.markers
    assert kept["least_brightness"] == 77.0


def test_another_session_begins_with_the_first_view_that_lacks(seen, view, workspace, store, ana):
    seen.choose_view("left_lateral")
    assert view.show_views.call_args.args[0] == "left_lateral"
    session = store.sessions.start(ana.pseudonym, SessionSetup())
    add_capture(store, session.session_id, "anterior")
    workspace.choose_session(store.sessions.get(session.session_id))
    assert view.show_views.call_args.args[0] == "posterior"
    workspace.choose_session(None)
    assert view.show_views.call_args.args[0] == "anterior"


def test_the_view_that_was_chosen_before_the_session_stays(seen, taking, clock):
    seen.choose_view("right_lateral")
    seen.capture()
    count_down(clock)
    assert taking.requests[0].view == "right_lateral"


@pytest.fixture
def bernat_after_ana(seen, workspace, store, ana):
    """Bernat is chosen, without a session, after a session of Ana's with all that it may have."""
    session = store.sessions.start(ana.pseudonym, SessionSetup("openni2", protocol="joints-15"))
    setup = SessionSetup("openni2", protocol="joints-15", is_repeat=True)
    workspace.choose_session(store.sessions.change(session.session_id, setup=setup))
    workspace.choose_patient(add_patient(store, Identity("Bernat")))
    be(workspace, LIVE)
    return seen


def test_a_repeat_of_one_patient_is_none_of_the_next(bernat_after_ana, workspace, taking, clock):
    bernat_after_ana.capture()
    count_down(clock)
    assert len(taking.requests) == 1
    assert workspace.session.patient == workspace.patient.pseudonym
    assert workspace.session.setup.source == "openni2", "the same sensor all day"
    assert not workspace.session.setup.is_repeat


def test_a_session_that_begins_with_a_capture_follows_the_preferred_protocol(
    bernat_after_ana, workspace, taking, clock
):
    assert workspace.live.naming is None
    bernat_after_ana.leave()
    workspace.preferences.change(protocol="sapo-1")
    bernat_after_ana.enter()
    assert workspace.live.naming == Naming("sapo-1", "anterior")
    bernat_after_ana.capture()
    count_down(clock)
    assert len(taking.requests) == 1
    assert workspace.session.setup.protocol == "sapo-1"


def test_small_pictures_are_fetched_once(seen, workspace, store, ana, view, monkeypatch):
    session = store.sessions.start(ana.pseudonym, SessionSetup())
    capture = add_capture(store, session.session_id, "anterior")
    workspace.choose_session(store.sessions.get(session.session_id))
    assert view.show_views.call_args.args[1]["anterior"].shape == (48, 64, 3)
    monkeypatch.setattr(type(store.captures), "thumbnail", None)
    workspace.choose_session(store.sessions.get(session.session_id))
    seen.enter()
    assert "anterior" in view.show_views.call_args.args[1]
    monkeypatch.undo()
    store.captures.delete(capture.capture_id)
    seen.enter()
    assert view.show_views.call_args.args[1] == {}


def test_a_taken_view_is_looked_at_in_the_review(seen, workspace, store, ana):
    wanted = []
    workspace.screen_wanted.subscribe(wanted.append)
    session = store.sessions.start(ana.pseudonym, SessionSetup())
    capture = add_capture(store, session.session_id, "anterior")
    workspace.choose_session(store.sessions.get(session.session_id))
    seen.review("posterior")
    assert wanted == []
    seen.review("anterior")
    seen.learn_markers()
    assert wanted == ["review", "markers"]
    assert workspace.capture_id == capture.capture_id


def test_a_recording_is_replayed_and_offered_until_the_end_but_on_no_disk(
    seen, workspace, preferences, view, tmp_path
):
    path = tmp_path / "walk.mcap"
    seen.sources.open_recording(path)
    assert workspace.live.opened[0] == str(path)
    assert "walk" not in str(preferences.now)
    choices, chosen = view.show_sources.call_args.args
    assert chosen == str(path)
    assert SourceChoice("walk.mcap", str(path), ()) in choices


def test_recent_recordings_are_few_and_the_newest_comes_first(seen, view, tmp_path):
    for number in range(MOST_RECENT + 3):
        seen.sources.open_recording(tmp_path / f"{number}.mcap")
    seen.sources.open_recording(tmp_path / "5.mcap")
    choices, _chosen = view.show_sources.call_args.args
    offered = [choice.title for choice in choices if choice.title.endswith(".mcap")]
    assert len(offered) == len(set(offered)) == MOST_RECENT
    assert offered[0] == "5.mcap"


def test_an_ended_or_closed_source_is_opened_anew(seen, workspace):
    n_orders = len(workspace.live.orders)
    seen.enter()
    assert len(workspace.live.orders) == n_orders, "it is live"
    for kind in ("closed", "ended"):
        be(workspace, SensorState(kind))
        seen.enter()
    assert len(workspace.live.orders) == n_orders + 2


def test_sensors_are_looked_for_at_first_and_then_when_asked(view, workspace, told):
    found, n_looks = [(), (XTION,)], []

    def look(recent):
        n_looks.append(recent)
        return (*found[len(n_looks) > 1], *usual_sources(recent))

    shown = CapturePresenter(view, workspace, look=look)
    shown.enter()
    shown.leave()
    shown.enter()
    assert len(n_looks) == 1
    assert told == [], "at first nobody asked"
    shown.sources.look_for_sources()
    assert view.show_sources.call_args.args[0][0] == XTION
    assert told == []
    found[1] = ()
    shown.sources.look_for_sources()
    assert told[0][1].startswith("No sensor was found")


def test_frames_are_shown_while_the_screen_is_seen(seen, view, workspace):
    frame = LiveFrame(1, 0, None, None)
    workspace.live.frame_arrived.emit(frame)
    view.show_frame.assert_called_once_with(frame)
    seen.leave()
    workspace.live.frame_arrived.emit(frame)
    view.show_frame.assert_called_once()


def test_the_disk_is_looked_at_while_the_screen_is_seen(seen, view, clock, monkeypatch):
    free = iter([4 * 2**30, 2**30 // 2, 2**20, 2**20])
    monkeypatch.setattr(disk_watch, "free_bytes", lambda _folder: next(free))
    told = [call.args[0] for call in view.show_disk.call_args_list]
    assert told[-1] is not None
    seen.enter()
    seen.enter()
    assert readiness(view)[0] == "The disk is full. Free some space on it before you capture."
    waiting = [call for ms, call in clock if ms == disk_watch.LOOK_MS]
    assert len(waiting) == 3
    for call in waiting:
        call()
    assert next(free) == 2**20, "of three visits only the last one still looks"
    seen.leave()
    clock[-1][1]()


def test_a_disk_that_cannot_be_asked_is_no_reason_to_refuse(seen, view, monkeypatch):
    def fail(_folder):
        raise SensorError("no")

    monkeypatch.setattr(disk_watch, "free_bytes", fail)
    seen.enter()
    view.show_disk.assert_called_with(None)
    assert readiness(view)[1]


def test_a_closed_screen_listens_no_more(seen, view, workspace, told):
    seen.close()
    view.reset_mock()
    be(workspace, SensorState("lost"))
    workspace.choose_session(None)
    assert view.mock_calls == []
    assert told == []


def test_libraries_are_asked_for_their_sensors(monkeypatch):
    modes = (
        VideoMode("color", 640, 480, 30.0, "RGB888"),
        VideoMode("color", 640, 480, 30.0, "YUYV"),
        VideoMode("color", 1280, 1024, 30.0, "RGB888"),
        VideoMode("depth", 320, 240, 30.0, "DEPTH_1_MM"),
    )
    sensors = [SensorDescription("Xtion", "ASUS", "1", "u", modes)]
    monkeypatch.setattr(sources.openni2_modes, "list_sensors", lambda: sensors)

    def missing():
        raise SensorError("The library is missing.")

    monkeypatch.setattr(sources.realsense_library, "list_sensors", missing)
    choices = find_sources(("/x/a.mcap",))
    assert [choice.source for choice in choices] == ["openni2", "simulator", "/x/a.mcap"]
    assert choices[0].title == "Xtion (OpenNI2)"
    assert [choice.sizes for choice in choices] == [(LARGE, SMALL), SIZES, ()]
    pair = [*sensors, SensorDescription("Xtion", "ASUS", "", "u2", modes)]
    monkeypatch.setattr(sources.openni2_modes, "list_sensors", lambda: pair)
    assert [(one.title, one.source) for one in find_sources(())[:2]] == [
        ("Xtion 1 (OpenNI2)", "openni2:1"),
        ("Xtion u2 (OpenNI2)", "openni2:u2"),
    ]
    nameless = [SensorDescription("", "", "", "u")]
    monkeypatch.setattr(sources.openni2_modes, "list_sensors", lambda: nameless)
    assert find_sources(())[0] == SourceChoice("OpenNI2 (OpenNI2)", "openni2", SIZES, True)


def test_live_markers_are_named_after_the_protocol_of_the_session(seen, workspace, store, ana):
    workspace.choose_session(
        store.sessions.start(ana.pseudonym, SessionSetup(protocol="joints-15"))
    )
    assert workspace.live.naming == Naming("joints-15", "anterior")
    seen.choose_view("posterior")
    assert workspace.live.naming == Naming("joints-15", "posterior")
    workspace.choose_session(store.sessions.start(ana.pseudonym, SessionSetup()))
    assert workspace.live.naming is None


def test_bones_are_drawn_between_the_joints_that_are_seen():
    places = {"left_elbow": (20.0, 30.0), "left_hand": (25.0, 60.0), "head": (3.0, 4.0)}
    frame = LiveFrame(1, 0, None, None, joints=places)
    assert overlays_of(frame, lambda _name: True) == (Line(25.0, 60.0, 20.0, 30.0, "bone"),)
    assert overlays_of(frame, lambda name: name != "markers") == ()
