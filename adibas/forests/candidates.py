"""Random features and thresholds for nodes to choose from (step 1 of section 6.2.2)."""

import math

import numpy as np

from adibas.arrays import Float32Array
from adibas.forests.feature_kernels import KIND
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
    features[:, :, KIND + 1 :] = drawn[:, :, :N_OFFSETS] * params.max_offset_m
    spread = drawn[:, :, N_OFFSETS:]
    size = FINEST_M * np.exp(np.abs(spread) * math.log(COARSEST_M / FINEST_M))
    thresholds = np.where(features[:, :, :1] == DEPTH, np.sign(spread) * size, spread * math.pi)
    return (
        features.reshape(-1, N_OFFSETS + 1),
        np.sort(thresholds, axis=2).astype(np.float32).reshape(-1, params.n_thresholds),
    )
