"""A recording of a moving camera becomes its path and one surface."""

import contextlib
import json

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from adibas.alignment import gtsam_graph, key_frames
from adibas.alignment.camera_track import KeyFrameParams
from adibas.alignment.pose_graph import GraphParams, optimise
from adibas.alignment.surfels import SurfelParams
from adibas.cli.command_line import main
from adibas.errors import RecordingError
from adibas.pipeline import mapping
from adibas.pipeline.mapping import MapRequest, map_recording
from adibas.reports.map_files import ROW
from adibas.simulation.furnished_room import FurnishedRoom
from tests.unit.room_recordings import CAMERA, YAWS_DEG, frame, pose, room_frames, written


@pytest.fixture(scope="module")
def taken(tmp_path_factory):
    room = FurnishedRoom(5)
    frames, poses = room_frames(room)
    return written(tmp_path_factory.mktemp("map") / "room.mcap", frames), poses, room


@pytest.fixture(scope="module")
def mapped(taken, tmp_path_factory):
    folder = tmp_path_factory.mktemp("out")
    ply, trajectory, said = folder / "m.ply", folder / "t.txt", folder / "said.json"
    arguments = ["map", str(taken[0]), "--out", str(ply), "--trajectory", str(trajectory)]
    with said.open("w") as out:
        code = run(arguments, out)
    assert code == 0
    return ply, trajectory, json.loads(said.read_text())


def run(arguments, out):
    """Run the command with its document on `out`."""

    code = 0
    with contextlib.redirect_stdout(out), contextlib.suppress(SystemExit):
        code = main([*arguments, "--json"])
    return code


def test_the_path_is_that_of_the_camera(taken, mapped):
    rows = np.loadtxt(mapped[1])
    assert rows.shape == (len(YAWS_DEG), 8)
    first = taken[1][0]
    for row, camera_from_world in zip(rows, taken[1], strict=True):
        truth = first @ camera_from_world.inverse()
        assert np.linalg.norm(row[1:4] - truth.translation_m) < 0.006
        turn = Rotation.from_quat(row[4:]) * Rotation.from_matrix(truth.rotation).inv()
        assert np.degrees(turn.magnitude()) < 0.15
    assert mapped[2]["placed"] == len(YAWS_DEG)
    assert mapped[2]["loops"] >= 1


def test_the_surface_is_that_of_the_room(taken, mapped):
    _, body = mapped[0].read_bytes().split(b"end_header\n", 1)
    rows = np.frombuffer(body, ROW)
    assert len(rows) == mapped[2]["surfels"] > 5000
    points = np.stack([rows["x"], rows["y"], rows["z"]], axis=1).astype(float)
    normals = np.stack([rows["nx"], rows["ny"], rows["nz"]], axis=1)
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1.0, atol=1e-3)
    seen = taken[2].look(CAMERA, taken[1][0])
    z = points[:, 2]
    ahead = z > 0.3
    u, v = np.rint(points[ahead, :2] / z[ahead, None] * 290.0 + (159.5, 119.5)).astype(int).T
    inside = (u >= 0) & (u < 320) & (v >= 0) & (v < 240)
    off_m = np.abs(1.0 / seen.inverse_depth[v[inside], u[inside]] - z[ahead][inside])
    assert np.median(off_m) < 0.004
    towards = (normals[ahead] * points[ahead]).sum(axis=1)[inside]
    assert (towards[off_m < 0.02] < 0).all()


def test_frames_of_different_rooms_are_not_put_together(tmp_path):
    two = [frame(FurnishedRoom(seed), pose(0.0, k), k) for k, seed in enumerate((5, 9))]
    path = written(tmp_path / "two.mcap", two)
    with pytest.raises(RecordingError, match="No two frames could be put together"):
        map_recording(MapRequest(path), lambda _done, _total: None)


def test_the_graph_is_solved_by_the_library_that_is_asked_for(taken, monkeypatch):
    asked = []

    def solve(world_from, edges, params):
        asked.append(len(edges))
        return optimise(world_from, edges, params)

    monkeypatch.setattr(key_frames, "optimise_by_gtsam", solve)
    monkeypatch.setattr(mapping, "check_gtsam", lambda: None)
    tracking = KeyFrameParams(graph=GraphParams(solver="gtsam"))
    assert (
        map_recording(MapRequest(taken[0], tracking=tracking), lambda _done, _total: None).n_loops
        > 0
    )
    assert asked


def test_without_the_library_the_command_says_how_to_get_it(taken, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(gtsam_graph, "MODULE", "no_such_library")
    out = tmp_path / "m.ply"
    assert main(["map", str(taken[0]), "--out", str(out), "--pose-graph", "gtsam"]) == 1
    assert "pip install 'adibas[gtsam]'" in capsys.readouterr().err
    assert not out.exists()


def test_a_surface_that_does_not_fit_in_says_so(taken):
    request = MapRequest(taken[0], frames=(0, 3), surfels=SurfelParams(capacity=1000))
    mapped = map_recording(request, lambda _done, _total: None)
    assert len(mapped.surface.points_m) <= 1000
    assert [notice.text for notice in mapped.notices if "left out" in notice.text]


def test_key_frames_that_are_read_again_give_the_same_path(taken):
    paths = [
        map_recording(
            MapRequest(taken[0], tracking=KeyFrameParams(n_kept=n_kept)), lambda _done, _total: None
        )
        for n_kept in (1, 16)
    ]
    assert paths[0].n_key_frames > 3
    for one, other in zip(*(path.world_from_camera for path in paths), strict=True):
        np.testing.assert_array_equal(one.translation_m, other.translation_m)
        np.testing.assert_array_equal(one.rotation, other.rotation)


def test_a_watcher_sees_the_map_grow_where_it_is_at_last(taken):
    seen = []
    mapped = map_recording(MapRequest(taken[0]), lambda _done, _total: None, seen.append)
    assert [len(one.path_m) for one in seen[:-1]] == list(range(1, mapped.n_key_frames + 1))
    surface = mapped.surface.points_m
    assert len(seen[-1].discs) == len(surface)
    grown = seen[-2]
    early = grown.discs.points_m[::50]
    apart_m = np.linalg.norm(early[:, None] - surface[None, ::5], axis=2).min(axis=1)
    assert np.median(apart_m) < 0.03
    # Discs look at where the camera was; it turned by less than a right angle.
    towards = np.median(grown.path_m, axis=0) - grown.discs.points_m
    facing = (grown.discs.normals * towards).sum(axis=1)
    known = np.isfinite(facing)
    assert known.mean() > 0.7
    assert (facing[known] > 0).mean() > 0.95
