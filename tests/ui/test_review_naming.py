"""The other markers are named by a model where that is asked for; one undo takes all names back."""

from unittest.mock import create_autospec

import numpy as np
import pytest

from adibas.data.joints import JOINT_NAMES
from adibas.data.markers import Marker
from adibas.geometry.pinhole import project
from adibas.simulation.body import load_body_model
from adibas.simulation.body_shape import BodyShape
from adibas.simulation.poses import standing
from tests.ui.review_scene import (
    COLOR,
    entered_review,
    new_capture,
    picture_rgb,
    saved_session,
    told,
)
from ui.review.presenter import ReviewView

HAND = "m09"
N_JOINTS = len(JOINT_NAMES)


def joint_markers():
    """Markers at the joints of somebody who stands, and what each of them is."""
    body = load_body_model().shaped(BodyShape("male", 35, 1.78, 75))
    joints_m = body.posed(standing()).joints_m + np.array([0.0, 0.8, 2.4])
    pixels = project(joints_m, COLOR.intrinsics)
    order = np.argsort(pixels[:, 1])
    labels = [f"m{i:02d}" for i in range(1, N_JOINTS + 1)]
    markers = tuple(
        Marker(label, *pixels[i].tolist(), 4.0, np.eye(2), joints_m[i].copy(), np.eye(3) * 1e-6)
        for label, i in zip(labels, order, strict=True)
    )
    return markers, dict(zip(labels, [JOINT_NAMES[i] for i in order], strict=True))


@pytest.fixture
def saved(store):
    patient, session, _captures = saved_session(store, (), protocol="joints-15")
    capture = store.captures.add(
        session.session_id, new_capture("anterior", joint_markers()[0]), picture_rgb()
    )
    return patient, session, (capture,)


@pytest.fixture
def view():
    return create_autospec(ReviewView, instance=True)


@pytest.fixture
def points(view, workspace, saved):
    with entered_review(view, workspace, saved) as presenter:
        yield presenter.points


def shown(view):
    return view.show_points.call_args.args[0]


def test_a_model_names_the_others_and_one_undo_takes_its_names_back(
    points, view, workspace, store, saved
):
    names, sentences = joint_markers()[1], told(workspace)
    points.rename(HAND, names[HAND])
    assert shown(view).can_name_others
    points.name_others()
    capture = store.captures.get(saved[2][0].capture_id)
    assert [one.label for one in capture.markers()] == list(names.values())
    by_hand = [one.label for one in capture.markers() if one.named_by is None]
    assert by_hand == [names[HAND]]
    assert sentences == [
        ("good", "Markers that got a name: 14. Without one: 0. Look them over."),
    ]
    assert not shown(view).can_name_others
    points.undo()
    labels = [one.label for one in shown(view).markers]
    assert labels == [names[HAND] if label == HAND else label for label in names]
    points.redo()
    assert [one.label for one in shown(view).markers] == list(names.values())


def test_where_no_marker_is_sure_the_user_hears_what_to_do(points, view, workspace):
    for label in joint_markers()[1]:
        if label not in ("m01", "m02"):
            points.select(label)
            points.delete()
    sentences = told(workspace)
    points.name_others()
    assert [one.label for one in shown(view).markers] == ["m01", "m02"]
    ((kind, sentence),) = sentences
    assert kind == "warning"
    assert sentence.startswith("No other marker can be named for sure")


def test_names_that_come_when_another_picture_is_open_are_dropped(
    points, store, saved, inline_jobs, monkeypatch
):
    waiting = []
    monkeypatch.setattr(inline_jobs, "start", lambda *job: waiting.append(job))
    points.name_others()
    points.close_capture()
    _label, work, done = waiting[0]
    found = work(None)
    assert len(found) == N_JOINTS
    done(found)
    assert not store.captures.get(saved[2][0].capture_id).history.can_undo


def test_without_a_protocol_nobody_is_asked(view, workspace, store, inline_jobs):
    with entered_review(view, workspace, saved_session(store)) as presenter:
        assert not shown(view).can_name_others
        n_jobs = len(inline_jobs.labels)
        presenter.points.name_others()
        assert len(inline_jobs.labels) == n_jobs


def test_a_protocol_that_no_model_knows_is_told(view, workspace, store, inline_jobs):
    with entered_review(view, workspace, saved_session(store, protocol="sapo-1")) as presenter:
        presenter.points.name_others()
    (problem,) = inline_jobs.problems
    assert "No model knows the landmarks of this protocol" in str(problem)
