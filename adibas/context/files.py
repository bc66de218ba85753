"""A context network as arrays of a file, and back: half-precision numbers, nothing that runs."""

from collections.abc import Mapping

import numpy as np

from adibas.arrays import AnyArray, Float32Array
from adibas.context.network import ContextNetwork, NetworkShape
from adibas.context.sites import N_NEIGHBORS

SHAPE, VALUES = "context_shape", "context_values"
"""Names of the arrays."""


def network_arrays(network: ContextNetwork) -> dict[str, AnyArray]:
    """Return the arrays of a network."""
    shape = network.shape
    parts = [*network.weights, *network.biases, network.last_weights, network.last_bias]
    return {
        SHAPE: np.array([shape.n_inputs, shape.n_labels, *shape.widths], np.int32),
        VALUES: np.concatenate([part.ravel() for part in parts]).astype(np.float16),
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
    values = arrays[VALUES].astype(np.float32)
    if not np.isfinite(values).all() or min(n_inputs, n_labels, *widths) < 1:
        raise ValueError("not all of it are numbers")
    sizes = list(shape.convolutions())
    shapes = [
        *((N_NEIGHBORS * before, behind) for before, behind in sizes),
        *((behind,) for _, behind in sizes),
        (shape.n_last, n_labels),
        (n_labels,),
    ]
    ends = np.cumsum([int(np.prod(one)) for one in shapes])
    if values.shape != (ends[-1],):
        raise ValueError(f"{ends[-1]} numbers are wanted, got {values.shape}")
    parts: list[Float32Array] = [
        np.ascontiguousarray(part.reshape(one))
        for part, one in zip(np.split(values, ends[:-1]), shapes, strict=True)
    ]
    n = len(sizes)
    return ContextNetwork(shape, tuple(parts[:n]), tuple(parts[n : 2 * n]), *parts[2 * n :])


def rounded(network: ContextNetwork) -> ContextNetwork:
    """Return the network as a file gives it back."""
    return network_of(network_arrays(network))
