"""Bad recordings for a map: each has its word, and no map is better than a wrong one."""

from dataclasses import replace

import numpy as np
import pytest

from adibas.alignment.camera_track import Track
from adibas.alignment.joint_fit import moved
from adibas.alignment.key_frames import Tracker
from adibas.alignment.pose_graph import Edge
from adibas.cli.command_line import main
from adibas.clock import NS_PER_S
from adibas.errors import RecordingError
from adibas.geometry.rigid import IDENTITY
from adibas.pipeline.map_following import Followed
from adibas.pipeline.mapping import MapRequest, _check, map_recording
from adibas.simulation.furnished_room import FurnishedRoom
from tests.unit.room_recordings import frame, pose, room_frames, written

SLOW_DEG = (0.0, 2.0, 4.0, 6.0, 8.0, 10.0, 12.0, 14.0)


@pytest.fixture(scope="module")
def scene():
    return room_frames()


def mapped(path):
    return map_recording(MapRequest(path), lambda _done, _total: None)


def told(result):
    return " ".join(notice.text for notice in result.notices)


def off_m(result, poses):
    """Return how far each placed camera is from where it was; frames are 33 ms apart."""
    numbers = np.rint((result.timestamps_ns - NS_PER_S) / 33_000_000).astype(int)
    first = poses[numbers[0]]
    truths = [(first @ poses[k].inverse()).translation_m for k in numbers]
    return [
        np.linalg.norm(one.translation_m - truth)
        for one, truth in zip(result.world_from_camera, truths, strict=True)
    ]


def test_a_bare_wall_is_no_map(tmp_path):
    bare = FurnishedRoom(1, is_plain=True)
    frames = [frame(bare, pose(0.0, k), k) for k in range(4)]
    with pytest.raises(
        RecordingError, match=r"No two frames could be put together.*(bare wall|recog)"
    ):
        mapped(written(tmp_path / "wall.mcap", frames))


def test_a_single_frame_is_no_map(scene, tmp_path):
    path = written(tmp_path / "still.mcap", scene[0][:1])
    with pytest.raises(RecordingError, match=r"still\.mcap\. It is a single frame\."):
        mapped(path)


def test_surface_and_path_have_files_of_their_own(scene, tmp_path, capsys):
    path, out = written(tmp_path / "room.mcap", scene[0][:2]), tmp_path / "map.ply"
    other = tmp_path / "." / "map.ply"
    assert main(["map", str(path), "--out", str(out), "--trajectory", str(other)]) == 1
    assert "map.ply cannot hold both" in capsys.readouterr().err
    assert not out.exists()


def passed_by(path, radius_m):
    """Write a recording in which somebody round passes, and return poses and places."""
    poses = [pose(yaw, k) for k, yaw in enumerate(SLOW_DEG)]
    places_m = [(-0.9 + 0.25 * k, -1.2, 0.3) for k in range(len(poses))]
    frames = []
    for k, (one, place_m) in enumerate(zip(poses, places_m, strict=True)):
        room = FurnishedRoom(5)
        room._spheres = np.vstack([room._spheres, [*place_m, radius_m]])
        room._colors = np.vstack([room._colors, [0.9, 0.1, 0.1]])
        frames.append(frame(room, one, k))
    return written(path, frames), poses, places_m


def test_a_moving_bystander_is_told_and_is_no_part_of_the_map(tmp_path):
    path, poses, places_m = passed_by(tmp_path / "passed.mcap", 0.2)
    result = mapped(path)
    assert "Something moved before the camera" in told(result)
    assert len(result.world_from_camera) == len(poses)
    assert max(off_m(result, poses)) < 0.002
    surface = result.surface
    is_red = (surface.colors_rgb[:, 0] > 180) & (surface.colors_rgb[:, 1] < 90)
    for early in places_m[:2]:
        apart_m = np.linalg.norm(surface.points_m - poses[0].apply(np.array(early)), axis=1)
        assert not (is_red & (apart_m < 0.21)).any(), "it was seen through later"


def test_frames_that_a_bystander_fills_are_left_out_and_told(tmp_path):
    path, poses, _places_m = passed_by(tmp_path / "filled.mcap", 0.3)
    result = mapped(path)
    assert "something large moved" in told(result)
    assert max(off_m(result, poses)) < 0.002


def test_a_gap_in_time_is_told(scene, tmp_path):
    frames, poses = scene
    later = [replace(one, timestamp_ns=one.timestamp_ns + 3 * NS_PER_S) for one in frames[4:]]
    result = mapped(written(tmp_path / "gap.mcap", [*frames[:4], *later]))
    assert "places where more than a second is missing: 1." in told(result)
    assert len(result.world_from_camera) == len(poses)


def test_a_jump_to_another_place_leaves_those_frames_out(scene, tmp_path):
    frames, poses = scene
    other = FurnishedRoom(9)
    elsewhere = [frame(other, poses[k], k) for k in range(6, 8)]
    result = mapped(written(tmp_path / "jump.mcap", [*frames[:6], *elsewhere]))
    assert len(result.world_from_camera) == 6
    assert "(In 2 of 8 frames.)" in told(result)
    assert max(off_m(result, poses)) < 0.01


@pytest.mark.parametrize(
    ("lacking", "word"),
    [
        ({"color": None, "color_timestamp_ns": None}, "no colour"),
        ({"depth_raw": None}, "no depth"),
        ({"depth_raw": np.zeros((240, 320), np.uint16)}, "no depth"),
    ],
)
def test_frames_without_depth_or_colour_are_counted_and_a_recording_of_them_refused(
    scene, tmp_path, lacking, word
):
    frames, _poses = scene
    some = [replace(one, **lacking) if k in (2, 5) else one for k, one in enumerate(frames)]
    result = mapped(written(tmp_path / "some.mcap", some))
    assert f"The frame has {word}, and a map takes depth and colour. (In 2 of 8" in told(result)
    assert len(result.world_from_camera) == 6
    every = [replace(one, **lacking) for one in frames]
    with pytest.raises(RecordingError, match=f"No two frames .*The frame has {word}"):
        mapped(written(tmp_path / "every.mcap", every))


def test_frames_out_of_order_are_left_out_and_told(scene, tmp_path, monkeypatch):
    frames, poses = scene
    path = written(tmp_path / "order.mcap", frames)
    from adibas.recordings import mcap_reader

    read = mcap_reader.McapReader.read
    order = (0, 1, 2, 5, 3, 4, 6, 7)
    monkeypatch.setattr(mcap_reader.McapReader, "read", lambda self, k: read(self, order[k]))
    result = mapped(path)
    assert "The frame is not after the one before. (In 2 of 8 frames.)" in told(result)
    assert len(result.world_from_camera) == 6
    assert max(off_m(result, poses)) < 0.01


def spoil_loops(monkeypatch, *, all_of_them):
    """Let loops be measured wrongly: one beside the right ones, or every one."""
    find = Tracker._loops

    def loops(self, own, before):
        found = find(self, own, before)
        spoiled = found if all_of_them else found[:1] * (len(self._keys) == 7)
        wrong = [
            Edge(
                *(one.target, one.source, moved(one.target_from_source, np.full(6, 0.3))),
                one.information,
                is_doubtful=True,
            )
            for one in spoiled
        ]
        return wrong if all_of_them else [*found, *wrong]

    monkeypatch.setattr(Tracker, "_loops", loops)


def test_a_loop_that_closes_wrongly_counts_nothing_and_is_told(scene, tmp_path, monkeypatch):
    frames, poses = scene
    spoil_loops(monkeypatch, all_of_them=False)
    result = mapped(written(tmp_path / "loop.mcap", frames))
    assert result.n_wrong_loops == 1
    assert "Loops that did not fit the rest and count nothing: 1." in told(result)
    assert max(off_m(result, poses)) < 0.01


def test_a_path_that_most_loops_deny_is_refused(scene, tmp_path, monkeypatch):
    frames, _poses = scene
    spoil_loops(monkeypatch, all_of_them=True)
    with pytest.raises(RecordingError, match=r"contradicts itself.*map the person alone\."):
        mapped(written(tmp_path / "loops.mcap", frames))


def test_whose_turn_is_denied_is_told_to_turn_and_not_to_move_the_camera(tmp_path):
    track = Track((IDENTITY, IDENTITY), {}, 2, 1, 8, 0)
    followed = Followed(np.arange(2), np.arange(2), track, (), ())
    with pytest.raises(RecordingError, match=r"of 9 views .* 8 do not .*person turn more slowly"):
        _check(MapRequest(tmp_path / "turn.mcap", is_body=True), followed)
