"""Learning which points are neighbours, and how they lie to one another."""

import numpy as np
from scipy.ndimage import gaussian_filter
from scipy.sparse.csgraph import breadth_first_order, minimum_spanning_tree

from adibas.arrays import FloatArray, IntArray
from adibas.shapes.tree_kernels import describe_pairs
from adibas.skeleton.model import NeighbourTree

N_BANDS, N_SECTORS = 12, 24
SPACE = 3
LENGTH_SD = 0.06
"""Least standard deviation of a log length: people that the training has not seen."""
EVEN_SHARE = 0.05
"""Of directions that may be anything."""
BLUR_CELLS = 0.8
NEARNESS = 0.1
"""How much a radius of distance counts against an edge, in standard deviations of log length."""
N_ROUNDS = 3


def learn_tree(shapes: FloatArray) -> NeighbourTree:
    """Learn the tree whose lengths vary least from (S, N, D) shapes in their common frame."""
    n_dimensions = shapes.shape[2]
    apart = np.linalg.norm(shapes[:, :, None] - shapes[:, None], axis=-1)
    logs = np.log(np.maximum(apart, 1e-6))
    edges, logs = _rigid_tree(logs, apart.mean(axis=0))
    means, sds = logs.mean(axis=0), logs.std(axis=0)
    n_bands = N_BANDS if n_dimensions == SPACE else 1
    counts = np.zeros((len(edges), n_bands, N_SECTORS))
    for shape in shapes:
        _, bands, sectors = describe_pairs(np.ascontiguousarray(shape), n_bands, N_SECTORS)
        for e, (parent, child) in enumerate(edges):
            counts[e, bands[parent, child], sectors[parent, child]] += 1
    area = (4.0 if n_dimensions == SPACE else 2.0) * np.pi / (n_bands * N_SECTORS)
    blur = (BLUR_CELLS if n_bands > 1 else 0.0, BLUR_CELLS)
    shares = np.stack([gaussian_filter(one, blur, mode=("nearest", "wrap")) for one in counts])
    shares = (1 - EVEN_SHARE) * shares / len(shapes) + EVEN_SHARE / (n_bands * N_SECTORS)
    picked = edges[:, 0], edges[:, 1]
    return NeighbourTree(
        edges, means[picked], np.maximum(sds[picked], LENGTH_SD), -np.log(shares / area)
    )


def _rigid_tree(logs: FloatArray, apart: FloatArray) -> tuple[IntArray, FloatArray]:
    """Return the edges, and the (S, N, N) log lengths as if all shapes had edges of one size."""
    edges = _spanning_tree((logs.std(axis=0) + NEARNESS) * apart)
    for _ in range(N_ROUNDS):
        picked = logs[:, edges[:, 0], edges[:, 1]]
        sizes = np.median(picked - picked.mean(axis=0), axis=1)
        logs = logs - sizes[:, None, None]
        edges = _spanning_tree((logs.std(axis=0) + NEARNESS) * apart)
    return edges, logs


def _spanning_tree(weights: FloatArray) -> IntArray:
    """Return (E, 2) edges of the cheapest tree, from the most central point outwards."""
    n = len(weights)
    if n == 1:
        return np.zeros((0, 2), np.int64)
    tree = minimum_spanning_tree(np.triu(weights + 1e-9, 1)).toarray()
    tree = tree + tree.T
    root = int(np.argmax((tree > 0).sum(axis=1)))
    order, parents = breadth_first_order(tree, root, directed=False)
    return np.array([(int(parents[i]), int(i)) for i in order[1:]], np.int64)
