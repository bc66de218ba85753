"""One simulated calibration of a depth camera, with its truth.

Each calibration has a device of its own, a person who holds a board at some places, corners with
noise, and bursts of 30 depth images. The burst's mean is drawn directly: noise and fixed pattern
of the simulated sensor (docs/simulation.md), averaged; `burst_of_frames` draws every frame.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import cv2
import numpy as np

from adibas.arrays import Float32Array, FloatArray
from adibas.calibration.depth_bias import camera_covariance, color_covariance, with_depth
from adibas.calibration.extrinsics import DepthFit, DepthFitParams, DepthStart, fit_depth
from adibas.calibration.extrinsics_model import camera_numbers
from adibas.calibration.extrinsics_pose import find_pose
from adibas.calibration.shots import BoardShot, WallShot, cells_on_board, cells_on_wall
from adibas.data.board import Board, BoardCorners
from adibas.data.calibration import CameraCalibration, DepthBias, RgbdCalibration
from adibas.data.surface import BurstDisparity
from adibas.geometry.distortion import pixel_rays, project_distorted
from adibas.geometry.pinhole import Intrinsics
from adibas.geometry.rigid import RigidTransform, rotation_from_vector, rotation_vector
from adibas.pipeline.calibrating_depth_types import DepthCalibratingParams
from adibas.simulation.depth_noise import SUBPIXELS, DepthNoise, DepthSensor
from adibas.simulation.device import Device, DeviceSpread

N_FRAMES = 30
FACTORY = RigidTransform(np.eye(3), np.array([-0.025, 0.0, 0.0]))
DEPTH_FOCAL_SD, DEPTH_CENTRE_SD_PX = 0.01, 6.0
"""How well the maker's calibration of the depth camera holds."""

DISTANCES_M = (0.8, 3.5)
BOARD = Board(columns=9, rows=6, square_m=0.04)
"""On A3."""

LARGE_BOARD = Board(columns=10, rows=7, square_m=0.105)
"""The thesis' 115.5 x 84 cm."""

SPREAD = DeviceSpread(bias_of_border_m=0.003)
"""Of devices whose depth also bends towards the image's border."""
COLOR_SDS = {"fx": 0.4, "fy": 0.4, "cx": 0.5, "cy": 0.5, "k1": 1e-3, "k2": 4e-3}
"""Of the colour calibration, pixels and none: as some 25 images of an A3 board leave it whose
corners have a noise of 0.06 pixels; in proportion with less."""


@dataclass(frozen=True, slots=True)
class Setting:
    """How a calibration is taken.

    Attributes
    ----------
    board : Board
        That is held.
    n_boards, n_walls : int
        Shots.
    tilt_rad : float
        Largest angle of the board: 45 degrees, as docs/calibration.md asks for. With 0.6 the errors
        are up to twice as large: the shift between the cameras along z and the offset of the depth
        differ by what they do to tilted boards beside the middle.
    corner_sd_px : float
        Noise of the corners: 0.06 at most is the goal; 0.03 is what noisy pictures have
        (`calibration_corners`), good ones a quarter of it.
    shift_sd_m : float or None
        See `DepthFitParams`; the default is that of `adibas calibrate`.
    has_color_error : bool
        The colour camera's calibration is wrong by as much as its covariance says.
    has_depth_error : bool
        Of the depth camera only the maker's calibration is known, and refined.
    """

    board: Board = BOARD
    n_boards: int = 25
    n_walls: int = 0
    tilt_rad: float = 0.8
    corner_sd_px: float = 0.06
    shift_sd_m: float | None = DepthCalibratingParams().shift_sd_m
    has_color_error: bool = True
    has_depth_error: bool = True


def true_inverse(
    device: Device, plane: FloatArray, board: Board | None, depth_from_board: RigidTransform | None
) -> Float32Array:
    """Return the (H, W) true 1/z of a wall, or of a board with nothing behind (0)."""
    rays = rays_of(device.depth)
    inverse = rays @ plane
    if board is not None and depth_from_board is not None:
        with np.errstate(divide="ignore", invalid="ignore"):
            points_m = depth_from_board.inverse().apply(rays / inverse[..., None])
        side = board.square_m
        x, y = points_m[..., 0], points_m[..., 1]
        is_on = (x > -side) & (x < board.columns * side) & (y > -side) & (y < board.rows * side)
        inverse = np.where(is_on & (inverse > 0), inverse, 0.0)
    return np.ascontiguousarray(np.maximum(inverse, 0.0), np.float32)


def rays_of(camera: CameraCalibration) -> FloatArray:
    """Return the (H, W, 3) viewing rays (x/z, y/z, 1) of all pixels."""
    rays = pixel_rays((camera.height, camera.width), camera.intrinsics, camera.distortion)
    return np.concatenate([rays, np.ones((*rays.shape[:2], 1))], axis=-1)


def measured_inverse(true_per_m: Float32Array, device: Device) -> FloatArray:
    """Return what the device measures of a true 1/z without any noise; NaN where nothing is."""
    bias = device.calibration.depth_bias
    with np.errstate(divide="ignore", invalid="ignore"):
        true_m = np.where(true_per_m > 0, 1.0 / true_per_m.astype(float), np.nan)
    square = bias.square_term_per_m(device.depth).astype(float)
    root = np.sqrt(bias.b**2 + 4.0 * square * (true_m - bias.a))
    return np.asarray((bias.b + root) / (2.0 * (true_m - bias.a)))


def _field(device: Device, noise: DepthNoise, rng: np.random.Generator) -> FloatArray:
    """Return a field of standard deviation 1 with the sensor's window."""
    across, down = noise.window_px
    shape = (device.depth.height + down, device.depth.width + across)
    white = cv2.blur(rng.standard_normal(shape, np.float32), (across, down))
    inner = white[: device.depth.height, : device.depth.width]
    return np.asarray(inner * np.sqrt(across * down), float)


def burst_mean(
    true_per_m: Float32Array, device: Device, rng: np.random.Generator
) -> BurstDisparity:
    """Return the mean of a burst, drawn at once: rounding is dithered by the noise."""
    noise = DepthNoise()
    weights = np.array(noise.temporal_weights)
    # A mean of many frames sees the noise as if its weights came one by one.
    factor = weights.sum() / np.sqrt((weights**2).sum())
    sd = noise.disparity_sd * factor / np.sqrt(N_FRAMES)
    rounding = np.sqrt(1.0 / 12.0 / N_FRAMES)
    pattern = _field(device, noise, np.random.default_rng([device.seed, 0xF1]))
    disparity = noise.static_sd * pattern + sd * _field(device, noise, rng)
    disparity += rounding * rng.standard_normal(disparity.shape)
    steps = SUBPIXELS * noise.projector_baseline_m * device.depth.intrinsics.fx
    mean = (measured_inverse(true_per_m, device) + disparity / steps).astype(np.float32)
    return BurstDisparity(mean, np.isfinite(mean).astype(np.int64) * N_FRAMES, N_FRAMES)


def burst_of_frames(true_per_m: Float32Array, device: Device, seed: int) -> BurstDisparity:
    """Return the mean of a burst of which every frame is simulated."""
    sensor = DepthSensor(device, DepthNoise(), seed)
    reflectance = np.full(true_per_m.shape, 0.6, np.float32)
    total, n = np.zeros(true_per_m.shape), np.zeros(true_per_m.shape, np.int64)
    for moment in range(N_FRAMES):
        raw = sensor.measure(true_per_m, reflectance, moment)
        is_seen = raw > 0
        total[is_seen] += 1000.0 / raw[is_seen]
        n += is_seen
    with np.errstate(invalid="ignore"):
        mean = np.where(n >= 0.3 * N_FRAMES, total / n, np.nan).astype(np.float32)
    return BurstDisparity(mean, n, N_FRAMES)


def board_poses(
    device: Device, setting: Setting, rng: np.random.Generator
) -> Iterator[RigidTransform]:
    """Give ``color_from_board`` of places all over the picture, wholly in view of both cameras."""
    board, color = setting.board, device.color
    middle = 0.5 * np.array([board.columns - 1, board.rows - 1, 0.0]) * board.square_m
    outline = board.points_m()[[0, board.columns - 1, -board.columns, -1]]
    while True:
        distance_m = 1.0 / rng.uniform(1.0 / DISTANCES_M[1], 1.0 / DISTANCES_M[0])
        turn = rotation_from_vector(np.array([0.0, 0.0, rng.uniform(-0.4, 0.4)]))
        axis = rng.uniform(-np.pi, np.pi)
        lean = setting.tilt_rad * np.sqrt(rng.uniform())
        tilt = rotation_from_vector(lean * np.array([np.cos(axis), np.sin(axis), 0.0]))
        rotation = tilt @ turn
        k = color.intrinsics
        pixel = rng.uniform((0.0, 0.0), (color.width, color.height))
        centre_m = distance_m * np.array([(pixel[0] - k.cx) / k.fx, (pixel[1] - k.cy) / k.fy, 1.0])
        pose = RigidTransform(rotation, centre_m - rotation @ middle)
        if _is_in_view(pose, outline, device):
            yield pose


def _is_in_view(pose: RigidTransform, outline_m: FloatArray, device: Device) -> bool:
    corners_m = pose.apply(outline_m)
    depth_m = device.calibration.color_from_depth.inverse().apply(corners_m)
    for camera, points_m in ((device.color, corners_m), (device.depth, depth_m)):
        pixels = project_distorted(points_m, camera.intrinsics, camera.distortion)
        limit = np.array([camera.width - 1, camera.height - 1])
        if not ((pixels > 4) & (pixels < limit - 4)).all():
            return False
    return True


def noisy_corners(
    pose: RigidTransform, setting: Setting, camera: CameraCalibration, rng: np.random.Generator
) -> BoardCorners:
    """Return the corners as a finder gives them."""
    board = setting.board
    pixels = project_distorted(pose.apply(board.points_m()), camera.intrinsics, camera.distortion)
    pixels = pixels + rng.normal(0.0, setting.corner_sd_px, pixels.shape)
    sigmas = np.full(board.n_corners, 0.05)
    return BoardCorners("board", camera.width, camera.height, pixels, sigmas)


@dataclass(frozen=True, slots=True, eq=False)
class Trial:
    """One calibration and the truth."""

    device: Device
    fit: DepthFit
    color: CameraCalibration
    color_names: tuple[str, ...]
    color_covariance: FloatArray

    @property
    def calibration(self) -> RgbdCalibration:
        """What the user has then: both cameras and the covariance of all."""
        color = RgbdCalibration(
            color=self.color,
            depth_unit_m=self.device.calibration.depth_unit_m,
            parameter_names=tuple(f"color.{name}" for name in self.color_names),
            covariance=self.color_covariance,
        )
        return with_depth(color, self.fit)

    @property
    def covariance(self) -> FloatArray:
        """Of the fit's parameters, the colour camera's error included."""
        return camera_covariance(self.fit, self.color_names, self.color_covariance)

    def errors(self) -> FloatArray:
        """Return estimated minus true parameters."""
        truth = self.device.calibration
        turn = self.fit.color_from_depth.rotation @ truth.color_from_depth.rotation.T
        shift_m = self.fit.color_from_depth.translation_m - truth.color_from_depth.translation_m
        bias = _bias_numbers(self.fit.bias) - _bias_numbers(truth.depth_bias)
        all_errors = [rotation_vector(turn), shift_m, bias]
        if len(self.fit.parameter_names) > sum(len(part) for part in all_errors):
            all_errors.append(camera_numbers(self.fit.camera) - camera_numbers(self.device.depth))
        return np.concatenate(all_errors)


def factory_depth(camera: CameraCalibration) -> CameraCalibration:
    """Return what the maker says of all depth cameras of this kind."""
    middle = Intrinsics(580.0, 580.0, 0.5 * (camera.width - 1), 0.5 * (camera.height - 1))
    return replace(camera, intrinsics=middle)


def _bias_numbers(bias: DepthBias) -> FloatArray:
    return np.array([bias.a, bias.b, bias.c, *bias.image_term, *[0.0] * 5])[:8]


def wrong_color(
    camera: CameraCalibration, corner_sd_px: float, rng: np.random.Generator
) -> tuple[CameraCalibration, tuple[str, ...], FloatArray]:
    """Return a camera that is wrong by what the covariance beside it says."""
    names = tuple(COLOR_SDS)
    sds = np.array(list(COLOR_SDS.values())) * corner_sd_px / Setting().corner_sd_px
    correlation = np.eye(len(sds))
    correlation[0, 1] = correlation[1, 0] = 0.95
    correlation[4, 5] = correlation[5, 4] = -0.8
    covariance = correlation * np.outer(sds, sds)
    dfx, dfy, dcx, dcy, dk1, dk2 = rng.multivariate_normal(np.zeros(len(sds)), covariance)
    k = camera.intrinsics
    lens = (camera.distortion[0] + dk1, camera.distortion[1] + dk2, *camera.distortion[2:])
    moved = replace(k, fx=k.fx + dfx, fy=k.fy + dfy, cx=k.cx + dcx, cy=k.cy + dcy)
    return (
        replace(camera, intrinsics=moved, distortion=tuple(float(v) for v in lens)),
        names,
        covariance,
    )


def run_trial(device: Device, setting: Setting, *, is_frame_by_frame: bool = False) -> Trial:
    """Calibrate a device; its seed draws the boards and the noise."""
    rng = np.random.default_rng([device.seed, 0xCA])
    names: tuple[str, ...] = ()
    color, covariance = device.color, np.zeros((0, 0))
    if setting.has_color_error:
        color, names, covariance = wrong_color(device.color, setting.corner_sd_px, rng)
    camera, params = device.depth, DepthFitParams(shift_sd_m=setting.shift_sd_m)
    if setting.has_depth_error:
        camera = factory_depth(device.depth)
        params = replace(params, focal_sd=DEPTH_FOCAL_SD, centre_sd_px=DEPTH_CENTRE_SD_PX)

    def burst(inverse: Float32Array, number: int) -> BurstDisparity:
        if is_frame_by_frame:
            return burst_of_frames(inverse, device, 1000 * device.seed + number)
        return burst_mean(inverse, device, rng)

    boards = _boards(device, (color, camera), setting, rng, burst)
    walls = _walls(device, setting, rng)
    first = DepthStart(camera, color_covariance=color_covariance(names, covariance))
    fit = fit_depth(first, boards, walls, FACTORY, params)
    return Trial(device, fit, color, names, covariance)


def _boards(
    device: Device,
    cameras: tuple[CameraCalibration, CameraCalibration],
    setting: Setting,
    rng: np.random.Generator,
    burst: Callable[[Float32Array, int], BurstDisparity],
) -> list[BoardShot]:
    color, camera = cameras
    boards: list[BoardShot] = []
    depth_from_color = device.calibration.color_from_depth.inverse()
    for number, true_pose in enumerate(board_poses(device, setting, rng)):
        if len(boards) == setting.n_boards:
            break
        depth_from_board = depth_from_color @ true_pose
        normal = depth_from_board.rotation[:, 2]
        plane = normal / (normal @ depth_from_board.translation_m)
        inverse = true_inverse(device, plane, setting.board, depth_from_board)
        corners = noisy_corners(true_pose, setting, device.color, rng)
        pose = find_pose(corners, setting.board, color)
        if pose is None:
            continue
        expected = FACTORY.inverse() @ pose.camera_from_board
        cells = cells_on_board(burst(inverse, number), camera, setting.board, expected)
        if cells is not None:
            boards.append(BoardShot(f"board {number}", pose, cells))
    return boards


def _walls(device: Device, setting: Setting, rng: np.random.Generator) -> list[WallShot]:
    camera = factory_depth(device.depth) if setting.has_depth_error else device.depth
    walls = []
    for number in range(setting.n_walls):
        distance_m = np.linspace(*DISTANCES_M, setting.n_walls)[number]
        normal = rotation_from_vector(rng.normal(0.0, 0.1, 3)) @ np.array([0.0, 0.0, 1.0])
        inverse = true_inverse(device, normal / distance_m, None, None)
        cells = cells_on_wall(burst_mean(inverse, device, rng), camera)
        if cells is not None:
            walls.append(WallShot(f"wall {number}", cells))
    return walls
