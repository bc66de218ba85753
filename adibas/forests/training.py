"""Growing a forest level by level, from images that are read in batches.

Memory holds the drawn pixels (20 bytes each), one batch of images (or as many as `Memory` allows)
and the counts of one group of nodes, whatever the number of images. Each tree depends on the seed
and its own number alone: trees can be grown in any order, on any machine, and after a break. Counts
are whole numbers: shares of the pixels can be counted on several machines and added up.
"""

from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import Protocol

import numpy as np

from adibas.arrays import Float32Array, Int32Array, IntArray
from adibas.forests.candidates import draw_candidates
from adibas.forests.forest import Forest
from adibas.forests.params import ForestParams
from adibas.forests.samples import Memory, PixelSample, TrainingImages
from adibas.forests.training_kernels import LEAF, THRESHOLD, best_splits

_INT32_BYTES = 4
_DRAW_CANDIDATES = 2
"""After the draws of `samples`."""
Progress = Callable[[int, int, int], None]
"""Told the tree, the level and the nodes to split there; raises to stop."""


@dataclass(frozen=True, slots=True, eq=False)
class Tree:
    """One grown tree; see `Forest` for its arrays, here with `LEAF` for all leaves.

    Attributes
    ----------
    child : (M,) int32 array
    nodes : (M, 6) float32 array
    counts : (M, L) int64 array
        Training pixels of each label at each node.
    """

    child: Int32Array
    nodes: Float32Array
    counts: IntArray


class CountedPixels(Protocol):
    """The pixels that a tree grows from, wherever they are."""

    def label_counts(self) -> IntArray:
        """Return the (L,) drawn pixels of each label."""
        ...

    def count(
        self,
        group: IntArray,
        grown: tuple[Int32Array, Float32Array],
        candidates: tuple[Float32Array, Float32Array],
        counts: Int32Array,
    ) -> None:
        """Move all pixels to the nodes of `grown`, and add what candidates make of a group's."""
        ...


DrawPixels = Callable[[TrainingImages, ForestParams, tuple[int, int], Memory], CountedPixels]
"""Draws pixels for one tree; see `PixelSample`."""


def train_forest(
    images: TrainingImages,
    params: ForestParams,
    seed: int,
    memory: Memory | None = None,
    progress: Progress | None = None,
) -> Forest:
    """Train all trees and join them.

    Parameters
    ----------
    images : TrainingImages
        At least one, with a labelled pixel that has depth.
    params : ForestParams
    seed : int
        The same seed gives the same forest, on any number of threads and with any `memory`.
    memory : Memory or None
    progress : function or None
        Called at every level of every tree.
    """
    trees = [train_tree(images, params, (seed, n), memory, progress) for n in range(params.n_trees)]
    return join_trees(trees, images.labels, params, {"seed": seed, "n_images": len(images)})


def join_trees(
    trees: list[Tree], labels: tuple[str, ...], params: ForestParams, source: dict[str, object]
) -> Forest:
    """Make a forest of trees; each label's count is divided by its total first (step 5)."""
    children, leaves, roots = [], [], []
    n_nodes = n_leaves = 0
    for tree in trees:
        is_leaf = tree.child == LEAF
        child = tree.child + n_nodes
        child[is_leaf] = -1 - n_leaves - np.arange(np.count_nonzero(is_leaf))
        children.append(child.astype(np.int32))
        leaves.append(node_probabilities(tree, params.shrinkage)[is_leaf])
        roots.append(n_nodes)
        n_nodes += len(child)
        n_leaves += len(leaves[-1])
    return Forest(
        labels,
        np.array(roots, np.int32),
        np.concatenate(children),
        np.concatenate([tree.nodes for tree in trees]),
        np.concatenate(leaves),
        params.far_m,
        params.smoothing_px,
        {
            "params": asdict(params),
            "label_pixels": [tree.counts[0].tolist() for tree in trees],
            **source,
        },
    )


def leaf_probabilities(counts: IntArray, totals: IntArray) -> Float32Array:
    """Return the (F, L) share of each label at leaves, each label weighed by 1 / its total."""
    weighed = counts / np.maximum(totals, 1)
    shares: Float32Array = (weighed / weighed.sum(axis=1, keepdims=True)).astype(np.float32)
    return shares


def node_probabilities(tree: Tree, shrinkage: float) -> Float32Array:
    """Return the (M, L) shares of each label at all nodes, each drawn to that of the node above.

    A leaf of few pixels says little: the node above counts as `shrinkage` more pixels.

    Source: Cestnik, Estimating probabilities: a crucial task in machine learning, ECAI 1990 (the
    m-estimate; the prior is here the parent's).
    """
    shares = leaf_probabilities(tree.counts, tree.counts[0])
    totals = np.maximum(tree.counts[0], 1)
    weighed = tree.counts * (totals.sum() / len(totals) / totals)
    parents = np.flatnonzero(tree.child[:1] != LEAF)
    while shrinkage > 0 and len(parents):
        for side in (0, 1):
            below = tree.child[parents] + side
            pulled = weighed[below] + shrinkage * shares[parents]
            shares[below] = pulled / pulled.sum(axis=1, keepdims=True)
        children = np.concatenate([tree.child[parents], tree.child[parents] + 1])
        parents = children[tree.child[children] != LEAF]
    return shares


def train_tree(
    images: TrainingImages,
    params: ForestParams,
    seed: tuple[int, int],
    memory: Memory | None = None,
    progress: Progress | None = None,
    draw: DrawPixels = PixelSample,
) -> Tree:
    """Grow a tree of a forest, breadth first.

    Parameters
    ----------
    images, params, memory, progress
        As for `train_forest`.
    seed : (int, int)
        Of the forest, and the number of the tree.
    draw : function
        Draws the pixels that it grows from, here or elsewhere.

    Raises
    ------
    ValueError
        No image has a labelled pixel with depth.
    """
    memory = memory or Memory()
    sample = draw(images, params, seed, memory)
    plan = _TreePlan(params, seed, len(images.labels), memory.count_bytes)
    return _grow_tree(sample, plan, progress)


@dataclass(frozen=True, slots=True)
class _TreePlan:
    """Which tree is grown, and how.

    Attributes
    ----------
    params : ForestParams
    seed : (int, int)
        Of the forest, and the number of the tree.
    n_labels : int
    count_bytes : int
        For the counts of a group of nodes.
    """

    params: ForestParams
    seed: tuple[int, int]
    n_labels: int
    count_bytes: int


def _grow_tree(pixels: CountedPixels, plan: _TreePlan, progress: Progress | None) -> Tree:
    """Grow a tree of pixels that were drawn for it.

    Raises
    ------
    ValueError
        There is no pixel.
    """
    label_counts = pixels.label_counts()
    if not label_counts.sum():
        raise ValueError("no image has a labelled pixel with depth")
    growth = _Growth(plan.n_labels, label_counts)
    for level in range(plan.params.max_depth):
        open_nodes = growth.open_nodes(plan.params)
        if progress is not None:
            progress(plan.seed[1], level, len(open_nodes))
        if not len(open_nodes):
            break
        _split_level(pixels, growth, open_nodes, level, plan)
    return growth.tree()


class _Growth:
    """The nodes of a tree while it grows."""

    def __init__(self, n_labels: int, root_counts: IntArray) -> None:
        self.child = np.full(1, LEAF, np.int32)
        self.nodes = np.zeros((1, THRESHOLD + 1), np.float32)
        self.counts = root_counts.reshape(1, n_labels)
        self.first_new = 0

    def open_nodes(self, params: ForestParams) -> IntArray:
        """Return the nodes of the last level that may be split."""
        new = np.arange(self.first_new, len(self.child))
        counts = self.counts[new]
        is_mixed = (counts > 0).sum(axis=1) > 1
        is_open = is_mixed & (counts.sum(axis=1) >= params.min_pixels)
        return np.asarray(new[is_open])

    def split(self, parents: IntArray, nodes: Float32Array, left: IntArray) -> None:
        """Give two children to each of `parents`."""
        n_new = 2 * len(parents)
        self.nodes[parents] = nodes
        self.child[parents] = len(self.child) + np.arange(0, n_new, 2)
        right = self.counts[parents] - left
        both = np.stack([left, right], axis=1).reshape(n_new, left.shape[1])
        self.child = np.concatenate([self.child, np.full(n_new, LEAF, np.int32)])
        self.nodes = np.concatenate([self.nodes, np.zeros((n_new, THRESHOLD + 1), np.float32)])
        self.counts = np.concatenate([self.counts, both])

    def tree(self) -> Tree:
        return Tree(self.child, self.nodes, self.counts)


def _split_level(
    pixels: CountedPixels, growth: _Growth, open_nodes: IntArray, level: int, plan: _TreePlan
) -> None:
    """Split the nodes of a level, group by group."""
    params = plan.params
    rng = np.random.default_rng([*plan.seed, _DRAW_CANDIDATES, level])
    n_candidates = params.n_candidates + params.n_gradient_candidates
    n_labels = growth.counts.shape[1]
    node_bytes = n_candidates * (params.n_thresholds + 1) * n_labels * _INT32_BYTES
    n_group = max(1, plan.count_bytes // node_bytes)
    growth_before = growth.child.copy(), growth.nodes.copy()
    growth.first_new = len(growth.child)
    for first in range(0, len(open_nodes), n_group):
        group = open_nodes[first : first + n_group]
        features, thresholds = draw_candidates(rng, len(group), params)
        shape = (n_candidates, len(group), params.n_thresholds + 1, n_labels)
        counts = np.zeros(shape, np.int32)
        pixels.count(group, growth_before, (features, thresholds), counts)
        gains, choices, left = best_splits(counts)
        is_split = gains > params.min_gain
        row = (np.arange(len(group)) * n_candidates + choices[:, 0])[is_split]
        tau = thresholds[row, choices[is_split, 1]]
        chosen = np.column_stack([features[row], tau]).astype(np.float32)
        growth.split(group[is_split], chosen, left[is_split])
