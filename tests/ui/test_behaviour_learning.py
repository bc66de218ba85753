"""A gesture is learned in the window from what is coded, and found with it at once."""

from dataclasses import replace
from unittest.mock import create_autospec

import numpy as np
import pytest
from PySide6.QtWidgets import QDialogButtonBox, QPushButton

from adibas.behaviour.editing import with_subject
from adibas.data.coding import Occurrence
from adibas.data.ethogram import Behaviour
from adibas.data.joints import JOINT_NAMES
from adibas.data.skeleton_track import track_of
from adibas.gestures.model_file import read_model
from adibas.pipeline.found_joints import FoundJoints
from adibas.pipeline.own_gestures import models_of, own_gestures
from adibas.texts import LANGUAGES, speaking
from tests.ui.behaviour_scene import FRAME_MS, START_MS, InlineFeed, make_recording
from tests.ui.conftest import NoSensor
from tests.ui.test_behaviour_presenter import LazyKeeper
from tests.ui.test_mnemonics import assert_each_letter_is_one_control
from tests.unit.gesture_examples import recording
from ui.behaviour.body_figure import BodyFigure
from ui.behaviour.learn_dialog import LearnDialog
from ui.behaviour.learning_presenter import LearningView
from ui.behaviour.presenter import BehaviourPresenter, BehaviourView
from ui.workspace import Workspace

Standard = QDialogButtonBox.StandardButton


@pytest.fixture(scope="module")
def moves():
    """Joints of somebody who waves, and when he does."""
    track, events = recording(3, ("wave", "stand", "stand") * 3)
    track = track_of(track.times_s + START_MS / 1000, track.joints_m)
    waves = [(begin, end) for name, begin, end in events if name == "wave"]
    return track, [
        Occurrence("wave", *(START_MS + round(1000 * at) for at in wave), "person 1")
        for wave in waves
    ]


@pytest.fixture(scope="module")
def video(tmp_path_factory, moves):
    track, _waves = moves
    n_frames = int(1000 * (track.times_s[-1] - track.times_s[0])) // FRAME_MS + 2
    return make_recording(tmp_path_factory.mktemp("video") / "child.mcap", n_frames)


@pytest.fixture
def asked(monkeypatch, tmp_path, moves):
    """Let joints be found at once, and models be kept in a folder of this test."""
    asked = []

    def find(request, *_told):
        asked.append(request)
        return FoundJoints((moves[0],))

    monkeypatch.setattr("adibas.pipeline.found_joints.find_joints", find)
    monkeypatch.setattr("platformdirs.user_data_path", lambda *_told, **_more: tmp_path)
    return asked


@pytest.fixture
def presenter(inline_jobs, preferences, tmp_path, video, asked):
    assert asked == []
    path = tmp_path / video.name
    path.write_bytes(video.read_bytes())
    workspace = Workspace(None, inline_jobs, preferences, NoSensor())
    view = create_autospec(BehaviourView, instance=True)
    made = BehaviourPresenter(view, workspace, InlineFeed(), LazyKeeper())
    made.told = []
    workspace.noticed.subscribe(lambda kind, sentence: made.told.append((kind, sentence)))
    made.open_file(path)
    yield made
    made.close()


def code(presenter, occurrences):
    """Code events by hand."""

    def with_all(draft):
        scheme = replace(draft.coding.ethogram, behaviours=(Behaviour("wave"),))
        draft = with_subject(replace(draft, coding=replace(draft.coding, ethogram=scheme)),
                             "person 1")  # fmt: skip
        return replace(draft, coding=replace(draft.coding, occurrences=tuple(occurrences)))

    assert presenter.coding.edit(with_all)


@pytest.fixture
def taught(presenter, moves):
    """A dialog's view, and what decides in it."""
    code(presenter, moves[1])
    view = create_autospec(LearningView, instance=True)
    return view, presenter.learn_from_marks(view)


def test_what_is_coded_is_offered_and_listed(taught):
    view, _learning = taught
    (marked, chosen) = view.show_marked.call_args.args
    assert ([(one.behaviour, one.n_examples) for one in marked], chosen) == ([("wave", 3)], "wave")
    assert len(view.show_examples.call_args.args[0].lines) == 3


def test_a_gesture_is_learned_kept_and_found_at_once(presenter, taught, asked, moves):
    view, learning = taught
    learning.learn("hello")
    sentence, shares = view.show_result.call_args.args
    assert "3 of 3 examples are recognised (100 %)" in sentence
    assert max(shares, key=shares.get) in ("left_hand", "left_elbow")
    assert sum(shares.values()) == pytest.approx(1.0)
    learning.keep("hello there")
    view.finish.assert_called_once_with()
    (kept,) = own_gestures()
    assert read_model(kept.path).labels == ("hello there",)
    assert models_of("own") == (kept.path,)
    found = presenter.coding.draft.proposed
    assert [one.behaviour for one in found].count("hello there") == len(moves[1])
    assert len(asked) == 1, "joints are found once"


def test_one_example_is_told_and_nothing_is_kept(presenter, moves):
    code(presenter, moves[1][:1])
    view = create_autospec(LearningView, instance=True)
    learning = presenter.learn_from_marks(view)
    learning.learn("hello")
    learning.keep("hello")
    learning.close()
    assert view.show_result.call_args.args == ("", {})
    assert own_gestures() == ()
    assert "only one example" in str(presenter._workspace.jobs.problems[-1])


def test_two_examples_are_learned_without_a_figure_of_how_well(presenter, moves):
    code(presenter, moves[1][:2])
    view = create_autospec(LearningView, instance=True)
    presenter.learn_from_marks(view).learn("hello")
    assert view.show_result.call_args.args[0].startswith("Learned. There are too few")


def test_a_gesture_is_forgotten(taught):
    view, learning = taught
    learning.learn("hello")
    learning.keep("hello")
    learning.forget(0)
    assert own_gestures() == ()
    assert view.show_own.call_args.args == ((),)


def test_the_gesture_that_is_shown_is_forgotten_whatever_was_learned_elsewhere(presenter, taught):
    _view, learning = taught
    learning.learn("hello")
    learning.keep("hello")
    view = create_autospec(LearningView, instance=True)
    shown = presenter.learn_from_marks(view)
    learning.keep("again")
    shown.forget(0)
    assert [one.name for one in own_gestures()] == ["again"]
    assert view.show_own.call_args.args == (("again",),)


def test_what_is_learned_of_another_behaviour_is_left(taught, presenter, monkeypatch):
    view, learning = taught
    started = []

    class Jobs:
        def start(self, _label, _work, done, **_more):
            started.append(done)
            self.is_running = True
            return self

        def cancel(self):
            started.clear()

    monkeypatch.setattr(presenter._workspace, "jobs", Jobs())
    learning.learn("hello")
    assert started
    learning.choose("nods")
    assert not started
    assert view.show_result.call_args.args == ("", {})


def test_who_codes_blind_teaches_nothing(presenter):
    presenter.files.begin_blind("XY")
    assert presenter.learn_from_marks(create_autospec(LearningView, instance=True)) is None


@pytest.fixture
def dialog(qtbot, presenter, theme, moves):
    code(presenter, moves[1])
    made = LearnDialog(theme)
    qtbot.addWidget(made)
    made.bind(presenter.learn_from_marks(made))
    made.show()
    return made


def test_the_dialog_learns_and_keeps(dialog, qtbot):
    keep = dialog.findChild(QDialogButtonBox).button(Standard.Ok)
    learn = next(one for one in dialog.findChildren(QPushButton) if one.text() == "&Learn")
    figure = dialog.findChild(BodyFigure)
    assert not keep.isEnabled()
    plain = figure.radius_px("left_hand")
    learn.click()
    assert keep.isEnabled()
    assert figure.radius_px("left_hand") > 2 * plain
    assert figure.radius_px("right_foot") < figure.radius_px("left_hand")
    assert "Left hand" in figure.accessibleDescription()
    assert not figure.grab().isNull()
    keep.click()
    qtbot.waitUntil(lambda: not dialog.isVisible())
    assert [one.name for one in own_gestures()] == ["wave"]


def test_the_persons_left_is_at_the_right(dialog):
    figure = dialog.findChild(BodyFigure)
    left, right = figure.place("left_hand"), figure.place("right_hand")
    assert left.x() > figure.width() / 2 > right.x()
    places = np.array([[figure.place(one).x(), figure.place(one).y()] for one in JOINT_NAMES])
    assert (places >= 0).all()
    assert (places <= [figure.width(), figure.height()]).all()


@pytest.mark.parametrize("language", LANGUAGES)
def test_a_letter_goes_to_one_control_of_the_dialog(dialog, language):
    with speaking(language):
        dialog.retranslate()
        assert_each_letter_is_one_control(dialog)
