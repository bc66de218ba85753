"""Markers on leaning skin, by many calibrations from boards: they scatter as each one says."""

from dataclasses import replace

import numpy as np
import pytest

from adibas.calibration.extrinsics import DepthFitParams, DepthStart, fit_depth
from adibas.data.calibration import DepthBias, RgbdCalibration
from adibas.geometry.distortion import pixel_rays, project_distorted
from adibas.markers.disparity import fuse_depth
from adibas.markers.position import DisparityNoise, PositionFinder, PositionParams
from tests.unit.depth_shots import (
    BIAS,
    COLOR,
    COLOR_FROM_DEPTH,
    DEPTH,
    board_shot,
    measured_depth_m,
)

N_CALIBRATIONS = 12
MAKERS = DepthFitParams(focal_sd=0.01, centre_sd_px=6.0, shift_sd_m=0.004)
NO_NOISE = PositionParams(
    noise=DisparityNoise(frame_sd_per_m=1e-5, quantum_per_m=1e-5, static_sd_per_m=0.0)
)
MARKERS_M = np.array([[-0.4, -0.3, 2.0], [0.3, 0.2, 2.0]])
SURE = np.eye(2) * 1e-8


def calibrated(seed):
    """A depth camera whose maker's values are wrong, by ten boards."""
    rng = np.random.default_rng(900 + seed)
    boards = [board_shot(f"b{i}", rng, 0.08, 0.0008) for i in range(10)]
    k = DEPTH.intrinsics
    (fx, fy), (cx, cy) = 1.0 + 0.01 * rng.normal(size=2), 6.0 * rng.normal(size=2)
    told = replace(k, fx=k.fx * fx, fy=k.fy * fy, cx=k.cx + cx, cy=k.cy + cy)
    start = DepthStart(replace(DEPTH, intrinsics=told))
    fit = fit_depth(start, boards, (), COLOR_FROM_DEPTH, MAKERS)
    return RgbdCalibration(
        color=COLOR,
        depth=fit.camera,
        color_from_depth=fit.color_from_depth,
        depth_bias=fit.bias,
        parameter_names=fit.parameter_names,
        covariance=np.array(fit.covariance),
    )


def seen_m(normal, marker_m):
    """What the device shows of a plane through a marker; both in colour axes."""
    in_depth = COLOR_FROM_DEPTH.rotation.T @ normal
    offset_m = normal @ (marker_m - COLOR_FROM_DEPTH.translation_m)
    rays = pixel_rays((DEPTH.height, DEPTH.width), DEPTH.intrinsics, DEPTH.distortion)
    rays = rays.reshape(-1, 2)
    true_m = offset_m / (np.column_stack([rays, np.ones(len(rays))]) @ in_depth)
    shown_m = measured_depth_m(np.where(true_m > 0, true_m, np.nan), rays, BIAS)
    return shown_m.reshape(DEPTH.height, DEPTH.width).astype(np.float32)


@pytest.fixture(scope="module")
def calibrations():
    return [calibrated(seed) for seed in range(N_CALIBRATIONS)]


@pytest.mark.parametrize("normal", [(0.0, 0.0, 1.0), (0.7, 0.0, 0.7), (0.0, 0.7, 0.7)])
def test_markers_of_many_calibrations_scatter_as_their_shared_error_says(calibrations, normal):
    shares = []
    for marker_m in MARKERS_M:
        pixel = project_distorted(marker_m, COLOR.intrinsics, COLOR.distortion)
        shown_m = seen_m(np.array(normal), marker_m)
        for calibration in calibrations:
            burst = fuse_depth([calibration.corrected_depth(shown_m)], DepthBias())
            found = PositionFinder(burst, calibration, NO_NOISE).locate(pixel, SURE)
            error_m = found.position_m[2] - marker_m[2]
            shares.append(error_m**2 / (found.shared_m[2] @ found.shared_m[2]))
    assert 0.4 < np.mean(shares) < 1.8
