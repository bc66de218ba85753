"""Pictures of chessboards as a camera takes them, with the exact place of every corner.

Each pixel gets the exact integral of ink and paper over its area, through the lens. A lens blurs
before the pixels sample: where its blur is narrow, the light is drawn several times as fine,
blurred there, and then gathered into pixels (`boards_camera.fineness`). What follows (motion,
noise, colour filter, curve) moves no edge either, as it is symmetric; only the curve of the
camera, sRGB, makes white look larger than black, as real cameras do, which leaves a corner of four
squares where it is.
"""

import functools
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from adibas.arrays import BoolArray, Float32Array, FloatArray, UInt8Array
from adibas.data.board import Board
from adibas.data.calibration import CameraCalibration
from adibas.geometry.distortion import project_distorted
from adibas.geometry.rigid import RigidTransform
from adibas.simulation.boards_background import paint_background
from adibas.simulation.boards_camera import fineness, finer, gathered, take_color, take_gray
from adibas.simulation.boards_kernels import stroke_distance
from adibas.simulation.boards_look import BoardLook, BoardView
from adibas.simulation.boards_painting import hand_strokes, lay_board

HIDDEN_MARGIN_PX = 2.0
"""A corner counts as hidden where a hand comes as near as this."""


@dataclass(frozen=True, slots=True, eq=False)
class BoardPicture:
    """A picture and the truth.

    Attributes
    ----------
    image : (H, W) or (H, W, 3) uint8 array
    corners_px : tuple of (rows * columns, 2) arrays
        For each board (u, v) of all its corners in the order of `Board.points_m`, as this image
        shows them; NaN outside the image and under a hand.
    """

    image: UInt8Array
    corners_px: tuple[FloatArray, ...]


def corner_pixels(
    board: Board, camera_from_board: RigidTransform, camera: CameraCalibration
) -> FloatArray:
    """Return the exact (rows * columns, 2) pixels of the corners, in the image or not.

    NaN where the lens cannot show a corner.
    """
    points_m = camera_from_board.apply(board.points_m())
    return project_distorted(points_m, camera.intrinsics, camera.distortion)


def visible_corners(
    view: BoardView, camera: CameraCalibration, *, is_mirrored: bool = False
) -> FloatArray:
    """Return the pixels of the corners as `BoardPicture` has them."""
    pixels = corner_pixels(view.board, view.camera_from_board, camera)
    middle = 0.5 * np.array([camera.width - 1, camera.height - 1])
    is_inside = (np.abs(pixels - middle) < middle + 0.5).all(axis=1)
    pixels[~is_inside | _is_hidden(view, camera)] = np.nan
    if is_mirrored:
        pixels[:, 0] = camera.width - 1 - pixels[:, 0]
    return pixels


def render_board(
    board: Board,
    camera_from_board: RigidTransform,
    camera: CameraCalibration,
    rng: np.random.Generator,
    look: BoardLook | None = None,
    *,
    in_color: bool = False,
) -> BoardPicture:
    """Return the picture of one board; see `render_boards`."""
    view = BoardView(board, camera_from_board)
    return render_boards((view,), camera, rng, look, in_color=in_color)


def render_boards(
    views: Sequence[BoardView],
    camera: CameraCalibration,
    rng: np.random.Generator,
    look: BoardLook | None = None,
    *,
    in_color: bool = False,
) -> BoardPicture:
    """Return the picture of some boards, the later ones before the earlier ones.

    Parameters
    ----------
    views : sequence of BoardView
        None at all gives the background.
    camera : CameraCalibration
        With its lens distortion.
    rng : Generator
        Of the noise.
    look : BoardLook, optional
        The default is a good picture.
    in_color : bool
        False: one channel, from a camera without colour filter.

    Raises
    ------
    ValueError
        A board turns its back to the camera.
    """
    look = look or BoardLook()
    linear = _linear(views, camera, look, 3 if in_color else 1)
    image = (
        take_color(linear, look.camera, rng) if in_color else take_gray(linear, look.camera, rng)
    )
    if look.is_mirrored:
        image = np.ascontiguousarray(image[:, ::-1])
    corners = (visible_corners(view, camera, is_mirrored=look.is_mirrored) for view in views)
    return BoardPicture(image, tuple(corners))


def _linear(
    views: Sequence[BoardView], camera: CameraCalibration, look: BoardLook, n_channels: int
) -> Float32Array:
    """Return the (H, W, C) light that falls on the pixels, through the lens."""
    size = (camera.height, camera.width)
    n = fineness(look.camera, camera.width, in_color=n_channels > 1)
    canvas = paint_background(look.background, size, n_channels)
    if n > 1:
        canvas = np.repeat(np.repeat(canvas, n, axis=0), n, axis=1)
    fine_camera = finer(camera, n)
    fine_look = replace(look, motion_px=(n * look.motion_px[0], n * look.motion_px[1]))
    for view in views:
        lay_board(canvas, view, fine_camera, fine_look)
    linear = gathered(canvas, look.camera, n)
    linear *= _light(look, size)
    return linear


def _is_hidden(view: BoardView, camera: CameraCalibration) -> BoolArray:
    """Say which corners lie under a hand, or so near that it shows."""
    points_m = view.board.points_m()
    depth_m = view.camera_from_board.apply(points_m)[:, 2]
    margin_m = HIDDEN_MARGIN_PX * depth_m / camera.intrinsics.fx
    hidden = np.zeros(len(points_m), bool)
    for stroke in hand_strokes(view):
        outside_m = [stroke_distance(x, y, stroke) for x, y, _ in points_m]
        hidden |= np.asarray(outside_m) < margin_m
    return hidden


@functools.lru_cache(maxsize=8)
def _shade(size: tuple[int, int], gradient: float, from_rad: float) -> Float32Array:
    height, width = size
    half_diagonal = 0.5 * math.hypot(width, height)
    u = (np.arange(width) - 0.5 * (width - 1)) * (math.cos(from_rad) * gradient / half_diagonal)
    v = (np.arange(height) - 0.5 * (height - 1)) * (math.sin(from_rad) * gradient / half_diagonal)
    shade: Float32Array = (1.0 + u + v[:, None]).astype(np.float32)[..., None]
    return shade


def _light(look: BoardLook, size: tuple[int, int]) -> Float32Array:
    return _shade(size, look.light_gradient, look.light_from_rad)
