"""A recording of a moving camera becomes its path and one surface."""

import contextlib
import json

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from adibas.alignment.surfels import SurfelParams
from adibas.cli.command_line import main
from adibas.data.calibration import CameraCalibration, RgbdCalibration
from adibas.data.frames import SensorFrame, SourceInfo
from adibas.errors import RecordingError
from adibas.geometry.pinhole import Intrinsics
from adibas.geometry.rigid import RigidTransform
from adibas.pipeline.mapping import MapRequest, map_recording
from adibas.recordings import create_recording
from adibas.reports.map_files import ROW
from adibas.simulation.furnished_room import FurnishedRoom

CAMERA = CameraCalibration(320, 240, Intrinsics(290.0, 290.0, 159.5, 119.5))
CALIBRATION = RgbdCalibration(
    depth=CAMERA, color=CAMERA, color_from_depth=RigidTransform(np.eye(3), np.zeros(3))
)
YAWS_DEG = (0.0, 10.0, 20.0, 30.0, 40.0, 28.0, 14.0, 1.0)
INFO = SourceInfo(calibration=CALIBRATION)


def pose(yaw_deg, k):
    turn = Rotation.from_euler("y", yaw_deg, degrees=True).as_matrix()
    return RigidTransform(turn, turn @ np.array([0.1 + 0.02 * k, 1.4, 1.1]))


def frame(room, camera_from_world, k):
    seen = room.look(CAMERA, camera_from_world)
    return SensorFrame(
        sequence=k,
        timestamp_ns=1_000_000_000 + k * 33_000_000,
        depth_raw=np.round(1000.0 / seen.inverse_depth).astype(np.uint16),
        color=np.round(255 * seen.rgb).astype(np.uint8),
        color_timestamp_ns=1_000_000_000 + k * 33_000_000,
    )


@pytest.fixture(scope="module")
def taken(tmp_path_factory):
    path = tmp_path_factory.mktemp("map") / "room.mcap"
    room, poses = FurnishedRoom(5), [pose(yaw, k) for k, yaw in enumerate(YAWS_DEG)]
    with create_recording(path, INFO) as recording:
        for k, one in enumerate(poses):
            recording.write(frame(room, one, k))
    return path, poses, room


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
    path = tmp_path / "two.mcap"
    with create_recording(path, INFO) as recording:
        recording.write(frame(FurnishedRoom(5), pose(0.0, 0), 0))
        recording.write(frame(FurnishedRoom(9), pose(0.0, 0), 1))
    with pytest.raises(RecordingError, match="No two frames could be put together"):
        map_recording(MapRequest(path), lambda _done, _total: None)


def test_a_surface_that_does_not_fit_in_says_so(taken):
    request = MapRequest(taken[0], frames=(0, 3), surfels=SurfelParams(capacity=1000))
    mapped = map_recording(request, lambda _done, _total: None)
    assert len(mapped.surface.points_m) <= 1000
    assert [notice.text for notice in mapped.notices if "left out" in notice.text]
