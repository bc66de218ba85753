"""The review without Qt: what is shown, what is saved, and what is left alone."""

import math
from dataclasses import replace
from unittest.mock import create_autospec

import numpy as np
import pytest

from adibas.data.corrections import FreeMeasure
from adibas.data.patients import Identity
from adibas.data.sessions import SessionSetup
from adibas.errors import StoreError
from adibas.markers.snapping import HAND_RADIUS_PX
from tests.ui.review_scene import (
    CALIBRATION,
    DOTS,
    HEIGHT,
    REFUSED,
    UNNOTICED,
    WIDTH,
    entered_review,
    mm_between,
    new_capture,
    picture_rgb,
    places,
    plain_marker,
    saved_session,
    told,
)
from tests.unit.store_samples import add_patient
from ui.review.content import Mode
from ui.review.presenter import ReviewPresenter, ReviewView
from ui.workspace import Workspace


class Seen:
    """What the view was told last."""

    def __init__(self, view):
        self._view = view

    def last(self, name):
        return getattr(self._view, name).call_args

    @property
    def points(self):
        return self.last("show_points").args[0]

    @property
    def measures(self):
        return self.last("show_measures").args[0]

    @property
    def strip(self):
        return self.last("show_captures").args

    @property
    def labels(self):
        return [one.label for one in self.points.markers]

    def place(self, label):
        found = next(one for one in self.points.markers if one.label == label)
        return found.u, found.v

    def value(self, *labels):
        return next(row.value for row in self.measures if row.labels == labels)


@pytest.fixture
def view():
    return create_autospec(ReviewView, instance=True)


@pytest.fixture
def seen(view):
    return Seen(view)


@pytest.fixture
def saved(store):
    return saved_session(store, ("anterior", "posterior"))


@pytest.fixture
def review(view, workspace, saved):
    """The review of a session of two captures, the first one open."""
    with entered_review(view, workspace, saved) as presenter:
        yield presenter


@pytest.fixture
def points(review):
    return review.points


def now(store, capture):
    return store.captures.get(capture.capture_id)


def test_without_a_session_the_user_is_sent_to_the_patients(view, workspace, seen):
    presenter = ReviewPresenter(view, workspace)
    presenter.entered()
    assert seen.last("show_nothing").args[1] == "patients"
    wanted = []
    workspace.screen_wanted.subscribe(wanted.append)
    presenter.go_to("patients")
    assert wanted == ["patients"]
    presenter.open_space()
    presenter.points.undo()
    presenter.points.escape()
    presenter.left()
    view.show_space.assert_not_called()


def test_a_session_without_pictures_sends_to_the_capture(view, workspace, seen, store, saved):
    session = store.sessions.start(saved[0].pseudonym, SessionSetup())
    workspace.choose_session(session)
    ReviewPresenter(view, workspace).entered()
    assert seen.last("show_nothing").args[1] == "capture"


@pytest.mark.usefixtures("review")
def test_the_first_capture_is_shown_with_its_picture_markers_and_measures(seen, saved):
    items, chosen, rotation_deg = seen.strip
    assert [item.view for item in items] == ["anterior", "posterior"]
    assert [item.n_markers for item in items] == [3, 3]
    assert items[0].thumbnail_rgb.shape[1] == 160
    assert chosen == saved[2][0].capture_id
    assert rotation_deg == 0
    np.testing.assert_array_equal(seen.last("show_picture").args[0], picture_rgb())
    assert seen.labels == list(DOTS)
    assert seen.points.can_edit
    assert not seen.points.can_undo
    assert len(seen.measures) == 3 + 3
    expected_mm = mm_between(DOTS["m01"], DOTS["m02"])
    assert seen.value("m01", "m02") == pytest.approx(expected_mm, rel=1e-4)
    assert seen.last("show_notices").args[0] == ("Markers were corrected by hand.",)


def test_nothing_is_read_before_the_screen_is_seen(view, workspace, saved, inline_jobs):
    workspace.choose_session(saved[1])
    ReviewPresenter(view, workspace)
    assert inline_jobs.labels == []
    workspace.choose_capture(saved[2][1].capture_id)
    assert inline_jobs.labels == []


def test_another_capture_can_be_chosen_here_and_elsewhere(review, seen, workspace, saved):
    first, second = (one.capture_id for one in saved[2])
    review.choose_capture(first)
    assert workspace.capture_id is None  # it is open already
    review.choose_capture(second)
    assert workspace.capture_id == second
    assert seen.strip[1] == second
    workspace.choose_capture(first)
    assert seen.strip[1] == first
    workspace.choose_capture("of another session")
    assert seen.strip[1] == first


def test_a_capture_that_was_chosen_elsewhere_is_the_one_that_opens(view, workspace, seen, saved):
    workspace.choose_session(saved[1])
    workspace.choose_capture(saved[2][1].capture_id)
    ReviewPresenter(view, workspace).entered()
    assert seen.strip[1] == saved[2][1].capture_id


def test_a_new_capture_joins_the_strip_and_the_open_one_stays(review, seen, store, saved, view):
    view.show_picture.reset_mock()
    store.captures.add(saved[1].session_id, new_capture("right_lateral"), picture_rgb())
    review.left()
    review.entered()
    assert len(seen.strip[0]) == 3
    assert seen.strip[1] == saved[2][0].capture_id
    view.show_picture.assert_not_called()


def test_a_marker_is_dragged_and_only_its_drop_is_saved(points, seen, store, saved):
    points.keep_measure(("m01", "m02"))
    before = now(store, saved[2][0])
    points.drag("m01", 90.0, 60.0)
    assert seen.place("m01") == (90.0, 60.0)
    expected_mm = mm_between((90.0, 60.0), DOTS["m02"])
    assert seen.points.measures[0].value == pytest.approx(expected_mm, rel=1e-4)
    assert seen.value("m01", "m02") == pytest.approx(expected_mm, rel=1e-4)
    assert places(now(store, saved[2][0])) == places(before)
    points.drop("m01", 150.0, 100.0, is_free=False)
    assert places(now(store, saved[2][0]))["m01"] == (150.0, 100.0)
    assert seen.points.by_hand == {"m01"}
    assert seen.points.selected == "m01"
    assert seen.strip[0][0].is_corrected


def test_a_marker_that_is_dropped_near_a_blob_snaps_to_it(points, seen):
    points.drag("m01", UNNOTICED[0] + 5, UNNOTICED[1] - 4)
    points.drop("m01", UNNOTICED[0] + 5, UNNOTICED[1] - 4, is_free=False)
    assert seen.place("m01") == pytest.approx(UNNOTICED, abs=0.3)


def test_a_marker_that_is_dropped_freely_stays_where_it_is(points, seen):
    points.drag("m01", UNNOTICED[0] + 5, UNNOTICED[1] - 4)
    points.drop("m01", UNNOTICED[0] + 5, UNNOTICED[1] - 4, is_free=True)
    assert seen.place("m01") == (UNNOTICED[0] + 5, UNNOTICED[1] - 4)
    assert seen.points.markers[0].radius_px == 4.0


def test_a_drop_without_a_drag_is_no_edit(points, seen):
    points.drop("m01", 10.0, 10.0, is_free=True)
    points.drag("nobody", 10.0, 10.0)
    assert seen.place("m01") == DOTS["m01"]


def test_leaving_the_screen_lets_a_drag_go(review, points, seen, store, saved):
    points.drag("m01", 90.0, 60.0)
    review.left()
    assert seen.place("m01") == DOTS["m01"]
    assert places(now(store, saved[2][0]))["m01"] == DOTS["m01"]


def test_escape_steps_back_from_drag_pick_mode_and_choice(points, seen):
    points.drag("m01", 90.0, 60.0)
    points.escape()
    assert seen.place("m01") == DOTS["m01"]
    points.choose_mode(Mode.ANGLE)
    points.press("m02")
    points.escape()
    assert seen.points.picked == ()
    assert seen.points.mode is Mode.ANGLE
    points.escape()
    assert seen.points.mode is Mode.CHOOSE
    assert seen.points.selected == "m01"
    points.escape()
    assert seen.points.selected is None


def test_a_marker_is_added_where_one_was_overlooked(points, seen, store, saved):
    points.click(*UNNOTICED, is_free=False)
    assert seen.labels == list(DOTS)
    points.choose_mode(Mode.ADD)
    points.click(UNNOTICED[0] + 4, UNNOTICED[1], is_free=False)
    assert seen.place("m04") == pytest.approx(UNNOTICED, abs=0.3)
    assert seen.points.selected == "m04"
    assert now(store, saved[2][0]).markers()[3].position_m[2] == pytest.approx(1.0, rel=1e-3)
    points.click(20.0, 20.0, is_free=True)
    assert seen.place("m05") == (20.0, 20.0)
    assert seen.points.markers[4].radius_px == HAND_RADIUS_PX


def test_an_empty_place_of_the_picture_chooses_nothing(points, seen):
    points.press("m02")
    assert seen.points.selected == "m02"
    points.click(5.0, 5.0, is_free=False)
    assert seen.points.selected is None


def test_the_chosen_marker_is_deleted_and_comes_back(points, seen, store, saved):
    points.delete()
    assert seen.labels == list(DOTS)
    points.select("m02")
    points.delete()
    assert seen.labels == ["m01", "m03"]
    assert seen.points.selected is None
    points.undo()
    assert seen.labels == list(DOTS)
    points.redo()
    points.redo()
    assert [one.label for one in now(store, saved[2][0]).markers()] == ["m01", "m03"]


def test_nudges_are_one_edit_when_the_key_is_let_go(points, seen, store, saved):
    points.nudge(1.0, 0.0)
    points.select("m02")
    for _repeat in range(3):
        points.nudge(1.0, 0.1)
    assert places(now(store, saved[2][0]))["m02"] == DOTS["m02"]
    points.end_nudge()
    points.end_nudge()
    assert places(now(store, saved[2][0]))["m02"] == (243.0, 60.3)
    points.undo()
    assert seen.place("m02") == DOTS["m02"]


def test_a_marker_is_not_nudged_out_of_the_picture(points, seen):
    points.select("m02")
    points.nudge(1000.0, -1000.0)
    points.end_nudge()
    assert seen.place("m02") == (WIDTH - 1, 0.0)
    points.nudge(-1000.0, 1000.0)
    points.end_nudge()
    assert seen.place("m02") == (0.0, HEIGHT - 1)


def test_names_are_changed_or_the_reason_why_not_is_told(points, seen, workspace):
    sentences = told(workspace)
    points.rename("m01", "C7")
    assert seen.labels == ["C7", "m02", "m03"]
    assert seen.points.selected == "C7"
    points.rename("m02", "C7")
    assert seen.labels == ["C7", "m02", "m03"]
    assert "C7" in sentences[0][1]


def test_measures_are_clicked_together(points, seen):
    points.choose_mode(Mode.DISTANCE)
    points.press("m01")
    assert seen.points.picked == ("m01",)
    points.press("m01")
    assert seen.points.picked == ()
    points.click(5.0, 5.0, is_free=False)
    points.press("m01")
    points.press("m03")
    points.choose_mode(Mode.ANGLE)
    for label in ("m01", "m02", "m03"):
        points.press(label)
    rows = seen.points.measures
    assert [row.labels for row in rows] == [("m01", "m03"), ("m01", "m02", "m03")]
    arms = np.subtract(DOTS["m01"], DOTS["m02"]), np.subtract(DOTS["m03"], DOTS["m02"])
    cosine = np.dot(*arms) / np.prod([np.linalg.norm(arm) for arm in arms])
    assert rows[1].value == pytest.approx(np.degrees(np.arccos(cosine)), abs=0.01)
    assert rows[1].interval[0] < rows[1].value < rows[1].interval[1]
    points.remove_measure(("m01", "m03"))
    assert len(seen.points.measures) == 1
    points.undo()
    assert len(seen.points.measures) == 2


def test_a_measure_whose_marker_has_no_depth_has_no_value(view, workspace, seen, store):
    patient, session, _captures = saved_session(store, surface=None)
    store.captures.add(
        session.session_id,
        new_capture("posterior", (plain_marker("a"), plain_marker("b", 50.0))),
        picture_rgb(),
    )
    workspace.choose_patient(patient)
    workspace.choose_session(session)
    presenter = ReviewPresenter(view, workspace)
    presenter.entered()
    presenter.choose_capture(seen.strip[0][1].capture_id)
    presenter.points.keep_measure(("a", "b"))
    assert seen.points.measures[0].value is None
    presenter.points.choose_mode(Mode.ADD)
    presenter.points.click(30.0, 30.0, is_free=True)
    assert seen.points.markers[2].position_m is None
    presenter.open_space()
    view.show_space.assert_called_once_with(None)


def test_what_was_refused_is_shown_on_demand_and_becomes_a_marker(points, seen):
    assert seen.points.rejected == ()
    assert seen.points.n_rejected == 1
    points.show_rejected(is_shown=True)
    assert seen.points.rejected == (REFUSED,)
    points.adopt(REFUSED)
    assert seen.place("m04") == (REFUSED.u, REFUSED.v)
    assert seen.points.rejected == ()
    points.undo()
    assert seen.points.rejected == (REFUSED,)


def test_corrections_are_told_to_the_other_screens_when_this_one_is_left(review, points, workspace):
    changes = []
    workspace.session_changed.subscribe(lambda: changes.append(1))
    review.left()
    assert changes == []
    review.entered()
    points.select("m01")
    points.delete()
    review.left()
    assert changes == [1]


def test_what_cannot_be_saved_is_told_and_taken_back(points, seen, workspace, store, monkeypatch):
    sentences = told(workspace)

    def full(_capture_id, _history, **_seen):
        raise StoreError("The disk is full. Free some space.")

    monkeypatch.setattr(store.captures, "correct", full)
    points.drag("m01", 90.0, 60.0)
    points.drop("m01", 90.0, 60.0, is_free=True)
    points.choose_mode(Mode.ADD)
    points.click(20.0, 20.0, is_free=True)
    assert sentences == [("bad", "The disk is full. Free some space.")] * 2
    assert seen.labels == list(DOTS)
    assert seen.place("m01") == DOTS["m01"]
    assert seen.points.selected is None


def test_a_second_window_looks_and_changes_nothing(
    view, seen, read_only_store, inline_jobs, preferences, saved
):
    workspace = Workspace(read_only_store, inline_jobs, preferences, live=None)
    workspace.choose_session(saved[1])
    presenter = ReviewPresenter(view, workspace)
    presenter.entered()
    points = presenter.points
    assert not seen.points.can_edit
    points.press("m01")
    for edit in (points.delete, points.undo, lambda: points.nudge(1.0, 0.0), points.end_nudge):
        edit()
    points.drag("m01", 5.0, 5.0)
    points.drop("m01", 5.0, 5.0, is_free=True)
    points.add(5.0, 5.0, is_free=True)
    points.rename("m01", "x")
    assert seen.labels == list(DOTS)
    assert seen.points.selected == "m01"
    assert len(seen.measures) == 6
    assert seen.last("show_notes").kwargs == {"can_edit": False}


def test_nothing_can_be_edited_until_the_depth_is_there(
    view, seen, workspace, inline_jobs, saved, monkeypatch
):
    workspace.choose_session(saved[1])
    waiting = []
    start = inline_jobs.start

    def hold_depth(label, work, done, failed=None):
        if label == "Opening the depth":
            waiting.append(lambda: start(label, work, done, failed))
            return None
        return start(label, work, done, failed)

    monkeypatch.setattr(inline_jobs, "start", hold_depth)
    presenter = ReviewPresenter(view, workspace)
    presenter.entered()
    assert seen.labels == list(DOTS)
    assert not seen.points.can_edit
    presenter.open_space()
    presenter.points.nudge(1.0, 0.0)
    presenter.choose_capture(saved[2][1].capture_id)
    waiting[0]()  # of the capture that was left meanwhile
    assert not seen.points.can_edit
    waiting[1]()
    assert seen.points.can_edit


def test_a_picture_that_fails_after_the_session_was_left_is_told_only(
    view, workspace, seen, inline_jobs, saved, monkeypatch
):
    sentences = told(workspace)
    waiting = []
    monkeypatch.setattr(inline_jobs, "start", lambda *job: waiting.append(job))
    workspace.choose_session(saved[1])
    ReviewPresenter(view, workspace).entered()
    workspace.choose_session(None)
    failed = next(job[3] for job in waiting if job[0] == "Opening the picture")
    failed(StoreError("It is damaged."))
    assert sentences == [("bad", "It is damaged.")]
    assert seen.measures == ()


def test_a_picture_that_comes_too_late_is_not_shown(
    view, workspace, inline_jobs, saved, monkeypatch
):
    workspace.choose_session(saved[1])
    waiting = []
    start = inline_jobs.start

    def hold_all(label, work, done, failed=None):
        waiting.append((label, lambda: start(label, work, done, failed)))

    monkeypatch.setattr(inline_jobs, "start", hold_all)
    presenter = ReviewPresenter(view, workspace)
    presenter.entered()
    presenter.choose_capture(saved[2][1].capture_id)
    view.show_picture.reset_mock()
    pictures = [run for label, run in waiting if label == "Opening the picture"]
    pictures[0]()
    view.show_picture.assert_not_called()
    pictures[1]()
    view.show_picture.assert_called_once()


def test_a_picture_that_cannot_be_read_is_told(view, workspace, seen, store, saved):
    sentences = told(workspace)
    for file in store.folder.joinpath("pictures").rglob("*.sealed"):
        file.write_bytes(b"damaged")
    workspace.choose_session(saved[1])
    presenter = ReviewPresenter(view, workspace)
    presenter.entered()
    assert [kind for kind, _sentence in sentences] == ["bad"]
    assert len(seen.measures) == 6
    presenter.open_space()
    view.show_space.assert_not_called()


def test_a_thumbnail_that_cannot_be_read_leaves_its_place_empty(
    view, workspace, seen, store, saved, monkeypatch
):
    def missing(_capture_id):
        raise StoreError("There is none.")

    monkeypatch.setattr(store.captures, "thumbnail", missing)
    workspace.choose_session(saved[1])
    ReviewPresenter(view, workspace).entered()
    assert seen.strip[0][0].thumbnail_rgb is None


def test_captures_that_cannot_be_read_are_told(view, workspace, seen, store, saved, monkeypatch):
    def broken(_session_id):
        raise StoreError("The store is damaged.")

    sentences = told(workspace)
    monkeypatch.setattr(store.captures, "of_session", broken)
    workspace.choose_session(saved[1])
    ReviewPresenter(view, workspace).entered()
    assert sentences == [("bad", "The store is damaged.")]
    assert seen.last("show_nothing").args[1] == "capture"


@pytest.mark.parametrize(
    "markers",
    [
        {"format": "adibas-leds", "version": 1, "least_brightness": 0.6},
        {"format": "nobody knows", "version": 99},
    ],
)
def test_a_session_with_learned_markers_opens_readable_or_not(
    view, workspace, seen, store, saved, markers
):
    session = store.sessions.change(saved[1].session_id, setup=SessionSetup(markers=markers))
    workspace.choose_session(session)
    ReviewPresenter(view, workspace).entered()
    assert seen.points.can_edit


def test_notes_are_saved_and_told(review, workspace, store, saved, seen):
    session_id = saved[1].session_id
    review.change_notes(session_id, "Stands on one leg.", "")
    assert store.sessions.get(session_id).notes == "Stands on one leg."
    assert workspace.session.notes == "Stands on one leg."
    assert seen.last("show_notes").args == (session_id, "Stands on one leg.")


def test_notes_that_were_typed_for_a_session_are_saved_for_that_one(
    review, workspace, store, saved
):
    other = store.sessions.start(saved[0].pseudonym, SessionSetup())
    workspace.choose_session(other)
    review.change_notes(saved[1].session_id, "Late.", "")
    assert store.sessions.get(saved[1].session_id).notes == "Late."
    assert workspace.session.session_id == other.session_id


def test_names_of_this_patient_are_suggested_but_no_numbers(review, seen, workspace, store, saved):
    store.captures.add(
        saved[1].session_id,
        new_capture("", (plain_marker("Left knee"), plain_marker("m17"))),
        picture_rgb(),
    )
    review.left()
    workspace.choose_session(None)
    review.entered()
    workspace.choose_session(saved[1])
    assert seen.last("show_names").args[0] == ("Left knee",)


@pytest.fixture
def named(store):
    """A session of Ana's, with a marker that somebody named."""
    markers = (plain_marker("scar_left"),)
    patient, session, _captures = saved_session(store)
    store.captures.add(session.session_id, new_capture("posterior", markers), picture_rgb())
    return patient, store.sessions.get(session.session_id)


def look_at(workspace, patient, session):
    workspace.choose_patient(patient)
    workspace.choose_session(session)


def test_names_of_one_patient_are_not_suggested_for_the_next(view, workspace, seen, store, named):
    bernat = add_patient(store, Identity("Bernat"))
    session = store.sessions.start(bernat.pseudonym, SessionSetup())
    look_at(workspace, *named)
    review = ReviewPresenter(view, workspace)
    review.entered()
    assert seen.last("show_names").args[0] == ("scar_left",)
    review.left()
    look_at(workspace, bernat, session)
    review.entered()
    assert seen.last("show_names").args[0] == (), "also before he has pictures"
    review.left()
    look_at(workspace, *named)
    review.entered()
    assert seen.last("show_names").args[0] == ("scar_left",)


def test_a_session_without_pictures_is_suggested_the_names_of_those_before(
    view, workspace, seen, store, named
):
    look_at(workspace, named[0], store.sessions.start(named[0].pseudonym, SessionSetup()))
    ReviewPresenter(view, workspace).entered()
    assert seen.last("show_names").args[0] == ("scar_left",)


def test_names_that_come_too_late_are_not_suggested(
    view, workspace, seen, saved, named, monkeypatch
):
    late, start = [], workspace.jobs.start

    def hold_names(label, work, done, *more):
        if label == "Collecting names":
            late.append(lambda: done(work(None)))
        else:
            start(label, work, done, *more)

    monkeypatch.setattr(workspace.jobs, "start", hold_names)
    look_at(workspace, *named)
    ReviewPresenter(view, workspace).entered()
    look_at(workspace, *saved[:2])
    for_ana, for_the_other = late
    for_the_other()
    for_ana()
    assert seen.last("show_names").args[0] == ()


def test_the_surface_is_shown_with_the_markers(review, view):
    review.open_space()
    space = view.show_space.call_args.args[0]
    assert len(space.discs) > 1000
    np.testing.assert_allclose(space.discs.points_m[:, 2], 1.0, rtol=1e-5)
    assert list(space.landmarks_m) == list(DOTS)


class Running:
    """A job that has not ended."""

    is_running = True


@pytest.fixture
def late_tables(inline_jobs, monkeypatch):
    """The tables of measures that are waited for; calling one ends its job."""
    waiting = []
    start = inline_jobs.start

    def hold_tables(label, work, done, failed=None):
        if label != "Measuring":
            return start(label, work, done, failed)
        job = Running()

        def run():
            job.is_running = False
            start(label, work, done, failed)

        waiting.append(run)
        return job

    monkeypatch.setattr(inline_jobs, "start", hold_tables)
    return waiting


UPRIGHT = replace(CALIBRATION, gravity=np.array([0.0, 1.0, 0.0]))


@pytest.fixture
def by_protocol(view, workspace, store):
    """The review of a session that follows SAPO-1, both acromia named."""
    saved = saved_session(store, ("anterior",), protocol="sapo-1", calibration=UPRIGHT)
    with entered_review(view, workspace, saved) as presenter:
        presenter.points.rename("m01", "right_acromion")
        presenter.points.rename("m02", "left_acromion")
        yield presenter.points


def tilt_deg(seen):
    """Return the tilt of the line of the acromia as the protocol tells it."""
    measures = seen.last("show_protocol").args[0]
    points = ("right_acromion", "left_acromion")
    (found,) = [
        one
        for one in measures.results
        if set(one.definition.points) == set(points) and one.definition.kind == "line_to_horizontal"
    ]
    return math.degrees(found.main.value)


def test_measures_of_the_protocol_follow_a_marker_that_is_dragged(by_protocol, seen):
    assert tilt_deg(seen) == pytest.approx(0.0, abs=0.01)
    x, y = DOTS["m02"]
    by_protocol.press("left_acromion")
    by_protocol.drag("left_acromion", x, y + 16)
    # On the wall, which the camera sees squarely, 16 pixels down on a way of 160.
    assert abs(tilt_deg(seen)) == pytest.approx(math.degrees(math.atan(0.1)), abs=0.01)
    by_protocol.drop("left_acromion", x, y - 16, is_free=True)
    after = tilt_deg(seen)
    by_protocol.undo()
    by_protocol.drag("left_acromion", x, y + 16)
    assert tilt_deg(seen) == pytest.approx(-after, abs=0.01)


def test_a_marker_placed_by_hand_is_told_among_the_measures(by_protocol, seen):
    x, y = DOTS["m02"]
    by_protocol.press("left_acromion")
    by_protocol.drag("left_acromion", x, y + 5)
    by_protocol.drop("left_acromion", x, y + 5, is_free=True)
    measures = seen.last("show_protocol").args[0]
    assert any("left_acromion" in one.by_hand for one in measures.results)


@pytest.mark.usefixtures("review")
def test_without_a_protocol_nothing_is_measured_by_one(seen):
    assert seen.last("show_protocol").args == (None,)
    assert seen.measures


def test_a_table_that_is_late_is_followed_by_the_newest(late_tables, points, seen):
    points.keep_measure(("m01", "m02"))
    assert seen.points.measures[0].value is None  # nothing was measured yet
    points.drag("m01", 90.0, 60.0)
    points.drag("m01", 95.0, 60.0)
    assert len(late_tables) == 1
    late_tables[0]()
    expected_mm = mm_between(DOTS["m01"], DOTS["m02"])
    assert seen.value("m01", "m02") == pytest.approx(expected_mm, rel=1e-4)
    assert seen.points.measures[0].value is not None
    assert len(late_tables) == 2
    late_tables[1]()
    expected_mm = mm_between((95.0, 60.0), DOTS["m02"])
    assert seen.value("m01", "m02") == pytest.approx(expected_mm, rel=1e-4)


def test_a_table_of_a_capture_that_was_left_is_not_shown(late_tables, review, seen, workspace):
    review.points.drag("m01", 99.0, 60.0)
    workspace.choose_session(None)
    late_tables[0]()
    assert seen.measures == ()


def test_a_surface_that_comes_too_late_is_not_shown(review, view, inline_jobs, saved, monkeypatch):
    waiting = []
    monkeypatch.setattr(inline_jobs, "start", lambda *job: waiting.append(job))
    review.open_space()
    work, done = waiting[0][1:]
    review.choose_capture(saved[2][1].capture_id)
    done(work(None))
    view.show_space.assert_not_called()


def test_measures_of_a_deleted_marker_go_with_it(points, seen, store, saved):
    points.keep_measure(("m01", "m02"))
    points.rename("m02", "C7")
    assert seen.points.measures[0].labels == ("m01", "C7")
    points.select("C7")
    points.delete()
    assert seen.points.measures == ()
    points.undo()
    assert now(store, saved[2][0]).history.measures() == (FreeMeasure(("m01", "C7")),)
