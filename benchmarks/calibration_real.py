"""Boards that others photographed: found, their corners, and what cameras they give.

Bouguet's tolerances are three standard errors of noise alone; `calibration_coma` shows what the
way of placing corners adds to that.
"""

import math
import os
import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from scipy.io import loadmat
from scipy.spatial import KDTree

from adibas.arrays import FloatArray, UInt8Array
from adibas.calibration.camera_fitting import FittingParams, fit_camera
from adibas.calibration.corners import CornerMethod, FitParams
from adibas.calibration.finder import FinderParams, find_board
from adibas.calibration.lens_models import BROWN_4
from adibas.calibration.refinement import Loss, RefinementParams
from adibas.data.board import Board, BoardCorners
from adibas.data.camera_fit import CameraFit
from benchmarks.calibration_corners import sb_corners
from benchmarks.table import Row

REAL_DATA = "ADIBAS_REAL_DATA"
SQUARES = RefinementParams(loss=Loss.SQUARES)
BOUGUET = {
    "fx": (657.463025, 0.318189),
    "fy": (657.946860, 0.340463),
    "cx": (303.136853, 0.646821),
    "cy": (242.569643, 0.592184),
    "k1": (-0.254027, 0.002483),
    "k2": (0.121439, 0.009864),
    "p1": (-0.000209, 0.000134),
    "p2": (0.000019, 0.000132),
}
"""His values, and his printed tolerances (three standard errors)."""
STORED_WINDOW_PX = 5
TOOLBOX_WINDOW = FinderParams(
    fit=FitParams(method=CornerMethod.GRADIENT, longest_px=STORED_WINDOW_PX, square_share=math.inf)
)
"""The one by which the stored corners were placed, however small the squares."""
METHODS = {
    "corners by gradients": FinderParams(fit=FitParams(method=CornerMethod.GRADIENT)),
    "our corners": FinderParams(),
}
DEFINITIONS = {
    "corners by gradients": "corners as he defines them (--corners gradient, like for like)",
    "our corners": "corners as we define them (--corners edges)",
}
CLOSE_PX, FAR_PX = 0.3, 3.0
"""Stored corners farther than the second from any of ours had not converged, or ours is hidden."""


@dataclass(frozen=True, slots=True)
class RealSet:
    """Images of one board, and the file with the corners that their owner found."""

    name: str
    pattern: str
    board: Board
    stored: str | None = None


SETS = (
    RealSet("Bouguet", "bouguet/Image*.tif", Board(12, 13, 0.03), "bouguet/calib_data.mat"),
    RealSet("OpenCV left", "opencv_left/left*.jpg", Board(9, 6, 0.025)),
    RealSet(
        "Kinect v1",
        "kinect1/LeftRgb*.png",
        Board(10, 7, 0.03),
        "kinect1/Calib_Results_left.mat",
    ),
)


@dataclass(frozen=True, slots=True, eq=False)
class Photo:
    """One image, its number in its name and the board in it."""

    number: int
    gray: UInt8Array
    corners: BoardCorners | None


def rows() -> Iterable[Row]:
    """Measure all sets; nothing without the folder of real data."""
    folder = os.environ.get(REAL_DATA)
    if folder is None:
        return
    root = Path(folder) / "calibration"
    for one in SETS:
        photos = look_at(root, one, FinderParams())
        told = f"{one.name}, {len(photos)} real images"
        yield from _found(told, photos, one.board)
        yield from _beside_opencv(told, photos, one.board)
        if one.stored is not None:
            yield from _stored(told, root, one)
    yield from _bouguet(root)


def look_at(root: Path, real: RealSet, params: FinderParams) -> list[Photo]:
    """Look for the board in every image."""
    photos = []
    for path in sorted(root.glob(real.pattern)):
        gray = np.asarray(cv2.imread(str(path), cv2.IMREAD_GRAYSCALE), np.uint8)
        number = int(re.findall(r"\d+", path.stem)[-1])
        photos.append(Photo(number, gray, find_board(gray, real.board, path.name, params)))
    return photos


def _found(told: str, photos: Sequence[Photo], board: Board) -> Iterator[Row]:
    n_found = sum(photo.corners is not None for photo in photos)
    n_sb = sum(sb_corners(photo.gray, board, 0) is not None for photo in photos)
    n_default = sum(default_corners(photo.gray, board) is not None for photo in photos)
    yield Row(f"{told}: found", n_found, "images", len(photos), "all of them")
    yield Row(f"{told}: found", n_found, "images", n_sb, "SB")
    yield Row(f"{told}: found", n_found, "images", n_default, "OpenCV's default finder")


def default_corners(gray: UInt8Array, board: Board) -> FloatArray | None:
    """Return what OpenCV's tutorial does: its default finder, then cornerSubPix in 11 x 11."""
    is_found, corners = cv2.findChessboardCorners(gray, (board.columns, board.rows))
    if not is_found:
        return None
    stop = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_MAX_ITER, 100, 1e-4)
    refined = cv2.cornerSubPix(gray, corners, (5, 5), (-1, -1), stop)
    return np.asarray(refined.reshape(-1, 2), np.float64)


def _moved_px(gray: UInt8Array, stored: FloatArray) -> FloatArray:
    """Return how far `cornerSubPix` in their window moves stored corners on; 0 if it was done."""
    stop = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_MAX_ITER, 100, 1e-4)
    window = (STORED_WINDOW_PX, STORED_WINDOW_PX)
    starts = stored.astype(np.float32).reshape(-1, 1, 2)
    moved = cv2.cornerSubPix(gray, starts.copy(), window, (-1, -1), stop)
    return np.asarray(np.linalg.norm(moved - starts, axis=-1)[:, 0], np.float64)


def _beside_opencv(told: str, photos: Sequence[Photo], board: Board) -> Iterator[Row]:
    """Our fit on our corners beside OpenCV's on its own, in the images where OpenCV finds them."""
    finders: dict[str, Callable[[UInt8Array], FloatArray | None]] = {
        "SB and cv2.calibrateCamera": lambda gray: sb_corners(gray, board, 0),
        "cornerSubPix and cv2.calibrateCamera": lambda gray: default_corners(gray, board),
    }
    for name, finder in finders.items():
        pairs = [(photo, finder(photo.gray)) for photo in photos if photo.corners is not None]
        both = [(photo, theirs) for photo, theirs in pairs if theirs is not None]
        fit = _fitted(board, [photo for photo, _ in both])
        size = photos[0].gray.shape[::-1]
        points = [board.points_m().astype(np.float32)] * len(both)
        pixels = [theirs.astype(np.float32).reshape(-1, 1, 2) for _, theirs in both]
        rms_px, *_ = cv2.calibrateCamera(points, pixels, size, None, None, flags=cv2.CALIB_FIX_K3)
        label = f"{told}: rms over points, k1 k2 p1 p2, the {len(both)} that OpenCV finds"
        yield Row(label, fit.rms_px, "px", float(rms_px), name)


def _fitted(board: Board, photos: Sequence[Photo]) -> CameraFit:
    found = [photo.corners for photo in photos if photo.corners is not None]
    fit = fit_camera(board, found, FittingParams(model=BROWN_4, refinement=SQUARES))
    if fit is None:
        raise ValueError("so many boards are enough")
    return fit


def _stored(told: str, root: Path, real: RealSet) -> Iterator[Row]:
    """How far our corners are from the stored ones."""
    stored = loadmat(root / str(real.stored))
    for name, params in (
        *METHODS.items(),
        ("corners by gradients in their window", TOOLBOX_WINDOW),
    ):
        apart_px, moved_px = np.concatenate(
            [
                (_apart_px(photo.corners, theirs), _moved_px(photo.gray, theirs))
                for photo in look_at(root, real, params)
                if photo.corners is not None
                for theirs in [stored[f"x_{photo.number}"].T]
            ],
            axis=1,
        )
        is_near, is_settled = apart_px < FAR_PX, moved_px <= CLOSE_PX
        near = apart_px[is_near & is_settled]
        label = f"{told}: {name}, within 0.3 px of the {len(near)} stored ones near any"
        yield Row(label, 100.0 * float((near <= CLOSE_PX).mean()), "%", 100.0, "goal")
        label = f"{told}: {name}, from the stored ones, median"
        yield Row(label, float(np.median(near)), "px", CLOSE_PX, "goal <=")
    yield Row(f"{told}: stored ones near none of ours", int((~is_near).sum()), "corners")
    label = f"{told}: stored ones near ours that OpenCV itself moves on by more than 0.3 px"
    yield Row(label, int((is_near & ~is_settled).sum()), "corners")


def _apart_px(ours: BoardCorners, theirs: FloatArray) -> FloatArray:
    known = ours.pixels[~np.isnan(ours.sigma_px)]
    return np.asarray(KDTree(known).query(theirs)[0], np.float64)


def _bouguet(root: Path) -> Iterator[Row]:
    """His images with his model: like for like with his corners; ours; our model beside it."""
    real = SETS[0]
    for name, params in METHODS.items():
        told = f"Bouguet's images, {DEFINITIONS[name]}"
        photos = look_at(root, real, params)
        fit = _fitted(real.board, photos)
        yield Row(f"{told}: rms over points", fit.rms_px, "px", 0.17, "goal <=")
        yield from _from_his(told, fit)
        found = [photo.corners for photo in photos if photo.corners is not None]
        chosen = fit_camera(real.board, found)
        if chosen is not None:
            label = f"{told}: rms with our model ({chosen.model}), biweight"
            yield Row(label, chosen.rms_px, "px", fit.rms_px, "his model")


def _from_his(told: str, fit: CameraFit) -> Iterator[Row]:
    """Give the farthest parameter from his, then each of them."""
    values = dict(zip(fit.parameter_names, fit.values.tolist(), strict=True))
    apart = {name: abs(values[name] - his) / error for name, (his, error) in BOUGUET.items()}
    farthest = max(apart, key=lambda name: apart[name])
    label = f"{told}: farthest parameter ({farthest}) from his, in his tolerances"
    yield Row(label, apart[farthest], "", 1.0, "goal <=")
    for name, (his, error) in BOUGUET.items():
        label = f"{told}: {name} = {values[name]:.6g}, his {his:.6g} +- {error:.2g}: apart"
        yield Row(label, apart[name], "", 1.0, "goal <=")
