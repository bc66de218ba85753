"""What the size of a marker says beside its place."""

import numpy as np
import pytest
from scipy.stats import norm

from adibas.skeleton.sizes import LOG_RANGE, ODD, SPREAD, size_log_odds


def test_alike_sizes_speak_for_markers_and_one_of_its_own_against_itself():
    odds = size_log_odds(np.array([0.009, 0.0095, 0.0088, 0.0091, 0.0084, 0.03]))
    assert (odds[:5] > 1.0).all()
    assert odds[5] < -6.0


def test_the_odds_are_those_of_the_densities():
    generator = np.random.default_rng(0)
    true_log = np.log(0.010)
    logs = true_log + generator.normal(scale=SPREAD, size=4000)
    odds = size_log_odds(np.exp(logs))
    density = norm(true_log, SPREAD).pdf(logs)
    expected = np.log((1 - ODD) * density * LOG_RANGE + ODD)
    np.testing.assert_allclose(odds, expected, atol=0.1)


def test_the_odds_of_several_sizes_are_those_of_their_density():
    generator = np.random.default_rng(1)
    middles = np.repeat(np.log([0.007, 0.024]), 2000)
    logs = middles + generator.normal(scale=SPREAD, size=4000)
    odds = size_log_odds(np.exp(logs))
    # What is left out of many is their own distribution, blurred once more by the kernel.
    density = 0.5 * norm(middles, SPREAD * np.sqrt(3.0)).pdf(logs)
    expected = np.log((1 - ODD) * density * LOG_RANGE + ODD)
    np.testing.assert_allclose(odds, expected, atol=0.25)


def test_one_size_is_known_more_sharply_than_several_and_whatever_chance_spots_are_among_it():
    markers_m = 0.009 * np.exp(np.linspace(-0.2, 0.2, 13))
    spots_m = np.array([0.0125, 0.04])
    odds = size_log_odds(np.concatenate([markers_m, spots_m]))
    middle = np.argmin(np.abs(markers_m - 0.009))
    sharp = norm(0.0, SPREAD * np.sqrt(1 + 1 / 12)).pdf(0.0) * LOG_RANGE
    assert odds[middle] == pytest.approx(np.log(sharp), abs=0.15)
    assert odds[13] < -1.0  # a third larger than the largest but one
    assert odds[14] < -6.0


def test_two_sizes_in_use_are_both_markers():
    odds = size_log_odds(np.array([0.009] * 5 + [0.020] * 5))
    assert (odds > 0.5).all()


def test_a_scale_common_to_all_changes_nothing():
    sizes_m = np.array([0.009, 0.0095, 0.0088, 0.012, 0.03])
    np.testing.assert_allclose(size_log_odds(2.5 * sizes_m), size_log_odds(sizes_m))


def test_unknown_sizes_say_nothing_of_themselves_or_of_others():
    sizes_m = np.array([0.009, np.nan, 0.0095, 0.0088, 0.03])
    odds = size_log_odds(sizes_m)
    assert odds[1] == 0.0
    np.testing.assert_array_equal(odds[[0, 2, 3, 4]], size_log_odds(sizes_m[[0, 2, 3, 4]]))


@pytest.mark.parametrize("n_known", [0, 1, 3])
def test_too_few_sizes_say_nothing(n_known):
    sizes_m = np.array([0.009, 0.03, 0.015][:n_known] + [np.nan] * 2)
    assert not size_log_odds(sizes_m).any()
