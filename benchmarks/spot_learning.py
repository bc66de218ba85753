"""From spots to the odds that one is a marker: a network of one layer, and what a crowd does."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import minimize
from scipy.special import expit

from adibas.arrays import BoolArray, Float32Array, FloatArray, IntArray
from adibas.markers.spot_odds import SpotOdds, crowd_size, log_crowd

N_UNITS, RIDGE, N_STEPS = 24, 5.0, 600
UNIT_SEED = 0
LEAST_ODDS = -12.0
"""Of spots by which it is learned what a crowd makes of log odds: all others are no markers."""
IS_MARKER, IS_NONE, IS_OPEN = 1, 0, -1
NO_CROWD = 0.0, 1.0, 0.0, 0.0


@dataclass(frozen=True, slots=True, eq=False)
class Spots:
    """N spots to learn from.

    Attributes
    ----------
    features : (N, 8) array
    kind : (N,) int array
        `IS_MARKER`, `IS_NONE`, or `IS_OPEN`: of no use but as one of the crowd.
    picture : (N,) int array
        Which picture each is in.
    """

    features: FloatArray
    kind: IntArray
    picture: IntArray

    @property
    def known(self) -> "Spots":
        """Return those that are a marker, or surely none."""
        return self.chosen(self.kind != IS_OPEN)

    def chosen(self, is_chosen: BoolArray) -> "Spots":
        """Return some of them."""
        return Spots(self.features[is_chosen], self.kind[is_chosen], self.picture[is_chosen])


def joined(found: Sequence[Spots]) -> Spots:
    """Return the spots of several scenes, whose pictures are different ones."""
    n_pictures = [one.picture.max(initial=-1) + 1 for one in found]
    before = np.cumsum([0, *n_pictures[:-1]])
    return Spots(
        np.concatenate([one.features for one in found]),
        np.concatenate([one.kind for one in found]),
        np.concatenate([one.picture + n for one, n in zip(found, before, strict=True)]),
    )


def learn_all(parts: Sequence[Spots]) -> SpotOdds:
    """Learn the network from all spots, and the crowd's weights from what it says of unseen ones.

    For that, each of the two parts is judged by a network which learned from the other.
    """
    first, second = parts
    judged = [
        _crowded(learn_look(first.known), second),
        _crowded(learn_look(second.known), first),
    ]
    rows = np.concatenate([one[0] for one in judged])
    is_marker = np.concatenate([one[1] for one in judged])
    return replace(learn_look(joined(parts).known), crowd=learn_crowd(rows, is_marker))


def _crowded(odds: SpotOdds, spots: Spots) -> tuple[FloatArray, BoolArray]:
    """Return the log odds of each known spot alone and its crowd, (N, 2), and what is a marker."""
    in_best_form = odds.alone_in_best_form(spots.features[:, :-1])
    crowds = np.zeros(len(in_best_form))
    for picture in np.unique(spots.picture):
        is_there = spots.picture == picture
        crowds[is_there] = crowd_size(in_best_form[is_there])
    rows = np.column_stack([odds.alone(spots.features), crowds])
    is_used = (spots.kind != IS_OPEN) & (rows[:, 0] > LEAST_ODDS)
    return rows[is_used], spots.kind[is_used] == IS_MARKER


def learn_look(spots: Spots) -> SpotOdds:
    """Return the network that tells markers from others best, with a ridge; no crowd counts."""
    mean, sd = spots.features.mean(axis=0), spots.features.std(axis=0)
    inputs = ((spots.features - mean) / sd).astype(np.float32)
    is_marker = spots.kind == IS_MARKER
    network = _Network(inputs, is_marker)
    found = minimize(
        network.loss,
        network.start(),
        jac=True,
        method="L-BFGS-B",
        options={"maxiter": N_STEPS, "maxfun": 2 * N_STEPS, "maxcor": 20},
    ).x
    values, biases, weights, offset = network.parts(found)
    weights = weights / sd
    units = np.column_stack([values, biases - weights @ mean, weights])
    rounded = tuple(tuple(_rounded(value) for value in unit) for unit in units)
    return SpotOdds(rounded, _rounded(offset), NO_CROWD)


class _Network:
    """Minus log likelihood of (N, F) inputs, as a function of one vector of weights."""

    def __init__(self, inputs: Float32Array, is_marker: BoolArray) -> None:
        self._inputs, self._is_marker = inputs, is_marker
        self._n_inputs = inputs.shape[1]

    def start(self) -> FloatArray:
        """Return small random weights, and the offset of something seldom."""
        rng = np.random.default_rng(UNIT_SEED)
        n = self._n_inputs
        weights = rng.normal(0.0, 1.0 / math.sqrt(n), n * N_UNITS)
        return np.concatenate([rng.normal(0.0, 0.5, 2 * N_UNITS), weights, [-4.0]])

    def parts(self, vector: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray, float]:
        """Return the units' (U,) values, (U,) biases and (U, F) weights, and the offset."""
        values, biases = vector[:N_UNITS], vector[N_UNITS : 2 * N_UNITS]
        weights = vector[2 * N_UNITS : -1].reshape(N_UNITS, self._n_inputs)
        return values, biases, weights, float(vector[-1])

    def loss(self, vector: FloatArray) -> tuple[float, FloatArray]:
        """Return it and its gradient."""
        values, biases, weights, offset = self.parts(vector.astype(np.float32))
        units = np.tanh(self._inputs @ weights.T + biases)
        log_odds = (units @ values).astype(float) + offset
        ridge = RIDGE * np.append(vector[:-1], 0.0)
        value, slope_of_odds = _unlikelihood(log_odds, self._is_marker)
        error = slope_of_odds.astype(np.float32)
        through = error[:, None] * values * (1.0 - units**2)
        slopes = (units.T @ error, through.sum(axis=0), (through.T @ self._inputs).ravel())
        slope = np.concatenate([*slopes, [error.sum()]]).astype(float) + ridge
        return value + 0.5 * float(ridge @ vector), slope


def learn_crowd(rows: FloatArray, is_marker: BoolArray) -> tuple[float, float, float, float]:
    """Return the weights of 1, log odds, crowd and both, of (N, 2) log odds alone and crowds."""
    alone, much = rows[:, 0], log_crowd(rows[:, 1])
    terms = np.column_stack([np.ones(len(rows)), alone, much, alone * much])

    def loss(weights: FloatArray) -> tuple[float, FloatArray]:
        log_odds = terms @ weights
        value, error = _unlikelihood(log_odds, is_marker)
        return value, terms.T @ error

    found = minimize(loss, np.array(NO_CROWD), jac=True).x
    base, slope, of_crowd, of_both = (_rounded(value) for value in found)
    return base, slope, of_crowd, of_both


def _unlikelihood(log_odds: FloatArray, is_marker: BoolArray) -> tuple[float, FloatArray]:
    """Return minus the log likelihood of what is a marker, and its (N,) slope by log odds."""
    value = np.logaddexp(0.0, log_odds).sum() - log_odds[is_marker].sum()
    return float(value), np.asarray(expit(log_odds) - is_marker)


def _rounded(value: float) -> float:
    return float(f"{value:.5g}")
