"""The simulated clinic's scenes: a patient before a sensor, frame by frame, with the truth.

A frame depends on its number and the scene's settings alone, so frames may be asked for in any
order and come out the same every time.
"""

import functools
import math
from dataclasses import dataclass, field, replace
from typing import Literal, TypeAlias, overload

import cv2
import numpy as np

from adibas.arrays import FloatArray, UInt8Array
from adibas.clock import NS_PER_S
from adibas.data.calibration import RgbdCalibration
from adibas.data.frames import EncodedImage, SensorFrame, SourceInfo
from adibas.geometry.planes import Plane
from adibas.geometry.rigid import RigidTransform
from adibas.simulation.boards_scenes import BoardScene, BoardSceneSettings
from adibas.simulation.boards_wall import WallScene, WallSceneSettings
from adibas.simulation.body import PosedBody
from adibas.simulation.body_shape import BodyShape
from adibas.simulation.color_noise import ColorNoise, ColorSensor
from adibas.simulation.depth_noise import DepthNoise, DepthSensor
from adibas.simulation.device import Device, draw_device
from adibas.simulation.frame_times import FRAME_RATE_HZ, check_index, frame_time_ns
from adibas.simulation.gestures import Gesture, gesture_names, perform
from adibas.simulation.light import Illumination, draw_illumination
from adibas.simulation.looks import Look, draw_look
from adibas.simulation.patient import SHAPES, MarkerSettings, Patient
from adibas.simulation.poses import Pose, View
from adibas.simulation.postures import POSTURES, random_sway
from adibas.simulation.room import Room, draw_room
from adibas.simulation.rotations import about
from adibas.simulation.studio import ColorStudio, DepthStudio
from adibas.simulation.truth import FrameTruth, MarkerTruth, SimulatedFrame

Mounting: TypeAlias = Literal["landscape", "portrait"]

BOARD, WALL = "board", "wall"
VIEWS: tuple[View, ...] = ("anterior", "posterior", "left_lateral", "right_lateral")

FIRST_STILL_S, TURN_S = 1.0, 10.0

_BOTH = ("left_", "right_")
VIEW_MARKERS: dict[str, tuple[str, ...]] = {
    "anterior": (
        "glabella",
        "sternal_notch",
        *(
            side + name
            for name in (
                "shoulder",
                "elbow",
                "wrist",
                "asis",
                "patella",
                "tibial_tuberosity",
            )
            for side in _BOTH
        ),
    ),
    "posterior": (
        "c7",
        "t4",
        "t10",
        "l4",
        *(
            side + name
            for name in ("inferior_scapula", "psis", "midleg", "achilles")
            for side in _BOTH
        ),
    ),
    **{
        f"{side}_lateral": (
            f"{side}_tragus",
            "c7",
            *(
                f"{side}_{name}"
                for name in (
                    "acromion",
                    "lateral_epicondyle",
                    "greater_trochanter",
                    "knee_joint_line",
                    "lateral_malleolus",
                )
            ),
        )
        for side in ("left", "right")
    },
}
"""Landmarks that a clinician marks for each view."""


@dataclass(frozen=True, slots=True)
class SceneSettings:
    """One scene; None means: drawn from the seed.

    Attributes
    ----------
    seed : int
        Of everything that is not set.
    view : str
        Side that the patient shows.
    posture : str
        One of `adibas.simulation.postures.POSTURES`.
    gesture : str or None
        Done over and over instead of standing in the posture.
    turn_s : float or None
        After a second the patient turns to the right, on the spot, once in so many seconds; None:
        the view stays.
    is_swaying : bool
        As living people do.
    has_patient : bool
        Else the room is empty.
    distance_m, camera_height_m, tilt_rad : float
        Of the sensor from the patient, above the floor, and its look downwards; at 2 m (thesis) a
        landscape image shows 1.6 m of the patient, at 2.6 m all.
    mounting : "landscape" or "portrait"
        Portrait: the sensor turned by 90 degrees to the right, so the image shows the patient
        lying with the head to the left.
    has_color : bool
        Else depth and labels alone, three times as fast; the truth then has no markers.
    color_size : (height, width)
        (1024, 1280) or (480, 640).
    markers : MarkerSettings
    shape, look : BodyShape, Look or None
    room, illumination : Room, Illumination or None
    depth_noise, color_noise : DepthNoise, ColorNoise
    device_seed : int or None
        Which sensor; None: the scene's seed.
    knows_bias : bool
        Whether the calibration handed out corrects the device's depth error.
    jpeg_quality : int or None
        Colour as JPEG of that quality, with colour at full resolution; None: as it is.
    color_delay_s : float
        By how much the colour is taken after the depth (PEERS: up to one frame).
    n_frames : int or None
        None: without end.
    """

    seed: int = 0
    view: View = "anterior"
    posture: str = "relaxed"
    gesture: str | None = None
    turn_s: float | None = None
    is_swaying: bool = True
    has_patient: bool = True
    distance_m: float = 2.0
    camera_height_m: float = 0.95
    tilt_rad: float = 0.0
    mounting: Mounting = "landscape"
    has_color: bool = True
    color_size: tuple[int, int] = (1024, 1280)
    markers: MarkerSettings = field(default_factory=MarkerSettings)
    shape: BodyShape | None = None
    look: Look | None = None
    room: Room | None = None
    illumination: Illumination | None = None
    depth_noise: DepthNoise = field(default_factory=DepthNoise)
    color_noise: ColorNoise = field(default_factory=ColorNoise)
    device_seed: int | None = None
    knows_bias: bool = True
    jpeg_quality: int | None = None
    color_delay_s: float = 0.0
    n_frames: int | None = None


class SimulatedScene:
    """A source of frames with truth.

    Attributes
    ----------
    settings : SceneSettings
    device : Device
    info : SourceInfo
        As a real sensor's, with the calibration.
    n_frames : int or None
        None: without end.
    depth_from_world : RigidTransform
        World axes: x to the image's right, y down, z away from the sensor; the patient stands
        at the origin on the floor y = 0.
    """

    def __init__(self, settings: SceneSettings) -> None:
        self.settings = settings
        seed = settings.seed
        rng = np.random.default_rng([seed, 0x5C])
        device_seed = seed if settings.device_seed is None else settings.device_seed
        self.device = draw_device(device_seed, settings.color_size)
        self.n_frames = settings.n_frames
        self.depth_from_world = depth_from_world = _sensor_pose(settings)
        color_from_depth = self.device.calibration.color_from_depth
        room = settings.room or draw_room(rng)
        illumination = settings.illumination or draw_illumination(rng)
        shape = settings.shape or SHAPES[seed % len(SHAPES)]
        look = settings.look or draw_look(rng, shape.sex)
        self._patient = _patient(shape, look) if settings.has_patient else None
        self._sway = random_sway(rng) if settings.is_swaying else None
        self._gesture = perform(settings.gesture, seed) if settings.gesture else None
        self._depth_studio = DepthStudio(room, depth_from_world, self.device.depth)
        self._depth_sensor = DepthSensor(self.device, settings.depth_noise, seed)
        self._color_studio = self._color_sensor = None
        if settings.has_color:
            camera = self.device.color
            color_from_world = color_from_depth @ depth_from_world
            self._color_studio = ColorStudio(room, color_from_world, camera, illumination)
            self._color_sensor = ColorSensor(camera, settings.color_noise, illumination, seed)
        self.info = SourceInfo(
            depth_unit_m=self.device.calibration.depth_unit_m,
            frame_rate_hz=FRAME_RATE_HZ,
            sensor_name="ADiBAS simulator",
            sensor_serial=self.device.calibration.sensor_serial,
            calibration=_handed_out(self.device, depth_from_world, settings),
        )

    def frame(self, index: int) -> SimulatedFrame:
        """Return frame number `index`, from 0.

        Raises
        ------
        IndexError
            The scene has no such frame.
        """
        check_index(index, self.n_frames)
        timestamp_ns = self._timestamp_ns(index)
        posed = self._posed(timestamp_ns)
        view = self._depth_studio.view(self._patient, posed, self.settings.markers)
        depth_raw = self._depth_sensor.measure(
            view.inverse_depth, view.reflectance, index, self._holes(posed)
        )
        color_timestamp_ns = timestamp_ns + round(1e9 * self.settings.color_delay_s)
        posed_later = posed if self.settings.color_delay_s == 0 else self._posed(color_timestamp_ns)
        color, markers = self._color(posed_later, index)
        joints_m = self._joints_m(posed)
        calibration = self.device.calibration
        truth = FrameTruth(
            joints_m=joints_m,
            joints_color_m=calibration.color_from_depth.apply(joints_m),
            markers=markers,
            labels=view.labels,
            depth_m=1.0 / view.inverse_depth,
            calibration=calibration,
        )
        sensor_frame = SensorFrame(
            sequence=index,
            timestamp_ns=timestamp_ns,
            depth_raw=depth_raw,
            color=color,
            color_timestamp_ns=None if color is None else color_timestamp_ns,
        )
        return SimulatedFrame(sensor_frame, truth)

    def _color(
        self, posed: PosedBody | None, index: int
    ) -> tuple[UInt8Array | EncodedImage | None, tuple[MarkerTruth, ...]]:
        if self._color_studio is None or self._color_sensor is None:
            return None, ()
        linear, markers = self._color_studio.view(self._patient, posed, self.settings.markers)
        picture = self._color_sensor.take(linear, index)
        quality = self.settings.jpeg_quality
        if quality is None:
            return picture, markers
        flags = [
            *(cv2.IMWRITE_JPEG_QUALITY, quality),
            *(cv2.IMWRITE_JPEG_SAMPLING_FACTOR, cv2.IMWRITE_JPEG_SAMPLING_FACTOR_444),
        ]
        _, payload = cv2.imencode(".jpg", picture[..., ::-1], flags)
        return EncodedImage("jpeg", payload.tobytes()), markers

    def person(self, index: int) -> tuple[Patient, PosedBody]:
        """Return the patient and how the body stands in frame `index`, in world axes.

        Raises
        ------
        ValueError
            The room is empty.
        """
        posed = self._posed(self._timestamp_ns(index))
        if self._patient is None or posed is None:
            raise ValueError("the room is empty")
        return self._patient, posed

    def _timestamp_ns(self, index: int) -> int:
        return frame_time_ns(self.settings.seed, index)

    def _posed(self, timestamp_ns: int) -> PosedBody | None:
        if self._patient is None:
            return None
        time_s = timestamp_ns / NS_PER_S
        pose = _pose(self._gesture, self.settings.posture, time_s)
        if self._sway is not None:
            pose = self._sway.applied(pose, time_s)
        return self._patient.body.posed(self._headed(pose, time_s))

    def _headed(self, pose: Pose, time_s: float) -> Pose:
        facing = pose.facing(self.settings.view)
        if self.settings.turn_s is None:
            return facing
        turns = max(time_s - FIRST_STILL_S, 0.0) / self.settings.turn_s
        return replace(facing, heading_rad=facing.heading_rad + 2.0 * math.pi * turns)

    def _joints_m(self, posed: PosedBody | None) -> FloatArray:
        if posed is None:
            return np.full((15, 3), np.nan)
        return self.depth_from_world.apply(posed.joints_m)

    def _holes(self, posed: PosedBody | None) -> FloatArray | None:
        """Return u, v and radius in the depth image of markers that reflect no pattern."""
        markers = self.settings.markers
        if self._patient is None or posed is None or markers.hole_radius_m == 0.0:
            return None
        points, normals = self._patient.places(posed, markers)
        points = self.depth_from_world.apply(points)
        normals = normals @ self.depth_from_world.rotation.T
        points = points[np.einsum("ij,ij->i", points, normals) < 0]
        k = self.device.depth.intrinsics
        z_m = points[:, 2]
        u, v = k.fx * points[:, 0] / z_m + k.cx, k.fy * points[:, 1] / z_m + k.cy
        return np.stack([u, v, k.fx * markers.hole_radius_m / z_m], axis=1)


def scene_names() -> tuple[str, ...]:
    """Return the names that `open_scene` knows: the clinic's, and two to calibrate with."""
    return (*_scenes(), BOARD, WALL)


# Whoever has a name that the type checker does not know takes any scene as one with a patient.
@overload
def open_scene(  # type: ignore[overload-overlap]
    name: Literal["board"], seed: int = 0, **changes: object
) -> BoardScene: ...


@overload
def open_scene(  # type: ignore[overload-overlap]
    name: Literal["wall"], seed: int = 0, **changes: object
) -> WallScene: ...


@overload
def open_scene(name: str, seed: int = 0, **changes: object) -> SimulatedScene: ...


def open_scene(
    name: str, seed: int = 0, **changes: object
) -> SimulatedScene | BoardScene | WallScene:
    """Return the scene `name`, with the patient, room, light and sensor of `seed`.

    `changes` replace fields of its `SceneSettings`; those of ``board`` and ``wall`` are
    `BoardSceneSettings` and `WallSceneSettings`.

    Raises
    ------
    KeyError
        There is no such scene.
    """
    if name == BOARD:
        return BoardScene(replace(BoardSceneSettings(seed), **changes))  # type: ignore[arg-type]
    if name == WALL:
        return WallScene(replace(WallSceneSettings(seed), **changes))  # type: ignore[arg-type]
    settings = _scenes()[name]
    return SimulatedScene(replace(settings, seed=seed, **changes))  # type: ignore[arg-type]


@functools.cache
def _scenes() -> dict[str, SceneSettings]:
    scenes: dict[str, SceneSettings] = {}
    for view in VIEWS:
        settings = SceneSettings(view=view, markers=MarkerSettings(VIEW_MARKERS[view]))
        scenes[view] = settings
        scenes[f"{view}_led"] = replace(
            settings, markers=replace(settings.markers, kind="led", diameter_m=0.005)
        )
    scenes["standing"] = scenes["anterior"]
    for gesture in gesture_names():
        scenes[gesture] = SceneSettings(gesture=gesture, distance_m=2.7)
    scenes["turn"] = replace(scenes["posterior"], turn_s=TURN_S, mounting="portrait")
    scenes["empty"] = SceneSettings(has_patient=False)
    return scenes


@functools.lru_cache(maxsize=8)
def _patient(shape: BodyShape, look: Look) -> Patient:
    return Patient.dressed(shape, look)


def _pose(gesture: Gesture | None, posture: str, time_s: float) -> Pose:
    if gesture is None:
        return POSTURES[posture].pose()
    return gesture.pose((time_s - FIRST_STILL_S) % (gesture.duration_s + 0.5))


def _sensor_pose(settings: SceneSettings) -> RigidTransform:
    """Return depth_from_world."""
    rotation = about(np.array([1.0, 0.0, 0.0]), settings.tilt_rad)
    if settings.mounting == "portrait":
        rotation = about(np.array([0.0, 0.0, 1.0]), -math.pi / 2) @ rotation
    eye_m = np.array([0.0, -settings.camera_height_m, -settings.distance_m])
    return RigidTransform(rotation, -rotation @ eye_m)


def _handed_out(
    device: Device, depth_from_world: RigidTransform, settings: SceneSettings
) -> RgbdCalibration:
    calibration = device.calibration
    if not settings.knows_bias:
        calibration = device.without_bias_correction()
    up = -depth_from_world.rotation[:, 1]
    floor = Plane(up, float(settings.camera_height_m))
    return replace(calibration, gravity=-up, floor=floor)
