"""A small network on the cells of a person: from what a forest says to what fits around it.

An encoder and a decoder with short cuts (Ronneberger, Fischer and Brox, U-Net, MICCAI 2015), on
occupied cells alone (`sites`). That labels are decided anew from a first opinion and what is around
it is auto-context (Tu and Bai, PAMI 32, 2010).
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from adibas.arrays import Float32Array, check_shape, read_only
from adibas.context.kernels import RECTIFIED, convolved, pooled, risen
from adibas.context.sites import N_NEIGHBORS, SiteLevel


@dataclass(frozen=True, slots=True)
class NetworkShape:
    """How large a network is.

    Attributes
    ----------
    n_inputs, n_labels : int
        Features of a cell; what is told of it.
    widths : tuple of int
        Features at each level, the finest first.
    """

    n_inputs: int
    n_labels: int
    widths: tuple[int, ...]

    def convolutions(self) -> Iterator[tuple[int, int]]:
        """Yield features before and behind each convolution, in the order of the work."""
        before = self.n_inputs
        for width in self.widths:
            yield before, width
            yield width, width
            before = width
        for width in self.widths[-2::-1]:
            yield before + width, width
            yield width, width
            before = width

    @property
    def n_last(self) -> int:
        """Return how many features the labels are told from: the last ones, and the inputs."""
        return self.widths[0] + self.n_inputs


@dataclass(frozen=True, slots=True, eq=False)
class ContextNetwork:
    """A trained network.

    Attributes
    ----------
    shape : NetworkShape
    weights : tuple of (9 C, D) float32 arrays
        Of the convolutions.
    biases : tuple of (D,) float32 arrays
    last_weights : (F, K) float32 array
        From the last features, and the inputs, to the labels.
    last_bias : (K,) float32 array
    """

    shape: NetworkShape
    weights: tuple[Float32Array, ...]
    biases: tuple[Float32Array, ...]
    last_weights: Float32Array
    last_bias: Float32Array

    def __post_init__(self) -> None:
        for (before, behind), weights, bias in zip(
            self.shape.convolutions(), self.weights, self.biases, strict=True
        ):
            check_shape("weights", weights, (N_NEIGHBORS * before, behind))
            check_shape("biases", bias, (behind,))
        check_shape("last_weights", self.last_weights, (self.shape.n_last, self.shape.n_labels))
        check_shape("last_bias", self.last_bias, (self.shape.n_labels,))
        for array in (*self.weights, *self.biases, self.last_weights, self.last_bias):
            read_only(array)

    def log_odds(self, inputs: Float32Array, levels: Sequence[SiteLevel]) -> Float32Array:
        """Return (N, K) logarithms of probabilities, but for what each row has in common.

        Parameters
        ----------
        inputs : (N, C) float32 array
        levels : sequence of SiteLevel
            Of the N cells; as many as the network has widths.
        """
        check_shape("inputs", inputs, (len(levels[0]), self.shape.n_inputs))
        layers = iter(zip(self.weights, self.biases, strict=True))
        features, kept = with_nothing(inputs), []
        for number, level in enumerate(levels):
            if number:
                features, _ = pooled(features, level.children)
            for _ in range(2):
                features = convolved(features, level.neighbors, *next(layers), RECTIFIED)
            kept.append(features)
        for level, skipped in zip(levels[-2::-1], kept[-2::-1], strict=True):
            features = risen(features, level.parents, skipped)
            for _ in range(2):
                features = convolved(features, level.neighbors, *next(layers), RECTIFIED)
        last = np.hstack([features[:-1], inputs])
        return np.asarray(last @ self.last_weights + self.last_bias)


def with_nothing(features: Float32Array) -> Float32Array:
    """Return (N + 1, C) features with a row of zeros behind: what lies where no cell is."""
    return np.vstack([features, np.zeros((1, features.shape[1]), np.float32)])
