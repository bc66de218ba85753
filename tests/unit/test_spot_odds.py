"""The odds of a faint spot are the quadratic form that was learned."""

import numpy as np
import pytest

from adibas.markers.spot_odds import FEATURES, LEARNED, SpotOdds
from benchmarks.train_spots import learn

N_TERMS = 1 + len(FEATURES)
RNG = np.random.default_rng(4)
ROWS = RNG.normal(size=(30, len(FEATURES)))


def with_bend(bend):
    """Return odds of random weights, the form's square with a weight of its own."""
    rows = [tuple(RNG.normal(size=n)) for n in range(N_TERMS, 1, -1)]
    return SpotOdds((*rows, (bend,)))


def test_the_odds_are_the_sum_of_the_weighted_products():
    odds = with_bend(-3.0)
    for row, found in zip(ROWS, odds.of(ROWS), strict=True):
        terms = [1.0, *row]
        wanted = sum(
            weight * terms[i] * terms[i + j]
            for i, line in enumerate(odds.weights)
            for j, weight in enumerate(line)
        )
        assert found == pytest.approx(wanted)


@pytest.mark.parametrize("bend", [-8.0, -1.0, 0.0, 2.0])
def test_no_form_is_likelier_than_the_best_one(bend):
    odds = with_bend(bend)
    looks = ROWS[:, :-1]
    forms = np.linspace(0.0, 1.0, 2001)
    by_form = [odds.of(np.column_stack([looks, np.full(len(looks), form)])) for form in forms]
    np.testing.assert_allclose(odds.in_best_form(looks), np.max(by_form, axis=0), atol=1e-5)


@pytest.mark.parametrize("weights", [LEARNED[:-1], LEARNED[1:], ((1.0,) * N_TERMS,) * N_TERMS])
def test_weights_that_are_no_upper_triangle_are_refused(weights):
    with pytest.raises(ValueError, match="triangle"):
        SpotOdds(weights)


def test_what_was_drawn_from_odds_is_learned_again():
    """Of 200,000 spots whose chances are known, the odds are found within a tenth."""
    rng = np.random.default_rng(0)
    rows = rng.normal(size=(200_000, len(FEATURES))) * [1, 2, 3, 1, 1, 2, 1, 2] + 1.0
    true = SpotOdds(tuple(tuple(rng.normal(size=n) * 0.2) for n in range(N_TERMS, 0, -1)))
    chances = 1.0 / (1.0 + np.exp(-true.of(rows)))
    found = learn(rows, rng.uniform(size=len(rows)) < chances)
    np.testing.assert_allclose(found.matrix, true.matrix, atol=0.1)
