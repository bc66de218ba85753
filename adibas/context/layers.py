"""Layers that learn: what they make, and the way back for derivatives.

Each layer's ``forward`` returns what it made, and a function that takes the derivatives of the loss
by that, leaves those by its own numbers in `gradients`, and returns those by what came in.
"""

from collections.abc import Callable
from typing import TypeAlias

import numpy as np

from adibas.arrays import AnyArray, Float32Array, FloatArray, Int32Array
from adibas.context.kernels import (
    AS_IT_IS,
    combined,
    convolved,
    mirrored,
    rectified,
    slopes_of_rectified,
    sums_with,
    weight_gradient,
)
from adibas.context.network import with_nothing
from adibas.context.sites import N_NEIGHBORS, SiteLevel

Back: TypeAlias = Callable[[Float32Array], Float32Array]
_FORGETS = 0.02
"""Share of the running mean and variance that each batch replaces; of few, each has the same."""
_LEAST_VARIANCE = 1e-5
_FIRST_LENGTH, _LEAST_LENGTH = np.sqrt(2.0), 1e-9
"""Of the weights of a feature, as they are drawn at first; of one that has none left."""


class NormalizedConvolution:
    """A convolution whose features have mean 0 and variance 1 in a batch, then scaled, rectified.

    Source: Ioffe and Szegedy, Batch Normalization, ICML 2015, algorithms 1 and 2.

    Parameters
    ----------
    n_before, n_behind : int
        Features.
    rng : numpy Generator
        Of the first weights (He et al., ICCV 2015, equation 10).
    """

    def __init__(self, n_before: int, n_behind: int, rng: np.random.Generator) -> None:
        n_gathered = N_NEIGHBORS * n_before
        weights = rng.normal(0.0, np.sqrt(2.0 / n_gathered), (n_gathered, n_behind))
        self.values = {
            "weights": weights.astype(np.float32),
            "scale": np.ones(n_behind, np.float32),
            "shift": np.zeros(n_behind, np.float32),
        }
        self.gradients: dict[str, Float32Array] = {}
        self.running = {
            "mean": np.zeros(n_behind, np.float32),
            "variance": np.ones(n_behind, np.float32),
            "n_batches": np.zeros(1, np.float32),
        }
        self._n_before = n_before

    def take_over(
        self, weights: Float32Array, bias: Float32Array, features: Float32Array, level: SiteLevel
    ) -> None:
        """Do with these features, and others like them, what a folded convolution does.

        The weights are made as long as they are drawn at first, so that they learn as fast as then:
        of a longer one the same step turns less.
        """
        lengths = np.maximum(np.linalg.norm(weights, axis=0), _LEAST_LENGTH)
        stretch = _single(_FIRST_LENGTH / lengths)
        self.values["weights"] = np.ascontiguousarray(weights * stretch)
        mean, variance = _moments(self._raw(features, level), max(len(level), 1))
        deviation = np.sqrt(variance + _LEAST_VARIANCE)
        self.values["scale"] = _single(deviation / stretch)
        self.values["shift"] = _single(bias + mean / stretch)

    def folded(self) -> tuple[Float32Array, Float32Array]:
        """Return weights and bias of a convolution that does the same with the running values."""
        scale = self.values["scale"] / np.sqrt(self.running["variance"] + _LEAST_VARIANCE)
        bias = self.values["shift"] - self.running["mean"] * scale
        return np.ascontiguousarray(self.values["weights"] * scale), bias

    def forward(self, features: Float32Array, level: SiteLevel) -> tuple[Float32Array, Back]:
        """Return (N + 1, D) features of (N + 1, C), and the way back."""
        weights, scale = self.values["weights"], self.values["scale"]
        raw = self._raw(features, level)
        n_cells = max(len(level), 1)
        mean, variance = _moments(raw, n_cells)
        self._remember(_single(mean), _single(variance))
        deviation = np.sqrt(variance + _LEAST_VARIANCE)
        factor = scale / deviation
        offset = self.values["shift"] - mean * factor
        made = rectified(raw, _single(factor), _single(offset))

        def back(by_made: Float32Array) -> Float32Array:
            by_line = slopes_of_rectified(by_made, made)
            by_shift, with_raw = sums_with(by_line, raw)
            by_scale = (with_raw - mean * by_shift) / deviation
            self.gradients.update(shift=_single(by_shift), scale=_single(by_scale))
            bend = factor * by_scale / (deviation * n_cells)
            common = factor * by_shift / n_cells - mean * bend
            by_raw = combined(by_line, _single(factor), raw, _single(bend), _single(common))
            self.gradients["weights"] = weight_gradient(features, level.neighbors, by_raw)
            back_weights = mirrored(weights, self._n_before)
            no_bias = np.zeros(self._n_before, np.float32)
            return convolved(by_raw, level.neighbors, back_weights, no_bias, AS_IT_IS)

        return made, back

    def _raw(self, features: Float32Array, level: SiteLevel) -> Float32Array:
        weights = self.values["weights"]
        nothing = np.zeros(weights.shape[1], np.float32)
        return convolved(features, level.neighbors, weights, nothing, AS_IT_IS)

    def _remember(self, mean: Float32Array, variance: Float32Array) -> None:
        self.running["n_batches"] += 1
        share = max(np.float32(_FORGETS), 1 / self.running["n_batches"][0])
        for name, value in (("mean", mean), ("variance", variance)):
            self.running[name] += share * (value - self.running[name])


def _moments(raw: Float32Array, n_cells: int) -> tuple[FloatArray, FloatArray]:
    """Return mean and variance of each feature over the cells."""
    mean, mean_square = sums_with(raw, raw) / n_cells
    return mean, np.maximum(mean_square - mean**2, 0.0)


def _single(values: FloatArray) -> Float32Array:
    return np.asarray(values, np.float32)


class Linear:
    """Sums of features with weights, and a bias."""

    def __init__(self, n_before: int, n_behind: int, rng: np.random.Generator) -> None:
        weights = rng.normal(0.0, np.sqrt(1.0 / n_before), (n_before, n_behind))
        self.values = {
            "weights": weights.astype(np.float32),
            "bias": np.zeros(n_behind, np.float32),
        }
        self.gradients: dict[str, Float32Array] = {}
        self.running: dict[str, Float32Array] = {}

    def forward(self, features: Float32Array) -> tuple[Float32Array, Back]:
        """Return (N, D) sums of (N, C) features, and the way back."""

        def back(by_made: Float32Array) -> Float32Array:
            self.gradients["weights"] = features.T @ by_made
            self.gradients["bias"] = by_made.sum(axis=0)
            return np.asarray(by_made @ self.values["weights"].T)

        return np.asarray(features @ self.values["weights"] + self.values["bias"]), back


def from_pooled(by_pooled: Float32Array, whose: Int32Array, n_before: int) -> Float32Array:
    """Take derivatives by `pooled` features back to the (n_before + 1, C) that were pooled."""
    by_before = np.zeros((n_before + 1, by_pooled.shape[1]), np.float32)
    columns = np.broadcast_to(np.arange(by_pooled.shape[1]), whose.shape)
    by_before[whose, columns] = by_pooled[:-1]  # a child has one parent: each place once
    by_before[-1] = 0
    return by_before


def from_parents(by_children: Float32Array, coarser: SiteLevel) -> Float32Array:
    """Take derivatives by (N, C) features that cells have of their parents back to (M + 1, C)."""
    summed: AnyArray = with_nothing(by_children)[coarser.children].sum(axis=1)
    return with_nothing(summed)
