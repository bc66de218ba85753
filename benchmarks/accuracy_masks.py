"""Body masks and floors beside the truth: simulated patients, and a real one by others' masks."""

import os
import time
from collections.abc import Iterable, Iterator
from pathlib import Path

import cv2
import numpy as np

from adibas.arrays import BoolArray
from adibas.body.floor import find_floor
from adibas.body.mask import find_body
from adibas.data.calibration import CameraCalibration
from adibas.data.frames import depth_in_metres
from adibas.geometry.pinhole import Intrinsics
from adibas.simulation.scenes import VIEWS, open_scene
from benchmarks.table import Row

SEEDS = range(7000, 7008)
DISTANCES_M = (2.0, 3.5, 3.9)
"""At the last two the end of the room is too far away to be measured."""
REAL_CAMERA = CameraCalibration(640, 480, Intrinsics(525, 525, 320, 240))
REAL_DATA = "ADIBAS_REAL_DATA"


def rows(*, quick: bool) -> Iterable[Row]:
    """Measure; with `quick` two seeds and every tenth real frame."""
    seeds = SEEDS[:2] if quick else SEEDS
    for distance_m in DISTANCES_M:
        yield from _simulated_rows(seeds, distance_m)
    folder = os.environ.get(REAL_DATA)
    if folder is None:
        return
    real = np.array(list(_real_overlaps(Path(folder), step=10 if quick else 1)))
    told = f"real person from the waist up, {len(real)} frames"
    yield Row(f"{told}: median overlap (IoU)", float(np.median(real)), "", 0.93, "goal >=")
    yield Row(f"{told}: worst overlap (IoU)", float(real.min()), "")


def _simulated_rows(seeds: range, distance_m: float) -> Iterator[Row]:
    views = f"{len(VIEWS)} views, seeds {seeds[0]}-{seeds[-1]}"
    told = f"simulated at {distance_m:g} m, {views}, floor found by us"
    results = [_simulated(view, seed, distance_m) for view in VIEWS for seed in seeds]
    overlaps, floors_rad, times_ms = map(np.array, zip(*results, strict=True))
    yield Row(f"{told}: median overlap (IoU)", float(np.median(overlaps)), "", 0.95, "goal >=")
    yield Row(f"{told}: worst overlap (IoU)", float(overlaps.min()), "")
    yield Row("same: largest tilt of the floor", float(np.degrees(floors_rad.max())), "deg")
    yield Row("same: time for floor and mask, median", float(np.median(times_ms)), "ms")


def _simulated(view: str, seed: int, distance_m: float) -> tuple[float, float, float]:
    """Return overlap, angle between found and true floor (rad, NaN: none), and time in ms."""
    scene = open_scene(view, seed=seed, distance_m=distance_m)
    frame, calibration = scene.frame(0), scene.info.calibration
    raw = frame.sensor_frame.depth_raw
    if raw is None or calibration is None or calibration.depth is None or not calibration.floor:
        raise ValueError("a simulated scene has depth, a calibration and a floor")
    depth_m = calibration.corrected_depth(depth_in_metres(raw, scene.info.depth_unit_m))
    find_body(depth_m, calibration.depth, None)
    start = time.perf_counter()
    floor = find_floor(depth_m, calibration.depth)
    body = find_body(depth_m, calibration.depth, floor)
    spent_ms = 1e3 * (time.perf_counter() - start)
    pixels = np.zeros(depth_m.shape, np.bool_) if body is None else body.pixels
    tilt_rad = np.nan
    if floor is not None:
        tilt_rad = float(np.arccos(np.clip(floor.normal @ calibration.floor.normal, -1.0, 1.0)))
    return _overlap(pixels, frame.truth.body_mask), tilt_rad, spent_ms


def _real_overlaps(folder: Path, step: int) -> Iterator[float]:
    for depth_path in sorted((folder / "person_turntable").glob("*_depth.png"))[::step]:
        depth_mm = cv2.imread(str(depth_path), cv2.IMREAD_UNCHANGED)
        mask_path = depth_path.with_name(depth_path.name.replace("_depth.png", "_mask.jpg"))
        mask = cv2.imread(str(mask_path), cv2.IMREAD_GRAYSCALE)
        if depth_mm is None or mask is None:
            raise ValueError(f"{depth_path.name} or its mask cannot be read")
        body = find_body(depth_in_metres(depth_mm.astype(np.uint16), 0.001), REAL_CAMERA)
        pixels = np.zeros(mask.shape, np.bool_) if body is None else body.pixels
        yield _overlap(pixels, np.asarray(mask > 127))


def _overlap(found: BoolArray, truth: BoolArray) -> float:
    return float((found & truth).sum() / max((found | truth).sum(), 1))
