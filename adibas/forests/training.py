"""Growing a forest level by level, from images that are read in batches.

Memory holds the drawn pixels (20 bytes each), one batch of images (or as many as `Memory` allows)
and the counts of one group of nodes, whatever the number of images. Each tree depends on the seed
and its own number alone: trees can be grown in any order, on any machine, and after a break.
"""

from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass
from typing import Protocol

import numpy as np

from adibas.arrays import AnyArray, Float32Array, FloatArray, Int32Array, IntArray, UInt8Array
from adibas.forests.candidates import draw_candidates
from adibas.forests.forest import Forest
from adibas.forests.images import ForestImage, ImageBatch, join_images, prepare_image
from adibas.forests.params import ForestParams
from adibas.forests.training_kernels import (
    COLUMN,
    IMAGE,
    LABEL,
    LEAF,
    ROW,
    THRESHOLD,
    best_splits,
    count_values,
    route,
    scales_of,
)

_INT32_BYTES = 4
_DRAW_IMAGES, _DRAW_PIXELS, _DRAW_CANDIDATES = range(3)
Progress = Callable[[int, int, int], None]
"""Told the tree, the level and the nodes to split there; raises to stop."""


class TrainingImages(Protocol):
    """Labelled depth images, read when needed and perhaps many times."""

    @property
    def labels(self) -> tuple[str, ...]:
        """Return the names of the L labels."""
        ...

    def __len__(self) -> int: ...

    def read(self, index: int) -> tuple[Float32Array, UInt8Array, float]:
        """Return an image: (H, W) metres with NaN, (H, W) labels 1 to L or 0, and focal_px."""
        ...


@dataclass(frozen=True, slots=True)
class Memory:
    """What training may hold.

    Attributes
    ----------
    n_batch_images : int
        Read and worked on at once.
    image_bytes : int
        For batches that are kept rather than read anew at every level.
    count_bytes : int
        For the counts of a group of nodes.
    """

    n_batch_images: int = 64
    image_bytes: int = 256 << 20
    count_bytes: int = 128 << 20


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
    trees = [train_tree(images, params, seed, n, memory, progress) for n in range(params.n_trees)]
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
    seed: int,
    number: int,
    memory: Memory | None = None,
    progress: Progress | None = None,
) -> Tree:
    """Grow tree `number` of a forest, breadth first.

    Raises
    ------
    ValueError
        No image has a labelled pixel with depth.
    """
    sample = _Sample(images, params, (seed, number), memory or Memory())
    growth = _Growth(len(images.labels), sample.label_counts())
    for level in range(params.max_depth):
        open_nodes = growth.open_nodes(params)
        if progress is not None:
            progress(number, level, len(open_nodes))
        if not len(open_nodes):
            break
        _split_level(sample, growth, open_nodes, level)
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


def _split_level(sample: "_Sample", growth: _Growth, open_nodes: IntArray, level: int) -> None:
    """Split the nodes of a level, group by group."""
    params = sample.params
    rng = np.random.default_rng([*sample.seed, _DRAW_CANDIDATES, level])
    n_candidates = params.n_candidates + params.n_gradient_candidates
    n_labels = growth.counts.shape[1]
    node_bytes = n_candidates * (params.n_thresholds + 1) * n_labels * _INT32_BYTES
    n_group = max(1, sample.memory.count_bytes // node_bytes)
    growth_before = growth.child.copy(), growth.nodes.copy()
    growth.first_new = len(growth.child)
    for first in range(0, len(open_nodes), n_group):
        group = open_nodes[first : first + n_group]
        features, thresholds = draw_candidates(rng, len(group), params)
        shape = (n_candidates, len(group), params.n_thresholds + 1, n_labels)
        counts = np.zeros(shape, np.int32)
        sample.count(group, growth_before, (features, thresholds), counts)
        gains, choices, left = best_splits(counts)
        is_split = gains > params.min_gain
        row = (np.arange(len(group)) * n_candidates + choices[:, 0])[is_split]
        tau = thresholds[row, choices[is_split, 1]]
        chosen = np.column_stack([features[row], tau]).astype(np.float32)
        growth.split(group[is_split], chosen, left[is_split])


class _Sample:
    """The pixels drawn for one tree, and the images they are in."""

    def __init__(
        self,
        images: TrainingImages,
        params: ForestParams,
        seed: tuple[int, int],
        memory: Memory,
    ) -> None:
        self.params, self.seed, self.memory = params, seed, memory
        self._images = images
        n_images = len(images)
        rng = np.random.default_rng([*seed, _DRAW_IMAGES])
        n_drawn = min(params.n_images or n_images, n_images)
        self._chosen = np.sort(rng.choice(n_images, n_drawn, replace=False))
        self._kept: dict[int, ImageBatch] = {}
        self._n_kept_bytes = 0
        self._pixels: list[Int32Array] = [
            self._draw(begin) for begin in range(0, n_drawn, memory.n_batch_images)
        ]
        self._at_node = [np.zeros(len(pixels), np.int32) for pixels in self._pixels]
        if not sum(map(len, self._pixels)):
            raise ValueError("no image has a labelled pixel with depth")

    def label_counts(self) -> IntArray:
        """Return the (L,) drawn pixels of each label."""
        n_labels = len(self._images.labels)
        drawn = np.concatenate(self._pixels)[:, LABEL]
        return np.bincount(drawn, minlength=n_labels).astype(np.int64)

    def count(
        self,
        group: IntArray,
        grown: tuple[Int32Array, Float32Array],
        candidates: tuple[Float32Array, Float32Array],
        counts: Int32Array,
    ) -> None:
        """Move all pixels to the nodes of `grown`, and count what candidates make of a group's."""
        child, nodes = grown
        slot_of = np.full(len(child), LEAF, np.int32)
        slot_of[group] = np.arange(len(group))
        for number, pixels in enumerate(self._pixels):
            batch, at_node = self._batch(number), self._at_node[number]
            images = batch.depth_m, batch.slope_x, batch.slope_y, batch.places
            scales = scales_of(batch.depth_m, batch.places, batch.focal_px, pixels)
            route(*images, pixels, scales, child, nodes, at_node)
            slots = slot_of[at_node]
            is_in = slots >= 0
            rows = np.ascontiguousarray(pixels[is_in])
            count_values(*images, rows, scales[is_in], slots[is_in], *candidates, counts)

    def _draw(self, begin: int) -> Int32Array:
        """Return (P, 4) pixels of the batch that begins with chosen image `begin`."""
        drawn = []
        for place, _, labels, box in self._read(begin):
            rng = np.random.default_rng([*self.seed, _DRAW_PIXELS, begin + place])
            rows, columns = np.nonzero(labels)
            n_pixels = min(self.params.n_pixels, len(rows))
            odds = _odds(labels[rows, columns], self.params.evenness)
            chosen = np.sort(rng.choice(len(rows), n_pixels, replace=False, p=odds))
            pixels = np.empty((n_pixels, 4), np.int32)
            pixels[:, IMAGE] = place
            pixels[:, ROW] = rows[chosen] - box[0]
            pixels[:, COLUMN] = columns[chosen] - box[1]
            pixels[:, LABEL] = labels[rows[chosen], columns[chosen]] - 1
            drawn.append(pixels)
        return np.concatenate(drawn)

    def _batch(self, number: int) -> ImageBatch:
        """Return the images of a batch: kept, or read again."""
        if number in self._kept:
            return self._kept[number]
        begin = number * self.memory.n_batch_images
        batch = join_images(
            [prepared for _, prepared, _, _ in self._read(begin)], self.params.far_m
        )
        if self._n_kept_bytes + batch.n_bytes <= self.memory.image_bytes:
            self._kept[number] = batch
            self._n_kept_bytes += batch.n_bytes
        return batch

    def _read(self, begin: int) -> Iterator[tuple[int, ForestImage, AnyArray, tuple[int, int]]]:
        """Read a batch: place in it, image, labels where there is depth, corner of its box."""
        params = self.params
        smoothing_px = params.smoothing_px if params.n_gradient_candidates else None
        for place, index in enumerate(self._chosen[begin : begin + self.memory.n_batch_images]):
            depth_m, labels, focal_px = self._images.read(int(index))
            mask = labels > 0
            image = prepare_image(depth_m, mask, focal_px, params.far_m, smoothing_px)
            known = np.where(np.isfinite(depth_m), labels, 0)
            yield place, image, known, (image.top, image.left)


def _odds(labels: AnyArray, evenness: float) -> FloatArray | None:
    """Return the (N,) probability of drawing each pixel; None where all are as likely."""
    if evenness == 0.0 or not len(labels):
        return None
    weights = np.bincount(labels)[labels].astype(np.float64) ** -evenness
    return np.asarray(weights / weights.sum())
