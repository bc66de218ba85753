"""A recording of a device that is carried in a circle through a simulated room, and its truth.

It looks outwards, goes round once and a little more, and sways as a hand does. The recording is
kept below `build/benchmarks`: drawing it takes longer than mapping it.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from adibas.clock import NS_PER_S
from adibas.data.frames import SensorFrame, SourceInfo
from adibas.geometry.rigid import RigidTransform, rotation_from_vector
from adibas.recordings import RecordingOptions, create_recording
from adibas.simulation.device import DEPTH_UNIT_M, draw_device
from adibas.simulation.furnished_room import FurnishedRoom
from benchmarks.mapping_rooms import COLOR_SIZE, Eye

FOLDER = Path(__file__).parents[1] / "build" / "benchmarks"
SEED = 3064
"""A room whose furniture leaves the circle free."""
RADIUS_M, HEIGHT_M = 0.6, 1.5
TURN_RAD = np.radians(380.0)
PITCH_RAD = 0.15
SWAY_RAD, SWAY_M, SWAYS = 0.02, 0.01, 17.0
PERIOD_NS = NS_PER_S // 30


@dataclass(frozen=True, slots=True)
class Walk:
    """A recording and where its camera was.

    Attributes
    ----------
    path : Path
    camera_from_world : tuple of RigidTransform
        Of every frame's depth camera.
    """

    path: Path
    camera_from_world: tuple[RigidTransform, ...]


def walk(n_frames: int, n_of_turn: int) -> Walk:
    """Return a recording, drawn where it is not kept yet.

    Parameters
    ----------
    n_frames : int
        So many; after the whole way it goes on round the room.
    n_of_turn : int
        Frames that the whole way takes: the fewer, the faster it goes.
    """
    shares = np.linspace(0.0, (n_frames - 1) / (n_of_turn - 1), n_frames)
    poses = tuple(_pose(share) for share in shares)
    path = FOLDER / f"walk-{SEED}-{n_frames}-of-{n_of_turn}.mcap"
    if not path.exists():
        _draw(path, poses)
    return Walk(path, poses)


def _draw(path: Path, poses: tuple[RigidTransform, ...]) -> None:
    device = draw_device(SEED, COLOR_SIZE)
    eye = Eye(FurnishedRoom(SEED), device, SEED)
    info = SourceInfo(calibration=device.calibration, depth_unit_m=DEPTH_UNIT_M)
    path.parent.mkdir(parents=True, exist_ok=True)
    options = RecordingOptions(color="jpeg", is_live=False)
    with create_recording(path, info, options) as recording:
        for number, pose in enumerate(poses):
            raw, color_rgb = eye.measure(pose, number)
            time_ns = NS_PER_S + number * PERIOD_NS
            recording.write(SensorFrame(number, time_ns, raw, color_rgb, time_ns))


def _pose(share: float) -> RigidTransform:
    """Return where the camera is, from the world, after a share of the way."""
    angle = share * TURN_RAD
    swing = 2.0 * np.pi * SWAYS * share
    place = np.array([RADIUS_M * np.sin(angle), -HEIGHT_M, RADIUS_M * np.cos(angle)])
    place += SWAY_M * np.array([np.cos(swing), np.sin(0.7 * swing), np.sin(swing)])
    yaw = rotation_from_vector(np.array([0.0, -angle, 0.0]))
    pitch = rotation_from_vector(np.array([PITCH_RAD + SWAY_RAD * np.sin(1.3 * swing), 0.0, 0.0]))
    turn = pitch @ yaw
    return RigidTransform(turn, -turn @ place)
