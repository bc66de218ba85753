"""What a calibration of the depth says about itself."""

from dataclasses import replace

import numpy as np
import pytest

from adibas.calibration.depth_bias import (
    camera_covariance,
    color_covariance,
    depth_sd_m,
    weak_directions,
    with_depth,
)
from adibas.calibration.extrinsics import DepthFitParams, DepthStart, fit_depth
from adibas.calibration.extrinsics_model import bias_numbers
from adibas.calibration.extrinsics_pose import find_pose
from adibas.calibration.shots import BoardShot
from adibas.calibration.vertical import Vertical
from adibas.data.calibration import DepthBias, RgbdCalibration
from adibas.geometry.planes import Plane
from adibas.geometry.projection import CAMERA_PARAMETERS
from tests.unit.depth_shots import (
    BIAS,
    BOARD,
    COLOR,
    DEPTH,
    board_shot,
    board_view,
)

RNG = np.random.default_rng
START = DepthStart(DEPTH)
COLOR_NAMES = ("color.fx", "color.fy", "color.k1")
COLOR_COVARIANCE = np.diag([0.5, 0.4, 1e-3]) ** 2


@pytest.fixture(scope="module")
def fit():
    rng = RNG(20)
    return fit_depth(START, [board_shot(f"b{i}", rng, 0.1, 0.0003) for i in range(12)])


def color_alone():
    return RgbdCalibration(
        color=COLOR,
        parameter_names=(*COLOR_NAMES, "depth_bias.a"),
        covariance=np.block([[COLOR_COVARIANCE, np.ones((3, 1))], [np.ones((1, 3)), np.eye(1)]]),
    )


def test_the_color_camera_s_covariance_is_found_among_other_things():
    names = ("color.k1", "depth.fx", "color.fy")
    covariance = np.arange(9.0).reshape(3, 3)
    whole = color_covariance(names, covariance)
    k1, fy = CAMERA_PARAMETERS.index("k1"), CAMERA_PARAMETERS.index("fy")
    assert [whole[k1, k1], whole[k1, fy], whole[fy, k1], whole[fy, fy]] == [0.0, 2.0, 6.0, 8.0]
    assert np.count_nonzero(whole) == 3


def test_one_calibration_has_both_cameras_and_all_covariances(fit):
    joined = with_depth(color_alone(), fit)
    assert joined.depth is DEPTH
    assert joined.depth_bias == fit.bias
    assert joined.parameter_names == (*COLOR_NAMES, *fit.parameter_names)
    np.testing.assert_allclose(joined.covariance[:3, :3], COLOR_COVARIANCE)
    np.testing.assert_allclose(joined.covariance, joined.covariance.T, atol=1e-18)
    sizes = np.sqrt(np.diag(joined.covariance))
    assert np.linalg.eigvalsh(joined.covariance / np.outer(sizes, sizes))[0] > -1e-9
    own = camera_covariance(fit, COLOR_NAMES, COLOR_COVARIANCE)
    np.testing.assert_allclose(joined.covariance[3:, 3:], own)
    assert (np.diag(own) >= fit.standard_deviations**2).all()


def test_a_calibration_without_intervals_gets_those_of_the_depth(fit):
    joined = with_depth(RgbdCalibration(color=COLOR), fit)
    assert joined.parameter_names == fit.parameter_names
    np.testing.assert_allclose(joined.covariance, fit.covariance)


def test_the_fit_goes_with_the_colour_camera_as_its_derivatives_say():
    rng = RNG(22)
    views = [board_view(rng, 0.1, 0.0003) for _ in range(12)]
    k, step = COLOR.intrinsics, 0.05

    def fitted(camera):
        shots = [
            BoardShot("b", find_pose(corners, BOARD, camera), cells) for corners, cells in views
        ]
        return fit_depth(START, shots)

    before = fitted(COLOR)
    for index, name in ((0, "fx"), (3, "cy")):
        after = fitted(replace(COLOR, intrinsics=replace(k, **{name: getattr(k, name) + step})))
        change = bias_numbers(after.bias) - bias_numbers(before.bias)
        expected = before.by_camera[6:, index] * step
        np.testing.assert_allclose(change, expected, atol=0.1 * np.abs(expected).max())


def test_the_depth_s_uncertainty_is_that_of_draws(fit):
    joined = with_depth(RgbdCalibration(color=COLOR), fit)
    pixels, depth_m = np.array([[20.0, 30.0], [320.0, 240.0]]), np.array([1.5, 3.0])
    sd_m = depth_sd_m(joined, pixels, depth_m)
    rng = RNG(23)
    draws = rng.multivariate_normal(bias_numbers(fit.bias), fit.covariance[6:, 6:], 4000)
    corrected = []
    image = np.zeros((DEPTH.height, DEPTH.width), np.float32)
    image[30, 20], image[240, 320] = depth_m
    for a, b, c, *terms in draws[:400].tolist():
        found = DepthBias(a, b, c, tuple(terms)).correct(image, DEPTH)
        corrected.append([found[30, 20], found[240, 320]])
    np.testing.assert_allclose(sd_m, np.std(corrected, axis=0), rtol=0.12)


def test_the_depth_s_uncertainty_needs_a_covariance():
    with pytest.raises(ValueError, match="covariance"):
        depth_sd_m(RgbdCalibration(depth=DEPTH), np.zeros((1, 2)), np.ones(1))


def test_a_vertical_is_kept_with_what_it_is_worth(fit):
    floor = Plane(np.array([0.0, -1.0, 0.0]), 1.0)
    down = np.array([0.0, 1.0, 0.0])
    joined = with_depth(color_alone(), fit, Vertical(down, 0.001, floor, 0.002))
    assert (joined.gravity_sd_rad, joined.floor_flatness_m) == (0.001, 0.002)
    assert joined.floor is floor
    felt = with_depth(color_alone(), fit, Vertical(down, 0.001))
    assert (felt.floor, felt.floor_flatness_m) == (None, None)
    np.testing.assert_array_equal(felt.gravity, down)


def test_frontal_boards_leave_the_shift_open_and_it_is_said(fit):
    rng = RNG(24)
    frontal = [board_shot(f"b{i}", rng, 0.1, 0.0003, tilt_rad=0.02) for i in range(8)]
    poor = fit_depth(START, frontal)
    told = " ".join(sentence.text for sentence in weak_directions(poor, poor.covariance))
    assert "color_from_depth.ty" in told
    assert "from one another" in told
    assert "stay open" in told
    assert weak_directions(fit, fit.covariance) == ()


def test_everything_unknown_has_a_name_and_an_effect():
    rng = RNG(25)
    params = DepthFitParams(n_image_terms=9, focal_sd=0.01, centre_sd_px=6.0)
    fit = fit_depth(START, [board_shot(f"b{i}", rng, 0.1, 0.0003) for i in range(8)], params=params)
    assert len(fit.parameter_names) == 6 + 3 + 9 + 4
    told = weak_directions(fit, np.eye(len(fit.parameter_names)))
    assert len(told) > 10
    assert "badly" in " ".join(sentence.text for sentence in told)
    assert len(BIAS.image_term) == 5
