"""Errors along the spine: as alike as they are said to be, and intervals that hold the truth."""

import numpy as np
import pytest

from adibas.surface.course_errors import (
    REACH_M,
    drawn_errors,
    greatest,
    greatest_interval,
    rms,
    rms_interval,
)

Y_M = np.arange(0.95, 1.40, 0.005)
SD = 0.003


def truths():
    """A wave of 12 mm to either side, and half of one."""
    return {"double": 0.012 * np.sin(14.0 * Y_M), "single": 0.012 * np.sin(7.0 * (Y_M - 0.95))}


def errors(n, seed):
    """Errors by the eigenvectors of the formula's matrix: another way than the module's."""
    apart = np.sqrt(3.0) * np.abs(np.subtract.outer(Y_M, Y_M)) / REACH_M
    values, vectors = np.linalg.eigh((1.0 + apart) * np.exp(-apart))
    root = vectors * np.sqrt(np.maximum(values, 0.0))
    return SD * root @ np.random.default_rng(seed).normal(size=(len(Y_M), n))


def test_drawn_errors_are_as_large_and_as_alike_as_told():
    drawn = drawn_errors(Y_M, SD)
    assert drawn.std(axis=1) == pytest.approx(np.full(len(Y_M), SD), rel=0.15)
    for steps, wanted in ((9, 0.816), (18, 0.532)):
        alike = np.mean([np.corrcoef(drawn[i], drawn[i + steps])[0, 1] for i in range(60)])
        assert alike == pytest.approx(wanted, abs=0.08)


def test_the_interval_of_a_greatest_value_holds_it_in_95_of_100_cases():
    """Of a course with one clear peak; a second one as high draws the estimate outward."""
    truth = truths()["single"]
    drawn = drawn_errors(Y_M, SD)
    held = [
        low <= greatest(truth) <= high
        for error in errors(400, 5).T
        for low, high in [greatest_interval((truth + error)[:, None] + drawn)]
    ]
    assert 0.88 < np.mean(held) <= 0.98


@pytest.mark.parametrize("name", ["double", "single"])
def test_the_interval_of_a_root_mean_square_holds_it(name):
    truth = truths()[name]
    drawn = drawn_errors(Y_M, SD)
    held = [
        low <= rms(truth) <= high
        for error in errors(400, 6).T
        for course in [truth + error]
        for low, high in [rms_interval(course, course[:, None] + drawn)]
    ]
    assert 0.90 < np.mean(held) <= 0.99


def test_of_a_straight_course_the_greatest_value_may_lie_to_either_side():
    drawn = drawn_errors(Y_M, SD)
    low, high = greatest_interval(np.zeros((len(Y_M), 1)) + drawn)
    assert low < -SD < SD < high
    assert rms_interval(np.zeros(len(Y_M)), drawn)[0] == 0.0


def test_the_greatest_value_has_its_sign():
    assert greatest(np.array([0.1, -0.4, 0.3])) == -0.4
    assert rms(np.array([3.0, -4.0])) == pytest.approx(np.sqrt(12.5))
