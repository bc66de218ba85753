"""What goes wrong when someone calibrates for the first time, each mistake as a set of pictures."""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Literal, TypeAlias, get_args

import numpy as np

from adibas.data.board import Board
from adibas.data.calibration import CameraCalibration
from adibas.geometry.rigid import RigidTransform
from adibas.simulation.boards import BoardPicture, render_boards
from adibas.simulation.boards_background import Background
from adibas.simulation.boards_look import BoardLook, BoardView
from adibas.simulation.boards_poses import (
    Holding,
    distances_m,
    place_board,
    random_board_poses,
    tilted,
)
from adibas.simulation.color_noise import ColorNoise

Mistake: TypeAlias = Literal[
    "none",
    "three_boards",
    "all_frontal",
    "one_place",
    "blurred",
    "shaken",
    "half_outside",
    "wrong_square_size",
    "wrong_board_size",
    "two_boards",
    "mirrored",
    "no_board",
    "too_dark",
]
MISTAKES: tuple[Mistake, ...] = get_args(Mistake)

WRONG_SQUARE = 1.2
"""The true square's side, as a multiple of what the user said."""


@dataclass(frozen=True, slots=True, eq=False)
class NoviceSet:
    """The pictures of one attempt, before they are rendered.

    Attributes
    ----------
    mistake : str
    told_board : Board
        What the user says the board is.
    shots : tuple of (views, look)
        The boards of each picture, and how it is taken.
    """

    mistake: Mistake
    told_board: Board
    shots: tuple[tuple[tuple[BoardView, ...], BoardLook], ...]

    def pictures(
        self, camera: CameraCalibration, rng: np.random.Generator, *, in_color: bool = False
    ) -> Iterator[BoardPicture]:
        """Render one after the other."""
        for views, look in self.shots:
            yield render_boards(views, camera, rng, look, in_color=in_color)


def novice_set(
    mistake: Mistake,
    rng: np.random.Generator,
    board: Board,
    camera: CameraCalibration,
    n: int = 20,
) -> NoviceSet:
    """Return `n` pictures with one mistake in them, else taken as a careful user does.

    Parameters
    ----------
    mistake : one of `MISTAKES`
        "none" makes none. "wrong_square_size": the squares are larger than told by
        `WRONG_SQUARE`. "wrong_board_size": the board has one column less than told. The others
        say what the pictures show.
    board : Board
        What the user says it is.
    n : int
        Pictures; "three_boards" takes three.
    """
    true_board = _true_board(mistake, board)
    if mistake == "three_boards":
        n = 3
    poses = _poses(mistake, rng, true_board, camera, n)
    shots = []
    for pose in poses:
        views: tuple[BoardView, ...] = (BoardView(true_board, pose),)
        if mistake == "no_board":
            views = ()
        elif mistake == "two_boards":
            views = _pair(rng, true_board, camera)
        shots.append((views, _look(mistake, rng)))
    return NoviceSet(mistake, board, tuple(shots))


def _true_board(mistake: Mistake, told: Board) -> Board:
    if mistake == "wrong_square_size":
        return replace(told, square_m=WRONG_SQUARE * told.square_m)
    if mistake == "wrong_board_size":
        return replace(told, columns=told.columns - 1)
    return told


def _poses(
    mistake: Mistake,
    rng: np.random.Generator,
    board: Board,
    camera: CameraCalibration,
    n: int,
) -> tuple[RigidTransform, ...]:
    if mistake == "all_frontal":
        # Someone who steps back and to the side, with the board as parallel as hands can.
        frontal = Holding(
            tilt_rad=(math.radians(1.5), math.radians(1.5)),
            frontal_share=1.0,
            roll_sd_rad=math.radians(2.0),
            upright_share=0.0,
        )
        return random_board_poses(rng, board, camera, n, frontal)
    if mistake == "one_place":
        return _at(rng, board, camera, n, place=(0.5, 0.5))
    if mistake == "half_outside":
        return _half_outside(rng, board, camera, n)
    return random_board_poses(rng, board, camera, n)


def _at(
    rng: np.random.Generator,
    board: Board,
    camera: CameraCalibration,
    n: int,
    place: tuple[float, float],
) -> tuple[RigidTransform, ...]:
    """Return poses that are the same but for a trembling hand."""
    distance_m = distances_m(board, camera, Holding())[1]
    poses = []
    for _ in range(n):
        tilt_rad, towards_rad, roll_rad = rng.normal((0.25, 0.4, 0.0), 0.03)
        rotation = tilted(tilt_rad, towards_rad, roll_rad)
        where = np.array(place) + rng.normal(0.0, 0.01, 2)
        poses.append(place_board(board, camera, rotation, distance_m, where, 4.0))
    return tuple(poses)


def _half_outside(
    rng: np.random.Generator, board: Board, camera: CameraCalibration, n: int
) -> tuple[RigidTransform, ...]:
    """Return poses in which some 30 to 60 % of the pattern is beyond the image's border."""
    whole = random_board_poses(rng, board, camera, n)
    poses = []
    for pose in whole:
        middle = pose.apply(board.points_m()).mean(axis=0)
        to_border = np.array([camera.width / 2, camera.height / 2]) / camera.intrinsics.fx
        side = int(rng.integers(2))
        beyond = np.array([middle[0], middle[1]])
        beyond[side] = (
            rng.choice((-1.0, 1.0)) * to_border[side] * middle[2] * rng.uniform(0.97, 1.1)
        )
        shift = np.array([*(beyond - middle[:2]), 0.0])
        poses.append(RigidTransform(pose.rotation, pose.translation_m + shift))
    return tuple(poses)


def _pair(
    rng: np.random.Generator, board: Board, camera: CameraCalibration
) -> tuple[BoardView, ...]:
    """Return two boards side by side, or one above the other where the image is narrow."""
    distance_m = 1.25 * camera.intrinsics.fx * (board.columns + 3) * board.square_m
    distance_m /= 0.5 * camera.width
    views = []
    for place_u in (0.03, 0.97):
        rotation = tilted(*(float(x) for x in rng.uniform((0, 0, -0.1), (0.5, 6.28, 0.1))))
        place = np.array([place_u, rng.uniform(0.2, 0.8)])
        views.append(
            BoardView(board, place_board(board, camera, rotation, distance_m, place, 12.0))
        )
    return tuple(views)


def _look(mistake: Mistake, rng: np.random.Generator) -> BoardLook:
    look = BoardLook(background=Background(is_cluttered=mistake == "no_board"))
    if mistake == "blurred":
        return replace(look, camera=replace(ColorNoise(), blur_px=float(rng.uniform(5.0, 8.0))))
    if mistake == "shaken":
        angle_rad, way_px = rng.uniform((0.0, 8.0), (math.pi, 20.0))
        return replace(look, motion_px=(way_px * math.cos(angle_rad), way_px * math.sin(angle_rad)))
    if mistake == "too_dark":
        return replace(look, exposure=0.03, background=Background(0.01))
    return replace(look, is_mirrored=mistake == "mirrored")
