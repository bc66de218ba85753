"""Simulated rooms seen twice through a noisy sensor, with the exact motion between."""

from dataclasses import dataclass

import numpy as np

from adibas.alignment.pairing import Moment
from adibas.alignment.sights import see
from adibas.arrays import FloatArray, UInt8Array, UInt16Array
from adibas.data.calibration import RgbdCalibration
from adibas.data.frames import depth_in_metres
from adibas.geometry.rigid import RigidTransform, rotation_from_vector
from adibas.simulation.color_noise import ColorNoise, ColorSensor
from adibas.simulation.depth_noise import DepthNoise, DepthSensor
from adibas.simulation.device import DEPTH_UNIT_M, Device, draw_device
from adibas.simulation.furnished_room import FurnishedRoom
from adibas.simulation.light import draw_illumination
from adibas.simulation.looks import linear_from_srgb

COLOR_SIZE = (480, 640)
N_ATTEMPTS = 400
FRAMES_APART = 50
"""So that the noise of the two moments, which fades with time, is independent."""


@dataclass(frozen=True, slots=True, eq=False)
class RoomPair:
    """Two moments.

    Attributes
    ----------
    target, source : Moment
    target_from_source : RigidTransform
        The truth.
    """

    target: Moment
    source: Moment
    target_from_source: RigidTransform


def room_pair(seed: int, turn_rad: float, shift_m: float) -> RoomPair | None:
    """Look at a room twice, so far apart; None where furniture is in the way."""
    rng = np.random.default_rng([seed, 7])
    room = FurnishedRoom(seed)
    device = draw_device(seed, COLOR_SIZE)
    first = _pose(rng, room)
    if first is None:
        return None
    for _ in range(N_ATTEMPTS):
        axis, way = (_direction(rng) for _ in range(2))
        motion = RigidTransform(rotation_from_vector(axis * turn_rad), way * shift_m)
        other = motion @ first
        if room.is_free(other.inverse().translation_m, 0.3):
            eye = Eye(room, device, seed)
            return RoomPair(eye.look(other, FRAMES_APART), eye.look(first, 0), motion)
    return None


class Eye:
    """A device in a room."""

    def __init__(self, room: FurnishedRoom, device: Device, seed: int) -> None:
        self._room = room
        self._calibration: RgbdCalibration = device.calibration
        self._depth = DepthSensor(device, DepthNoise(), seed)
        color = self._calibration.color
        if color is None or self._calibration.depth is None:
            raise ValueError("a simulated device has both cameras")
        self._cameras = self._calibration.depth, color
        light = draw_illumination(np.random.default_rng(seed))
        self._color = ColorSensor(color, ColorNoise(), light, seed)

    @property
    def calibration(self) -> RgbdCalibration:
        """Of the device."""
        return self._calibration

    def measure(
        self, camera_from_world: RigidTransform, moment: int
    ) -> tuple[UInt16Array, UInt8Array]:
        """Return raw depth and the colour picture."""
        depth_camera, color_camera = self._cameras
        view = self._room.look(depth_camera, camera_from_world)
        raw = self._depth.measure(view.inverse_depth, view.reflectance, moment)
        color_from_world = self._calibration.color_from_depth @ camera_from_world
        srgb = 255.0 * self._room.look(color_camera, color_from_world).rgb.astype(float)
        return raw, self._color.take(linear_from_srgb(srgb).astype(np.float32), moment)

    def look(self, camera_from_world: RigidTransform, moment: int) -> Moment:
        """Return what the device measures, ready for alignment."""
        raw, color_rgb = self.measure(camera_from_world, moment)
        depth_m = self._calibration.corrected_depth(depth_in_metres(raw, DEPTH_UNIT_M))
        return Moment(see(np.ascontiguousarray(depth_m, np.float32), color_rgb, self._calibration))


def _pose(rng: np.random.Generator, room: FurnishedRoom) -> RigidTransform | None:
    """Return a pose that looks across the room, camera from world; None if none was found."""
    for _ in range(N_ATTEMPTS):
        place = np.array([rng.uniform(-1.6, 1.6), -rng.uniform(0.9, 1.6), rng.uniform(-1.6, 1.6)])
        if not room.is_free(place, 0.45) or np.hypot(place[0], place[2]) < 1.0:
            continue
        yaw_rad = -np.arctan2(-place[0], -place[2]) + rng.normal(0.0, 0.3)
        pitch_rad = rng.normal(0.25, 0.1)
        turn = rotation_from_vector(np.array([pitch_rad, 0.0, 0.0])) @ rotation_from_vector(
            np.array([0.0, yaw_rad, 0.0])
        )
        return RigidTransform(turn, -turn @ place)
    return None


def _direction(rng: np.random.Generator) -> FloatArray:
    way = rng.normal(size=3)
    unit: FloatArray = way / np.linalg.norm(way)
    return unit
