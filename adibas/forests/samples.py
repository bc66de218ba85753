"""The pixels that a tree is trained on: drawn from images, which are read in batches."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from adibas.arrays import AnyArray, Float32Array, FloatArray, Int32Array, IntArray, UInt8Array
from adibas.forests.images import ForestImage, ImageBatch, join_images, prepare_image
from adibas.forests.params import ForestParams
from adibas.forests.training_kernels import (
    COLUMN,
    IMAGE,
    LABEL,
    LEAF,
    ROW,
    count_values,
    route,
    scales_of,
)

_DRAW_IMAGES, _DRAW_PIXELS = range(2)


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


class PixelSample:
    """The pixels drawn for one tree, or a share of them, and the images they are in.

    Parameters
    ----------
    images : TrainingImages
    params : ForestParams
    seed : (int, int)
        Of the forest, and the number of the tree.
    memory : Memory
    share : (k, n)
        Batches k, k + n, k + 2 n ... of those that the tree is drawn from.
    """

    def __init__(
        self,
        images: TrainingImages,
        params: ForestParams,
        seed: tuple[int, int],
        memory: Memory,
        share: tuple[int, int] = (0, 1),
    ) -> None:
        self._params, self._seed, self._memory = params, seed, memory
        self._images = images
        n_images = len(images)
        rng = np.random.default_rng([*seed, _DRAW_IMAGES])
        n_drawn = min(params.n_images or n_images, n_images)
        self._chosen = np.sort(rng.choice(n_images, n_drawn, replace=False))
        self._kept: dict[int, ImageBatch] = {}
        self._n_kept_bytes = 0
        first, n_shares = share
        self._begins = range(0, n_drawn, memory.n_batch_images)[first::n_shares]
        self._pixels: list[Int32Array] = [self._draw(begin) for begin in self._begins]
        self._at_node = [np.zeros(len(pixels), np.int32) for pixels in self._pixels]

    def label_counts(self) -> IntArray:
        """Return the (L,) drawn pixels of each label."""
        n_labels = len(self._images.labels)
        counts: IntArray = np.zeros(n_labels, np.int64)
        for pixels in self._pixels:
            counts += np.bincount(pixels[:, LABEL], minlength=n_labels)
        return counts

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
            rng = np.random.default_rng([*self._seed, _DRAW_PIXELS, begin + place])
            rows, columns = np.nonzero(labels)
            n_pixels = min(self._params.n_pixels, len(rows))
            odds = _odds(labels[rows, columns], self._params.evenness)
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
        read = self._read(self._begins[number])
        batch = join_images([prepared for _, prepared, _, _ in read], self._params.far_m)
        if self._n_kept_bytes + batch.n_bytes <= self._memory.image_bytes:
            self._kept[number] = batch
            self._n_kept_bytes += batch.n_bytes
        return batch

    def _read(self, begin: int) -> Iterator[tuple[int, ForestImage, AnyArray, tuple[int, int]]]:
        """Read a batch: place in it, image, labels where there is depth, corner of its box."""
        params = self._params
        smoothing_px = params.smoothing_px if params.n_gradient_candidates else None
        for place, index in enumerate(self._chosen[begin : begin + self._memory.n_batch_images]):
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
