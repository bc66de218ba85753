"""How someone who knows what is wanted holds a board before a camera."""

import math
from dataclasses import dataclass

import numpy as np

from adibas.arrays import FloatArray
from adibas.data.board import Board
from adibas.data.calibration import CameraCalibration
from adibas.geometry.distortion import project_distorted
from adibas.geometry.rigid import RigidTransform, rotation_from_vector

N_PLACING_ROUNDS = 12
_PLASTIC = 1.32471795724474602596


@dataclass(frozen=True, slots=True)
class Holding:
    """How a board is held; angles and shares are drawn evenly unless said otherwise.

    Attributes
    ----------
    tilt_rad : (float, float)
        Between the board's normal and the line to the camera (10-45 degrees; Zhang 1999 finds
        45 degrees best and the corners hard to find beyond).
    frontal_share : float
        Of the views that are tilted less than the smallest of `tilt_rad` (assumed); with 1 all.
    roll_sd_rad : float
        Of the turn about the line of sight (assumed).
    upright_share : float
        Of the views with the board turned by a quarter (assumed).
    fill : (float, float)
        The board's longer side as a share of the image's width, small to large.
    distance_m : (float, float)
        Nearest and farthest (arms' length to the end of the working volume).
    smallest_square_px : float
        No farther than squares appear so large, when they face the camera.
    border_px : float
        The whole pattern is at least so far from the image's border.
    reach : float
        More than 1: so much of the way beyond the border is tried, and stopped there, so that
        some views fill the image's corners (assumed).
    """

    tilt_rad: tuple[float, float] = (math.radians(10.0), math.radians(45.0))
    frontal_share: float = 0.2
    roll_sd_rad: float = math.radians(8.0)
    upright_share: float = 0.15
    fill: tuple[float, float] = (0.25, 0.75)
    distance_m: tuple[float, float] = (0.5, 3.5)
    smallest_square_px: float = 12.0
    border_px: float = 4.0
    reach: float = 1.3


def random_board_poses(
    rng: np.random.Generator,
    board: Board,
    camera: CameraCalibration,
    n: int,
    holding: Holding | None = None,
) -> tuple[RigidTransform, ...]:
    """Return `n` poses `camera_from_board` that cover the image, near and far, tilted each way.

    The whole pattern is in the image in each of them. Places, tilts and distances are spread
    evenly over the views (Roberts' sequence), so that few views cover the image as well.

    Raises
    ------
    ValueError
        The board is so large that it does not fit into the image within `Holding.distance_m`.
    """
    holding = holding or Holding()
    near_m, far_m = distances_m(board, camera, holding)
    spread = np.array([_PLASTIC**-1, _PLASTIC**-2])
    places = np.mod(rng.random(2) + np.outer(np.arange(n), spread), 1.0)
    places = np.clip(0.5 + holding.reach * (places - 0.5), 0.0, 1.0)
    far_share, tilt_share = ((rng.permutation(n) + rng.random(n)) / n for _ in range(2))
    poses = []
    for i in range(n):
        distance_m = near_m * (far_m / near_m) ** float(far_share[i])
        towards_rad = 2.0 * math.pi * (i * _PLASTIC**-1 % 1.0)
        rotation = _rotation(rng, holding, float(tilt_share[i]), towards_rad)
        poses.append(place_board(board, camera, rotation, distance_m, places[i], holding.border_px))
    return tuple(poses)


def distances_m(board: Board, camera: CameraCalibration, holding: Holding) -> tuple[float, float]:
    """Return the nearest and the farthest distance at which this board is held."""
    focal_px = camera.intrinsics.fx
    side_m = (max(board.columns, board.rows) + 1) * board.square_m
    small, large = (focal_px * side_m / (fill * camera.width) for fill in holding.fill)
    near_m = max(large, holding.distance_m[0])
    smallest_m = focal_px * board.square_m / holding.smallest_square_px
    far_m = min(max(small, near_m), smallest_m, holding.distance_m[1])
    return near_m, max(far_m, near_m)


def place_board(
    board: Board,
    camera: CameraCalibration,
    rotation: FloatArray,
    distance_m: float,
    place: FloatArray,
    border_px: float,
) -> RigidTransform:
    """Return the pose in which the pattern takes a place among all that show it whole.

    Parameters
    ----------
    rotation : (3, 3) array
        Of `camera_from_board`.
    distance_m : float
        Of the pattern's middle along z; more where it would not fit.
    place : (2,) array
        0 = as far left or up as goes, 1 = as far right or down.
    border_px : float
        That stays free around; negative lets the pattern out of the image.

    Raises
    ------
    ValueError
        It does not fit however far away, as a lens without any distance would show it.
    """
    outline = outline_m(board)
    middle = outline.mean(axis=0)
    size = np.array([camera.width, camera.height], float)
    normalised = np.zeros(2)
    for _ in range(N_PLACING_ROUNDS):
        at_m = np.array([*normalised, 1.0]) * distance_m
        points_m = (outline - middle) @ rotation.T + at_m
        pixels = project_distorted(points_m, camera.intrinsics, camera.distortion)
        low, high = pixels.min(axis=0), pixels.max(axis=0)
        free = size - 1 - 2 * border_px - (high - low)
        if np.isnan(free).any() or (free < 0).any():
            distance_m, normalised = 1.08 * distance_m, np.zeros(2)
            continue
        move_px = border_px + place * free - low
        if np.abs(move_px).max() < 0.1:  # noqa: PLR2004  (pixels: nobody sees it)
            return RigidTransform(rotation, at_m - rotation @ middle)
        normalised += move_px / (camera.intrinsics.fx, camera.intrinsics.fy)
    raise ValueError("the board does not fit into the image")


def outline_m(board: Board) -> FloatArray:
    """Return (N, 3) points around the outer squares, in the board's frame."""
    t = np.linspace(-1.0, 1.0, 9)
    one = np.ones_like(t)
    rim = np.concatenate([np.stack(side, axis=1) for side in ((t, -one), (one, t), (-t, one))])
    rim = np.concatenate([rim, np.stack([-one, -t], axis=1)])
    half = 0.5 * np.array([board.columns + 1, board.rows + 1]) * board.square_m
    middle = 0.5 * np.array([board.columns - 1, board.rows - 1]) * board.square_m
    return np.column_stack([middle + rim * half, np.zeros(len(rim))])


def tilted(tilt_rad: float, towards_rad: float, roll_rad: float) -> FloatArray:
    """Return the (3, 3) rotation of a board tilted about an axis across the line of sight.

    `towards_rad` is where that axis points in the image; `roll_rad` turns the board in its plane,
    before.
    """
    axis = np.array([math.cos(towards_rad), math.sin(towards_rad), 0.0])
    roll = rotation_from_vector(np.array([0.0, 0.0, roll_rad]))
    return rotation_from_vector(tilt_rad * axis) @ roll


def _rotation(
    rng: np.random.Generator, holding: Holding, share: float, towards_rad: float
) -> FloatArray:
    """Return a tilt that grows with `share`, 0 to 1, about a wavering axis, and a chance roll."""
    knots = np.array([0.0, holding.frontal_share, 1.0])
    tilt_rad = float(np.interp(share, knots, [0.0, *holding.tilt_rad]))
    roll_rad = float(rng.normal(0.0, holding.roll_sd_rad))
    if rng.random() < holding.upright_share:
        roll_rad += float(rng.choice((-0.5, 0.5))) * math.pi
    return tilted(tilt_rad, towards_rad + float(rng.normal(0.0, 0.3)), roll_rad)
