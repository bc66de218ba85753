"""What a lens that blurs outwards (coma) does to corners and to the camera they give.

Boards are rendered through Bouguet's camera; then each pixel's light is drawn out, away from the
image's middle, the longer the farther from it, as edges in his images are. The corner of such a
blur is a matter of definition. The middle of its light moves in proportion to the field, which is
a larger focal length and no other lens; what gradients cling to moves less and less, which is
taken for distortion.
"""

from collections.abc import Callable, Iterator

import cv2
import numpy as np

from adibas.arrays import FloatArray, UInt8Array
from adibas.calibration.camera_fitting import FittingParams, fit_camera
from adibas.calibration.finder import find_board
from adibas.calibration.lens_models import BROWN_4
from adibas.data.board import Board, BoardCorners
from adibas.data.calibration import CameraCalibration
from adibas.geometry.pinhole import Intrinsics
from adibas.simulation.boards import render_board
from adibas.simulation.boards_look import BoardLook
from adibas.simulation.boards_poses import Holding, random_board_poses
from adibas.simulation.color_noise import ColorNoise
from benchmarks.calibration_real import BOUGUET, METHODS, SQUARES
from benchmarks.table import Row

SEED = 77
N_VIEWS = 20
BOARD = Board(12, 13, 0.03)
CAMERA = CameraCalibration(
    640,
    480,
    Intrinsics(*(BOUGUET[name][0] for name in ("fx", "fy", "cx", "cy"))),
    tuple(BOUGUET[name][0] for name in ("k1", "k2", "p1", "p2")),
)
LOOK = BoardLook(camera=ColorNoise(blur_px=1.2, full_well=1e6, read_noise=1.0))
LONGEST_TAIL = 0.024
"""Of the way from the middle: six pixels in a corner of the image."""
CORE, FADING = 2.0, 3.0
"""Light in the sharp end beside that of the tail, and the step of nine at which that is 1 / e."""
SHARPENING, KNEE, NOISE = 0.5, 215.0, 1.2
"""Overshoot of the camera, above which grey level it saturates, and noise in grey levels."""


def rows(*, quick: bool) -> Iterator[Row]:
    """Calibrate with the same 20 pictures, plain and drawn out, by both kinds of corners.

    With `quick` drawn out alone.
    """
    rng = np.random.default_rng(SEED)
    poses = random_board_poses(rng, BOARD, CAMERA, N_VIEWS, Holding())
    pictures = [render_board(BOARD, pose, CAMERA, rng, LOOK) for pose in poses]
    changes: dict[str, Callable[[FloatArray], FloatArray]] = {
        "symmetric blur": lambda image: image,
        "symmetric blur, sharpened": sharpened,
        "coma": drawn_out,
        "coma, gamma 0.45, sharpened": lambda image: sharpened(darkened(drawn_out(image))),
    }
    for name in ("coma",) if quick else tuple(changes):
        noise = np.random.default_rng(SEED)
        images = [_taken(changes[name](picture.image.astype(float)), noise) for picture in pictures]
        for method, params in METHODS.items():
            found = [find_board(image, BOARD, "simulated", params) for image in images]
            seen = [corners for corners in found if corners is not None]
            pairs = zip(found, pictures, strict=True)
            error_px = [c.pixels - p.corners_px[0] for c, p in pairs if c is not None]
            yield from _camera_rows(f"{N_VIEWS} pictures, {name}, {method}", seen, error_px)


def drawn_out(image: FloatArray) -> FloatArray:
    """Return the image with a tail behind every point, away from the middle."""
    v, u = np.indices(image.shape).astype(np.float32)
    right, down = u - CAMERA.intrinsics.cx, v - CAMERA.intrinsics.cy
    weights = np.exp(-np.arange(9) / FADING)
    weights[0] += CORE
    total = np.zeros(image.shape)
    for step, weight in zip(
        np.linspace(0.0, LONGEST_TAIL, 9), weights / weights.sum(), strict=True
    ):
        at_u, at_v = (u - step * right).astype(np.float32), (v - step * down).astype(np.float32)
        total += weight * cv2.remap(image.astype(np.float32), at_u, at_v, cv2.INTER_CUBIC)
    return total


def darkened(image: FloatArray) -> FloatArray:
    """Return the grey levels after a tone curve of exponent 0.45."""
    curved: FloatArray = 255.0 * (np.clip(image, 0.0, 255.0) / 255.0) ** 0.45
    return curved


def sharpened(image: FloatArray) -> FloatArray:
    """Return the image sharpened along its rows, its whites compressed."""
    more = image + SHARPENING * (image - cv2.GaussianBlur(image, (0, 0), sigmaX=1.5, sigmaY=0.01))
    compressed: FloatArray = np.where(more > KNEE, KNEE + 0.3 * (more - KNEE), more)
    return compressed


def _taken(image: FloatArray, rng: np.random.Generator) -> UInt8Array:
    noisy = np.round(image + rng.normal(0.0, NOISE, image.shape))
    return np.clip(noisy, 0, 255).astype(np.uint8)


def _camera_rows(told: str, seen: list[BoardCorners], error_px: list[FloatArray]) -> Iterator[Row]:
    fit = fit_camera(BOARD, seen, FittingParams(model=BROWN_4, refinement=SQUARES))
    if fit is None:
        raise ValueError("so many boards are enough")
    errors = np.concatenate(error_px)
    rms_px = float(np.sqrt(np.nanmean((errors**2).sum(axis=1))))
    yield Row(f"{told}: corners from the blur's sharp end, rms", rms_px, "px")
    yield Row(f"{told}: rms over points", fit.rms_px, "px")
    for parameter, value in zip(fit.parameter_names, fit.values, strict=True):
        if parameter not in ("fx", "k1", "k2"):
            continue
        truth, tolerance = BOUGUET[parameter]
        label = f"{told}: {parameter} from the truth, in Bouguet's tolerances"
        yield Row(label, (value - truth) / tolerance, "")
