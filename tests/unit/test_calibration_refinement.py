"""The joint refinement against OpenCV, differences, gross errors and its own statistics."""

import cv2
import numpy as np
import pytest
from scipy.integrate import quad

from adibas.calibration import refinement_kernels as kernels
from adibas.calibration.camera_fitting import FittingParams, fit_camera, start_from
from adibas.calibration.homography import fit_homography
from adibas.calibration.lens_models import (
    BROWN_4,
    BROWN_5,
    FULL,
    MODELS,
    RATIONAL,
    LensModel,
    model_named,
)
from adibas.calibration.model_choice import choose, covers, fit_models
from adibas.calibration.refinement import (
    Loss,
    RefinementParams,
    empty_arrow,
    observe,
    refine,
)
from adibas.calibration.uncertainty import uncertainty_of
from adibas.calibration.view_shares import view_shares
from adibas.data.board import BoardCorners
from tests.unit.calibration_views import BOARD, CAMERA, SIZE, as_corners, drawn_pixels

SQUARES = RefinementParams(loss=Loss.SQUARES)
FLAGS = {
    BROWN_4: cv2.CALIB_FIX_K3,
    BROWN_5: 0,
    RATIONAL: cv2.CALIB_RATIONAL_MODEL,
    FULL: cv2.CALIB_RATIONAL_MODEL | cv2.CALIB_THIN_PRISM_MODEL,
}


def started(pixels):
    """Observations and the closed form's estimate."""
    observations = observe(BOARD.points_m(), pixels)
    plane = BOARD.points_m()[:, :2]
    return observations, start_from(observations, [fit_homography(plane, p) for p in pixels], SIZE)


@pytest.mark.parametrize("model", FLAGS, ids=lambda model: model.name)
def test_least_squares_end_where_opencv_ends(model):
    pixels = drawn_pixels(np.random.default_rng(1), 12).astype(np.float32).astype(float)
    observations, start = started(pixels)
    ours = refine(observations, start, model, SQUARES)
    assert ours.has_converged
    points = [BOARD.points_m().astype(np.float32)] * len(pixels)
    seen = [p.astype(np.float32) for p in pixels]
    criteria = (cv2.TERM_CRITERIA_COUNT + cv2.TERM_CRITERIA_EPS, 500, 1e-15)
    flags = FLAGS[model]
    theirs_rms, matrix, lens, *_ = cv2.calibrateCamera(
        points, seen, SIZE[::-1], None, None, flags=flags, criteria=criteria
    )
    ours_rms = np.sqrt((ours.residuals_px**2).sum(axis=-1).mean())
    # OpenCV sees the corners of the board in single precision.
    assert ours_rms <= theirs_rms * (1 + 2e-5)
    theirs = [matrix[0, 0], matrix[1, 1], matrix[0, 2], matrix[1, 2]]
    np.testing.assert_allclose(ours.estimate.camera[:4], theirs, atol=1e-3)
    if model in {BROWN_4, BROWN_5}:
        np.testing.assert_allclose(ours.estimate.camera[5:10], lens.ravel()[:5], atol=2e-5)


def test_the_slope_of_the_loss_is_that_of_small_steps():
    observations, start = started(drawn_pixels(np.random.default_rng(2), 3, 0.3))
    free = BROWN_4.free()
    views = kernels.Views(observations.points_m, observations.pixels, observations.sigmas)
    arrow = empty_arrow(len(free), 3)

    def loss(camera, step, into):
        rotations = np.empty_like(start.rotations)
        moved = kernels.turn(start.rotations, start.translations_m, step, rotations)
        guess = kernels.Guess(camera, rotations, moved)
        return kernels.accumulate(views, guess, free, kernels.HUBER, 0.5, into)

    still, other = np.zeros((3, 6)), empty_arrow(len(free), 3)
    loss(start.camera, still, arrow)
    for place, name in enumerate(free):
        step = np.zeros(17)
        step[name] = 1e-5 * max(1.0, start.camera[name])
        up, down = (loss(start.camera + s, still, other) for s in (step, -step))
        expected = -(up - down) / (4 * step[name])
        assert arrow.slope_a[:, place].sum() == pytest.approx(expected, rel=1e-3, abs=1e-3)
    for view in range(3):
        for axis in range(6):
            step = np.zeros((3, 6))
            step[view, axis] = 1e-6
            up, down = (loss(start.camera, s, other) for s in (step, -step))
            assert arrow.slope_c[view, axis] == pytest.approx(
                (up - down) / -4e-6, rel=1e-3, abs=0.1
            )


def test_the_arrow_is_solved_as_the_whole_matrix_would_be():
    observations, start = started(drawn_pixels(np.random.default_rng(3), 4))
    free = BROWN_4.free()
    n = len(free)
    arrow = empty_arrow(n, 4)
    views = kernels.Views(observations.points_m, observations.pixels, observations.sigmas)
    guess = kernels.Guess(start.camera, start.rotations, start.translations_m)
    kernels.accumulate(views, guess, free, kernels.PLAIN, np.inf, arrow)
    whole, slope = np.zeros((n + 24, n + 24)), np.zeros(n + 24)
    whole[:n, :n], slope[:n] = arrow.a.sum(axis=0), arrow.slope_a.sum(axis=0)
    for view in range(4):
        at = slice(n + 6 * view, n + 6 * view + 6)
        whole[:n, at], whole[at, :n] = arrow.b[view], arrow.b[view].T
        whole[at, at], slope[at] = arrow.c[view], arrow.slope_c[view]
    damping = 0.1
    damped = whole + damping * np.diag(np.diag(whole))
    step_a, step_c = np.empty(n), np.empty((4, 6))
    assert kernels.solve_arrow(damping, arrow, np.empty((n, n)), step_a, step_c)
    scale = np.sqrt(np.diag(damped))
    expected = np.linalg.solve(damped / np.outer(scale, scale), slope / scale) / scale
    np.testing.assert_allclose(
        np.concatenate([step_a, step_c.ravel()]) * scale, expected * scale, rtol=1e-6, atol=1e-9
    )


def test_a_singular_system_is_said_to_be_one():
    arrow = empty_arrow(1, 1)
    assert not kernels.solve_arrow(0.0, arrow, np.empty((1, 1)), np.empty(1), np.empty((1, 6)))


def test_points_behind_the_camera_cost_everything():
    observations, start = started(drawn_pixels(np.random.default_rng(4), 3))
    arrow = empty_arrow(4, 3)
    views = kernels.Views(observations.points_m, observations.pixels, observations.sigmas)
    guess = kernels.Guess(start.camera, start.rotations, -start.translations_m)
    free = LensModel(()).free()
    assert kernels.accumulate(views, guess, free, kernels.PLAIN, np.inf, arrow) == np.inf
    assert np.isnan(kernels.residuals_of(views, guess)).all()


def test_nothing_descends_from_a_view_behind_the_camera():
    observations, start = started(drawn_pixels(np.random.default_rng(4), 3))
    start.translations_m[1] *= -1.0
    found = refine(observations, start, LensModel(()), RefinementParams(loss=Loss.SQUARES))
    assert not found.has_converged
    assert found.estimate is start
    assert uncertainty_of(observations, found, LensModel(()), np.inf) is None


def test_gross_errors_change_nothing_that_matters():
    rng = np.random.default_rng(5)
    clean = drawn_pixels(rng, 10)
    spoiled = clean.copy()
    wrong = rng.random(spoiled.shape[:2]) < 0.08
    spoiled[wrong] += rng.uniform(3, 20, (wrong.sum(), 2))
    params = FittingParams(model=BROWN_4)
    before, after = (fit_camera(BOARD, as_corners(p), params) for p in (clean, spoiled))
    assert np.abs((after.values - before.values) / before.standard_deviations).max() < 1.5
    named = [(i, corner) for i, view in enumerate(after.views) for corner in view.outlier_corners]
    assert {tuple(pair) for pair in np.argwhere(wrong)} <= set(named)
    assert len(named) <= wrong.sum() + 3


def test_an_image_with_its_corners_in_the_wrong_order_is_named():
    pixels = drawn_pixels(np.random.default_rng(6), 9)
    pixels[4] = np.roll(pixels[4], 1, axis=0)
    fit = fit_camera(BOARD, as_corners(pixels))
    assert [view.image for view in fit.views if view.is_outlier] == ["view05"]
    assert fit.views[4].weights.max() == 0.0
    assert abs(fit.camera.intrinsics.fx - CAMERA[0]) < 4 * fit.standard_deviations[0]


def test_hidden_corners_take_no_part():
    pixels = drawn_pixels(np.random.default_rng(7), 8)
    pixels[2, :20] = np.nan
    pixels[5, 30:] = np.nan
    fit = fit_camera(BOARD, as_corners(pixels), FittingParams(model=BROWN_4, is_weighted=True))
    assert np.isnan(fit.views[2].weights[:20]).all()
    assert fit.views[2].is_used.sum() == 34
    errors = (fit.values - np.append(CAMERA[:4], CAMERA[4:8])) / fit.standard_deviations
    assert np.abs(errors).max() < 4


def test_nothing_to_fit_gives_nothing():
    pixels = drawn_pixels(np.random.default_rng(8), 1)
    pixels[0, 3:] = np.nan
    assert fit_camera(BOARD, as_corners(pixels)) is None


def test_images_of_two_sizes_are_refused():
    images = as_corners(drawn_pixels(np.random.default_rng(9), 2))
    other = BoardCorners("other", 640, 480, images[1].pixels, images[1].sigma_px)
    with pytest.raises(ValueError, match="one size"):
        fit_camera(BOARD, [images[0], other])
    with pytest.raises(ValueError, match="corners each"):
        fit_camera(BOARD, [BoardCorners("few", 640, 480, np.ones((4, 2)), np.ones(4))])


def test_two_views_are_fitted_with_few_terms():
    fit = fit_camera(BOARD, as_corners(drawn_pixels(np.random.default_rng(10), 2, tilt_rad=0.7)))
    assert fit.model in {"none", "k1", "k1 k2"}


def test_terms_that_the_images_need_are_chosen_and_others_not():
    rng = np.random.default_rng(11)
    observations, start = started(drawn_pixels(rng, 15))
    candidates = fit_models(observations, start)
    assert choose(candidates, SIZE).model == BROWN_4
    assert min(candidates, key=lambda one: one.bic).model == BROWN_4


def test_the_loss_without_a_view_is_that_of_fitting_without_it():
    pixels = drawn_pixels(np.random.default_rng(12), 8)
    observations, start = started(pixels)
    (candidate,) = fit_models(observations, start, [BROWN_4])
    camera = refine(*started(np.delete(pixels, 3, axis=0)), BROWN_4, SQUARES).estimate.camera
    lens = _matrix(camera), camera[5:10]
    _, *pose = cv2.solvePnP(BOARD.points_m(), pixels[3], *lens)
    projected = cv2.projectPoints(BOARD.points_m(), *pose, *lens)[0][:, 0]
    expected = ((projected - pixels[3]) ** 2).sum() / BOARD.n_corners
    assert candidate.left_out_px2[3] == pytest.approx(expected, rel=0.01)


def _matrix(camera):
    return np.array([[camera[0], 0, camera[2]], [0, camera[1], camera[3]], [0, 0, 1.0]])


def test_a_lens_that_folds_inside_the_image_is_refused():
    camera = np.zeros(17)
    camera[:6] = 500, 500, 640, 512, 0, -0.4
    assert not covers(camera, SIZE)
    camera[5] = 0.0
    assert covers(camera, SIZE)
    camera[0] = -1.0
    assert not covers(camera, SIZE)


def test_the_biweights_limit_keeps_95_percent_of_the_efficiency():
    cut = RefinementParams().cut_sigmas

    def mean(function):
        return quad(lambda r: function(r) * r * np.exp(-r * r / 2), 0, cut)[0]

    influence = mean(lambda r: (r * (1 - (r / cut) ** 2) ** 2) ** 2) / 2
    slope = mean(lambda r: (1 - (r / cut) ** 2) * (1 - 3 * (r / cut) ** 2))
    assert slope**2 / influence == pytest.approx(0.95, abs=0.002)


@pytest.mark.parametrize(("kind", "cut"), [(0, np.inf), (1, 2.0), (2, 5.12)])
def test_weights_are_the_slope_of_the_loss(kind, cut):
    for residual in (0.1, 1.0, 1.9, 3.0, 6.0):
        _, weight = kernels.loss_and_weight(residual, kind, cut)
        up, down = (kernels.loss_and_weight(residual + h, kind, cut)[0] for h in (1e-6, -1e-6))
        assert weight * residual == pytest.approx((up - down) / 4e-6, abs=1e-6)


@pytest.mark.parametrize("loss", [Loss.SQUARES, Loss.BIWEIGHT])
def test_intervals_hold_the_truth_as_often_as_they_say(loss):
    truth = np.append(CAMERA[:4], CAMERA[4:8])
    errors = []
    for seed in range(40):
        pixels = drawn_pixels(np.random.default_rng([13, seed]), 10, 0.15)
        params = FittingParams(model=BROWN_4, refinement=RefinementParams(loss=loss))
        fit = fit_camera(BOARD, as_corners(pixels), params)
        errors.append((fit.values - truth) / fit.standard_deviations)
    # Eight correlated hits of each of 40.
    assert 0.90 <= (np.abs(errors) < 1.96).mean() <= 0.99
    assert np.std(errors) == pytest.approx(1.0, abs=0.15)


def test_views_that_share_errors_widen_the_intervals():
    rng = np.random.default_rng(14)
    pixels = drawn_pixels(rng, 12)
    bent = pixels + 0.5 * np.sin(np.arange(54) / 9)[None, :, None] * rng.normal(size=(12, 1, 2))
    params = FittingParams(model=BROWN_4)
    plain, shared = (fit_camera(BOARD, as_corners(p), params) for p in (pixels, bent))
    assert plain.birge_ratio < 1.5
    assert shared.birge_ratio > 3
    ratio = (shared.standard_deviations / plain.standard_deviations) / (
        shared.sigma_px / plain.sigma_px
    )
    assert (ratio > 1.5).all()


def test_the_skew_that_was_drawn_is_found_and_not_used():
    pixels = drawn_pixels(np.random.default_rng(15), 12, 0.02)
    skewed = pixels.copy()
    skewed[..., 0] += 2e-4 * (pixels[..., 1] - CAMERA[3])
    params = FittingParams(model=BROWN_4)
    fit, straight = (fit_camera(BOARD, as_corners(p), params) for p in (skewed, pixels))
    assert abs(fit.skew_px - 2e-4 * CAMERA[1]) < 4 * fit.skew_sd_px
    assert fit.skew_px > 4 * fit.skew_sd_px
    assert abs(straight.skew_px) < 4 * straight.skew_sd_px


def test_too_few_corners_for_the_unknowns_have_no_covariance():
    pixels = drawn_pixels(np.random.default_rng(16), 1)
    pixels[0, 8:] = np.nan
    observations = observe(BOARD.points_m(), pixels)
    _, start = started(drawn_pixels(np.random.default_rng(16), 1))
    refined = refine(observations, start, FULL, SQUARES)
    assert uncertainty_of(observations, refined, FULL, np.inf) is None


def test_frontal_views_are_known_to_say_nothing_of_the_focal_length():
    fit = fit_camera(BOARD, as_corners(drawn_pixels(np.random.default_rng(17), 8, tilt_rad=1e-3)))
    assert not fit.is_settled or fit.standard_deviations[0] > 0.02 * CAMERA[0]


def test_a_view_without_information_has_no_share():
    arrow = empty_arrow(4, 1)
    for part in arrow:
        part[:] = 0.0
    assert view_shares(arrow) is None


def test_models_are_named_by_their_terms():
    assert [model_named(model.name) for model in MODELS] == list(MODELS)
    assert [model.n_stored for model in MODELS] == [0, 4, 4, 5, 4, 5, 12, 8, 12]
    with pytest.raises(ValueError, match="no lens model"):
        model_named("k9")
    with pytest.raises(ValueError, match="terms"):
        LensModel(("k1", "k1"))


@pytest.mark.parametrize(("most_steps", "is_there"), [(1, False), (60, True)])
def test_a_descent_that_runs_out_of_steps_has_converged_if_nothing_is_left_to_gain(
    most_steps, is_there
):
    observations, start = started(drawn_pixels(np.random.default_rng(8), 8))
    endless = RefinementParams(loss=Loss.SQUARES, done=-1.0, most_steps=most_steps)
    assert refine(observations, start, BROWN_4, endless).has_converged is is_there


@pytest.mark.parametrize("seed", range(6))
def test_a_descent_without_an_end_of_its_own_stops_where_rounding_hides_every_gain(seed):
    observations, start = started(drawn_pixels(np.random.default_rng(seed), 8))
    endless = RefinementParams(loss=Loss.SQUARES, done=-1.0, most_steps=10_000)
    with np.errstate(all="raise", under="ignore"):
        assert refine(observations, start, BROWN_4, endless).has_converged
