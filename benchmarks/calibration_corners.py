"""Corners of simulated chessboards beside the truth, and beside OpenCV's finder."""

import time
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from functools import partial

import cv2
import numpy as np

from adibas.arrays import FloatArray, UInt8Array
from adibas.calibration.finder import find_boards, search_board
from adibas.data.board import Board, BoardCorners
from adibas.data.calibration import CameraCalibration
from adibas.data.printed_boards import PRINTED_BOARDS
from adibas.geometry.pinhole import Intrinsics
from adibas.geometry.rigid import RigidTransform
from adibas.simulation.boards import BoardPicture, render_board, render_boards
from adibas.simulation.boards_background import Background
from adibas.simulation.boards_look import BoardLook
from adibas.simulation.boards_poses import Holding, random_board_poses
from adibas.simulation.color_noise import ColorNoise
from benchmarks.table import Row

CAMERA = CameraCalibration(
    1280,
    1024,
    Intrinsics(1050.0, 1050.0, 640.0, 512.0),
    (0.12, -0.25, 0.001, -0.001),
)
GOOD = BoardLook()
CLUTTERED = Background(is_cluttered=True, seed=3)
LOOKS = {
    "good": GOOD,
    "blurred 1.5 px": replace(GOOD, camera=ColorNoise(blur_px=1.5)),
    "blurred 3 px": replace(GOOD, camera=ColorNoise(blur_px=3.0)),
    "noisy (SNR 20)": replace(GOOD, camera=ColorNoise(full_well=400.0)),
    "dark (1/5), uneven": replace(GOOD, exposure=0.16, light_gradient=0.5),
    "moving 4 px": replace(GOOD, motion_px=(4.0, 1.0)),
    "cluttered room": replace(GOOD, background=CLUTTERED),
}
BOARD = PRINTED_BOARDS["A4"].board
SEED = 11
EXACT = cv2.CALIB_CB_EXHAUSTIVE | cv2.CALIB_CB_ACCURACY
HOLDINGS = {
    "": Holding(),
    ", tilted 45-60 degrees": Holding(tilt_rad=(0.785, 1.05), frontal_share=0.0),
    ", small squares 6-12 px": Holding(smallest_square_px=6.0, fill=(0.05, 0.12)),
}


@dataclass(slots=True)
class Tally:
    """What a finder did with pictures of one kind."""

    squared_px: list[FloatArray]
    normalised: list[FloatArray]
    n_found: int = 0
    n_wrong: int = 0
    n_pictures: int = 0
    spent_s: float = 0.0

    def add(self, found: BoardCorners | FloatArray | None, truth: FloatArray) -> None:
        """Count one picture."""
        self.n_pictures += 1
        if found is None:
            return
        pixels = found.pixels if isinstance(found, BoardCorners) else found
        error = pixels - truth
        seen = ~np.isnan(error[:, 0])
        if np.median(np.abs(error[seen])) > 2.0:
            self.n_wrong += 1
            return
        self.n_found += 1
        self.squared_px.append((error[seen] ** 2).sum(axis=1))
        if isinstance(found, BoardCorners):
            self.normalised.append((error[seen] / found.sigma_px[seen, None]).ravel())

    @property
    def rms_px(self) -> float:
        """Root mean square distance from the truth, over corners."""
        return float(np.sqrt(np.concatenate(self.squared_px).mean())) if self.n_found else np.nan

    @property
    def spread(self) -> float:
        """Root mean square of error by its own standard deviation."""
        return float(np.sqrt((np.concatenate(self.normalised) ** 2).mean()))

    @property
    def time_ms(self) -> float:
        """Mean time of a picture."""
        return 1e3 * self.spent_s / max(self.n_pictures, 1)


def sb_corners(gray: UInt8Array, board: Board, flags: int) -> FloatArray | None:
    """Return what OpenCV's sector-based finder says."""
    is_found, corners = cv2.findChessboardCornersSB(gray, (board.columns, board.rows), flags=flags)
    return corners.reshape(-1, 2).astype(float) if is_found else None


def _turned_alike(corners: FloatArray | None, truth: FloatArray) -> FloatArray | None:
    """Count OpenCV's corners from the other end where that is nearer the truth."""
    if corners is None:
        return None
    known = ~np.isnan(truth[:, 0])
    both = corners, corners[::-1]
    return min(both, key=lambda c: float(np.abs(c[known] - truth[known]).sum()))


def pictures(
    board: Board, look: BoardLook, holding: Holding, n: int, seed: int
) -> Iterator[BoardPicture]:
    """Render `n` boards held at different places, without those seen from behind."""
    rng = np.random.default_rng(seed)
    poses = random_board_poses(rng, board, CAMERA, n, holding)
    for pose in poses:
        if _faces(pose):
            yield render_board(board, pose, CAMERA, rng, look)


def _faces(camera_from_board: RigidTransform) -> bool:
    """Say whether the camera sees the front of a board's plane.

    Tilted by 60 degrees and beside the image's middle, a board may turn its back.
    """
    return bool(camera_from_board.rotation[:, 2] @ camera_from_board.translation_m > 0.0)


def measure(
    board: Board, look: BoardLook, holding: Holding, n: int, *, with_opencv: bool = True
) -> dict[str, Tally]:
    """Let the finders look at the same pictures, one after the other, each on one thread."""
    finders: dict[str, Callable[[UInt8Array], BoardCorners | FloatArray | None]] = {
        "ours": lambda gray: search_board(gray, board, "simulated").corners
    }
    if with_opencv:
        finders["SB"] = lambda gray: sb_corners(gray, board, 0)
        finders["SB exhaustive"] = lambda gray: sb_corners(gray, board, EXACT)
    tallies = {name: Tally([], []) for name in finders}
    for picture in pictures(board, look, holding, n, SEED):
        truth = picture.corners_px[0]
        for name, finder in finders.items():
            start = time.thread_time()
            found = finder(picture.image)
            tallies[name].spent_s += time.thread_time() - start
            if not isinstance(found, BoardCorners):
                found = _turned_alike(found, truth)
            tallies[name].add(found, truth)
    return tallies


def rows(*, quick: bool) -> Iterable[Row]:
    """Measure; with `quick` few pictures of some kinds, and OpenCV on the good ones alone."""
    cv2.setNumThreads(1)
    n = 2 if quick else 40
    measure(BOARD, GOOD, Holding(), 1)
    for holding_name, holding in HOLDINGS.items():
        for look_name, look in LOOKS.items():
            if quick and holding_name and look is not GOOD:
                continue
            with_opencv = not quick or (look is GOOD and not holding_name)
            tallies = measure(BOARD, look, holding, n, with_opencv=with_opencv)
            told = f"{look_name}{holding_name}, {tallies['ours'].n_pictures} pictures"
            yield from _simulated_rows(told, tallies)
    yield from _boardless_rows()


def _simulated_rows(told: str, tallies: dict[str, Tally]) -> Iterator[Row]:
    ours, others = tallies["ours"], [name for name in tallies if name != "ours"]
    yield Row(f"{told}: rms over corners", ours.rms_px, "px", 0.06, "goal <=")
    for name in others:
        yield Row(f"{told}: rms", ours.rms_px, "px", tallies[name].rms_px, name)
    yield Row(f"{told}: rms of error by its own deviation", ours.spread, "", 1.0, "ideal")
    yield Row(f"{told}: found", 100 * ours.n_found / ours.n_pictures, "%")
    for name in others:
        share = 100 * tallies[name].n_found / tallies[name].n_pictures
        yield Row(f"{told}: found", 100 * ours.n_found / ours.n_pictures, "%", share, name)
    yield Row(f"{told}: put in a wrong place", ours.n_wrong, "pictures", 0, "goal")
    for name in others:
        yield Row(f"{told}: CPU time", ours.time_ms, "ms", tallies[name].time_ms, name)


def _boardless_rows() -> Iterator[Row]:
    """Time what it takes to see that there is no board, 1280 x 1024."""
    rng = np.random.default_rng(1)
    images = {
        "an empty wall": render_boards((), CAMERA, rng, GOOD).image,
        "a cluttered room": render_boards((), CAMERA, rng, LOOKS["cluttered room"]).image,
        "white noise": rng.integers(0, 256, (1024, 1280), np.uint8),
    }
    for name, image in images.items():
        if find_boards(image):
            raise AssertionError(f"a board is seen in {name}")
        ours_ms = _median_ms(partial(find_boards, image))
        theirs_ms = _median_ms(partial(sb_corners, image, BOARD, 0))
        yield Row(f"no board, {name}", ours_ms, "ms", 45.0, "goal <=")
        yield Row(f"no board, {name}", ours_ms, "ms", theirs_ms, "SB")


def _median_ms(look: Callable[[], object]) -> float:
    spent = []
    for _ in range(7):
        start = time.thread_time()
        look()
        spent.append(time.thread_time() - start)
    return 1e3 * float(np.median(spent))
