"""Boards in front of a camera, projected by OpenCV, which shares no code with ours."""

import cv2
import numpy as np

from adibas.arrays import FloatArray
from adibas.data.board import Board, BoardCorners

BOARD = Board(9, 6, 0.025)
SIZE = (1024, 1280)
CAMERA = np.array([1050.0, 1046.0, 645.0, 507.0, 0.06, -0.12, 6e-4, -5e-4, 0.0])


def drawn_poses(
    rng: np.random.Generator, n_views: int, tilt_rad: float = 0.45, camera: FloatArray = CAMERA
) -> list[tuple[FloatArray, FloatArray]]:
    """Rotation vectors and translations of boards that are whole in the picture."""
    poses = []
    while len(poses) < n_views:
        vector = rng.normal(0.0, tilt_rad, 3)
        z_m = rng.uniform(0.3, 0.7)
        middle_m = np.array([rng.uniform(-0.5, 0.5) * z_m, rng.uniform(-0.4, 0.4) * z_m, z_m])
        shift_m = middle_m - cv2.Rodrigues(vector)[0] @ BOARD.points_m().mean(axis=0)
        pixels = projected(vector, shift_m, camera)
        if (pixels > 0).all() and (pixels < (SIZE[1] - 1, SIZE[0] - 1)).all():
            poses.append((vector, shift_m))
    return poses


def projected(vector: FloatArray, shift_m: FloatArray, camera: FloatArray = CAMERA) -> FloatArray:
    """Pixels of the board's corners, by OpenCV."""
    matrix = np.array([[camera[0], 0.0, camera[2]], [0.0, camera[1], camera[3]], [0.0, 0.0, 1.0]])
    return cv2.projectPoints(BOARD.points_m(), vector, shift_m, matrix, camera[4:])[0][:, 0]


def drawn_pixels(
    rng: np.random.Generator, n_views: int, sigma_px: float = 0.1, tilt_rad: float = 0.45
) -> FloatArray:
    """(V, P, 2) noisy corners."""
    pixels = np.stack([projected(*pose) for pose in drawn_poses(rng, n_views, tilt_rad)])
    return pixels + rng.normal(0.0, sigma_px, pixels.shape)


def as_corners(pixels: FloatArray, sigma_px: float = 0.1) -> list[BoardCorners]:
    """Corners of each view, with names."""
    return [
        BoardCorners(
            f"view{i:02d}",
            SIZE[1],
            SIZE[0],
            view.copy(),
            np.where(np.isnan(view).any(axis=1), np.nan, sigma_px),
        )
        for i, view in enumerate(pixels, 1)
    ]
