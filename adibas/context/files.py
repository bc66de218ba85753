"""A context network as arrays of a file, and back: whole steps of 8 bits, nothing that runs.

The weights of each feature that a layer makes are whole steps of a size of their own, the largest
one 127 of them: a quarter of what single precision takes, and right as often (docs/limbs.md).
"""

from collections.abc import Mapping

import numpy as np

from adibas.arrays import AnyArray, Float32Array
from adibas.context.network import ContextNetwork, NetworkShape
from adibas.context.sites import N_NEIGHBORS

SHAPE, STEPS, NUMBERS = "context_shape", "context_steps", "context_numbers"
"""Names of the arrays: sizes; weights in steps; sizes of the steps, then what is added."""
_MOST_STEPS = 127
_LEAST = 1e-20
"""Taken for the largest weight where all are zero."""


def network_arrays(network: ContextNetwork) -> dict[str, AnyArray]:
    """Return the arrays of a network."""
    shape = network.shape
    layers = (*network.weights, network.last_weights)
    step_sizes = [np.maximum(np.abs(one).max(axis=0), _LEAST) / _MOST_STEPS for one in layers]
    steps = [np.rint(one / size) for one, size in zip(layers, step_sizes, strict=True)]
    return {
        SHAPE: np.array([shape.n_inputs, shape.n_labels, *shape.widths], np.int32),
        STEPS: np.concatenate([one.ravel() for one in steps]).astype(np.int8),
        NUMBERS: np.concatenate([*step_sizes, *network.biases, network.last_bias]).astype(
            np.float32
        ),
    }


def network_of(arrays: Mapping[str, AnyArray]) -> ContextNetwork:
    """Return the network of such arrays.

    Raises
    ------
    ValueError
        They are no network: too few or too many numbers, or some that are none.
    """
    n_inputs, n_labels, *widths = (int(one) for one in arrays[SHAPE])
    shape = NetworkShape(n_inputs, n_labels, tuple(widths))
    numbers = arrays[NUMBERS].astype(np.float32)
    if not np.isfinite(numbers).all() or min(n_inputs, n_labels, *widths) < 1:
        raise ValueError("not all of it are numbers")
    sizes = [
        *((N_NEIGHBORS * before, behind) for before, behind in shape.convolutions()),
        (shape.n_last, n_labels),
    ]
    steps = _split(arrays[STEPS], [before * behind for before, behind in sizes])
    of_layers = _split(numbers, 2 * [behind for _, behind in sizes])
    n_layers = len(sizes)
    weights: list[Float32Array] = [
        np.ascontiguousarray(one.reshape(size) * step)
        for one, size, step in zip(steps, sizes, of_layers[:n_layers], strict=True)
    ]
    biases = [one.copy() for one in of_layers[n_layers:]]
    return ContextNetwork(shape, tuple(weights[:-1]), tuple(biases[:-1]), weights[-1], biases[-1])


def _split(values: AnyArray, lengths: list[int]) -> list[AnyArray]:
    ends = np.cumsum(lengths)
    if values.shape != (ends[-1],):
        raise ValueError(f"{ends[-1]} numbers are wanted, got {values.shape}")
    return np.split(values, ends[:-1])


def rounded(network: ContextNetwork) -> ContextNetwork:
    """Return the network as a file gives it back."""
    return network_of(network_arrays(network))
