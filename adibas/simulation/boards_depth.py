"""Boards and flat walls before the depth camera, which `DepthSensor` turns into raw depth.

A board is a plane as large as its paper. Print is told from paper in infrared only by how much of
the pattern comes back; that it might shift the depth a little, as some say, is left out.
"""

import functools
from collections.abc import Sequence
from dataclasses import replace
from typing import Protocol

import numpy as np

from adibas.arrays import Float32Array, FloatArray
from adibas.data.calibration import CameraCalibration
from adibas.geometry.distortion import pixel_rays
from adibas.geometry.planes import Plane
from adibas.geometry.rigid import RigidTransform
from adibas.simulation.boards_depth_kernels import see_shapes, see_sheet
from adibas.simulation.boards_integral_kernels import Sheet
from adibas.simulation.boards_kernels import Shapes
from adibas.simulation.boards_look import BoardView
from adibas.simulation.boards_painting import hand_strokes, plane_of
from adibas.simulation.studio import DepthView

PAPER_INFRARED, INK_INFRARED, SKIN_INFRARED, WALL_INFRARED = 0.8, 0.35, 0.6, 0.75
"""Shares of the projected pattern that come back (assumed)."""
HAND_M = 0.02
"""By how much hands stand out before the board."""


class Behind(Protocol):
    """What stands behind; a `Backdrop` is one."""

    @property
    def inverse_depth(self) -> Float32Array: ...  # noqa: D102  (see `Backdrop`)
    @property
    def infrared(self) -> Float32Array: ...  # noqa: D102


def seen_from(view: BoardView, other_from_camera: RigidTransform) -> BoardView:
    """Return the same board in the axes of another camera."""
    return replace(view, camera_from_board=other_from_camera @ view.camera_from_board)


def flat_wall(
    wall: Plane, camera: CameraCalibration, reflectance: float = WALL_INFRARED
) -> DepthView:
    """Return the ideal depth image of an endless plane in the depth camera's axes.

    Pixels that do not meet it in front of the camera see nothing.
    """
    rays = _rays(camera)
    inverse_m = -(rays @ wall.normal[:2] + wall.normal[2]) / wall.offset_m
    size = inverse_m.shape
    return DepthView(
        np.maximum(inverse_m, 0.0).astype(np.float32),
        np.zeros(size, np.uint8),
        np.full(size, reflectance, np.float32),
    )


def see_boards(
    views: Sequence[BoardView], camera: CameraCalibration, behind: Behind | None = None
) -> DepthView:
    """Return the ideal depth image of boards with the hands on them.

    Parameters
    ----------
    views : sequence of BoardView
        Their `camera_from_board` leads into the depth camera's axes: see `seen_from`.
    camera : CameraCalibration
        The depth camera.
    behind : Backdrop or DepthView-like, optional
        What is seen where no board is; nothing at all by default.

    Raises
    ------
    ValueError
        A board turns its back to the camera.
    """
    size = (camera.height, camera.width)
    if behind is None:
        inverse_m, infrared = np.zeros(size, np.float32), np.zeros(size, np.float32)
    else:
        inverse_m, infrared = behind.inverse_depth.copy(), behind.infrared.copy()
    for view in views:
        _lay_board(view, camera, inverse_m, infrared)
    return DepthView(inverse_m, np.zeros(size, np.uint8), infrared)


def lay_strokes(
    camera_from_plane: RigidTransform,
    strokes: FloatArray,
    camera: CameraCalibration,
    images: tuple[Float32Array, Float32Array],
    reflectance: float = SKIN_INFRARED,
) -> None:
    """Put flat rounded strokes (N, 5: both ends, radius; metres) before what is in `images`.

    `images` are 1/z and reflectance (H, W); the strokes lie in x and y of the plane's frame.
    """
    shades = np.full((len(strokes), 1), reflectance)
    shapes = Shapes(plane_of(camera_from_plane, 1.0), np.ascontiguousarray(strokes), shades)
    see_shapes(_rays(camera), shapes, *images)


def _lay_board(
    view: BoardView,
    camera: CameraCalibration,
    inverse_m: Float32Array,
    infrared: Float32Array,
) -> None:
    board = view.board
    sheet = Sheet(
        plane=plane_of(view.camera_from_board, board.square_m),
        last=np.array([board.columns, board.rows], float),
        margin=view.margin_squares,
        dots=np.zeros((0, 3)),
        shades=np.array([[PAPER_INFRARED], [INK_INFRARED]]),
    )
    see_sheet(_rays(camera), sheet, inverse_m, infrared)
    if view.hands:
        nearer = RigidTransform(np.eye(3), np.array([0.0, 0.0, -HAND_M]))
        pose = view.camera_from_board @ nearer
        lay_strokes(pose, hand_strokes(view), camera, (inverse_m, infrared))


@functools.lru_cache(maxsize=4)
def _rays(camera: CameraCalibration) -> FloatArray:
    return pixel_rays((camera.height, camera.width), camera.intrinsics, camera.distortion)
