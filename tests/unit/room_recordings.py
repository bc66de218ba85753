"""Recordings of a camera that looks around in a simulated room, without noise."""

import numpy as np
from scipy.spatial.transform import Rotation

from adibas.data.calibration import CameraCalibration, RgbdCalibration
from adibas.data.frames import SensorFrame, SourceInfo
from adibas.geometry.pinhole import Intrinsics
from adibas.geometry.rigid import RigidTransform
from adibas.recordings import create_recording
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


def room_frames(room=None, yaws_deg=YAWS_DEG):
    """Return frames of a camera that turns there and back, and its poses."""
    room = room or FurnishedRoom(5)
    poses = [pose(yaw, k) for k, yaw in enumerate(yaws_deg)]
    return [frame(room, one, k) for k, one in enumerate(poses)], poses


def written(path, frames):
    """Write frames as a recording."""
    with create_recording(path, INFO) as recording:
        for one in frames:
            recording.write(one)
    return path
