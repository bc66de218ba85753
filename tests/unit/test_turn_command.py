"""One recording of somebody who turns around becomes the four views, one surface and measures."""

import json
from types import SimpleNamespace

import numpy as np
import pytest

from adibas.data.markers import Marker
from adibas.data.posture import VIEWS
from adibas.pipeline import body
from adibas.pipeline.body_views import ViewRequest
from adibas.pipeline.turning import see_turn
from benchmarks.body_truth import distances_mm
from tests.unit.test_back_command import run
from tests.unit.turning_bodies import (
    N_FRAMES,
    STEP_DEG,
    drawn,
    posed,
    turn_images,
    turning_scene,
    write,
)


@pytest.fixture(scope="module")
def scene():
    return turning_scene()


@pytest.fixture(scope="module")
def images():
    return turn_images()


@pytest.fixture(scope="module")
def turn(tmp_path_factory, images, scene):
    return write(tmp_path_factory.mktemp("turn") / "turn.mcap", images, scene)


def seen(path, begins="posterior", frames=(0, None)):
    return see_turn(ViewRequest(begins, path, frames=frames), lambda _done, _total: None)


@pytest.fixture(scope="module")
def found(turn):
    return seen(turn)


def test_the_sides_are_found_where_they_face_the_sensor(found):
    assert found.n_lost == 0
    assert np.degrees(found.turned_rad) == pytest.approx(-STEP_DEG * (N_FRAMES - 1), rel=0.03)
    assert [view.view for view in found.views] == list(found.frames)
    # To the patient's right: the right side comes after the back.
    wanted = {"posterior": 0, "right_lateral": 15, "anterior": 30, "left_lateral": 45}
    assert set(found.frames) == set(wanted)
    for view, frame in wanted.items():
        turned_by = found.frames[view] - frame
        assert min(turned_by % 60, -turned_by % 60) <= 2


def test_a_view_is_the_mean_of_moments_around_it(found, scene):
    triangles = scene.patient.body.model.triangles
    for view in found.views:
        assert view.n_frames >= 3
        body_m = scene.depth_from_world.apply(posed(scene, found.frames[view.view], 1).vertices_m)
        off_mm = distances_mm(view.points_m(), body_m, triangles)
        assert abs(np.median(off_mm)) < 1.5
        # Of single frames it is 5 to 7 mm.
        assert 1.4826 * np.median(np.abs(off_mm)) < 3.5


def test_a_turn_to_the_left_shows_the_left_side_first(tmp_path, scene):
    path = write(tmp_path / "left.mcap", drawn(scene, 20, -1), scene)
    found = seen(path)
    assert list(found.frames) == ["posterior", "left_lateral"]
    assert found.turned_rad > 0.0
    assert list(seen(path, "anterior").frames) == ["anterior", "right_lateral"]


def test_the_command_writes_surface_measures_and_report(turn, tmp_path):
    ply, xlsx = tmp_path / "b.ply", tmp_path / "r.xlsx"
    code, out, _ = run("body", f"turn={turn}", "--out", ply, "--report", xlsx, "--json")
    assert code == 0
    document = json.loads(out)
    assert set(document["views"]) == set(VIEWS)
    assert document["points"] > 15_000
    values = {one["id"]: one["value"] for one in document["measures"]}
    assert 30.0 < values["BACK.KYPHOSIS"] < 60.0
    assert values["GIRTH.TRUNK.LEAST"] is not None
    assert {one["recording_sha256"] for one in document["provenance"].values()} == {
        document["provenance"]["posterior"]["recording_sha256"]
    }
    assert ply.exists()
    assert xlsx.exists()


def test_markers_are_looked_for_in_the_middle_frames(turn, tmp_path):
    code, _, err = run("body", f"turn={turn}", "--markers", "led", "--out", tmp_path / "b.ply")
    assert code == 1
    assert "colour" in err


def test_markers_are_looked_for_in_no_frame_that_was_not_wanted(turn, monkeypatch):
    looked = {}

    def look(request, _progress, *, may_lack):
        assert may_lack
        looked[request.view] = request.frames
        return SimpleNamespace(markers=(Marker("m01", 0.0, 0.0, 5.0, np.eye(2)),), doubts=())

    monkeypatch.setattr(body, "find_in_recording", look)
    wanted = ViewRequest("posterior", turn, frames=(2, 17))  # 84 degrees: each side is at an end
    request = body.BodyRequest((), markers="led", turn=wanted)
    body.measure_body(request, lambda _done, _total: None)
    assert looked == {"posterior": (2, 4), "right_lateral": (15, 17)}


def test_a_wrong_beginning_is_noticed(turn, tmp_path):
    told = f"turn={turn}"
    code, _, err = run("body", told, "--begins", "anterior", "--out", tmp_path / "b.ply")
    assert code == 1
    assert "The toes point to the sensor" in err


def test_too_little_of_a_turn_is_told(turn, tmp_path):
    told = f"turn={turn}"
    code, _, err = run("body", told, "--frames", "0:8", "--out", tmp_path / "b.ply")
    assert code == 1
    assert "degrees of a turn can be followed in turn.mcap" in err


def test_a_recording_that_was_cut_is_told_where_too_little_is_left(turn, tmp_path):
    cut = tmp_path / "cut.mcap"
    whole = turn.read_bytes()
    cut.write_bytes(whole[: len(whole) // 8])
    code, _, err = run("body", f"turn={cut}", "--out", tmp_path / "b.ply")
    assert code == 1
    assert "cut.mcap is cut" in err
    assert "degrees of a turn. Restore cut.mcap from a copy" in err


def test_somebody_who_leaves_is_told_by_the_frame(images, scene, tmp_path):
    gone = np.zeros_like(images[0])
    path = write(tmp_path / "gone.mcap", [*images[:20], *[gone] * 20], scene)
    code, _, err = run("body", f"turn={path}", "--out", tmp_path / "b.ply")
    assert code == 1
    assert "lost in frame 35 of gone.mcap" in err


def test_a_short_gap_is_bridged(images, scene, tmp_path):
    some = [np.zeros_like(one) if 8 <= number < 10 else one for number, one in enumerate(images)]
    path = write(tmp_path / "gap.mcap", [*some[:20], None], scene)
    found = seen(path)
    assert (found.n_lost, found.n_frames) == (3, 21)
    assert list(found.frames) == ["posterior", "right_lateral"]
    code, _, err = run("body", f"turn={path}", "--out", tmp_path / "b.ply")
    assert code == 0
    assert "In 3 of 21 frames of the turn" in err


@pytest.mark.parametrize(
    ("content", "changes", "words"),
    [
        ("black", {}, "Nobody is seen in bad.mcap"),
        ("colour", {}, "bad.mcap holds no depth"),
        ("black", {"floor": None}, "No floor is seen in bad.mcap"),
        ("turn", {"depth": None}, "lacks the depth camera"),
    ],
)
def test_what_cannot_be_followed_is_told(images, scene, tmp_path, content, changes, words):
    frames = {
        "black": [np.zeros_like(images[0])] * 3,
        "colour": [None] * 3,
        "turn": images[:3],
    }
    path = write(tmp_path / "bad.mcap", frames[content], scene, **changes)
    code, _, err = run("body", f"turn={path}", "--out", tmp_path / "b.ply")
    assert code == 1
    assert words in err


def test_a_turn_stands_alone(turn, tmp_path):
    told, out = f"turn={turn}", ("--out", tmp_path / "b.ply")
    code, _, err = run("body", told, f"posterior={turn}", *out)
    assert code == 1
    assert "Give the turn alone" in err
    code, _, err = run("body", told, told, *out)
    assert code == 1
    assert "Two turns" in err
    code, _, err = run("body", told, "--frames", "0:30", "--labels", f"left_lateral={turn}", *out)
    assert code == 1
    assert "labels for the view left_lateral" in err
