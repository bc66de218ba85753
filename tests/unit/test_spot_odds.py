"""The odds of a faint spot are those of the network that was learned, among what is about it."""

import math

import numpy as np
import pytest

from adibas.markers.spot_odds import FEATURES, FORMS, LARGEST_CROWD, SpotOdds, crowd_size
from benchmarks.spot_learning import IS_MARKER, IS_NONE, Spots, joined, learn_crowd, learn_look
from benchmarks.train_spots import FRINGES_PX, with_fringes

RNG = np.random.default_rng(4)
ROWS = RNG.normal(size=(30, len(FEATURES)))
RANDOM = SpotOdds(tuple(tuple(RNG.normal(size=2 + len(FEATURES))) for _ in range(5)), 0.3)


def test_alone_the_odds_are_the_sum_of_the_units():
    for row, found in zip(ROWS, RANDOM.alone(ROWS), strict=True):
        wanted = RANDOM.offset + sum(
            value * math.tanh(bias + sum(w * x for w, x in zip(weights, row, strict=True)))
            for value, bias, *weights in RANDOM.units
        )
        assert found == pytest.approx(wanted)


def test_no_form_is_likelier_than_the_best_one():
    looks = ROWS[:, :-1]
    by_form = [RANDOM.alone(np.column_stack([looks, np.full(len(looks), a)])) for a in FORMS]
    best = RANDOM.alone_in_best_form(looks)
    np.testing.assert_allclose(best, np.max(by_form, axis=0))
    between = RANDOM.alone(np.column_stack([looks, RNG.uniform(0.2, 1.0, len(looks))]))
    assert (between <= best + 0.05).all()


def test_a_crowd_counts_by_its_weights():
    odds = SpotOdds(crowd=(2.0, 1.5, -0.5, -0.1))
    alone = np.array([-3.0, 0.0, 4.0])
    for size in (0, 7, LARGEST_CROWD):
        much = math.log(1 + size)
        wanted = 2.0 + 1.5 * alone - 0.5 * much - 0.1 * alone * much
        np.testing.assert_allclose(odds.among(alone, size), wanted)


def test_no_crowd_is_larger_than_those_that_were_learned_from():
    odds, alone = SpotOdds(), np.linspace(-5.0, 5.0, 5)
    most = odds.among(alone, LARGEST_CROWD)
    np.testing.assert_array_equal(odds.among(alone, 10_000), most)


@pytest.mark.parametrize("size", [0, 1, 10, LARGEST_CROWD])
def test_in_any_crowd_the_likelier_spot_stays_the_likelier_one(size):
    assert (np.diff(SpotOdds().among(np.linspace(-12.0, 12.0, 50), size)) > 0.0).all()


def test_in_a_larger_crowd_what_is_in_doubt_is_less_likely():
    odds, doubtful = SpotOdds(), np.linspace(-1.0, 3.0, 9)
    by_size = np.array([odds.among(doubtful, size) for size in range(LARGEST_CROWD)])
    assert (np.diff(by_size, axis=0) < 0.0).all()


def test_the_crowd_is_what_looks_a_little_like_a_marker():
    assert crowd_size(np.array([-20.0, -8.5, -7.5, -4.0, -2.5, -1.0, 6.0])) == 3
    assert crowd_size(np.empty(0)) == 0


@pytest.mark.parametrize("units", [(), ((1.0,) * 9,), ((1.0,) * 10, (1.0,) * 11)])
def test_units_of_another_number_of_weights_are_refused(units):
    with pytest.raises(ValueError, match="unit"):
        SpotOdds(units)


def test_what_was_drawn_from_odds_is_learned_again():
    """Of 40,000 spots whose chances are known; other spots are judged nearly as by the truth."""
    rng = np.random.default_rng(0)
    rows = rng.normal(size=(50_000, len(FEATURES))) * [1, 2, 3, 1, 1, 2, 1, 2] + 1.0
    slope = np.array([1.0, 0.3, -0.3, 0.5, 0.8, -0.4, 0.2, 0.3])
    true = rows @ slope - 1.0 + 2.0 * np.tanh(rows[:, 0] * rows[:, 4])
    is_marker = rng.uniform(size=len(rows)) < 1.0 / (1.0 + np.exp(-true))
    kind, seen = np.where(is_marker, IS_MARKER, IS_NONE), np.arange(len(rows)) < 40_000
    found = learn_look(Spots(rows, kind, np.zeros(len(rows), int)).chosen(seen)).alone(rows)
    losses = [_loss(odds[~seen], is_marker[~seen]) for odds in (found, true, rows @ slope - 1.0)]
    assert losses[0] < losses[1] + 0.01
    assert losses[2] > losses[1] + 0.05  # what bends counts


def _loss(odds, is_marker):
    """Return minus the mean log likelihood."""
    return np.logaddexp(0.0, np.where(is_marker, -odds, odds)).mean()


def test_joined_scenes_keep_their_pictures_apart():
    kind = np.full(4, IS_NONE)
    scenes = [Spots(ROWS[:4], kind, np.array(at)) for at in ([0, 0, 1, 2], [0, 1, 1, 1])]
    empty = Spots(ROWS[:0], kind[:0], np.empty(0, int))
    found = joined([scenes[0], empty, scenes[1]])
    np.testing.assert_array_equal(found.picture, [0, 0, 1, 2, 3, 4, 4, 4])
    np.testing.assert_array_equal(found.features, np.vstack([ROWS[:4], ROWS[:4]]))


def test_what_a_crowd_makes_of_odds_is_learned_again():
    rng = np.random.default_rng(1)
    alone, size = rng.normal(-2.0, 3.0, 100_000), rng.integers(0, 60, 100_000)
    wanted = (1.0, 1.2, -0.6, -0.1)
    chances = 1.0 / (1.0 + np.exp(-_among(wanted, alone, size)))
    found = learn_crowd(np.column_stack([alone, size]), rng.uniform(size=len(alone)) < chances)
    np.testing.assert_allclose(found, wanted, atol=0.12)


def _among(weights, alone, size):
    much = np.log(1.0 + size)
    return weights[0] + weights[1] * alone + weights[2] * much + weights[3] * alone * much


@pytest.mark.parametrize("seed", range(5))
def test_fringes_lay_red_and_blue_apart_and_leave_green_in_place(seed):
    """Seen by the centres of a bright disc, one for each colour."""
    rows, columns = np.mgrid[:61, :61]
    disc = 30.0 + 200.0 / (1.0 + np.exp(np.hypot(rows - 30.0, columns - 30.0) - 8.0))
    picture = np.repeat(np.rint(disc)[..., None], 3, axis=2).astype(np.uint8)
    fringed = with_fringes(picture, np.random.default_rng(seed))
    red, green, blue = (_centre(fringed[..., channel]) for channel in range(3))
    np.testing.assert_array_equal(fringed[..., 1], picture[..., 1])
    assert FRINGES_PX[0] - 0.1 <= np.linalg.norm(red - green) <= FRINGES_PX[1] + 0.1
    cosine = (red - green) @ (blue - green)
    cosine /= np.linalg.norm(red - green) * np.linalg.norm(blue - green)
    assert cosine < -0.95
    assert (picture == np.repeat(np.rint(disc)[..., None], 3, axis=2)).all()


def _centre(channel):
    light = channel.astype(float) - 30.0
    rows, columns = np.mgrid[:61, :61]
    return np.array([(light * columns).sum(), (light * rows).sum()]) / light.sum()
