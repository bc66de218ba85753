"""Intervals of distances and angles against Monte Carlo, most of all near a straight angle."""

import itertools

import numpy as np
import pytest
from scipy.stats import ncx2, rice

from adibas.geometry import uncertainty_kernels as kernels
from adibas.geometry.angles import angle
from adibas.geometry.uncertainty import independent, uncertain_angles, uncertain_distances

N_CASES = 1500
DEPTH = np.array([0.0, 0.0, 1.0])


def covariance(sigma_m, anisotropy=1.0, axis=DEPTH):
    return sigma_m**2 * (np.eye(3) + (anisotropy**2 - 1.0) * np.outer(axis, axis))


def leg(deviation_deg, fold_rad, *, is_straight, lengths_m=(0.4, 0.38)):
    """Hip, knee, ankle 2 m before the camera, bent to the side or towards it."""
    up = np.array([0.0, -1.0, 0.0])
    side = np.array([np.cos(fold_rad), 0.0, np.sin(fold_rad)])
    turn_rad = np.radians(deviation_deg)
    vertex_m = np.array([0.1, 0.2, 2.0])
    base = -up if is_straight else up
    c_m = vertex_m + lengths_m[1] * (np.cos(turn_rad) * base + np.sin(turn_rad) * side)
    return np.stack([vertex_m + lengths_m[0] * up, vertex_m, c_m])


def measured(points_m, covariance_m2, rng, n=N_CASES):
    """Points with noise, and the joint covariance of each case."""
    n_points = len(points_m)
    noise = rng.normal(size=(n, n_points, 3)) @ np.linalg.cholesky(covariance_m2).T
    joint = independent(*[covariance_m2] * n_points)
    return points_m + noise, np.broadcast_to(joint, (n, *joint.shape))


def coverage(found, truth):
    return float(((found.intervals[:, 0] <= truth) & (truth <= found.intervals[:, 1])).mean())


@pytest.mark.parametrize("is_straight", [True, False])
@pytest.mark.parametrize("anisotropy", [1.0, 5.0])
def test_intervals_of_angles_hold_the_truth_however_straight(is_straight, anisotropy):
    rng = np.random.default_rng(11)
    shares = {}
    for deviation_deg, sigma_m, fold_rad in itertools.product(
        (0.0, 0.1, 0.5, 1.0, 2.0, 5.0, 20.0, 70.0), (0.0003, 0.001, 0.005), (0.0, 0.8, np.pi / 2)
    ):
        points_m = leg(deviation_deg, fold_rad, is_straight=is_straight)
        found = uncertain_angles(*measured(points_m, covariance(sigma_m, anisotropy), rng))
        assert (found.intervals >= 0.0).all()
        assert (found.intervals <= np.pi).all()
        assert (found.intervals[:, 0] <= found.values).all()
        assert (found.values <= found.intervals[:, 1]).all()
        shares[deviation_deg, sigma_m, fold_rad] = coverage(found, angle(*points_m))
    assert min(shares.values()) >= 0.92, min(shares, key=shares.get)
    assert max(shares.values()) <= 0.985, max(shares, key=shares.get)
    near_straight = [share for key, share in shares.items() if key[0] <= 5.0]
    assert 0.94 <= np.mean(near_straight) <= 0.97
    assert 0.94 <= np.mean(list(shares.values())) <= 0.97


@pytest.mark.parametrize("anisotropy", [1.0, 5.0])
def test_intervals_of_distances_hold_the_truth_also_near_zero(anisotropy):
    rng = np.random.default_rng(12)
    for distance_m, slant_rad in itertools.product((0.0, 0.003, 0.02, 0.4), (0.0, 0.7, np.pi / 2)):
        across, along = np.cos(slant_rad), np.sin(slant_rad)
        points_m = np.array([[0.0, 0.0, 2.0], [distance_m * across, 0.0, 2.0 + distance_m * along]])
        found = uncertain_distances(*measured(points_m, covariance(0.003, anisotropy), rng))
        assert 0.93 <= coverage(found, distance_m) <= 0.985
        assert (found.intervals[:, 0] >= 0.0).all()


def test_far_from_its_ends_the_interval_is_the_first_order_one():
    points_m = leg(80.0, 0.3, is_straight=True)
    sigma_m = 1e-6
    found = uncertain_angles(points_m[None], independent(*[covariance(sigma_m)[None]] * 3))
    a, c = 0.4, 0.38
    # Both ends and, by the opposite side of the triangle, the vertex: the law of cosines.
    opposite2 = a**2 + c**2 - 2 * a * c * np.cos(found.values[0])
    deviation_rad = sigma_m * np.sqrt(1 / a**2 + 1 / c**2 + opposite2 / (a * c) ** 2)
    expected = found.values[0] + 1.959964 * deviation_rad * np.array([-1.0, 1.0])
    np.testing.assert_allclose(found.intervals[0], expected, atol=1e-4 * deviation_rad)


def test_observed_straight_leg_has_the_exact_limit_of_round_noise():
    """A deviation of 0 is seen: the upper limit is where |z| = r exceeds the circle's limit."""
    sigma_m, length_m = 0.001, 0.4
    points_m = leg(0.0, 0.0, is_straight=True, lengths_m=(length_m, length_m))
    found = uncertain_angles(points_m[None], independent(*[covariance(sigma_m)[None]] * 3))
    scale_rad = np.sqrt(6.0) * sigma_m / length_m
    radius = (np.pi - found.intervals[0, 0]) / scale_rad
    held = ncx2.cdf((2 * radius) ** 2, 2, radius**2)
    assert held == pytest.approx(0.95, abs=2e-4)
    assert found.intervals[0, 1] == np.pi


def test_stated_bias_is_that_of_monte_carlo_for_a_known_truth():
    rng = np.random.default_rng(13)
    nodes, weights = np.polynomial.legendre.leggauss(48)
    nodes, weights = 0.5 * (nodes + 1.0), 0.5 * weights
    for length in (0.0, 0.3, 1.0, 4.0, 12.0):
        vector = length * np.array([0.6, 0.8])
        found = kernels.length_biases(vector[None], np.array([[0.25, 0.25]]), nodes, weights)[0]
        exact = rice.mean(length / 0.5, scale=0.5) - length
        assert found == pytest.approx(exact, abs=1e-4)
        noise = rng.normal(size=(400_000, 2)) * (0.2, 1.0)
        found = kernels.length_biases(vector[None], np.array([[0.04, 1.0]]), nodes, weights)[0]
        mean = np.linalg.norm(vector + noise, axis=1).mean() - length
        assert found == pytest.approx(mean, abs=0.006)


@pytest.mark.parametrize(
    ("deviation_deg", "tolerance"), [(5.0, 0.1), (20.0, 0.05), (70.0, 0.05), (90.0, 0.05)]
)
@pytest.mark.parametrize("is_straight", [True, False])
@pytest.mark.parametrize("fold_rad", [0.0, 0.8])
def test_bias_of_an_angle_is_its_mean_error(deviation_deg, tolerance, is_straight, fold_rad):
    rng = np.random.default_rng(14)
    points_m = leg(deviation_deg, fold_rad, is_straight=is_straight)
    covariance_m2 = covariance(0.0004, 5.0, np.array([0.0, 0.6, 0.8]))
    noisy_m, joint = measured(points_m, covariance_m2, rng, n=30_000)
    # Each noise with both signs: the first order cancels, and the mean error is seen well.
    found = uncertain_angles(
        np.concatenate([noisy_m, 2 * points_m - noisy_m]), np.concatenate([joint, joint])
    )
    errors_rad = (found.values - angle(*points_m)).reshape(2, -1).mean(axis=0)
    scale_rad = 6 * (0.002 / 0.39) ** 2 / (2 * np.sin(np.radians(deviation_deg)))
    error_of_mean_rad = errors_rad.std() / np.sqrt(errors_rad.size)
    allowed_rad = tolerance * scale_rad + 3 * error_of_mean_rad
    assert found.biases.mean() == pytest.approx(errors_rad.mean(), abs=allowed_rad)


def test_noise_bends_a_straight_leg_and_the_bias_says_so():
    rng = np.random.default_rng(15)
    points_m = leg(0.0, 0.0, is_straight=True)
    found = uncertain_angles(*measured(points_m, covariance(0.002), rng))
    mean_error_rad = (found.values - np.pi).mean()
    assert (found.biases < 0).all()
    # The truth is not known: the most plausible one is less straight, which hides some bias.
    assert 0.6 < found.biases.mean() / mean_error_rad < 1.0


def test_an_error_that_all_points_share_does_not_count():
    points_m = leg(10.0, 0.4, is_straight=True)[None]
    own = independent(*[covariance(0.001)[None]] * 3)
    shared = own + np.kron(np.ones((3, 3)), covariance(0.02))
    alone, together = uncertain_angles(points_m, own), uncertain_angles(points_m, shared)
    np.testing.assert_allclose(together.intervals, alone.intervals, atol=1e-7)
    pair = uncertain_distances(points_m[:, :2], shared[:, :6, :6])
    expected = uncertain_distances(points_m[:, :2], own[:, :6, :6])
    np.testing.assert_allclose(pair.intervals, expected.intervals, atol=1e-8)


def test_without_noise_the_interval_is_the_value():
    points_m = leg(10.0, 0.4, is_straight=True)[None]
    found = uncertain_angles(points_m, np.zeros((1, 9, 9)))
    np.testing.assert_allclose(found.intervals, found.values[:, None] * [1, 1], atol=1e-15)
    assert found.biases[0] == pytest.approx(0.0, abs=1e-15)
    same = uncertain_distances(np.ones((1, 2, 3)), np.zeros((1, 6, 6)))
    np.testing.assert_array_equal(same.intervals, [[0.0, 0.0]])
    assert same.biases[0] == 0.0


def test_missing_and_coincident_points_give_no_measure():
    points_m = leg(10.0, 0.4, is_straight=True)
    missing, coincident = points_m.copy(), points_m.copy()
    missing[0, 1] = np.nan
    coincident[2] = coincident[1]
    joint = independent(*[np.stack([covariance(0.001)] * 3)] * 3)
    found = uncertain_angles(np.stack([points_m, missing, coincident]), joint)
    assert np.isfinite(found.intervals[0]).all()
    assert np.isnan(found.values[1:]).all()
    assert np.isnan(found.intervals[1:]).all()
    assert np.isnan(found.biases[1:]).all()


def test_huge_noise_stays_inside_the_range_of_angles():
    points_m = leg(40.0, 0.4, is_straight=False)[None]
    found = uncertain_angles(points_m, independent(*[covariance(1.0)[None]] * 3))
    assert found.intervals[0].tolist() == [0.0, np.pi]


@pytest.mark.parametrize("measure", [uncertain_distances, uncertain_angles])
def test_shapes_are_checked(measure):
    with pytest.raises(ValueError, match="must have shape"):
        measure(np.zeros((4, 5, 3)), np.zeros((4, 6, 6)))


def test_kernels_say_the_same_compiled_or_not(monkeypatch):
    rng = np.random.default_rng(16)
    points_m = np.concatenate([rng.normal(size=(6, 2, 3)), np.ones((2, 2, 3))])
    sigmas_m = np.array([1e-7, 0.001, 0.1, 0.5, 3.0, 0.0, 0.0, 1.0])
    flat = np.diag([1.0, 0.01, 0.0])
    joint = independent(*[sigmas_m[:, None, None] ** 2 * flat] * 2)
    compiled = uncertain_distances(points_m, joint)
    for name in ("critical_value", "excess", "limit_towards", "length_intervals", "length_biases"):
        monkeypatch.setattr(kernels, name, getattr(kernels, name).py_func)
    found = uncertain_distances(points_m, joint)
    np.testing.assert_allclose(found.intervals, compiled.intervals, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(found.biases, compiled.biases, rtol=1e-9, atol=1e-12)


def test_limit_that_is_never_reached_is_the_farthest_sphere():
    d, s, mu = np.array([3.0, 4.0]), np.array([1.0, 1.0]), np.zeros(2)
    table = np.array([100.0, 100.0])
    for limit_towards in (kernels.limit_towards, kernels.limit_towards.py_func):
        assert limit_towards(np.log(2.0), d, s, table, mu) == pytest.approx(2.5)
    assert kernels.critical_value.py_func(np.zeros(2), s, np.array([6.0, 4.0])) == 6.0
