"""Pictures of a board before a small camera, as the live view gives them."""

from dataclasses import replace
from functools import cache

import numpy as np

from adibas.data.board import Board
from adibas.data.calibration import CameraCalibration, RgbdCalibration
from adibas.data.frames import SensorFrame, SourceInfo
from adibas.geometry.pinhole import Intrinsics
from adibas.pipeline.acquisition import Arrival
from adibas.pipeline.looking import Look, look_at
from adibas.simulation.boards import render_board
from adibas.simulation.boards_look import BoardLook
from adibas.simulation.boards_poses import random_board_poses

BOARD = Board(9, 6, 0.03)
CAMERA = CameraCalibration(640, 480, Intrinsics(525.0, 524.0, 318.0, 241.0), (0.05, -0.1, 0.0, 0.0))
MAKERS = RgbdCalibration(
    color=CameraCalibration(640, 480, Intrinsics(530.0, 530.0, 319.5, 239.5)),
    depth=CameraCalibration(64, 48, Intrinsics(57.0, 57.0, 31.5, 23.5)),
    sensor_serial="SN1",
)
INFO = SourceInfo(sensor_name="S", sensor_serial="SN1", calibration=MAKERS)
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


def sensor_frame(index, **faults):
    """Return a frame with the board in that pose, and a wall behind."""
    depth_raw = np.full((48, 64), 1500 + 10 * index, np.uint16)
    return SensorFrame(0, 0, depth_raw, picture(index, **faults), 0)


@cache
def seen_frame(index, board, faults):
    """Return what the live view tells of a frame at its beginning."""
    arrival = Arrival(sensor_frame(index, **dict(faults)), INFO, 30.0, 0)
    return look_at(arrival, Look(board=board))


def live_frame(index, time_s=0.0, board=BOARD, **faults):
    """Return what the live view tells of a frame at some time."""
    frame = seen_frame(index, board, tuple(faults.items()))
    return replace(frame, sequence=round(time_s * 30), timestamp_ns=round(time_s * NS))
