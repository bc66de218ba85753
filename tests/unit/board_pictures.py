"""Pictures of a board before a small camera, as the live view gives them."""

from dataclasses import replace
from functools import cache

import numpy as np

from adibas.calibration.kept import KeptCalibrations
from adibas.data.board import Board
from adibas.data.calibration import CameraCalibration, DepthBias, RgbdCalibration
from adibas.data.frames import SensorFrame, SourceInfo
from adibas.geometry.pinhole import Intrinsics
from adibas.geometry.rigid import RigidTransform
from adibas.pipeline.acquisition import Arrival
from adibas.pipeline.calibration_session import CalibrationSession
from adibas.pipeline.looking import Look, Looker
from adibas.pipeline.sensor_calibration import CalibratedSensor
from adibas.simulation.boards import render_board
from adibas.simulation.boards_look import BoardLook
from adibas.simulation.boards_poses import random_board_poses

BOARD = Board(9, 6, 0.03)
CAMERA = CameraCalibration(640, 480, Intrinsics(525.0, 524.0, 318.0, 241.0), (0.05, -0.1, 0.0, 0.0))
DEPTH = CameraCalibration(320, 240, Intrinsics(285.0, 285.0, 159.5, 119.5))
COLOR_FROM_DEPTH = RigidTransform(np.eye(3), np.array([-0.026, 0.001, 0.002]))
BIAS = DepthBias(-0.004, 1.01, 0.002)
MAKERS = RgbdCalibration(
    color=CameraCalibration(640, 480, Intrinsics(530.0, 530.0, 319.5, 239.5)),
    depth=DEPTH,
    color_from_depth=RigidTransform(np.eye(3), np.array([-0.025, 0.0, 0.0])),
    sensor_serial="SN1",
)
WALL_M = 2.5
MARGIN_SQUARES = 1.0
INFO = SourceInfo(sensor_name="S", sensor_serial="SN1", calibration=MAKERS)
SENSOR = CalibratedSensor("SN1", (640, 480), INFO)
N_POSES = 12
NS = 1_000_000_000


@cache
def poses():
    """Return where a careful user holds the board."""
    return tuple(random_board_poses(np.random.default_rng(4), BOARD, CAMERA, N_POSES))


@cache
def picture(index, *, motion_px=(0.0, 0.0), is_mirrored=False):
    """Return the picture of one of `poses`."""
    look = BoardLook(motion_px=motion_px, is_mirrored=is_mirrored)
    rng = np.random.default_rng(index)
    return render_board(BOARD, poses()[index], CAMERA, rng, look, in_color=True).image


@cache
def depth_raw(index):
    """Return the depth of the board in that pose, and of a wall behind, as a device errs."""
    depth_from_board = COLOR_FROM_DEPTH.inverse() @ poses()[index]
    k = DEPTH.intrinsics
    v, u = np.indices((DEPTH.height, DEPTH.width))
    rays = np.stack([(u - k.cx) / k.fx, (v - k.cy) / k.fy, np.ones(u.shape)], axis=-1)
    normal = depth_from_board.rotation[:, 2]
    board_m = normal @ depth_from_board.translation_m / (rays @ normal)
    x_m, y_m, _ = np.moveaxis(depth_from_board.inverse().apply(rays * board_m[..., None]), -1, 0)
    side_m = BOARD.square_m
    is_board = (
        (
            np.abs(x_m - (BOARD.columns - 1) / 2 * side_m)
            < (BOARD.columns + 1 + 2 * MARGIN_SQUARES) / 2 * side_m
        )
        & (
            np.abs(y_m - (BOARD.rows - 1) / 2 * side_m)
            < (BOARD.rows + 1 + 2 * MARGIN_SQUARES) / 2 * side_m
        )
        & (board_m > 0)
    )
    true_m = np.where(is_board, board_m, WALL_M)
    # BIAS takes what is measured to what is true: the other way round it is a root.
    half = BIAS.b / (2.0 * BIAS.c)
    measured_m = -half + np.sqrt(half**2 + (true_m - BIAS.a) / BIAS.c)
    noise_m = np.random.default_rng(index).normal(0.0, 0.001, true_m.shape) * true_m**2
    return np.rint(1000.0 * (measured_m + noise_m)).astype(np.uint16)


def sensor_frame(index, **faults):
    """Return a frame with the board in that pose, and a wall behind."""
    return SensorFrame(0, 0, depth_raw(index), picture(index, **faults), 0)


@cache
def seen_frame(index, board, faults):
    """Return what the live view tells of a frame at its beginning."""
    arrival = Arrival(sensor_frame(index, **dict(faults)), INFO, 30.0, 0)
    return Looker().look(arrival, Look(board=board))


def live_frame(index, time_s=0.0, board=BOARD, **faults):
    """Return what the live view tells of a frame at some time."""
    frame = seen_frame(index, board, tuple(faults.items()))
    return replace(frame, sequence=round(time_s * 30), timestamp_ns=round(time_s * NS))


def taken(folder):
    """Return a session in which the board was held still everywhere, for half a second each."""
    session = CalibrationSession(SENSOR, KeptCalibrations(folder), BOARD)
    for index in range(N_POSES):
        frames = [live_frame(index, index + 0.1 * step) for step in range(6)]
        for frame in frames:
            session.see(frame)
        session.add(session.keep(session.picture(frames[-1])))
    return session
