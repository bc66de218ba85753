"""The joints of a moving patient by the names of the markers, frame by frame."""

import numpy as np
import pytest

from adibas.data.joints import JOINT_NAMES
from adibas.markers.led import LedParams
from adibas.pipeline import movement_joints, put_together
from adibas.pipeline.movement_frames import MovementFrames
from adibas.pipeline.movement_joints import (
    SIDES,
    SPARE_MARKERS,
    VIEW_FOUND,
    VIEW_HELPS,
    joints_of_markers,
)
from adibas.pipeline.posture import PostureParams
from adibas.recordings import open_recording
from tests.unit.films import BENT, filmed

NEAR_M = 0.05


def measured(path, view):
    with open_recording(path) as recording:
        return joints_of_markers(
            recording,
            recording.info.calibration,
            LedParams(),
            PostureParams(),
            view,
            lambda _done, _all: None,
        )


def compared(found, truth):
    """Return how many joints are where they should be, elsewhere, and in view."""
    n_right = n_wrong = n_visible = 0
    for joints_m, markers in zip(found.track.joints_m, truth, strict=True):
        for name, place_m in zip(JOINT_NAMES, joints_m, strict=True):
            n_visible += name in markers and markers[name].is_visible
            if np.isfinite(place_m[0]):
                is_there = np.linalg.norm(place_m - markers[name].position_m) < NEAR_M
                n_right += is_there
                n_wrong += not is_there
    return n_right, n_wrong, n_visible


@pytest.fixture(scope="module")
def bending(tmp_path_factory):
    path = tmp_path_factory.mktemp("movement") / "bend.mcap"
    return path, filmed(path, BENT, seed=7, gesture="bend")


def test_a_chosen_frame_shows_what_it_shows_among_all(tmp_path):
    path = tmp_path / "standing.mcap"
    filmed(path, range(3), seed=7)
    with open_recording(path) as recording:
        calibration = recording.info.calibration
        film = MovementFrames(recording, calibration, LedParams(), PostureParams())
        with film.seen() as frames:
            every = list(frames)
        with film.seen(np.array([2])) as frames:
            (last,) = frames
    assert last.time_s == every[2].time_s == pytest.approx(2.0 / 30.0, abs=2e-3)
    assert len(last.upright_m) > 5
    np.testing.assert_array_equal(last.upright_m, every[2].upright_m)


def test_who_bends_down_keeps_all_markers(bending):
    """Bent forwards nobody is tall, and head, arms and legs fall apart in the depth."""
    path, truth = bending
    n_right, n_wrong, n_visible = compared(measured(path, "anterior"), truth)
    assert n_wrong == 0
    assert n_right > 0.95 * n_visible


def test_without_the_frame_before_most_of_a_bend_is_lost(bending, monkeypatch):
    monkeypatch.setattr(put_together, "SOON_S", 0.0)
    path, truth = bending
    n_right, _n_wrong, n_visible = compared(measured(path, "anterior"), truth)
    assert n_right < 0.6 * n_visible


def test_nobody_is_put_together_for_ever(bending, monkeypatch):
    monkeypatch.setattr(put_together, "LONGEST_APART_S", 0.0)
    path, truth = bending
    n_right, _n_wrong, n_visible = compared(measured(path, "anterior"), truth)
    assert n_right < 0.6 * n_visible


def test_it_is_told_by_what_the_markers_were_named(bending):
    path, truth = bending
    declared = measured(path, "anterior")
    assert declared.names["n_frames_with_body"] > 0.8 * len(truth)
    assert declared.names["view"] == "anterior"
    assert declared.names["n_frames_that_told_view"] == 0
    assert VIEW_FOUND not in [one.message for one in declared.doubts]


def test_a_view_that_nobody_declared_is_found_by_the_names_and_told(bending):
    path, truth = bending
    found = measured(path, "")
    assert found.names["view"] == "anterior"
    n_telling = found.names["n_frames_that_told_view"]
    assert n_telling >= 3
    (said,) = [one for one in found.doubts if one.message == VIEW_FOUND]
    assert (said.fields["side"], said.fields["n"]) == (SIDES["anterior"], n_telling)
    assert compared(found, truth) == compared(measured(path, "anterior"), truth)


@pytest.mark.parametrize(("early_s", "most", "n"), [(10.0, 30, 12), (0.55, 30, 6), (10.0, 4, 4)])
def test_the_view_is_asked_of_some_early_frames_a_tenth_of_a_second_apart(
    bending, monkeypatch, early_s, most, n
):
    """The recording has 18 frames in 1.13 s."""
    asked_s = []

    def nothing_told(_namer, frames):
        asked_s.extend(frame.time_s for frame in frames)

    monkeypatch.setattr(movement_joints, "first_view", nothing_told)
    monkeypatch.setattr(movement_joints, "EARLY_S", early_s)
    monkeypatch.setattr(movement_joints, "N_EARLY", most)
    path, _truth = bending
    assert measured(path, "").names["view"] == ""
    assert len(asked_s) == n
    assert asked_s[0] == 0.0
    assert np.all(np.diff(np.floor(np.array(asked_s) / 0.1)) > 0)


def test_markers_without_a_name_and_without_a_view_are_told_what_would_help(tmp_path):
    """Two frames do not tell which side is seen, and from the side places alone name few."""
    path = tmp_path / "side.mcap"
    filmed(path, range(2), view="left_lateral", seed=7)
    said = [one.message for one in measured(path, "").doubts]
    assert SPARE_MARKERS in said
    assert VIEW_HELPS in said
    assert VIEW_HELPS not in [one.message for one in measured(path, "left_lateral").doubts]
