"""People as cells, with their labels: what a context network learns from."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from adibas.arrays import AnyArray, Float32Array, IntArray, check_shape, read_only
from adibas.context.sites import SiteLevel, site_levels


@dataclass(frozen=True, slots=True, eq=False)
class ContextExample:
    """The N cells of one person, row by row.

    Attributes
    ----------
    rows, columns : (N,) int16 arrays
    features : (N, C) float16 array
        First what a forest says of each of the K labels, then what does not change in a mirror.
    labels : (N,) int8 array
        That of most of a cell; -1 where it is not known.
    seconds : (N,) int8 array
        The next most frequent label of each cell, or the same one.
    second_share : (N,) float16 array
        Of the cell, that it has; at most a half.
    """

    rows: AnyArray
    columns: AnyArray
    features: AnyArray
    labels: AnyArray
    seconds: AnyArray
    second_share: AnyArray

    def __post_init__(self) -> None:
        n_cells = len(self.rows)
        check_shape("features", self.features, (n_cells, None))
        for name in ("columns", "labels", "seconds", "second_share"):
            check_shape(name, getattr(self, name), (n_cells,))
        for array in (self.rows, self.columns, self.features, self.labels):
            read_only(array)
        read_only(self.seconds)
        read_only(self.second_share)

    def drawn_labels(self, rng: np.random.Generator) -> IntArray:
        """Return (N,) labels, each its cell's second one as often as its share of the cell.

        So a network learns how much of a cell at a border is on either side, and what lies between
        the middles of two cells tells where the border runs.
        """
        is_second = rng.random(len(self.labels)) < self.second_share
        return np.where(is_second, self.seconds, self.labels).astype(np.intp)


@dataclass(frozen=True, slots=True, eq=False)
class Batch:
    """Several people, one below the other, too far apart to touch at any level.

    Attributes
    ----------
    inputs : (N, C) float32 array
    labels : (N,) int array
    levels : tuple of SiteLevel
    """

    inputs: Float32Array
    labels: IntArray
    levels: tuple[SiteLevel, ...]


def batch_of(
    examples: Sequence[ContextExample],
    mirror_order: IntArray,
    n_levels: int,
    rng: np.random.Generator,
) -> Batch:
    """Return examples together, each mirrored or not, moved a little, its labels drawn."""
    size = 2 ** (n_levels - 1)
    placed = [_placed(one, mirror_order, size, rng) for one in examples]
    height = 0
    tops = []
    for rows, _, _, _ in placed:
        tops.append(height)
        height += (-(-(int(rows.max()) + 1) // size) + 1) * size  # and an empty coarsest row
    width = max(int(columns.max()) for _, columns, _, _ in placed) + 1
    occupied = np.zeros((height, width), bool)
    for top, (rows, columns, _, _) in zip(tops, placed, strict=True):
        occupied[top + rows, columns] = True
    return Batch(
        np.vstack([features for _, _, features, _ in placed]).astype(np.float32),
        np.concatenate([labels for _, _, _, labels in placed]).astype(np.intp),
        site_levels(occupied, n_levels),
    )


def _placed(
    example: ContextExample, mirror_order: IntArray, size: int, rng: np.random.Generator
) -> tuple[IntArray, IntArray, AnyArray, IntArray]:
    """Return rows, columns, features and labels, row by row."""
    down, right = rng.integers(0, size, 2)
    rows, columns = example.rows + down, example.columns + right
    features, labels = example.features, example.drawn_labels(rng)
    if rng.random() < 0.5:  # noqa: PLR2004  (a half)
        columns = right + example.columns.max() - example.columns
        n_labels = len(mirror_order)
        features = np.hstack([features[:, mirror_order], features[:, n_labels:]])
        labels = np.where(labels >= 0, mirror_order[labels], labels)
        order = np.lexsort((columns, rows))
        rows, columns, features, labels = (
            rows[order],
            columns[order],
            features[order],
            labels[order],
        )
    return rows, columns, features, labels
