"""Depth of a calibrated sensor beside the truth: planes at each distance, and intervals."""

from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from functools import partial
from multiprocessing import get_context

import numpy as np

from adibas.arrays import FloatArray
from adibas.data.calibration import CameraCalibration, DepthBias
from adibas.simulation.device import Device, draw_device
from benchmarks.calibration_depth_trials import (
    BOARD,
    LARGE_BOARD,
    SPREAD,
    Setting,
    Trial,
    burst_mean,
    measured_inverse,
    rays_of,
    run_trial,
    true_inverse,
)
from benchmarks.calibration_fitting import binomial_interval
from benchmarks.table import Row

BOARDS = {"board 115.5 x 84 cm": LARGE_BOARD, "board A3": BOARD}
CORNER_SDS_PX = (0.06, 0.03)
TEST_DISTANCES_M = (0.8, 1.2, 1.6, 2.0, 2.5, 3.0, 3.5)
N_PROCESSES = 2
GOAL_MM = 3.0


def rows(*, quick: bool) -> Iterable[Row]:
    """Calibrate one simulated device after the other; `quick`: 12 of 200 a setting."""
    n = 12 if quick else 200
    for corner_sd_px in CORNER_SDS_PX:
        for name, board in BOARDS.items():
            trials = _trials(n, Setting(board=board, corner_sd_px=corner_sd_px))
            yield from plane_rows(trials, f"{name}, corners {corner_sd_px:g} px, {n} devices")
            yield from coverage_rows(trials, name)
    with_walls = _trials(n, replace(Setting(), n_boards=12, n_walls=5))
    yield _total_row(with_walls, "12 boards and 5 walls")
    whole = [
        run_trial(draw_device(seed, spread=SPREAD), Setting(), is_frame_by_frame=True)
        for seed in range(1 if quick else 8)
    ]
    worst = 1000.0 * max(float(np.abs(plane_errors_m(trial)[:, 0]).max()) for trial in whole)
    name = f"plane in depth, every frame simulated, {len(whole)} calibrations: worst"
    yield Row(name, worst, "mm", GOAL_MM, "goal <=")


def _trials(n: int, setting: Setting) -> list[Trial]:
    work = partial(run_trial, setting=setting)
    with ProcessPoolExecutor(N_PROCESSES, mp_context=get_context("spawn")) as pool:
        devices = [draw_device(seed, spread=SPREAD) for seed in range(n)]
        return list(pool.map(work, devices, chunksize=4))


def plane_errors_m(trial: Trial) -> FloatArray:
    """Return what `wall_errors_m` does, of a trial's sensor."""
    return wall_errors_m(trial.device, trial.fit.bias, trial.fit.camera)


def wall_errors_m(device: Device, bias: DepthBias, camera: CameraCalibration) -> FloatArray:
    """Return (distance, 3) errors of a frontal wall in depth, burst of 30 frames.

    Of the fitted plane in the middle of the image, the root mean square of the systematic error
    over the image, and the same before any correction.
    """
    rng = np.random.default_rng([device.seed, 0x7E])
    rows = []
    for distance_m in TEST_DISTANCES_M:
        inverse = true_inverse(device, np.array([0.0, 0.0, 1.0 / distance_m]), None, None)
        seen = burst_mean(inverse, device, rng)
        exact_m = (1.0 / measured_inverse(inverse, device)).astype(np.float32)
        corrected_m = bias.correct((1.0 / seen.mean_per_m), camera)
        clean_m = bias.correct(exact_m, camera)
        rays = rays_of(device.depth)
        inner = (slice(None, None, 8), slice(None, None, 8))
        m = np.linalg.lstsq(rays[inner].reshape(-1, 3), 1.0 / corrected_m[inner].ravel())[0]
        rows.append(
            [
                1.0 / m[2] - distance_m,
                np.sqrt(np.mean((clean_m - distance_m) ** 2)),
                np.sqrt(np.mean((exact_m - distance_m) ** 2)),
            ]
        )
    return np.array(rows)


def plane_rows(trials: Sequence[Trial], told: str) -> Iterator[Row]:
    """Give the error of a wall at each distance: of its plane, over the image, and before."""
    errors_mm = 1000.0 * np.array([plane_errors_m(trial) for trial in trials])
    plane, image, before = np.moveaxis(errors_mm, -1, 0)
    for index, distance_m in enumerate(TEST_DISTANCES_M):
        label = f"{told}, wall at {distance_m:g} m, 30 frames"
        before_mm = float(np.sqrt((before[:, index] ** 2).mean()))
        rms_mm = float(np.sqrt((plane[:, index] ** 2).mean()))
        far_mm = float(np.percentile(np.abs(plane[:, index]), 95))
        most_mm = float(np.abs(plane[:, index]).max())
        over_mm = float(np.sqrt((image[:, index] ** 2).mean()))
        yield Row(f"{label}: depth before, rms over the image", before_mm, "mm")
        yield Row(f"{label}: plane, rms", rms_mm, "mm", GOAL_MM, "goal <=")
        yield Row(f"{label}: plane, 95 % below", far_mm, "mm", GOAL_MM, "goal <=")
        yield Row(f"{label}: plane, worst device", most_mm, "mm", GOAL_MM, "goal <=")
        yield Row(f"{label}: rms over the image", over_mm, "mm", GOAL_MM, "goal <=")


def coverage_rows(trials: Sequence[Trial], told: str) -> Iterator[Row]:
    """Give how often 95 % intervals hold the truth, with the binomial interval of that share."""
    is_held = _held(trials)
    for index, name in enumerate(trials[0].fit.parameter_names):
        yield _share_row(f"{told}: 95 % interval of {name} holds the truth", is_held[:, index])
    yield _total_row(trials, f"25 times {told}")


def _total_row(trials: Sequence[Trial], what: str) -> Row:
    # Parameters of one calibration err together: the calibrations are what is counted.
    is_held = _held(trials)
    share = 100.0 * float(is_held.mean())
    half = 196.0 * float(is_held.mean(axis=1).std(ddof=1)) / np.sqrt(len(trials))
    label = f"95 % intervals of the depth camera hold the truth, {what}, {len(trials)} devices"
    return Row(f"{label} ({share - half:.1f}-{share + half:.1f})", share, "%", 95.0, "goal 93-97")


def _share_row(label: str, is_held: FloatArray) -> Row:
    low, high = binomial_interval(int(is_held.sum()), len(is_held))
    share = 100.0 * float(is_held.mean())
    name = f"{label}, {len(is_held)} devices ({low:.1f}-{high:.1f})"
    return Row(name, share, "%", 95.0, "goal 93-97")


def _held(trials: Sequence[Trial]) -> FloatArray:
    """Return the (trials, parameters) intervals that hold the truth, as 0 or 1."""
    errors = np.array([trial.errors() for trial in trials])
    sds = np.array([np.sqrt(np.diag(trial.covariance)) for trial in trials])
    return np.asarray(np.abs(errors) <= 1.959964 * sds, float)
