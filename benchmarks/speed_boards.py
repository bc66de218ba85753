"""How fast boards are drawn, and how exactly: the other side of every figure of a calibration."""

from collections.abc import Iterable, Iterator

import cv2
import numpy as np

from adibas.data.printed_boards import PRINTED_BOARDS
from adibas.simulation.boards import corner_pixels, render_board
from adibas.simulation.boards_poses import random_board_poses
from adibas.simulation.device import COLOR_SIZES, draw_device
from adibas.simulation.scenes import open_scene
from benchmarks.table import Row
from benchmarks.works import median_ms

GOAL_RENDER_MS = 60.0
GOAL_SCENE_HZ = 10.0
FRAMES_APART = 43


def rows(*, quick: bool) -> Iterable[Row]:
    """Measure CPU time on one core, so that what else runs on the machine counts little."""
    n_threads = cv2.getNumThreads()
    cv2.setNumThreads(1)
    try:
        yield from _rows(5 if quick else 40)
    finally:
        cv2.setNumThreads(n_threads)


def _rows(n: int) -> Iterator[Row]:
    for size in COLOR_SIZES:
        name = f"{size[1]}x{size[0]}"
        for in_color, kind in ((False, "grey"), (True, "colour")):
            milliseconds = _ms_a_board(size, n, in_color=in_color)
            yield Row(f"board at {name}, {kind}", milliseconds, "ms", GOAL_RENDER_MS, "goal <=")
        rms_px = _corner_rms_px(size, n)
        yield Row(f"OpenCV's cornerSubPix on grey boards at {name}", rms_px, "px rms")
    for size in COLOR_SIZES:
        name = f"simulator:board, colour {size[1]}x{size[0]} and depth"
        yield Row(name, 1e3 / _ms_a_frame(size, n), "frames/s", GOAL_SCENE_HZ, "goal >=")


def _ms_a_board(size: tuple[int, int], n: int, *, in_color: bool) -> float:
    board, camera = PRINTED_BOARDS["A3"].board, draw_device(1, size).color
    rng = np.random.default_rng(1)
    poses = iter(random_board_poses(rng, board, camera, n + 1))
    return median_ms(lambda: render_board(board, next(poses), camera, rng, in_color=in_color), n)


def _ms_a_frame(size: tuple[int, int], n: int) -> float:
    scene = open_scene("board", 7, color_size=size)
    numbers = iter(range(0, (n + 1) * FRAMES_APART, FRAMES_APART))
    return median_ms(lambda: scene.frame(next(numbers)), n)


def _corner_rms_px(size: tuple[int, int], n: int) -> float:
    """Return the error of OpenCV's refinement, started at the truth."""
    board, camera = PRINTED_BOARDS["A3"].board, draw_device(1, size).color
    rng = np.random.default_rng(2)
    stop = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 100, 1e-5)
    errors = []
    for pose in random_board_poses(rng, board, camera, n):
        image = render_board(board, pose, camera, rng).image
        truth = corner_pixels(board, pose, camera)
        start = np.ascontiguousarray(truth.reshape(-1, 1, 2), np.float32)
        found = cv2.cornerSubPix(image, start, (4, 4), (-1, -1), stop)
        errors.append(found.reshape(-1, 2) - truth)
    return float(np.sqrt((np.concatenate(errors) ** 2).sum(axis=1).mean()))
