"""Training of a forest: how long it takes, and what memory it holds for which set and batch."""

import tempfile
import time
import tracemalloc
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

from adibas.arrays import Float32Array, UInt8Array
from adibas.data.joints import BODY_PART_NAMES
from adibas.forests.params import ForestParams
from adibas.forests.samples import Memory
from adibas.forests.training import train_tree
from adibas.pipeline.limb_simulator import simulate_folder
from adibas.pipeline.limb_training import SHIPPED, TrainingRequest, train_model
from benchmarks.limb_frames import LimbFrames
from benchmarks.table import Row

SEED = 6200
GOAL_MIN = 10.0
GOAL_FRAMES = 2000
SMALL = ForestParams(n_trees=1, n_images=None, n_pixels=50, max_depth=6, n_candidates=10)
BATCH_IMAGES, LARGER_BATCH = 64, 256
MEBIBYTE = 1 << 20
SECONDS_A_MINUTE = 60.0


def training_row(n_frames: int) -> Row:
    """Time `adibas limbs train FOLDER` on simulated people, as it trains if nothing is said."""
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place) / "frames"
        simulate_folder(folder, n_frames, SEED, lambda _done, _all: None)
        begin = time.perf_counter()
        train_model(TrainingRequest(Path(place) / "model.npz", (folder,)), lambda *_told: None)
        spent_min = (time.perf_counter() - begin) / SECONDS_A_MINUTE
    name = f"limbs train, {n_frames} frames, {SHIPPED.n_trees} trees, by the clock, all cores"
    if n_frames < GOAL_FRAMES:
        return Row(name, spent_min, "min")
    return Row(name, spent_min, "min", GOAL_MIN, "goal <")


def memory_rows(set_sizes: tuple[int, ...]) -> Iterator[Row]:
    """Grow one tree on sets of several sizes by the same batch, then by a larger one."""
    images = LimbFrames(8, BODY_PART_NAMES, SEED)
    warm = replace(SMALL, max_depth=2)
    train_tree(_Repeated(images, 8), warm, (SEED, 0), _memory(BATCH_IMAGES))
    sizes = [(n_frames, BATCH_IMAGES) for n_frames in set_sizes]
    for n_frames, n_batch in (*sizes, (set_sizes[-1], LARGER_BATCH)):
        frames = _Repeated(images, n_frames)
        tracemalloc.start()
        train_tree(frames, SMALL, (SEED, 0), _memory(n_batch))
        peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        drawn = n_frames * SMALL.n_pixels * 20 / MEBIBYTE
        told = f"training memory, {n_frames} frames, {n_batch} in a batch"
        yield Row(f"{told}; of it drawn pixels {drawn:.1f}", peak / MEBIBYTE, "MiB")


def _memory(n_batch_images: int) -> Memory:
    return Memory(n_batch_images, image_bytes=0, count_bytes=32 * MEBIBYTE)


class _Repeated:
    """A set of any size, of a few small frames again and again."""

    def __init__(self, frames: LimbFrames, n_frames: int) -> None:
        self.labels = frames.labels
        self._n_frames = n_frames
        self._small = [self._shrunk(*frames.read(index)) for index in range(len(frames))]

    @staticmethod
    def _shrunk(
        depth_m: Float32Array, labels: UInt8Array, focal_px: float
    ) -> tuple[Float32Array, UInt8Array, float]:
        every = (slice(None, None, 4),) * 2
        return depth_m[every].copy(), labels[every].copy(), focal_px / 4

    def __len__(self) -> int:
        return self._n_frames

    def read(self, index: int) -> tuple[Float32Array, UInt8Array, float]:
        """Return frame `index`, 160x120."""
        return self._small[index % len(self._small)]
