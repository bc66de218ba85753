"""The live chain on 640x480: people, limbs by forest and cut, joints; in a process of its own.

Depth comes in as the sensor gives it. Time is CPU time of all threads, and the clock's: on a
machine that does other work the latter is of the machine. Memory is the most that the process held.
"""

import multiprocessing
import time
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass

import numpy as np

from adibas.arrays import Float32Array, FloatArray
from adibas.body.mask import find_body
from adibas.data.calibration import CameraCalibration
from adibas.data.frames import depth_in_metres
from adibas.geometry.planes import Plane
from adibas.limbs.segmentation import LimbParams, segment
from adibas.pipeline.limb_segmenting import shipped_model
from adibas.pipeline.person_judge import person_judge
from adibas.pipeline.pose_following import PoseEstimator, forest_segmenter
from adibas.pipeline.pose_model import joint_model_for
from adibas.simulation.scenes import open_scene
from benchmarks.process_memory import peak_memory_mib
from benchmarks.table import Row

SCENES = ("greet", "clap", "bend")
FRAME_MS = 33.0
MOST_MIB = 500.0
WARM_FRAMES = 3


@dataclass(frozen=True, slots=True)
class _Spent:
    """Milliseconds of every frame, and the process's memory."""

    cpu_ms: FloatArray
    clock_ms: FloatArray
    limbs_ms: FloatArray
    memory_mib: float


def chain_rows(n_frames: int) -> Iterator[Row]:
    """Measure `n_frames` of each scene."""
    with ProcessPoolExecutor(1, multiprocessing.get_context("spawn")) as process:
        spent = process.submit(_measure, n_frames).result()
    told = f"whole chain, {len(spent.cpu_ms)} frames 640x480, one person"
    yield Row(f"{told}: median", float(np.median(spent.cpu_ms)), "ms CPU")
    yield Row(f"{told}: 99 % of frames within", float(np.percentile(spent.cpu_ms, 99)), "ms CPU")
    median_ms = float(np.median(spent.clock_ms))
    yield Row(f"{told}: median", median_ms, "ms clock", FRAME_MS, "goal <=")
    most_ms = float(np.percentile(spent.clock_ms, 99))
    yield Row(f"{told}: 99 % of frames within", most_ms, "ms clock", FRAME_MS, "goal <=")
    limbs_ms = float(np.median(spent.limbs_ms))
    yield Row(f"{told}: of it forest and cut, every second pixel", limbs_ms, "ms CPU")
    if spent.memory_mib:
        yield Row(f"{told}: memory of the process", spent.memory_mib, "MiB", MOST_MIB, "goal <")


def _measure(n_frames: int) -> _Spent:
    model = shipped_model()
    times: list[tuple[float, float, float]] = []
    for name in SCENES:
        frames, camera, floor = _frames(name, n_frames + WARM_FRAMES)
        estimator = PoseEstimator(
            *(camera, forest_segmenter(model, camera), floor),
            joints=joint_model_for(model),
            judge=person_judge(model, camera),
        )
        for number, depth_m in enumerate(frames):
            cpu, clock = time.process_time(), time.perf_counter()
            estimator.look(depth_m, number / 30)
            spent = time.process_time() - cpu, time.perf_counter() - clock
            body = find_body(depth_m, camera, floor)
            cpu = time.process_time()
            if body is not None:
                segment(depth_m, body.pixels, camera.intrinsics.fx, model, LimbParams())
            if number >= WARM_FRAMES:
                times.append((*spent, time.process_time() - cpu))
    cpu_ms, clock_ms, limbs_ms = 1000 * np.array(times).T
    return _Spent(cpu_ms, clock_ms, limbs_ms, peak_memory_mib())


def _frames(name: str, n_frames: int) -> tuple[list[Float32Array], CameraCalibration, Plane | None]:
    scene = open_scene(name, seed=11, has_color=False)
    calibration = scene.info.calibration
    if calibration is None or calibration.depth is None:
        raise ValueError("the scene has no calibration")
    raw = [scene.frame(2 * number).sensor_frame.depth_raw for number in range(n_frames)]
    unit_m = scene.info.depth_unit_m
    frames = [depth_in_metres(one, unit_m) for one in raw if one is not None]
    return frames, calibration.depth, calibration.floor
