"""Short recordings of a board or a wall before the simulated sensor, for calibrations."""

from dataclasses import dataclass, replace

import cv2
import numpy as np

from adibas.data.board import Board
from adibas.data.frames import EncodedImage, SensorFrame
from adibas.geometry.planes import Plane
from adibas.recordings import create_recording
from adibas.simulation.boards import render_board
from adibas.simulation.boards_depth import flat_wall, see_boards, seen_from
from adibas.simulation.boards_device import factory_info, uncalibrated_device
from adibas.simulation.boards_look import BoardView
from adibas.simulation.boards_poses import Holding, random_board_poses
from adibas.simulation.depth_noise import DepthNoise, DepthSensor

BOARD = Board(9, 6, 0.1)
DEVICE = uncalibrated_device(3, (480, 640))
N_EACH = 20
N_DRAWN = 5
"""Depth images drawn of each moment; they come again and again, which saves time."""

HEIGHT_M = 1.0
"""Of the depth camera above the floor."""


@dataclass(frozen=True)
class Room:
    """What stands behind a board: 1/z, and how much of the pattern comes back."""

    inverse_depth: np.ndarray
    infrared: np.ndarray


def room(distance_m):
    """Return a wall with the floor before it."""
    wall = flat_wall(Plane(np.array([0.0, 0.0, -1.0]), distance_m), DEVICE.depth)
    floor = flat_wall(Plane(np.array([0.0, -1.0, 0.0]), HEIGHT_M), DEVICE.depth)
    nearer = np.maximum(wall.inverse_depth, floor.inverse_depth)
    return Room(nearer, wall.reflectance)


def board_moments(n, seed, board=BOARD):
    """Give a depth view and a colour picture for each place of a board."""
    rng = np.random.default_rng(seed)
    holding = Holding(distance_m=(0.9, 2.7), border_px=25)
    depth_from_color = DEVICE.calibration.color_from_depth.inverse()
    for pose in random_board_poses(rng, board, DEVICE.color, n, holding):
        picture = render_board(board, pose, DEVICE.color, rng, in_color=True).image
        view = seen_from(BoardView(board, pose), depth_from_color)
        yield see_boards((view,), DEVICE.depth, room(3.6)), picture


def wall_moments(distances_m):
    """Give a depth view and a blank picture for each distance of a wall."""
    blank = np.full((DEVICE.color.height, DEVICE.color.width, 3), 128, np.uint8)
    for distance_m in distances_m:
        yield see_boards((), DEVICE.depth, room(distance_m)), blank


def record_moments(path, moments, n_each=N_EACH, info=None, *, has_color=True, has_depth=True):
    """Write a recording in which one moment follows the other."""
    sensor = DepthSensor(DEVICE, DepthNoise(), 5)
    number = 0
    with create_recording(path, info or factory_info(DEVICE)) as writer:
        for view, picture in moments:
            color = encoded(picture) if has_color else None
            drawn = [
                sensor.measure(view.inverse_depth, view.reflectance, number + i)
                for i in range(min(N_DRAWN, n_each))
            ]
            for i in range(n_each):
                time_ns = 1_000_000_000 + number * 33_333_333
                depth = drawn[i % len(drawn)].copy()
                writer.write(
                    SensorFrame(
                        sequence=number,
                        timestamp_ns=time_ns,
                        depth_raw=depth if has_depth else None,
                        color=color,
                        color_timestamp_ns=time_ns if has_color else None,
                    )
                )
                number += 1
    return path


def encoded(picture_rgb):
    """Return a picture as the PNG that a recording keeps as it is."""
    _, data = cv2.imencode(".png", picture_rgb[..., ::-1])
    return EncodedImage("png", data.tobytes())


def color_alone(**changes):
    """Return the exact calibration of the colour camera, and nothing else."""
    from adibas.data.calibration import RgbdCalibration

    return replace(RgbdCalibration(color=DEVICE.color), **changes)
