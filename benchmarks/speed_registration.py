"""Depth onto colour: ours beside `cv2.registerDepth`, in turn, on a simulated patient."""

import time
from collections.abc import Callable, Iterable
from dataclasses import replace
from functools import partial

import cv2
import numpy as np

from adibas.alignment.registration import register_depth_nearest, register_pixels
from adibas.arrays import Float32Array
from adibas.data.calibration import RgbdCalibration
from adibas.data.frames import depth_in_metres
from adibas.simulation.scenes import SimulatedScene, open_scene
from benchmarks.table import Row

SEED = 4001


def rows(*, quick: bool) -> Iterable[Row]:
    """Measure; with `quick` fewer rounds."""
    n_rounds = 10 if quick else 60
    small = open_scene("anterior", seed=SEED, color_size=(480, 640))
    depth_m, calibration = _depth(small)
    plain = _without_distortion(calibration)
    transform = np.eye(4)
    transform[:3, :3] = plain.color_from_depth.rotation
    transform[:3, 3] = plain.color_from_depth.translation_m
    depth_matrix, color_matrix = (
        camera.intrinsics.matrix() for camera in (plain.depth, plain.color) if camera
    )

    def opencv() -> object:
        # Its type hints forbid the None that stands for no distortion.
        return cv2.registerDepth(  # type: ignore[call-overload]
            depth_matrix, color_matrix, None, transform, depth_m, (640, 480)
        )

    ours_ms, opencv_ms = medians_ms(
        [lambda: register_depth_nearest(depth_m, plain), opencv], n_rounds
    )
    name = f"640x480, nearest pixel (seed {SEED}{', quick' if quick else ''})"
    yield Row(name, ours_ms, "ms", opencv_ms, "cv2.registerDepth")
    for color_size in ((480, 640), (1024, 1280)):
        scene = open_scene("anterior", seed=SEED, color_size=color_size)
        depth_m, calibration = _depth(scene)
        registering = partial(register_pixels, depth_m, calibration)
        (dense_ms,) = medians_ms([registering], n_rounds)
        yield Row(f"640x480 onto {color_size[1]}x{color_size[0]}, no holes", dense_ms, "ms")


def medians_ms(works: list[Callable[[], object]], n_rounds: int) -> list[float]:
    """Run `works` in turn, `n_rounds` times after a first one; return the median of each, ms."""
    times_s: list[list[float]] = [[] for _ in works]
    for _ in range(n_rounds + 1):
        for work, spent in zip(works, times_s, strict=True):
            start = time.perf_counter()
            work()
            spent.append(time.perf_counter() - start)
    return [1e3 * float(np.median(spent[1:])) for spent in times_s]


def _depth(scene: SimulatedScene) -> tuple[Float32Array, RgbdCalibration]:
    raw, calibration = scene.frame(0).sensor_frame.depth_raw, scene.info.calibration
    if raw is None or calibration is None:
        raise ValueError("a simulated scene has depth and a calibration")
    depth_m = depth_in_metres(raw, scene.info.depth_unit_m)
    return calibration.corrected_depth(depth_m), calibration


def _without_distortion(calibration: RgbdCalibration) -> RgbdCalibration:
    if calibration.color is None:
        raise ValueError("a simulated scene has a colour camera")
    return replace(calibration, color=replace(calibration.color, distortion=()))
