"""Fitting a camera: beside OpenCV on the same corners, its intervals, Q on the thesis' board."""

import math
import time
from collections.abc import Iterable, Iterator

import cv2
import numpy as np
from scipy.stats import beta

from adibas.arrays import FloatArray
from adibas.calibration.camera_fitting import FittingParams, fit_camera, start_from
from adibas.calibration.homography import fit_homography
from adibas.calibration.lens_models import BROWN_4, BROWN_5, FULL, RATIONAL, LensModel
from adibas.calibration.quality import board_errors
from adibas.calibration.refinement import Loss, Refinement, RefinementParams, observe, refine
from adibas.data.board import Board, BoardCorners
from adibas.data.calibration import CameraCalibration
from adibas.data.camera_fit import CameraFit
from adibas.data.printed_boards import PRINTED_BOARDS
from adibas.geometry.distortion import project_distorted
from adibas.pipeline.calibrating import NamedImage, calibrate_camera
from adibas.simulation.boards import render_board
from adibas.simulation.boards_poses import Holding, random_board_poses
from adibas.simulation.device import draw_device
from benchmarks.table import Row

SEED = 4104
N_VIEWS = 20
NOISE_PX = 0.06
BOARD = Board(9, 6, 0.035)
SQUARES = RefinementParams(loss=Loss.SQUARES)
FLAGS = {
    BROWN_4: cv2.CALIB_FIX_K3,
    BROWN_5: 0,
    RATIONAL: cv2.CALIB_RATIONAL_MODEL,
    FULL: cv2.CALIB_RATIONAL_MODEL | cv2.CALIB_THIN_PRISM_MODEL,
}


def rows(*, quick: bool) -> Iterable[Row]:
    """Measure; with `quick` fewer calibrations."""
    yield from _beside_opencv(quick=quick)
    yield from _intervals(10 if quick else 1000)
    yield from _thesis_board(quick=quick)


def simulated_corners(
    seed: int, noise_px: float = NOISE_PX
) -> tuple[CameraCalibration, FloatArray]:
    """Return a simulated device's camera and (V, P, 2) noisy corners of boards held before it."""
    camera = draw_device(seed).color
    rng = np.random.default_rng([SEED, seed])
    poses = random_board_poses(rng, BOARD, camera, N_VIEWS)
    pixels = np.stack(
        [
            project_distorted(pose.apply(BOARD.points_m()), camera.intrinsics, camera.distortion)
            for pose in poses
        ]
    )
    return camera, pixels + rng.normal(0.0, noise_px, pixels.shape)


def _named(pixels: FloatArray, camera: CameraCalibration) -> list[BoardCorners]:
    sigma_px = np.full(pixels.shape[1], NOISE_PX)
    return [
        BoardCorners(f"{i:02d}", camera.width, camera.height, view.copy(), sigma_px.copy())
        for i, view in enumerate(pixels, 1)
    ]


def _ours(pixels: FloatArray, model: LensModel, size: tuple[int, int]) -> Refinement:
    """Fit as `cv2.calibrateCamera` does: closed form, then plain least squares."""
    points_m = BOARD.points_m()
    observations = observe(points_m, pixels)
    homographies = [fit_homography(points_m[:, :2], view, is_refined=False) for view in pixels]
    start = start_from(observations, [h for h in homographies if h is not None], size)
    return refine(observations, start, model, SQUARES)


def _beside_opencv(*, quick: bool) -> Iterator[Row]:
    """Fit the same corners with the same model by plain least squares, in turn."""
    n_rounds = 3 if quick else 20
    for model, flags in FLAGS.items():
        camera, pixels = simulated_corners(1)
        single = pixels.astype(np.float32)
        pixels = single.astype(float)
        size = (camera.height, camera.width)
        points = [BOARD.points_m().astype(np.float32)] * N_VIEWS
        times_s: list[list[float]] = [[], []]
        for _ in range(n_rounds + 1):
            begin = time.process_time()
            ours = _ours(pixels, model, size)
            middle = time.process_time()
            theirs = cv2.calibrateCamera(points, list(single), size[::-1], None, None, flags=flags)
            times_s[0].append(middle - begin)
            times_s[1].append(time.process_time() - middle)
        ours_ms, theirs_ms = (1000.0 * float(np.median(times[1:])) for times in times_s)
        rms_px = math.sqrt(float((ours.residuals_px**2).sum(axis=-1).mean()))
        matrix = theirs[1]
        wanted = np.array([matrix[0, 0], matrix[1, 1], matrix[0, 2], matrix[1, 2]])
        apart_px = float(np.abs(ours.estimate.camera[:4] - wanted).max())
        name = f"20 views 9x6, {model.name}"
        yield Row(f"{name}: CPU time", ours_ms, "ms", theirs_ms, "cv2.calibrateCamera")
        yield Row(f"{name}: rms over points", rms_px, "px", float(theirs[0]), "cv2")
        yield Row(f"{name}: fx fy cx cy apart", apart_px, "px", 1e-3, "goal <=")


def _intervals(n: int) -> Iterator[Row]:
    """How often 95 % intervals hold the truth: all parameters of the model, fixed and chosen."""
    for name, params in (
        ("k1 k2 p1 p2, squares", FittingParams(model=BROWN_4, refinement=SQUARES)),
        ("k1 k2 p1 p2, biweight", FittingParams(model=BROWN_4)),
        ("chosen model, biweight", FittingParams()),
    ):
        held: dict[str, list[bool]] = {}
        for seed in range(n):
            camera, pixels = simulated_corners(seed)
            fit = fit_camera(BOARD, _named(pixels, camera), params)
            if fit is None:
                raise ValueError("simulated corners are always enough")
            for parameter, is_held in intervals_held(fit, camera).items():
                held.setdefault(parameter, []).append(is_held)
        for parameter, hits in held.items():
            share = 100.0 * float(np.mean(hits))
            low, high = binomial_interval(sum(hits), len(hits))
            label = (
                f"95 % interval of {parameter} holds the truth, {name}, {len(hits)} calibrations"
            )
            yield Row(f"{label} ({low:.1f}-{high:.1f})", share, "%", 95.0, "goal 93-97")


def intervals_held(fit: CameraFit, camera: CameraCalibration) -> dict[str, bool]:
    """Say of each parameter whether its 95 % interval holds the truth."""
    k = camera.intrinsics
    names = ("k1", "k2", "p1", "p2", "k3")
    truth = {"fx": k.fx, "fy": k.fy, "cx": k.cx, "cy": k.cy}
    truth |= dict(zip(names, camera.distortion, strict=False))
    half = 1.959964 * fit.standard_deviations
    return {
        name: bool(abs(value - truth.get(name, 0.0)) <= reach)
        for name, value, reach in zip(fit.parameter_names, fit.values, half, strict=True)
    }


def binomial_interval(n_hits: int, n: int) -> tuple[float, float]:
    """Return the 95 % interval of a share in percent (Clopper & Pearson 1934)."""
    low = beta.ppf(0.025, n_hits, n - n_hits + 1) if n_hits > 0 else 0.0
    high = beta.ppf(0.975, n_hits + 1, n - n_hits) if n_hits < n else 1.0
    return 100.0 * float(low), 100.0 * float(high)


def _thesis_board(*, quick: bool) -> Iterator[Row]:
    """Q of rendered pictures: pose from every other corner, error on the rest."""
    board = PRINTED_BOARDS["115.5x84cm"].board
    camera = draw_device(2).color
    rng = np.random.default_rng(SEED)
    holding = Holding(distance_m=(1.2, 3.5), fill=(0.1, 0.9))
    poses = random_board_poses(rng, board, camera, 8 if quick else 60, holding)
    images = [
        NamedImage(f"{i:02d}", render_board(board, pose, camera, rng).image)
        for i, pose in enumerate(poses)
    ]
    outcome = calibrate_camera(images, board)
    if outcome is None or outcome.fit is None:
        raise ValueError("simulated boards are always found")
    errors = board_errors(outcome.fit)
    for near_m, far_m in ((1.2, 2.0), (2.0, 2.75), (2.75, 3.6)):
        chosen = [error.q_m for error in errors if near_m <= error.distance_m < far_m]
        if chosen:
            label = f"Q on the thesis' board, {near_m}-{far_m} m, {len(chosen)} pictures"
            q_mm = 1000.0 * float(np.mean(chosen))
            yield Row(label, q_mm, "mm", 0.5, "goal <=")
            yield Row(label, q_mm, "mm", 3.547, "thesis")
