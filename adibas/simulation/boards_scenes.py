"""What a sensor sees while it is calibrated: someone carries a board about before it.

See `adibas.simulation.boards_device` for the sensor, and for the calibration that it hands out.
"""

from dataclasses import dataclass, field, replace

import numpy as np

from adibas.arrays import FloatArray, UInt8Array
from adibas.clock import NS_PER_S
from adibas.data.board import Board
from adibas.data.frames import SensorFrame
from adibas.data.printed_boards import PRINTED_BOARDS
from adibas.geometry.rigid import RigidTransform
from adibas.simulation.boards import visible_corners
from adibas.simulation.boards_depth import lay_strokes, see_boards, seen_from
from adibas.simulation.boards_device import (
    factory_info,
    true_calibration,
    truth_without_person,
    uncalibrated_device,
)
from adibas.simulation.boards_look import BoardLook, BoardView
from adibas.simulation.boards_painting import lay_board, lay_figure
from adibas.simulation.boards_person import figure, holding_hands
from adibas.simulation.boards_walk import Walk, WalkHabits
from adibas.simulation.color_noise import ColorNoise, ColorSensor
from adibas.simulation.depth_noise import DepthNoise, DepthSensor
from adibas.simulation.frame_times import FIRST_FRAME_NS, check_index, frame_time_ns
from adibas.simulation.light import Illumination, draw_illumination, lamp_position_m
from adibas.simulation.looks import linear_from_srgb
from adibas.simulation.patient import MarkerSettings
from adibas.simulation.room import Room, draw_room, see_room
from adibas.simulation.studio import FILL, TARGET_M, ColorStudio, DepthView
from adibas.simulation.truth import BoardTruth, SimulatedFrame


@dataclass(frozen=True, slots=True)
class BoardSceneSettings:
    """The scene with the board; what is None is drawn from the seed.

    Attributes
    ----------
    seed : int
    board : Board
    has_marks : bool
        See `BoardView`.
    margin_squares : float
    careless_every : int
        At every so many stops a thumb hides some corners.
    walk : WalkHabits
    exposure_s : float
        Of the colour camera, in which the board moves (assumed).
    color_size : (height, width)
        (1024, 1280) or (480, 640).
    room, illumination : Room, Illumination or None
    depth_noise, color_noise : DepthNoise, ColorNoise
    device_seed : int or None
        Which sensor; None: the scene's seed.
    distance_m, camera_height_m : float
        Of the sensor from the room's origin, and above the floor.
    n_frames : int or None
        None: without end.
    """

    seed: int = 0
    board: Board = PRINTED_BOARDS["A0"].board
    has_marks: bool = True
    margin_squares: float = 0.6
    careless_every: int = 5
    walk: WalkHabits = field(default_factory=WalkHabits)
    exposure_s: float = 1.0 / 60.0
    color_size: tuple[int, int] = (1024, 1280)
    room: Room | None = None
    illumination: Illumination | None = None
    depth_noise: DepthNoise = field(default_factory=DepthNoise)
    color_noise: ColorNoise = field(default_factory=ColorNoise)
    device_seed: int | None = None
    distance_m: float = 2.0
    camera_height_m: float = 1.1
    n_frames: int | None = None


class BoardScene:
    """A source of frames with a board in them, and with truth; see `SimulatedScene`."""

    def __init__(self, settings: BoardSceneSettings) -> None:
        self.settings = settings
        device_seed = settings.seed if settings.device_seed is None else settings.device_seed
        self.device = uncalibrated_device(device_seed, settings.color_size)
        self.n_frames = settings.n_frames
        self.info = factory_info(self.device)
        rng = np.random.default_rng([settings.seed, 0xB0])
        room = settings.room or replace(draw_room(rng), back_m=1.9, chair=None)
        self._illumination = settings.illumination or draw_illumination(rng)
        eye_m = np.array([0.0, -settings.camera_height_m, -settings.distance_m])
        self.depth_from_world = RigidTransform(np.eye(3), -eye_m)
        self._color_from_world = self.device.calibration.color_from_depth @ self.depth_from_world
        self.walk = Walk(settings.board, self.device.color, rng, settings.walk)
        self._empty_depth = see_room(room, self.depth_from_world, self.device.depth)
        studio = ColorStudio(room, self._color_from_world, self.device.color, self._illumination)
        self._empty_color, _ = studio.view(None, None, MarkerSettings())
        seed, illumination = settings.seed, self._illumination
        self._depth_sensor = DepthSensor(self.device, settings.depth_noise, seed)
        self._color_sensor = ColorSensor(
            self.device.color, settings.color_noise, illumination, seed
        )
        self._truth = true_calibration(self.device, self.depth_from_world)

    def frame(self, index: int) -> SimulatedFrame:
        """Return frame number `index`, from 0.

        Raises
        ------
        IndexError
            The scene has no such frame.
        """
        check_index(index, self.n_frames)
        time_ns = frame_time_ns(self.settings.seed, index)
        time_s = (time_ns - FIRST_FRAME_NS) / NS_PER_S
        view = self._view(time_s)
        depth = self._depth_view(view)
        frame = SensorFrame(
            sequence=index,
            timestamp_ns=time_ns,
            depth_raw=self._depth_sensor.measure(depth.inverse_depth, depth.reflectance, index),
            color=self._picture(view, time_s, index),
            color_timestamp_ns=time_ns,
        )
        board = BoardTruth(
            board=view.board,
            camera_from_board=view.camera_from_board,
            corners_px=visible_corners(view, self.device.color),
            station=self.walk.station_at(time_s),
        )
        return SimulatedFrame(frame, truth_without_person(depth, self._truth, board=board))

    def _view(self, time_s: float) -> BoardView:
        settings = self.settings
        n_stops = self.walk.last_station(time_s)
        is_careless = n_stops % settings.careless_every == settings.careless_every - 1
        return BoardView(
            settings.board,
            self.walk.pose_at(time_s),
            has_marks=settings.has_marks,
            margin_squares=settings.margin_squares,
            hands=holding_hands(settings.board, settings.margin_squares, is_careless=is_careless),
        )

    def _depth_view(self, view: BoardView) -> DepthView:
        camera = self.device.depth
        depth_from_color = self.device.calibration.color_from_depth.inverse()
        world_from_board = self._color_from_world.inverse() @ view.camera_from_board
        world_from_plane, strokes, _ = figure(
            world_from_board, view.board, self.settings.margin_squares
        )
        behind = replace(
            self._empty_depth,
            inverse_depth=self._empty_depth.inverse_depth.copy(),
            infrared=self._empty_depth.infrared.copy(),
        )
        images = (behind.inverse_depth, behind.infrared)
        lay_strokes(self.depth_from_world @ world_from_plane, strokes, camera, images)
        return see_boards((seen_from(view, depth_from_color),), camera, behind)

    def _picture(self, view: BoardView, time_s: float, index: int) -> UInt8Array:
        camera = self.device.color
        linear = self._empty_color.copy()
        world_from_board = self._color_from_world.inverse() @ view.camera_from_board
        world_from_plane, strokes, srgb = figure(
            world_from_board, view.board, self.settings.margin_squares
        )
        light = self._light(world_from_plane, np.array([0.0, -1.2, 0.0]))
        albedo = linear_from_srgb(srgb)
        lay_figure(
            linear, camera, self._color_from_world @ world_from_plane, strokes, albedo * light
        )
        look = BoardLook(motion_px=self._motion_px(view, time_s))
        middle_m = view.board.points_m().mean(axis=0)
        brightness = self._light(world_from_board, middle_m)
        lay_board(linear, view, camera, replace(look, exposure=look.paper * brightness))
        return self._color_sensor.take(linear, index)

    def _light(self, world_from_plane: RigidTransform, place_m: FloatArray) -> float:
        """Return how bright white is at a place of a plane, as the room around it is lit."""
        light = self._illumination
        place_m = world_from_plane.apply(place_m)
        to_lamp_m = lamp_position_m(light, TARGET_M) - place_m
        distance_m = float(np.linalg.norm(to_lamp_m))
        normal = -world_from_plane.rotation[:, 2]
        facing = max(float(normal @ to_lamp_m) / distance_m, 0.0)
        direct = (1.0 - light.ambient) * (light.lamp_m / distance_m) ** 2 * facing
        around = light.ambient * (0.775 - 0.225 * float(normal[1]))
        return direct + around + FILL * max(-float(normal[2]), 0.0)

    def _motion_px(self, view: BoardView, time_s: float) -> tuple[float, float]:
        if self.walk.station_at(time_s) is not None:
            return (0.0, 0.0)
        middle_m = view.board.points_m().mean(axis=0)
        half_s = 0.5 * self.settings.exposure_s
        k = self.device.color.intrinsics
        ends = np.array(
            [self.walk.pose_at(time_s + step).apply(middle_m) for step in (-half_s, half_s)]
        )
        pixels = ends[:, :2] / ends[:, 2:] * (k.fx, k.fy)
        du, dv = pixels[1] - pixels[0]
        return (float(du), float(dv))
