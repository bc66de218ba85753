"""A point distribution model knows what shapes look like, and is laid onto points."""

import numpy as np
import pytest
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation

from adibas.shapes.point_distribution import learn_distribution
from adibas.shapes.procrustes import align_shapes
from adibas.shapes.shape_fitting import fit_shape
from adibas.shapes.similarity import fit_similarity

N_POINTS = 9
NAMES = tuple(f"p{i}" for i in range(N_POINTS))


def shapes_of(n, n_dimensions, n_modes=2, seed=0, noise=0.0, spread=(0.3, 0.15)):
    """Return shapes that vary in `n_modes` ways about one mean, and what they vary."""
    rng = np.random.default_rng(seed)
    basis = np.random.default_rng(42)
    mean = basis.normal(size=(N_POINTS, n_dimensions))
    ways = basis.normal(size=(n_modes, N_POINTS, n_dimensions))
    amounts = rng.normal(size=(n, n_modes)) * np.array(spread)[:n_modes]
    shapes = mean + np.tensordot(amounts, ways, axes=1)
    return shapes + noise * rng.normal(size=shapes.shape)


def moved(shape, seed=0, scale=3.0):
    turn = Rotation.random(random_state=seed).as_matrix()
    if shape.shape[1] == 2:
        turn = Rotation.from_euler("z", 0.7).as_matrix()[:2, :2]
    return scale * shape @ turn.T + np.arange(shape.shape[1]) + 5.0


@pytest.mark.parametrize("n_dimensions", [2, 3])
def test_modes_are_those_of_the_covariance(n_dimensions):
    shapes = shapes_of(60, n_dimensions, noise=0.02)
    model = learn_distribution(NAMES, shapes, kept_variance=1.0)
    aligned = align_shapes(shapes)
    rows = aligned.shapes.reshape(60, -1)
    values = np.linalg.eigvalsh(np.cov(rows.T))[::-1]
    np.testing.assert_allclose(model.variances, values[: len(model.variances)], rtol=1e-6)
    np.testing.assert_allclose(model.modes @ model.modes.T, np.eye(len(model.modes)), atol=1e-9)


def test_so_many_modes_are_kept_as_hold_the_variance():
    shapes = shapes_of(200, 3, noise=0.03)
    whole = learn_distribution(NAMES, shapes, kept_variance=1.0)
    for kept in (0.5, 0.9, 0.98):
        model = learn_distribution(NAMES, shapes, kept_variance=kept)
        held = whole.variances[: len(model.variances)].sum() / whole.variances.sum()
        fewer = whole.variances[: len(model.variances) - 1].sum() / whole.variances.sum()
        assert fewer < kept <= held
        lost = whole.variances.sum() - model.variances.sum()
        assert model.rest_variance == pytest.approx(lost / model.mean.size)


def test_parameters_and_shapes_are_each_other_s_inverse():
    model = learn_distribution(NAMES, shapes_of(50, 3))
    b = np.sqrt(model.variances) * np.linspace(-1, 1, len(model.variances))
    np.testing.assert_allclose(model.parameters(model.shape(b)), b, atol=1e-12)


@pytest.mark.parametrize("n", [15, 60, 300])
def test_ninety_nine_of_a_hundred_new_shapes_are_plausible(n):
    model = learn_distribution(NAMES, shapes_of(n, 3, seed=1, noise=0.03))
    new = shapes_of(1000, 3, seed=2, noise=0.03)
    found = [fit_shape(model, shape, 1e-6).is_plausible for shape in new]
    assert np.mean(found) > 0.975


def test_shapes_of_another_kind_are_not_plausible():
    model = learn_distribution(NAMES, shapes_of(300, 3, seed=1, noise=0.01))
    rng = np.random.default_rng(3)
    others = shapes_of(50, 3, seed=4, noise=0.01)[:, rng.permutation(N_POINTS)]
    fits = [fit_shape(model, shape, 1e-6) for shape in others]
    assert np.mean([fit.is_plausible and fit.result.rms < 0.1 for fit in fits]) < 0.05


def test_an_implausible_shape_is_drawn_back_to_the_limit_and_no_further():
    model = learn_distribution(NAMES, shapes_of(100, 2))
    far = 20 * np.sqrt(model.variances)
    near = model.nearest_plausible(far)
    assert model.distance(near) == pytest.approx(model.limit)
    np.testing.assert_allclose(near / np.linalg.norm(near), far / np.linalg.norm(far))
    np.testing.assert_array_equal(model.nearest_plausible(0.1 * near), 0.1 * near)


@pytest.mark.parametrize("n_dimensions", [2, 3])
def test_a_shape_of_the_model_is_found_wherever_it_stands(n_dimensions):
    model = learn_distribution(NAMES, shapes_of(100, n_dimensions), kept_variance=1.0)
    truth = moved(model.shape(np.sqrt(model.variances) * 1.2), scale=400.0)
    fit = fit_shape(model, truth, 0.01)
    np.testing.assert_allclose(fit.points, truth, atol=0.05)
    assert fit.result.rms < 0.05
    assert fit.is_plausible
    assert len(fit.rounds) < 12


def test_missing_points_are_put_where_the_model_knows_them():
    model = learn_distribution(NAMES, shapes_of(300, 3), kept_variance=1.0)
    truth = moved(model.shape(1.1 * np.sqrt(model.variances)))
    points = truth.copy()
    points[[1, 4]] = np.nan
    fit = fit_shape(model, points, 1e-4)
    np.testing.assert_allclose(fit.points[[1, 4]], truth[[1, 4]], atol=0.01)


def test_no_pose_and_shape_near_by_is_more_probable():
    model = learn_distribution(NAMES, shapes_of(100, 2), kept_variance=1.0)
    rng = np.random.default_rng(5)
    points = moved(model.shape(0.5 * np.sqrt(model.variances)), scale=1.0)
    points += 0.02 * rng.normal(size=points.shape)
    sigma = 0.05
    fit = fit_shape(model, points, sigma)

    def cost(values):
        angle, log_scale, shift, b = values[0], values[1], values[2:4], values[4:]
        turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
        off = points - (np.exp(log_scale) * model.shape(b) @ turn.T + shift)
        return (off**2).sum() / sigma**2 + model.distance(b)

    pose = fit.result.pose
    angle = np.arctan2(pose.rotation[1, 0], pose.rotation[0, 0])
    found = np.concatenate([[angle, np.log(pose.scale)], pose.translation, fit.result.parameters])
    best = minimize(cost, found, method="BFGS")
    assert cost(found) < best.fun * 1.02 + 1e-3


def test_without_sizes_taken_out_a_larger_shape_is_another_shape():
    shapes = shapes_of(200, 3)
    model = learn_distribution(NAMES, shapes, has_scale=False)
    fit = fit_shape(model, 1.6 * moved(shapes[0], scale=1.0), 0.01)
    assert fit.result.pose.scale == 1.0
    assert not (fit.is_plausible and fit.result.rms < 0.05)


def test_too_few_points_fix_nothing():
    model = learn_distribution(NAMES, shapes_of(20, 3))
    points = np.full((N_POINTS, 3), np.nan)
    points[:2] = 1.0
    assert fit_shape(model, points, 0.1) is None


def test_a_model_needs_shapes_that_differ():
    one = shapes_of(1, 3)
    with pytest.raises(ValueError, match="at least 3"):
        learn_distribution(NAMES, np.repeat(one, 2, axis=0))
    with pytest.raises(ValueError, match="differ"):
        learn_distribution(NAMES, np.repeat(one, 5, axis=0))


def test_three_shapes_make_a_model_with_the_limit_of_a_normal_distribution():
    model = learn_distribution(NAMES, shapes_of(3, 2))
    assert model.limit > 5
    assert fit_similarity(model.mean, model.mean) is not None
