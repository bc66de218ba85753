"""The finder on boards that others photographed."""

import cv2
import numpy as np
import pytest
from scipy.io import loadmat

from adibas.calibration.finder import find_board
from adibas.data.board import Board

SETS = {
    "bouguet": ("bouguet", "Image*.tif", Board(12, 13, 0.03)),
    "opencv": ("opencv_left", "left*.jpg", Board(9, 6, 0.025)),
    "kinect": ("kinect1", "LeftRgb*.png", Board(10, 7, 0.03)),
}


def found_in(real_data, name):
    folder, pattern, board = SETS[name]
    files = sorted((real_data / "calibration" / folder).glob(pattern))
    grays = [cv2.imread(str(file), cv2.IMREAD_GRAYSCALE) for file in files]
    return board, {
        f.stem: (g, find_board(g, board, f.name)) for f, g in zip(files, grays, strict=True)
    }


def same_method(gray, pixels):
    """Return our places moved by the method of the tools that stored theirs."""
    start = pixels.astype(np.float32).reshape(-1, 1, 2)
    stop = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_MAX_ITER, 100, 1e-4)
    return cv2.cornerSubPix(gray, start, (5, 5), (-1, -1), stop).reshape(-1, 2)


def calibration_rms_px(board, pictures):
    points, pixels = [], []
    for _, corners in pictures:
        seen = ~np.isnan(corners.sigma_px)
        points.append(board.points_m()[seen].astype(np.float32))
        pixels.append(corners.pixels[seen].astype(np.float32).reshape(-1, 1, 2))
    size = pictures[0][0].shape[::-1]
    return cv2.calibrateCamera(points, pixels, size, None, None, flags=cv2.CALIB_FIX_K3)[0]


@pytest.mark.parametrize(
    ("name", "n_images", "most_px"),
    [("bouguet", 20, 0.15), ("opencv", 13, 0.2), ("kinect", 18, 0.42)],
)
def test_every_board_is_found_and_fits_a_camera(real_data, name, n_images, most_px):
    board, found = found_in(real_data, name)
    assert len(found) == n_images
    assert [stem for stem, (_, corners) in found.items() if corners is None] == []
    assert calibration_rms_px(board, list(found.values())) < most_px


@pytest.mark.parametrize(
    ("name", "file", "image"),
    [
        ("bouguet", "bouguet/calib_data.mat", "Image"),
        ("kinect", "kinect1/Calib_Results_left.mat", "LeftRgbobjects"),
    ],
)
def test_our_corners_are_the_stored_ones(real_data, name, file, image):
    """The stored ones were refined by gradients; from our places that method finds them again."""
    stored = loadmat(real_data / "calibration" / file)
    _, found = found_in(real_data, name)
    n_compared = 0
    for number in range(1, len(found) + 1):
        gray, corners = found[f"{image}{number}"]
        theirs = stored[f"x_{number}"].T
        ours = corners.pixels[~np.isnan(corners.sigma_px)]
        moved = same_method(gray, ours)
        apart = np.linalg.norm(theirs[:, None] - moved[None], axis=-1).min(axis=1)
        close = np.linalg.norm(theirs[:, None] - ours[None], axis=-1).min(axis=1) < 3.0
        n_compared += close.sum()
        assert np.quantile(apart[close], 0.97) < 0.3
    assert n_compared > 0.9 * sum(stored[f"x_{n}"].shape[1] for n in range(1, len(found) + 1))
