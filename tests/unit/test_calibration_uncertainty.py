"""What a calibration's error does to pixels and lengths, against repeated calibrations."""

import numpy as np
import pytest
from scipy.optimize import least_squares

from adibas.calibration.camera_fitting import FittingParams, fit_camera
from adibas.calibration.lens_models import BROWN_4
from adibas.calibration.projection_uncertainty import (
    distance_uncertainty,
    map_uncertainty,
    point_uncertainty,
)
from adibas.data.calibration import CameraCalibration
from adibas.geometry.distortion import project_distorted, undistort_pixels
from adibas.geometry.pinhole import Intrinsics
from adibas.geometry.rigid import rotation_from_vector
from tests.unit.calibration_views import BOARD, CAMERA, SIZE, as_corners, drawn_poses, projected

POSES = drawn_poses(np.random.default_rng(1), 8)
PIXELS = np.stack([projected(*pose) for pose in POSES])
TRUTH = CameraCalibration(SIZE[1], SIZE[0], Intrinsics(*CAMERA[:4]), tuple(CAMERA[4:8]))
PLACES_M = np.array([[0.0, 0.0, 0.5], [0.2, -0.15, 0.5], [-0.8, 0.6, 2.0]])
N = 40


@pytest.fixture(scope="module")
def fits():
    """The same boards, calibrated again and again with fresh noise."""
    found = []
    for seed in range(N):
        noise = np.random.default_rng([2, seed]).normal(0, 0.1, PIXELS.shape)
        params = FittingParams(model=BROWN_4)
        found.append(fit_camera(BOARD, as_corners(PIXELS + noise), params))
    return found


def on_boards(vector, camera):
    """Pixels of the true boards in a camera whose frame is moved by a turn and a shift."""
    points_m = np.concatenate(
        [rotation_from_vector(v) @ BOARD.points_m().T + t[:, None] for v, t in POSES], axis=1
    ).T
    moved = points_m @ rotation_from_vector(vector[:3]).T + vector[3:]
    return project_distorted(moved, camera.intrinsics, camera.distortion)


def left_over(fit):
    """Pixels that places move by, when the frame has made up for the error over the boards."""
    wanted = PIXELS.reshape(-1, 2)
    best = least_squares(
        lambda v: (on_boards(v, fit.camera) - wanted).ravel(), np.zeros(6), x_scale=1e-3
    ).x
    moved = PLACES_M @ rotation_from_vector(best[:3]).T + best[3:]
    now = project_distorted(moved, fit.camera.intrinsics, fit.camera.distortion)
    return now - project_distorted(PLACES_M, TRUTH.intrinsics, TRUTH.distortion)


def test_projections_scatter_as_much_as_the_map_says(fits):
    moves = np.array([left_over(fit) for fit in fits])
    worst = [np.sqrt(np.linalg.eigvalsh(np.cov(moves[:, i].T))[-1]) for i in range(len(PLACES_M))]
    said, _ = point_uncertainty(fits[0], PLACES_M)
    # The largest of two axes of 40 samples: about 15 %, and a little too large.
    np.testing.assert_allclose(said, worst, rtol=0.45)


def test_lengths_scatter_as_much_as_is_said(fits):
    ends = np.array([[340.0, 100.0], [340.0, 900.0]])
    lengths = []
    for fit in fits:
        rays = undistort_pixels(ends, fit.camera.intrinsics, fit.camera.distortion)
        lengths.append(2.0 * np.hypot(*(rays[1] - rays[0])))
    said = distance_uncertainty(fits[0], 2.0, float(np.mean(lengths)))
    assert 0.7 * np.std(lengths) < said < 4.0 * np.std(lengths)


def test_the_map_is_worst_at_the_border_and_grows_with_distance(fits):
    near, far = (map_uncertainty(fits[0], z, (5, 7)) for z in (1.0, 4.0))
    assert near.sd_px.shape == (5, 7)
    assert near.sd_px[0, 0] > near.sd_px[2, 3]
    assert (far.sd_m > near.sd_m).all()
    np.testing.assert_allclose(near.pixels[0, 0], [-0.5, -0.5])


def test_a_length_that_fits_nowhere_has_no_uncertainty(fits):
    assert np.isnan(distance_uncertainty(fits[0], 0.3, 5.0))
