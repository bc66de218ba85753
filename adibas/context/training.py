"""Training of a context network: batches of people, Adam, a rate that falls like a cosine.

Sources: Kingma and Ba, Adam, ICLR 2015, algorithm 1; Loshchilov and Hutter, SGDR, ICLR 2017,
equation 5: one fall a training, from half the rate where a network goes on.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from adibas.arrays import AnyArray, Float32Array, FloatArray, IntArray
from adibas.context.examples import Batch, ContextExample, batch_of
from adibas.context.kernels import pooled, risen
from adibas.context.layers import Back, Linear, NormalizedConvolution, from_parents, from_pooled
from adibas.context.network import ContextNetwork, NetworkShape, with_nothing
from adibas.context.sites import SiteLevel
from adibas.progress import Progress

_DECAYS, _LEAST_ROOT = (0.9, 0.999), 1e-8
"""Of Adam's means of derivatives and of their squares."""
_N_WARMING = 100
"""Steps in which the rate rises to its full size."""
_FIRST_CORRECTION, _FIRST_OPINION = 0.1, 2.0
"""Weights, at first, of what is around and of the inputs, halves of logarithms of probabilities."""
_RATE_OF_THE_TAUGHT = 0.5
"""Share of the rate with which a network that learned before goes on."""
_N_MEASURING = 4
"""Batches that tell how large the features of such a network are."""
_FIRST_WEIGHTS, _ORDER = 0xC0, 0xC1
"""What is drawn from the seed."""


@dataclass(frozen=True, slots=True)
class ContextTraining:
    """How a network is trained.

    Attributes
    ----------
    widths : tuple of int
        Of `NetworkShape`.
    n_passes : int
        How often each example is looked at.
    batch_size : int
        Examples between two steps.
    rate : float
        Of the steps, at the most; half of it where a network goes on that learned before.
    evenness : float
        1: all labels weigh the same in sum, however many cells they have; 0: all cells do.
    seed : int
    """

    widths: tuple[int, ...] = (48, 72, 112, 160)
    n_passes: int = 7
    batch_size: int = 32
    rate: float = 2e-3
    evenness: float = 0.85
    seed: int = 1


@dataclass(frozen=True, slots=True, eq=False)
class _TakingOver:
    """A layer that does what a taught one does, from the first features on that it is given."""

    layer: NormalizedConvolution
    weights: Float32Array
    bias: Float32Array

    def forward(self, features: Float32Array, level: SiteLevel) -> tuple[Float32Array, Back]:
        self.layer.take_over(self.weights, self.bias, features, level)
        return self.layer.forward(features, level)


_Convolution: TypeAlias = NormalizedConvolution | _TakingOver


class LearningNetwork:
    """A network while it learns; the first inputs are an opinion on each label.

    Parameters
    ----------
    shape : NetworkShape
    rng : numpy Generator
    """

    def __init__(self, shape: NetworkShape, rng: np.random.Generator) -> None:
        self.shape = shape
        self._convolutions = [
            NormalizedConvolution(before, behind, rng) for before, behind in shape.convolutions()
        ]
        self._last = Linear(shape.n_last, shape.n_labels, rng)
        self._begin_with_first_opinion()

    def _begin_with_first_opinion(self) -> None:
        """Let the labels be those of the inputs at first: the network learns what to correct."""
        n_features, n_labels = self.shape.widths[0], self.shape.n_labels
        weights = self._last.values["weights"]
        weights[:n_features] *= np.float32(_FIRST_CORRECTION)
        weights[n_features:] = 0
        opinions = np.arange(n_labels)
        weights[n_features + opinions, opinions] = _FIRST_OPINION

    def take_over(
        self, network: ContextNetwork, inputs: Float32Array, levels: Sequence[SiteLevel]
    ) -> None:
        """Do with these inputs, and others like them, what a network of the same shape does."""
        taught = zip(network.weights, network.biases, strict=True)
        layers = [
            _TakingOver(layer, weights, bias)
            for layer, (weights, bias) in zip(self._convolutions, taught, strict=True)
        ]
        self._last.values = {
            "weights": network.last_weights.copy(),
            "bias": network.last_bias.copy(),
        }
        self._forward(layers, inputs, levels)

    @property
    def layers(self) -> list[NormalizedConvolution | Linear]:
        """Return all layers, in the order in which they are done."""
        return [*self._convolutions, self._last]

    def forward(
        self, inputs: Float32Array, levels: Sequence[SiteLevel]
    ) -> tuple[Float32Array, Back]:
        """Return (N, K) log odds, and what takes derivatives by them to every layer."""
        return self._forward(self._convolutions, inputs, levels)

    def _forward(
        self,
        convolutions: Sequence[_Convolution],
        inputs: Float32Array,
        levels: Sequence[SiteLevel],
    ) -> tuple[Float32Array, Back]:
        layers = iter(convolutions)
        ways: list[tuple[Back, Back]] = []
        features, kept, owners = with_nothing(inputs), [], []
        for number, level in enumerate(levels):
            if number:
                features, whose = pooled(features, level.children)
                owners.append(whose)
            features, way = _twice(layers, features, level)
            ways.append(way)
            kept.append(features)
        for level, skipped in zip(levels[-2::-1], kept[-2::-1], strict=True):
            joined = risen(features, level.parents, skipped)
            features, way = _twice(layers, joined, level)
            ways.append(way)
        log_odds, last_way = self._last.forward(np.hstack([features[:-1], inputs]))

        def back(by_log_odds: Float32Array) -> Float32Array:
            by_last = last_way(by_log_odds)
            by_features = with_nothing(by_last[:, : self.shape.widths[0]])
            by_kept: list[Float32Array] = []
            for number in range(len(levels) - 1):
                by_joined = _both_back(ways.pop(), by_features)[:-1]
                n_coarser = by_joined.shape[1] - kept[number].shape[1]
                by_kept.append(with_nothing(by_joined[:, n_coarser:]))
                by_features = from_parents(by_joined[:, :n_coarser], levels[number + 1])
            for number in range(len(levels) - 1, -1, -1):
                by_features = _both_back(ways.pop(), by_features)
                if number:
                    n_finer = len(levels[number - 1])
                    by_features = from_pooled(by_features, owners[number - 1], n_finer)
                    by_features += by_kept[number - 1]
            return by_features[:-1] + by_last[:, self.shape.widths[0] :]

        return log_odds, back

    def learned(self) -> ContextNetwork:
        """Return the network as it is now."""
        folded = [layer.folded() for layer in self._convolutions]
        return ContextNetwork(
            self.shape,
            tuple(weights.copy() for weights, _ in folded),
            tuple(bias.copy() for _, bias in folded),
            self._last.values["weights"].copy(),
            self._last.values["bias"].copy(),
        )


def _twice(
    layers: Iterator[_Convolution], features: Float32Array, level: SiteLevel
) -> tuple[Float32Array, tuple[Back, Back]]:
    features, first_way = next(layers).forward(features, level)
    features, second_way = next(layers).forward(features, level)
    return features, (first_way, second_way)


def _both_back(ways: tuple[Back, Back], by_made: Float32Array) -> Float32Array:
    first_way, second_way = ways
    return first_way(second_way(by_made))


class _Adam:
    """Takes steps along means of derivatives, measured by their size."""

    def __init__(self, network: LearningNetwork) -> None:
        self._network, self.n_steps = network, 0
        self.means = [_zeros(layer.values) for layer in network.layers]
        self.squares = [_zeros(layer.values) for layer in network.layers]

    def step(self, rate: float) -> None:
        self.n_steps += 1
        first, second = _DECAYS
        rate *= math.sqrt(1.0 - second**self.n_steps) / (1.0 - first**self.n_steps)
        for layer, means, squares in zip(
            self._network.layers, self.means, self.squares, strict=True
        ):
            for name, slope in layer.gradients.items():
                means[name] += np.float32(1.0 - first) * (slope - means[name])
                squares[name] += np.float32(1.0 - second) * (slope * slope - squares[name])
                way = means[name] / (np.sqrt(squares[name]) + np.float32(_LEAST_ROOT))
                layer.values[name] -= np.float32(rate) * way


def _zeros(values: Mapping[str, Float32Array]) -> dict[str, Float32Array]:
    return {name: np.zeros_like(value) for name, value in values.items()}


def loss_and_slope(
    log_odds: Float32Array, labels: IntArray, weights: Float32Array
) -> tuple[float, Float32Array]:
    """Return the cross entropy, the mean by weight, and its (N, K) derivatives by the log odds.

    Parameters
    ----------
    log_odds : (N, K) float32 array
    labels : (N,) int array
        -1: not known, does not count.
    weights : (K,) float32 array
        Of a cell of each label.
    """
    known = labels >= 0
    weight = np.where(known, weights[labels], np.float32(0))
    weight = weight / max(float(weight.sum()), 1e-9)
    shifted = log_odds - log_odds.max(axis=1, keepdims=True)
    odds = np.exp(shifted)
    total = odds.sum(axis=1, keepdims=True)
    rows = np.arange(len(labels))
    told = shifted[rows, labels] - np.log(total[:, 0])
    slope = odds / total
    slope[rows, labels] -= 1.0
    return -float(told @ weight), np.asarray(slope * weight[:, None], np.float32)


def label_shares(examples: Sequence[ContextExample], n_labels: int) -> FloatArray:
    """Return (K,) shares of the cells that have each label; one that never occurs has one cell."""
    counts = np.zeros(n_labels)
    for example in examples:
        counts += np.bincount(example.labels[example.labels >= 0], minlength=n_labels)
    return np.asarray(np.maximum(counts, 1.0) / max(counts.sum(), 1.0))


def label_weights(shares: FloatArray, evenness: float) -> Float32Array:
    """Return (K,) weights of cells, 1 in the mean over all cells."""
    weights = shares**-evenness
    return np.asarray(weights / (weights @ shares), np.float32)


class ContextTrainer:
    """Trains a network pass by pass; between two of them it can be kept and gone on with.

    The same examples, parameters and seed give the same network, with any number of cores, and
    after a break, too.

    Parameters
    ----------
    examples : sequence of ContextExample
        Each is looked at as it is or mirrored, by chance.
    mirror_order : (K,) int array
        Label of the other side of each label.
    params : ContextTraining
    taught : ContextNetwork or None
        Goes on learning, with smaller steps; None: a new one.

    Attributes
    ----------
    label_shares : (K,) array
        Of the cells of all examples.
    """

    def __init__(
        self,
        examples: Sequence[ContextExample],
        mirror_order: IntArray,
        params: ContextTraining,
        taught: ContextNetwork | None = None,
    ) -> None:
        n_labels, n_inputs = len(mirror_order), examples[0].features.shape[1]
        shape = NetworkShape(n_inputs, n_labels, params.widths)
        rng = np.random.default_rng([params.seed, _FIRST_WEIGHTS])
        self._examples, self._mirror_order, self._params = examples, mirror_order, params
        self._network = LearningNetwork(shape, rng)
        self._rate = params.rate
        if taught is not None:
            self._rate *= _RATE_OF_THE_TAUGHT
            order = rng.permutation(len(examples))[: _N_MEASURING * params.batch_size]
            batch = self._batch(order, rng)
            self._network.take_over(taught, batch.inputs, batch.levels)
        self._adam = _Adam(self._network)
        self.label_shares = label_shares(examples, n_labels)
        self._weights = label_weights(self.label_shares, params.evenness)
        self._per_pass = -(-len(examples) // params.batch_size)

    @property
    def n_done(self) -> int:
        """Return how many passes are done."""
        return self._adam.n_steps // self._per_pass

    def run_pass(self, progress: Progress) -> None:
        """Look at all examples once; `progress` takes steps done and those of all passes."""
        rng = np.random.default_rng([self._params.seed, _ORDER, self.n_done])
        n_steps = self._params.n_passes * self._per_pass
        order, size = rng.permutation(len(self._examples)), self._params.batch_size
        for first in range(0, len(order), size):
            batch = self._batch(order[first : first + size], rng)
            log_odds, back = self._network.forward(batch.inputs, batch.levels)
            back(loss_and_slope(log_odds, batch.labels, self._weights)[1])
            self._adam.step(_rate(self._rate, self._adam.n_steps, n_steps))
            progress(self._adam.n_steps, n_steps)

    def _batch(self, order: IntArray, rng: np.random.Generator) -> Batch:
        chosen = [self._examples[number] for number in order]
        return batch_of(chosen, self._mirror_order, len(self._params.widths), rng)

    def kept(self) -> dict[str, AnyArray]:
        """Return everything that the next pass needs, by name."""
        return {
            "n_steps": np.array(self._adam.n_steps),
            **{name: value.copy() for name, value in self._state()},
        }

    def go_on(self, kept: Mapping[str, AnyArray]) -> None:
        """Be as `kept` was told.

        Raises
        ------
        KeyError, ValueError
            That is of another training.
        """
        state = [(value, kept[name]) for name, value in self._state()]
        n_steps = int(kept["n_steps"])
        for value, read in state:  # all of it could be read
            value[...] = read
        self._adam.n_steps = n_steps

    def learned(self) -> ContextNetwork:
        """Return the network as it is now."""
        return self._network.learned()

    def _state(self) -> Iterator[tuple[str, Float32Array]]:
        adam = self._adam
        for number, (layer, means, squares) in enumerate(
            zip(self._network.layers, adam.means, adam.squares, strict=True)
        ):
            kinds = {"values": layer.values, "means": means, "squares": squares}
            for kind, arrays in {**kinds, "running": layer.running}.items():
                for name, value in arrays.items():
                    yield f"{number}.{kind}.{name}", value


def _rate(most: float, done: int, n_steps: int) -> float:
    warmed = min(1.0, (done + 1) / _N_WARMING)
    return most * warmed * 0.5 * (1.0 + math.cos(math.pi * done / n_steps))
