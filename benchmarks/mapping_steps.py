"""The dense step of one pair beside OpenCV's odometry, and its features apart.

Both begin from frames that are prepared, without a guess. Times are the work of all cores, the
least of some rounds: another program may be running.
"""

import time
from collections.abc import Callable, Iterator

import cv2
import numpy as np

from adibas.alignment.features import follow_corners
from adibas.alignment.joint_fit import fit_joint
from adibas.arrays import FloatArray
from adibas.geometry.rigid import IDENTITY, RigidTransform
from benchmarks.mapping_far import motion_error
from benchmarks.mapping_rooms import RoomPair, room_pair
from benchmarks.table import Row

SEEDS = range(1000, 1012)
TURN_RAD, SHIFT_M = np.radians(1.5), 0.03
N_ROUNDS = 5
OPENCV = "cv2.Odometry"


def step_rows(*, quick: bool) -> Iterator[Row]:
    """Measure pairs of rooms 1.5 degrees and 3 cm apart."""
    seeds = SEEDS[:3] if quick else SEEDS
    pairs = [pair for seed in seeds if (pair := room_pair(seed, TURN_RAD, SHIFT_M)) is not None]
    found = np.array([_measured(pair) for pair in pairs])
    ours_ms, opencv_ms, features_ms, ours_mm, opencv_mm = np.nanmedian(found, axis=0).tolist()
    told = f"one pair of 640x480, surfaces alone, {len(pairs)} rooms"
    yield Row(f"{told}: work, median", ours_ms, "ms", opencv_ms, OPENCV)
    yield Row("same: error of the shift, median", ours_mm, "mm", opencv_mm, OPENCV)
    yield Row("same: features to follow, work apart, median", features_ms, "ms")


def _measured(pair: RoomPair) -> FloatArray:
    """Return times (ms) of both and of features, and errors (mm) of both."""
    target, source = pair.target.sight, pair.source.sight
    fit = fit_joint(target, source, IDENTITY)
    ours = None if fit is None else fit.target_from_source
    opencv, opencv_ms = _by_opencv(pair)
    return np.array(
        [
            _least_ms(lambda: fit_joint(target, source, IDENTITY)),
            opencv_ms,
            _least_ms(lambda: follow_corners(target, source, IDENTITY)),
            _error_mm(ours, pair),
            _error_mm(opencv, pair),
        ]
    )


def _by_opencv(pair: RoomPair) -> tuple[RigidTransform | None, float]:
    """Return what OpenCV finds, and how long it takes."""
    lens = pair.target.sight.view.camera.intrinsics
    settings = cv2.OdometrySettings()
    settings.setCameraMatrix(lens.matrix().astype(np.float32))
    odometry = cv2.Odometry(cv2.OdometryType_DEPTH, settings, cv2.OdometryAlgoType_COMMON)
    source, target = (
        cv2.OdometryFrame(1.0 / moment.sight.view.levels[0].inverse_per_m)
        for moment in (pair.source, pair.target)
    )
    odometry.prepareFrames(source, target)
    is_found, found = odometry.compute(source, target)
    took_ms = _least_ms(lambda: odometry.compute(source, target))
    if not is_found:
        return None, took_ms
    matrix = np.asarray(found, float)
    left, _, right = np.linalg.svd(matrix[:3, :3])
    return RigidTransform(left @ right, matrix[:3, 3]), took_ms


def _error_mm(motion: RigidTransform | None, pair: RoomPair) -> float:
    return np.nan if motion is None else 1e3 * motion_error(motion, pair.target_from_source)[0]


def _least_ms(work: Callable[[], object]) -> float:
    spent_s = []
    for _ in range(N_ROUNDS):
        begin_s = time.process_time()
        work()
        spent_s.append(time.process_time() - begin_s)
    return 1e3 * min(spent_s)
