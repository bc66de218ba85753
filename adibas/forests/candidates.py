"""Random features and thresholds for nodes to choose from (step 1 of section 6.2.2)."""

import math

import numpy as np

from adibas.arrays import Float32Array, FloatArray
from adibas.forests.feature_kernels import KIND, V_ROW
from adibas.forests.params import DEPTH, GRADIENT, ForestParams

N_OFFSETS = 4
FINEST_M, COARSEST_M = 0.003, 3.0
"""Depth thresholds, of either sign, evenly over the logarithm: noise to another person."""


def draw_candidates(
    rng: np.random.Generator, n_nodes: int, params: ForestParams
) -> tuple[Float32Array, Float32Array]:
    """Draw candidates for some nodes; in groups of nodes one after the other they are the same.

    Returns
    -------
    features : (n_nodes * C, 5) float32 array
        For each node first depth comparisons, then gradient angles.
    thresholds : (n_nodes * C, T) float32 array
        Rising; metres or radians.
    """
    n_candidates = params.n_candidates + params.n_gradient_candidates
    drawn = rng.uniform(-1.0, 1.0, (n_nodes, n_candidates, N_OFFSETS + params.n_thresholds))
    features = np.empty((n_nodes, n_candidates, N_OFFSETS + 1), np.float32)
    features[:, : params.n_candidates, KIND] = DEPTH
    features[:, params.n_candidates :, KIND] = GRADIENT
    features[:, :, KIND + 1 :] = _offsets_m(drawn[:, :, :N_OFFSETS], params)
    for first, last in ((0, params.n_candidates), (params.n_candidates, n_candidates)):
        n_pixel = round(params.pixel_share * (last - first))
        features[:, first : first + n_pixel, V_ROW:] = 0.0
    spread = drawn[:, :, N_OFFSETS:]
    size = FINEST_M * np.exp(np.abs(spread) * math.log(COARSEST_M / FINEST_M))
    thresholds = np.where(features[:, :, :1] == DEPTH, np.sign(spread) * size, spread * math.pi)
    return (
        features.reshape(-1, N_OFFSETS + 1),
        np.sort(thresholds, axis=2).astype(np.float32).reshape(-1, params.n_thresholds),
    )


def _offsets_m(drawn: FloatArray, params: ForestParams) -> FloatArray:
    """Return (..., 4) offsets u and v, row and column, of numbers drawn evenly from -1 to 1."""
    if params.min_offset_m == 0.0:
        return np.asarray(drawn * params.max_offset_m)
    lengths = np.abs(drawn[..., ::2]) * math.log(params.max_offset_m / params.min_offset_m)
    lengths_m = params.min_offset_m * np.exp(lengths)
    angles = drawn[..., 1::2] * math.pi
    ways = np.stack([lengths_m * np.sin(angles), lengths_m * np.cos(angles)], axis=-1)
    return np.asarray(ways.reshape(drawn.shape))
