"""Mixtures of normal distributions: found where they are, and never narrower than their floor."""

import numpy as np
import pytest
from scipy.stats import multivariate_normal

from adibas.shapes.gaussian_mixture import Mixture, fit_mixture

FLOOR = np.full(2, 1e-6)


def test_two_clouds_are_told_apart():
    rng = np.random.default_rng(3)
    first = rng.normal([0.0, 0.0], [0.2, 0.5], (300, 2))
    second = rng.normal([4.0, -3.0], [0.6, 0.1], (700, 2))
    found = fit_mixture(np.concatenate([first, second]), 2, FLOOR, np.random.default_rng(0))
    order = np.argsort(found.weights)
    np.testing.assert_allclose(found.weights[order], [0.3, 0.7], atol=1e-6)
    np.testing.assert_allclose(found.means[order], [[0, 0], [4, -3]], atol=0.1)
    sds = np.sqrt(np.diagonal(found.covariances, axis1=1, axis2=2))[order]
    np.testing.assert_allclose(sds, [[0.2, 0.5], [0.6, 0.1]], rtol=0.15)


def test_densities_are_those_of_scipy():
    covariances = np.array([[[2.0, 0.3], [0.3, 1.0]], [[0.5, 0.0], [0.0, 0.1]]])
    mixture = Mixture(np.array([0.4, 0.6]), np.array([[0.0, 1.0], [2.0, -1.0]]), covariances)
    rows = np.random.default_rng(1).normal(size=(5, 2))
    for k in range(2):
        expected = multivariate_normal(mixture.means[k], covariances[k]).logpdf(rows)
        expected = expected + np.log(mixture.weights[k])
        np.testing.assert_allclose(mixture.log_densities(rows)[:, k], expected)


def test_rows_that_are_all_the_same_keep_the_floor():
    found = fit_mixture(np.ones((90, 2)), 2, np.array([0.04, 0.09]), np.random.default_rng(0))
    for covariance in found.covariances:
        np.testing.assert_allclose(covariance, np.diag([0.04, 0.09]), atol=1e-9)


def test_a_few_rows_make_one_component():
    rows = np.random.default_rng(2).normal(size=(30, 2))
    assert len(fit_mixture(rows, 5, FLOOR, np.random.default_rng(0)).weights) == 1


def test_arrays_that_do_not_fit_are_refused():
    with pytest.raises(ValueError, match="means"):
        Mixture(np.ones(2), np.zeros((1, 2)), np.ones((1, 2, 2)))
    with pytest.raises(ValueError, match="rows"):
        fit_mixture(np.zeros((4, 3)), 1, FLOOR, np.random.default_rng(0))
