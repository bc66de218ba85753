"""What a sensor sees while its depth is calibrated: a flat wall, from near to far.

See `adibas.simulation.boards_device` for the sensor, and for the calibration that it hands out.
"""

import functools
import math
from dataclasses import dataclass, field, replace

import numpy as np

from adibas.arrays import Float32Array
from adibas.data.frames import SensorFrame
from adibas.geometry.planes import Plane
from adibas.geometry.rigid import RigidTransform
from adibas.simulation.boards_device import (
    factory_info,
    true_calibration,
    truth_without_person,
    uncalibrated_device,
)
from adibas.simulation.color_noise import ColorNoise, ColorSensor
from adibas.simulation.depth_noise import DepthNoise, DepthSensor
from adibas.simulation.frame_times import check_index, frame_time_ns
from adibas.simulation.light import Illumination, draw_illumination
from adibas.simulation.patient import MarkerSettings
from adibas.simulation.room import Room, draw_room
from adibas.simulation.rotations import about
from adibas.simulation.studio import ColorStudio, DepthStudio, DepthView
from adibas.simulation.truth import SimulatedFrame

BETWEEN_NS = 5_000_000_000
"""How long it takes to move the sensor; nothing is recorded meanwhile (assumed)."""


@dataclass(frozen=True, slots=True)
class WallSceneSettings:
    """The scene with the flat wall; what is None is drawn from the seed.

    Attributes
    ----------
    seed : int
    distances_m : tuple of float
        Of the sensor from the wall, one after the other; then it begins again.
    frames_each : int
        At every distance.
    tilt_rad : float
        Of the look downwards: with it the floor is in the depth image from 1.2 m on.
    aim_sd_rad : float
        By how much the sensor is turned aside, each time anew (assumed).
    camera_height_m : float
    color_size, room, illumination, depth_noise, color_noise, device_seed, n_frames
        As in `BoardSceneSettings`.
    """

    seed: int = 0
    distances_m: tuple[float, ...] = (0.8, 1.1, 1.5, 2.0, 2.5, 3.0, 3.5, 4.0)
    frames_each: int = 45
    tilt_rad: float = math.radians(9.0)
    aim_sd_rad: float = math.radians(2.0)
    camera_height_m: float = 0.75
    color_size: tuple[int, int] = (1024, 1280)
    room: Room | None = None
    illumination: Illumination | None = None
    depth_noise: DepthNoise = field(default_factory=DepthNoise)
    color_noise: ColorNoise = field(default_factory=ColorNoise)
    device_seed: int | None = None
    n_frames: int | None = None


@dataclass(frozen=True, slots=True, eq=False)
class _Station:
    """The sensor at one distance: the true images, and the wall in the depth camera's axes."""

    depth: DepthView
    color: Float32Array
    wall: Plane
    depth_from_world: RigidTransform


class WallScene:
    """A source of frames of a flat wall, and of the floor before it; see `SimulatedScene`.

    The sensor stands still at one distance after the other. While it is moved there are no frames:
    the time jumps.
    """

    def __init__(self, settings: WallSceneSettings) -> None:
        self.settings = settings
        device_seed = settings.seed if settings.device_seed is None else settings.device_seed
        self.device = uncalibrated_device(device_seed, settings.color_size)
        self.n_frames = settings.n_frames
        self.info = factory_info(self.device)
        rng = np.random.default_rng([settings.seed, 0xA11])
        self._room = settings.room or replace(draw_room(rng), chair=None)
        self._illumination = settings.illumination or draw_illumination(rng)
        self._turns_rad = rng.normal(0.0, settings.aim_sd_rad, (len(settings.distances_m), 3))
        self._depth_sensor = DepthSensor(self.device, settings.depth_noise, settings.seed)
        self._color_sensor = ColorSensor(
            self.device.color, settings.color_noise, self._illumination, settings.seed
        )
        self._station = functools.lru_cache(maxsize=2)(self._drawn)

    def frame(self, index: int) -> SimulatedFrame:
        """Return frame number `index`, from 0.

        Raises
        ------
        IndexError
            The scene has no such frame.
        """
        check_index(index, self.n_frames)
        settings = self.settings
        n_moves = index // settings.frames_each
        station = self._station(n_moves % len(settings.distances_m))
        depth = station.depth
        time_ns = frame_time_ns(settings.seed, index) + n_moves * BETWEEN_NS
        frame = SensorFrame(
            sequence=index,
            timestamp_ns=time_ns,
            depth_raw=self._depth_sensor.measure(depth.inverse_depth, depth.reflectance, index),
            color=self._color_sensor.take(station.color, index),
            color_timestamp_ns=time_ns,
        )
        calibration = true_calibration(self.device, station.depth_from_world)
        truth = truth_without_person(depth, calibration, wall=station.wall)
        return SimulatedFrame(frame, truth)

    def _drawn(self, number: int) -> _Station:
        settings, room = self.settings, self._room
        x_rad, y_rad, z_rad = self._turns_rad[number] + (settings.tilt_rad, 0.0, 0.0)
        rotation = np.eye(3)
        for axis, angle_rad in zip(np.eye(3), (x_rad, y_rad, z_rad), strict=True):
            rotation = about(axis, float(angle_rad)) @ rotation
        distance_m = settings.distances_m[number]
        eye_m = np.array([0.0, -settings.camera_height_m, room.back_m - distance_m])
        depth_from_world = RigidTransform(rotation, -rotation @ eye_m)
        color_from_world = self.device.calibration.color_from_depth @ depth_from_world
        none = MarkerSettings()
        color, _ = ColorStudio(room, color_from_world, self.device.color, self._illumination).view(
            None, None, none
        )
        towards = -depth_from_world.rotation[:, 2]
        return _Station(
            depth=DepthStudio(room, depth_from_world, self.device.depth).view(None, None, none),
            color=color,
            wall=Plane(towards, distance_m),
            depth_from_world=depth_from_world,
        )
