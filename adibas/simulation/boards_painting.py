"""Lays a board over a picture of linear light."""

import functools
import math

import cv2
import numpy as np
from scipy.interpolate import RectBivariateSpline

from adibas.arrays import Float32Array, FloatArray, IntArray
from adibas.data.board import MARK_RADIUS
from adibas.data.calibration import CameraCalibration
from adibas.geometry.distortion import project_distorted, undistort_pixels
from adibas.geometry.rigid import RigidTransform
from adibas.simulation.boards_integral_kernels import Sheet
from adibas.simulation.boards_kernels import Shapes, paint_shapes, paint_sheet
from adibas.simulation.boards_look import BoardLook, BoardView
from adibas.simulation.looks import linear_from_srgb

BOX_MARGIN_PX = 3.0
RIM_POINTS = 9
N_COLORS = 3
_RAY_STEP_PX, _PROBE_STEP_PX = 12, 7
_RAY_TOLERANCE = 3e-8


def lay_board(
    canvas: Float32Array, view: BoardView, camera: CameraCalibration, look: BoardLook
) -> None:
    """Draw a board with its hands over the (H, W, C) float32 `canvas` of reflectances."""
    if look.motion_px == (0.0, 0.0):
        _paint(canvas, view, camera, look, np.full(2, BOX_MARGIN_PX))
        return
    # One more channel, in which all that is painted is 1, tells how much of a pixel is covered.
    n_channels = canvas.shape[2]
    layer = np.zeros((*canvas.shape[:2], n_channels + 1), np.float32)
    reach_px = BOX_MARGIN_PX + np.abs(look.motion_px)
    top, bottom, left, right = _paint(layer, view, camera, look, reach_px)
    part = (slice(top, bottom), slice(left, right))
    kernel = motion_kernel(look.motion_px)
    moved = cv2.filter2D(layer[part], -1, kernel, borderType=cv2.BORDER_REPLICATE)
    canvas[part] = canvas[part] * (1.0 - moved[..., n_channels:]) + moved[..., :n_channels]


@functools.lru_cache(maxsize=2)
def corner_rays(camera: CameraCalibration) -> FloatArray:
    """Return the (H + 1, W + 1, 2) rays (x/z, y/z) of the corners of all pixels."""
    u = np.linspace(-0.5, camera.width - 0.5, camera.width + 1)
    v = np.linspace(-0.5, camera.height - 0.5, camera.height + 1)
    coarse_u, coarse_v = _knots(u), _knots(v)
    knots = _rays(coarse_u, coarse_v, camera)
    if not np.isnan(knots).any():
        # A lens is so smooth that splines through some rays are exact; if not, it shows.
        splines = [RectBivariateSpline(coarse_v, coarse_u, knots[..., axis]) for axis in (0, 1)]
        probe_u, probe_v = (np.linspace(w[0], w[-1], len(w) // _PROBE_STEP_PX) for w in (u, v))
        expected = _rays(probe_u, probe_v, camera)
        guessed = np.dstack([spline(probe_v, probe_u) for spline in splines])
        if np.abs(guessed - expected).max() < _RAY_TOLERANCE:
            return np.dstack([spline(v, u) for spline in splines])
    return _rays(u, v, camera)


def _knots(places: FloatArray) -> FloatArray:
    return np.linspace(places[0], places[-1], max(len(places) // _RAY_STEP_PX, 4) + 1)


def _rays(u: FloatArray, v: FloatArray, camera: CameraCalibration) -> FloatArray:
    pixels = np.empty((len(v), len(u), 2))
    pixels[..., 0], pixels[..., 1] = u, v[:, None]
    return undistort_pixels(pixels, camera.intrinsics, camera.distortion)


def plane_of(camera_from_board: RigidTransform, unit_m: float) -> FloatArray:
    """Return the (3, 3) matrix that turns a ray (x/z, y/z, 1) into (X/z, Y/z, 1/z).

    X and Y are those of the point of the plane that it meets, in units of `unit_m`.

    Raises
    ------
    ValueError
        The plane turns its back to the camera.
    """
    rotation, origin_m = camera_from_board.rotation, camera_from_board.translation_m
    if rotation[:, 2] @ origin_m <= 0.0:
        raise ValueError("the board turns its back to the camera")
    return np.linalg.inv(
        np.column_stack([rotation[:, 0] * unit_m, rotation[:, 1] * unit_m, origin_m])
    )


def motion_kernel(motion_px: tuple[float, float]) -> Float32Array:
    """Return the weights of a straight, even motion of (du, dv) pixels about its middle."""
    reach = math.ceil(max(abs(motion_px[0]), abs(motion_px[1])) / 2.0) + 1
    n_steps = 16 * (reach + 1)
    shares = (np.arange(n_steps) + 0.5) / n_steps - 0.5
    u, v = shares * motion_px[0] + reach, shares * motion_px[1] + reach
    kernel = np.zeros((2 * reach + 1, 2 * reach + 1))
    for row in (0, 1):
        for column in (0, 1):
            iu, iv = np.floor(u).astype(int) + column, np.floor(v).astype(int) + row
            weights = (1 - np.abs(u - iu)) * (1 - np.abs(v - iv))
            np.add.at(kernel, (iv, iu), weights / n_steps)
    return kernel.astype(np.float32)


def _paint(
    canvas: Float32Array,
    view: BoardView,
    camera: CameraCalibration,
    look: BoardLook,
    reach_px: FloatArray,
) -> IntArray:
    """Draw board and hands, and return the rows and columns, from and to, that they may reach."""
    rays = corner_rays(camera)
    box = _board_box(view, camera, reach_px)
    paint_sheet(rays, _sheet(view, look, canvas.shape[2]), box, canvas)
    if not view.hands:
        return box
    hands = _hands(view, look, canvas.shape[2])
    hands_box = _paint_strokes(canvas, hands, view.camera_from_board, camera, reach_px)
    return _union([box, hands_box])


def lay_figure(
    canvas: Float32Array,
    camera: CameraCalibration,
    camera_from_plane: RigidTransform,
    strokes: FloatArray,
    light_rgb: FloatArray,
) -> None:
    """Draw flat strokes over (H, W, 3) light.

    Parameters
    ----------
    strokes : (N, 5) array
        Both ends (x, y) in the plane's frame, and the radius, metres; later ones lie over earlier
        ones.
    light_rgb : (N, 3) array
        Linear light that comes from each.
    """
    shapes = Shapes(plane_of(camera_from_plane, 1.0), strokes, light_rgb)
    _paint_strokes(canvas, shapes, camera_from_plane, camera, np.full(2, BOX_MARGIN_PX))


def _paint_strokes(
    canvas: Float32Array,
    shapes: Shapes,
    camera_from_plane: RigidTransform,
    camera: CameraCalibration,
    reach_px: FloatArray,
) -> IntArray:
    """Draw strokes one by one, each within its own box; return the box of all."""
    boxes = []
    for i in range(len(shapes.strokes)):
        one = slice(i, i + 1)
        strokes, shades = shapes.strokes[one], shapes.shades[one]
        boxes.append(_stroke_box(strokes[0], camera_from_plane, camera, reach_px))
        paint_shapes(corner_rays(camera), Shapes(shapes.plane, strokes, shades), boxes[i], canvas)
    return _union(boxes)


def _union(boxes: list[IntArray]) -> IntArray:
    first, last = np.min(boxes, axis=0), np.max(boxes, axis=0)
    return np.array([first[0], last[1], first[2], last[3]])


def hand_strokes(view: BoardView) -> FloatArray:
    """Return (N, 5) both ends and radius of what hides the board, in its frame, metres."""
    strokes = [(*hand.begin_m, *hand.end_m, hand.radius_m) for hand in view.hands]
    return np.array(strokes, float).reshape(-1, 5)


def _sheet(view: BoardView, look: BoardLook, n_channels: int) -> Sheet:
    board = view.board
    marked = board.marked_squares() if view.has_marks else ()
    dots = np.array([(column - 0.5, row - 0.5, MARK_RADIUS) for row, column in marked])
    shades = np.repeat([[look.exposure], [look.exposure * look.ink / look.paper]], 3, axis=1)
    return Sheet(
        plane=plane_of(view.camera_from_board, board.square_m),
        last=np.array([board.columns, board.rows], float),
        margin=view.margin_squares,
        dots=dots.reshape(-1, 3),
        shades=_in_channels(shades, n_channels),
    )


def _hands(view: BoardView, look: BoardLook, n_channels: int) -> Shapes:
    albedo = linear_from_srgb(np.array([hand.srgb for hand in view.hands]))
    return Shapes(
        plane=plane_of(view.camera_from_board, 1.0),
        strokes=hand_strokes(view),
        shades=_in_channels(albedo * look.exposure / look.paper, n_channels),
    )


def _in_channels(rgb: FloatArray, n_channels: int) -> FloatArray:
    """Return (N, 3) colours as a canvas has them: grey or RGB, then the cover if there is one."""
    colors = rgb if n_channels >= N_COLORS else rgb.mean(axis=1, keepdims=True)
    is_covered = n_channels > colors.shape[1]
    return np.column_stack([colors, np.ones(len(rgb))]) if is_covered else colors


def _board_box(view: BoardView, camera: CameraCalibration, reach_px: FloatArray) -> IntArray:
    board = view.board
    low = np.full(2, -(1.0 + view.margin_squares) * board.square_m)
    high = (np.array([board.columns, board.rows]) + view.margin_squares) * board.square_m
    return _box(view.camera_from_board, (low, high), camera, reach_px)


def _stroke_box(
    stroke: FloatArray,
    camera_from_plane: RigidTransform,
    camera: CameraCalibration,
    reach_px: FloatArray,
) -> IntArray:
    ends = stroke[:4].reshape(2, 2)
    rectangle_m = ends.min(axis=0) - stroke[4], ends.max(axis=0) + stroke[4]
    return _box(camera_from_plane, rectangle_m, camera, reach_px)


def _box(
    camera_from_board: RigidTransform,
    rectangle_m: tuple[FloatArray, FloatArray],
    camera: CameraCalibration,
    reach_px: FloatArray,
) -> IntArray:
    """Return rows and columns, from and to, that may show a rectangle of the board's plane."""
    low, high = rectangle_m
    whole = np.array([0, camera.height, 0, camera.width])
    t = np.linspace(0.0, 1.0, RIM_POINTS)
    zero, one = np.zeros_like(t), np.ones_like(t)
    rim = np.stack([np.concatenate([t, one, t, zero]), np.concatenate([zero, t, one, t])], axis=1)
    points_m = np.column_stack([low + rim * (high - low), np.zeros(len(rim))])
    pixels = project_distorted(
        camera_from_board.apply(points_m), camera.intrinsics, camera.distortion
    )
    if np.isnan(pixels).any():
        return whole
    first = np.floor(pixels.min(axis=0) - reach_px)
    last = np.ceil(pixels.max(axis=0) + reach_px) + 1
    box = np.array([first[1], last[1], first[0], last[0]])
    clipped: IntArray = np.clip(box, 0, whole[[1, 1, 3, 3]]).astype(np.int64)
    return clipped
