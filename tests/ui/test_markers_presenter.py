"""The learner's decisions, without Qt."""

from types import SimpleNamespace
from unittest.mock import create_autospec

import cv2
import numpy as np
import pytest

from adibas.data.frames import SourceInfo
from adibas.data.patients import Identity
from adibas.data.sessions import SessionSetup
from adibas.errors import ServerAwayError
from adibas.markers.color_files import read_colors
from adibas.markers.color_model import ColorModel
from adibas.markers.led import LedParams
from adibas.pipeline.live import LiveFrame, SensorState
from adibas.sensors.ports import SensorOptions
from tests.ui.conftest import InlineJob
from tests.unit.store_samples import add_patient
from ui.markers.ports import LearnerView
from ui.markers.presenter import LearnerPresenter
from ui.ports import CancelledError

SKIN, GREEN = (205, 160, 130), (60, 170, 80)
STICKERS = ((60, 40), (160, 40), (60, 140), (160, 140))


def picture(size=(480, 640)):
    """Green discs of 5 pixels in radius on skin."""
    height, width = size
    rng = np.random.default_rng(1)
    color = np.clip(np.array(SKIN) + rng.normal(size=(height, width, 3)), 0, 255).astype(np.uint8)
    v, u = np.mgrid[:height, :width]
    for place in STICKERS:
        color[np.hypot(u - place[0], v - place[1]) < 5] = GREEN
    return color


@pytest.fixture
def view():
    return create_autospec(LearnerView, instance=True)


@pytest.fixture
def live(workspace):
    """A live sensor that shows the stickers."""
    live = workspace.live
    live.newest = LiveFrame(1, 0, picture(), None)
    live.state = SensorState("live", None, SourceInfo())
    live.view = SimpleNamespace(calibration=None)
    return live


@pytest.fixture
def learner(view, workspace, live):  # noqa: ARG001  (it is there)
    learner = LearnerPresenter(view, workspace)
    learner.enter()
    return learner


def shown(view):
    return view.show_controls.call_args.args[0]


def found(view):
    detections = view.show_found.call_args.args[0]
    return None if detections is None else sorted((b.u, b.v) for b in detections.blobs)


def assert_all_found(view):
    np.testing.assert_allclose(found(view), sorted(STICKERS), atol=0.5)


def test_a_click_freezes_grows_learns_and_finds(learner, view, live):
    learner.click(*STICKERS[0])
    picture_rgb = view.show_picture.call_args.args[0]
    assert picture_rgb is live.newest.color_rgb
    assert view.show_picture.call_args.kwargs == {"is_frozen": True}
    v, u = np.mgrid[:480, :640]
    np.testing.assert_array_equal(view.show_taken.call_args.args[0], np.hypot(u - 60, v - 40) < 5)
    assert shown(view).regions == ((GREEN, int((np.hypot(u - 60, v - 40) < 5).sum())),)
    assert np.abs(np.array(shown(view).swatches) - GREEN).max() <= 2, "the sticker's own colour"
    assert shown(view).has_target
    assert_all_found(view)


def test_the_slider_changes_the_last_region_at_once(learner, view):
    learner.click(*STICKERS[0])
    small = view.show_taken.call_args.args[0].sum()
    learner.set_sensitivity(200)
    assert view.show_taken.call_args.args[0].all(), "everything is near enough"
    assert shown(view).sensitivity == 200
    learner.set_sensitivity(20)
    assert view.show_taken.call_args.args[0].sum() == small


def test_regions_are_added_and_discarded_and_the_colours_follow(learner, view):
    learner.click(*STICKERS[0])
    learner.click(200, 100)
    assert len(shown(view).regions) == 2
    learner.set_clusters(2)
    assert len(shown(view).swatches) == 2
    learner.discard(1)
    assert len(shown(view).regions) == 1
    assert_all_found(view)
    learner.discard(0)
    learner.discard(0)
    assert (shown(view).regions, shown(view).swatches) == ((), ())
    assert found(view) is None
    assert not shown(view).has_target


def test_leds_are_found_by_their_threshold(learner, view, live, workspace):
    dark = np.full((480, 640, 3), 12, np.uint8)
    for place in STICKERS:
        cv2.circle(dark, place, 4, (150, 150, 150), -1)
    live.newest = LiveFrame(2, 0, dark, None)
    learner.set_mode("led")
    learner.freeze()
    assert_all_found(view)
    learner.click(100, 100)
    assert shown(view).regions == (), "LEDs are not clicked"
    learner.set_brightness(140)
    assert shown(view).least_brightness == 140
    assert found(view) == []
    learner.set_brightness(135)
    assert_all_found(view)
    learner.use()
    assert workspace.target == LedParams(least_brightness=135)
    learner.set_mode("color")
    assert found(view) is None


def test_used_markers_are_looked_for_and_kept_with_the_session(learner, workspace, store, told):
    wanted = []
    workspace.screen_wanted.subscribe(wanted.append)
    patient = add_patient(store, Identity("Ana"))
    workspace.choose_patient(patient)
    workspace.choose_session(store.sessions.start(patient.pseudonym, SessionSetup()))
    learner.use()
    assert wanted == [], "nothing was learned yet"
    learner.click(*STICKERS[0])
    learner.use()
    assert workspace.live.target is workspace.target is not None
    kept = store.sessions.get(workspace.session.session_id).setup.markers
    np.testing.assert_allclose(kept["centroids_lab"], workspace.target.centroids_lab)
    assert told[-1] == ("good", "From now on these markers are looked for.")
    assert wanted == ["capture"]


def test_that_saving_could_be_tried_again_is_not_covered_by_good_news(
    learner, workspace, store, told, monkeypatch
):
    offers, change = [], store.sessions.change

    def change_once_it_answers(*ids, **fields):
        if not offers:
            raise ServerAwayError("The server does not answer.")
        return change(*ids, **fields)

    workspace.retry_offered.subscribe(lambda _sentence, again: offers.append(again))
    patient = add_patient(store, Identity("Ana"))
    workspace.choose_patient(patient)
    workspace.choose_session(store.sessions.start(patient.pseudonym, SessionSetup()))
    learner.click(*STICKERS[0])
    monkeypatch.setattr(store.sessions, "change", change_once_it_answers)
    learner.use()
    assert told == []
    (again,) = offers
    again()
    assert workspace.session.setup.markers is not None


def test_markers_chosen_elsewhere_take_the_place_of_clicks(learner, view, workspace):
    learner.click(200, 100)
    workspace.set_target(ColorModel(np.array([[62.4, -46.8, 35.9]]), 14.0))
    assert shown(view).regions == ()
    assert len(shown(view).swatches) == 1
    assert_all_found(view)
    workspace.set_target(LedParams(least_brightness=99.0))
    assert (shown(view).mode, shown(view).least_brightness) == ("led", 99.0)
    workspace.set_target(None)
    assert shown(view).mode == "led"


def test_markers_in_use_are_there_from_the_start(view, workspace, live):  # noqa: ARG001
    workspace.set_target(LedParams(least_brightness=99.0))
    LearnerPresenter(view, workspace)
    assert (shown(view).mode, shown(view).least_brightness) == ("led", 99.0)


def test_what_was_learned_and_not_used_is_given_back(learner, view, workspace, live):  # noqa: ARG001
    assert learner.draft() == ""
    learner.set_mode("led")
    assert learner.draft() == ""
    learner.set_brightness(88.0)
    draft = learner.draft()
    learner.reset()
    learner.take_back(draft)
    assert (shown(view).mode, shown(view).least_brightness) == ("led", 88.0)
    learner.use()
    assert learner.draft() == ""


def test_learned_colours_are_given_back_without_the_picture(learner, view, workspace):
    learner.click(*STICKERS[0])
    swatches, draft = shown(view).swatches, learner.draft()
    assert swatches
    learner.close()
    later = LearnerPresenter(view, workspace)
    later.take_back(draft)
    assert shown(view).swatches == swatches
    assert not shown(view).has_picture
    assert shown(view).has_target


def test_colours_are_saved_and_loaded(learner, view, tmp_path, told):
    path = tmp_path / "green.json"
    learner.save(path)
    assert not path.exists(), "nothing was learned yet"
    learner.click(*STICKERS[0])
    swatches = shown(view).swatches
    learner.save(path)
    assert "green.json" in told[-1][1]
    learner.reset()
    assert (shown(view).swatches, found(view)) == ((), None)
    learner.load(path)
    assert shown(view).swatches == swatches
    assert_all_found(view)
    learner.set_sensitivity(33)
    learner.set_clusters(1)
    assert shown(view).swatches == swatches, "colours of a file stay as they are"
    assert len(read_colors(path).centroids_lab) == len(swatches)


def test_a_file_without_colours_is_told_and_changes_nothing(learner, view, tmp_path, told):
    learner.click(*STICKERS[0])
    (tmp_path / "x.json").write_text("{}")
    learner.load(tmp_path / "x.json")
    learner.save(tmp_path / "none" / "y.json" / "z.json")
    assert told[0][0] == "bad"
    assert_all_found(view)


def test_reset_forgets_all_but_the_picture(learner, view):
    learner.click(*STICKERS[0])
    learner.set_sensitivity(44)
    learner.reset()
    assert view.show_taken.call_args.args == (None,)
    assert (shown(view).regions, shown(view).swatches) == ((), ())
    assert shown(view).sensitivity == 20
    assert shown(view).has_picture
    assert not shown(view).has_target
    learner.click(*STICKERS[1])
    assert_all_found(view)


def test_a_picture_of_another_size_begins_without_what_was_drawn(learner, view, live):
    learner.click(*STICKERS[0])
    view.reset_mock()
    live.newest = LiveFrame(2, 0, picture((400, 600)), None)
    learner.show_sensor()
    assert view.show_taken.call_args.args == (None,)
    assert found(view) is None
    learner.freeze()
    first = [call.args[0] for call in view.show_found.call_args_list]
    assert first[:2] == [None, None], "nothing of the old picture is drawn over the new one"
    assert_all_found(view)
    learner.click(*STICKERS[3])
    assert view.show_taken.call_args.args[0].shape == (400, 600)


def test_a_picture_of_a_file_is_learned_on(learner, view, tmp_path, inline_jobs):
    path = tmp_path / "p.png"
    cv2.imwrite(str(path), cv2.cvtColor(picture(), cv2.COLOR_RGB2BGR))
    learner.open_file(path)
    learner.click(*STICKERS[2])
    assert_all_found(view)
    learner.open_file(tmp_path / "none.png")
    assert len(inline_jobs.problems) == 1
    assert shown(view).has_picture, "the old one stays"


def test_live_pictures_are_shown_until_one_is_frozen(learner, view, workspace, live):
    workspace.live.frame_arrived.emit(live.newest)
    assert view.show_picture.call_args.kwargs == {"is_frozen": False}
    learner.freeze()
    view.show_picture.reset_mock()
    workspace.live.frame_arrived.emit(live.newest)
    learner.enter()
    view.show_picture.assert_not_called()
    learner.show_sensor()
    learner.leave()
    view.show_picture.reset_mock()
    workspace.live.frame_arrived.emit(live.newest)
    view.show_picture.assert_not_called()


def test_without_a_picture_a_click_says_so(learner, view, live, told):
    live.newest = None
    learner.click(3, 3)
    assert told == [("warning", "There is no picture of the sensor yet.")]
    live.newest = LiveFrame(2, 0, None, None)
    learner.freeze()
    assert len(told) == 2
    assert not shown(view).has_picture


def test_the_picture_of_another_patient_goes_and_the_colours_stay(
    view, workspace, live, store, learner
):
    ana, bernat = (add_patient(store, Identity(name)) for name in ("Ana", "Bernat"))
    workspace.choose_patient(ana)
    learner.click(*STICKERS[0])
    learner.leave()
    live.newest = None
    workspace.choose_patient(store.patients.change(ana.pseudonym, notes="left knee"))
    assert shown(view).has_picture, "she is the same"
    swatches = shown(view).swatches
    workspace.choose_patient(bernat)
    view.show_picture.assert_called_with(None, is_frozen=False)
    view.show_taken.assert_called_with(None)
    assert found(view) is None
    assert (shown(view).has_picture, shown(view).regions) == (False, ())
    assert shown(view).swatches == swatches
    live.newest = LiveFrame(2, 0, picture(), None)
    learner.enter()
    view.show_picture.assert_called_with(live.newest.color_rgb, is_frozen=False)


def test_the_live_picture_is_shown_at_once_where_another_patient_is_chosen(
    view, workspace, live, store, learner
):
    learner.freeze()
    workspace.choose_patient(add_patient(store, Identity("Ana")))
    view.show_picture.assert_called_with(live.newest.color_rgb, is_frozen=False)


def test_a_learner_that_is_made_for_a_patient_keeps_her_picture(view, workspace, live, store):  # noqa: ARG001
    ana = add_patient(store, Identity("Ana"))
    workspace.choose_patient(ana)
    learner = LearnerPresenter(view, workspace)
    learner.freeze()
    workspace.choose_patient(ana)
    assert shown(view).has_picture


def test_a_sensor_at_rest_is_opened_as_it_was(learner, workspace, live, store):
    assert live.orders == [], "it is live"
    live.state = SensorState("closed")
    learner.enter()
    assert live.orders == [("simulator", SensorOptions(color_size=(1280, 1024)))]
    patient = add_patient(store, Identity("Ana"))
    live.orders.clear()
    setup = SessionSetup("openni2", (640, 480))
    workspace.choose_session(store.sessions.start(patient.pseudonym, setup))
    learner.enter()
    assert live.orders == [("openni2", SensorOptions(color_size=(640, 480)))]
    live.open("simulator:posterior", SensorOptions())
    learner.enter()
    assert live.orders[-1] == ("simulator:posterior", SensorOptions())


class HeldJobs:
    """Jobs that run when the test says so."""

    def __init__(self):
        self.held = []

    def start(self, label, work, done, failed=None, ended=None):  # noqa: ARG002
        job = HeldJob(work, done, ended or (lambda: None))
        self.held.append(job)
        return job

    def run(self):
        for job in tuple(self.held):
            self.held.remove(job)
            job.run()


class HeldJob(InlineJob):
    def __init__(self, work, done, ended):
        super().__init__(False)
        self.is_running = True
        self._work, self._done, self._ended = work, done, ended

    def run(self):
        try:
            self.progress(0, 0)
            result = self._work(self)
        except CancelledError:
            result = None
        self.is_running = False
        self._ended()
        if not self.is_stopped:
            self._done(result)


@pytest.fixture
def held(workspace, learner):  # noqa: ARG001  (it is made before)
    workspace.jobs = HeldJobs()
    return workspace.jobs


def test_clicks_wait_for_the_picture_to_be_ready(learner, view, held):
    learner.click(*STICKERS[0])
    view.show_taken.assert_called_with(None)
    for _ in range(3):
        held.run()
    assert_all_found(view)


def test_a_picture_whose_preparation_was_stopped_is_prepared_by_the_next_click(learner, view, held):
    learner.freeze()
    for job in held.held:
        job.cancel()
    held.run()
    learner.click(*STICKERS[0])
    for _ in range(3):
        held.run()
    assert_all_found(view)


def test_one_search_runs_at_a_time_and_the_newest_wish_wins(learner, view, held):
    learner.freeze()
    held.run()
    learner.click(*STICKERS[0])
    for sensitivity in range(10, 40):
        learner.set_sensitivity(sensitivity)
    assert len(held.held) == 1
    held.run()
    held.run()
    assert held.held == []
    assert_all_found(view)
    assert shown(view).sensitivity == 39


def test_what_a_search_finds_after_the_picture_went_is_not_shown(learner, view, held):
    learner.freeze()
    held.run()
    learner.click(*STICKERS[0])
    learner.show_sensor()
    held.run()
    assert found(view) is None
    learner.freeze()
    learner.reset()
    for _ in range(3):
        held.run()
    assert shown(view).swatches == ()


def test_of_two_pictures_the_last_one_is_taken(learner, view, held, live):
    learner.freeze()
    live.newest = LiveFrame(2, 0, picture((400, 600)), None)
    learner.show_sensor()
    learner.freeze()
    learner.click(*STICKERS[0])
    for _ in range(4):
        held.run()
    assert view.show_taken.call_args.args[0].shape == (400, 600)


def test_what_was_found_is_used_at_once(learner, workspace, held):
    learner.freeze()
    held.run()
    learner.click(*STICKERS[0])
    held.run()
    learner.use()
    assert workspace.target is not None
    assert held.held == []


def test_what_is_used_is_what_was_clicked_last(learner, workspace, held):
    learner.freeze()
    held.run()
    learner.click(*STICKERS[0])
    search = held.held.pop()
    learner.use()
    assert workspace.target is None, "nothing is learned in the window's thread"
    held.run()
    assert workspace.target is not None, "the search need not be over"
    search.run()


def test_a_closed_learner_listens_no_more(learner, view, workspace, live):
    learner.close()
    view.reset_mock()
    workspace.live.frame_arrived.emit(live.newest)
    workspace.set_target(LedParams())
    assert view.mock_calls == []
