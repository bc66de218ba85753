"""Boards before a colour and a depth camera, as exact corners and cells of depth."""

import numpy as np

from adibas.calibration.extrinsics_pose import find_pose
from adibas.calibration.shots import BoardShot, Cells, WallShot
from adibas.data.board import Board, BoardCorners
from adibas.data.calibration import CameraCalibration, DepthBias
from adibas.geometry.distortion import project_distorted
from adibas.geometry.pinhole import Intrinsics
from adibas.geometry.rigid import RigidTransform, rotation_from_vector

BOARD = Board(10, 7, 0.1)
COLOR = CameraCalibration(
    1280, 1024, Intrinsics(1055.0, 1050.0, 645.0, 510.0), (0.05, -0.1, 0.001, -0.0005)
)
DEPTH = CameraCalibration(640, 480, Intrinsics(580.0, 581.0, 322.0, 238.0))
COLOR_FROM_DEPTH = RigidTransform(
    rotation_from_vector(np.array([0.01, -0.02, 0.015])), np.array([-0.026, 0.002, 0.004])
)
BIAS = DepthBias(0.008, 0.99, 0.006, (0.002, -0.001, 0.004, -0.002, 0.003))
CELL_PX = 16


def random_pose(rng, largest_tilt_rad=0.6):
    """Return a ``color_from_board`` between 1 and 3.5 m."""
    distance_m = 1.0 / rng.uniform(1 / 3.5, 1.0)
    axis = rng.uniform(-np.pi, np.pi)
    tilt = largest_tilt_rad * rng.uniform()
    rotation = rotation_from_vector(tilt * np.array([np.cos(axis), np.sin(axis), 0.0]))
    rotation = rotation @ rotation_from_vector(np.array([0.0, 0.0, rng.uniform(-0.3, 0.3)]))
    middle_m = BOARD.points_m().mean(axis=0)
    centre_m = distance_m * np.array([*rng.uniform(-0.25, 0.25, 2), 1.0])
    return RigidTransform(rotation, centre_m - rotation @ middle_m)


def corners_of(pose, rng, sd_px, camera=COLOR, board=BOARD):
    """Return the corners of a board, with noise."""
    pixels = project_distorted(pose.apply(board.points_m()), camera.intrinsics, camera.distortion)
    pixels = pixels + rng.normal(0.0, 1.0, pixels.shape) * sd_px
    sigmas = np.full(board.n_corners, sd_px or 0.05)
    return BoardCorners("board", camera.width, camera.height, pixels, sigmas)


def measured_depth_m(true_m, places, bias):
    """Return what a device with this bias measures, by bisection."""
    x, y = places.T
    terms = (x, y, x * x, x * y, y * y)
    image = sum(f * term for f, term in zip(bias.image_term, terms, strict=False))
    low, high = 0.5 * true_m, 2.0 * true_m
    for _ in range(60):
        middle = 0.5 * (low + high)
        is_low = bias.a + bias.b * middle + (bias.c + image) * middle**2 < true_m
        low, high = np.where(is_low, middle, low), np.where(is_low, high, middle)
    return middle


def cells_of(plane_depth, is_on, bias, rng, sd_per_m):
    """Return the cells of a plane ``1/z = m . ray`` in the depth camera, where `is_on` holds."""
    rows, columns = np.mgrid[0 : DEPTH.height // CELL_PX, 0 : DEPTH.width // CELL_PX]
    blocks = np.stack([rows.ravel(), columns.ravel()], axis=-1)
    k = DEPTH.intrinsics
    u, v = (blocks[:, ::-1] * CELL_PX + (CELL_PX - 1) / 2).T
    places = np.stack([(u - k.cx) / k.fx, (v - k.cy) / k.fy], axis=-1)
    rays = np.column_stack([places, np.ones(len(places))])
    true_m = 1.0 / (rays @ plane_depth)
    kept = is_on(rays * true_m[:, None])
    inverse_m = 1.0 / measured_depth_m(true_m[kept], places[kept], bias)
    inverse_m = inverse_m + rng.normal(0.0, 1.0, kept.sum()) * sd_per_m
    n_pixels = np.full(kept.sum(), float(CELL_PX**2))
    pixels = np.stack([u, v], axis=-1)[kept]
    return Cells(places[kept], pixels, inverse_m, n_pixels, blocks[kept])


def board_shot(name, rng, sd_px=0.0, sd_per_m=0.0, bias=BIAS, tilt_rad=0.6):
    """Return a shot of a board somewhere; of one that both cameras see."""
    corners, cells = board_view(rng, sd_px, sd_per_m, bias, tilt_rad)
    return BoardShot(name, find_pose(corners, BOARD, COLOR), cells)


def board_view(rng, sd_px=0.0, sd_per_m=0.0, bias=BIAS, tilt_rad=0.6):
    """Return corners and cells of a board somewhere."""
    while True:
        pose = random_pose(rng, tilt_rad)
        depth_from_board = COLOR_FROM_DEPTH.inverse() @ pose
        normal = depth_from_board.rotation[:, 2]
        plane = normal / (normal @ depth_from_board.translation_m)

        def is_on(points_m, depth_from_board=depth_from_board):
            x, y, _ = depth_from_board.inverse().apply(points_m).T
            return (x > -0.1) & (x < 1.0) & (y > -0.1) & (y < 0.7)

        cells = cells_of(plane, is_on, bias, rng, sd_per_m)
        corners = corners_of(pose, rng, sd_px)
        if find_pose(corners, BOARD, COLOR) is not None and len(cells) >= 12:
            return corners, cells


def wall_shot(name, distance_m, rng, sd_per_m=0.0, bias=BIAS):
    """Return a slightly turned wall."""
    normal = rotation_from_vector(rng.normal(0.0, 0.1, 3))[2]
    cells = cells_of(
        normal / distance_m, lambda points_m: np.ones(len(points_m), bool), bias, rng, sd_per_m
    )
    return WallShot(name, cells)
