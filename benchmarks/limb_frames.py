"""Simulated people with labelled limbs, 640x480: what the limbs' speed is measured on."""

from functools import cache

import numpy as np

from adibas.arrays import BoolArray, Float32Array, IntArray, UInt8Array
from adibas.data.joints import BODY_PART_NAMES
from adibas.geometry.pinhole import Intrinsics
from adibas.simulation.body import ShapedBody, load_body_model
from adibas.simulation.body_shape import BodyShape
from adibas.simulation.random_poses import random_figure
from adibas.simulation.raster import rasterise

FOCAL_PX = 570.0
SIZE = (480, 640)
UPPER_BODY = (
    *(
        f"{side}_{part}"
        for side in ("left", "right")
        for part in ("upper_arm", "lower_arm", "hand")
    ),
    "torso",
)
"""The 7 labels; head and legs count as torso here."""
_NOISE_M = 0.003
_NEAREST_M, _FARTHEST_M = 1.6, 2.4
_SHAPES = (
    BodyShape("female", 35, 1.66, 60),
    BodyShape("male", 50, 1.78, 85),
    BodyShape("female", 9, 1.33, 30),
)


class LimbFrames:
    """Frames of different people in random poses, in front of nothing.

    Parameters
    ----------
    n_frames : int
    labels : tuple of str
        `BODY_PART_NAMES` or `UPPER_BODY`.
    seed : int
        Other seeds have other poses.
    """

    def __init__(self, n_frames: int, labels: tuple[str, ...], seed: int = 0) -> None:
        self.labels = labels
        self._n_frames, self._seed = n_frames, seed
        self._of_part = _label_of_part(labels)
        self._kept: dict[int, tuple[Float32Array, UInt8Array, float]] = {}

    def __len__(self) -> int:
        return self._n_frames

    def read(self, index: int) -> tuple[Float32Array, UInt8Array, float]:
        """Return (480, 640) metres with NaN, (480, 640) labels 1 to L or 0, and focal_px."""
        if index not in self._kept:
            self._kept[index] = self._draw(index)
        return self._kept[index]

    def _draw(self, index: int) -> tuple[Float32Array, UInt8Array, float]:
        rng = np.random.default_rng([self._seed, index])
        body = _body(index % len(_SHAPES))
        vertices_m = body.posed(random_figure(rng, "moving").pose()).vertices_m
        distance_m = rng.uniform(_NEAREST_M, _FARTHEST_M)
        middle_m = 0.5 * (vertices_m.min(axis=0) + vertices_m.max(axis=0))
        seen = rasterise(
            vertices_m - middle_m + np.array([0.0, 0.0, distance_m]),
            body.model.triangles,
            Intrinsics(FOCAL_PX, FOCAL_PX, (SIZE[1] - 1) / 2, (SIZE[0] - 1) / 2),
            SIZE,
            hides_back_faces=True,
        )
        mask = seen.triangle >= 0
        labels = np.zeros(SIZE, np.uint8)
        labels[mask] = 1 + self._of_part[body.model.triangle_parts[seen.triangle[mask]]]
        depth_m = seen.depth_m + rng.normal(0, _NOISE_M, SIZE)
        return depth_m.astype(np.float32), labels, FOCAL_PX

    def person(self, index: int) -> tuple[Float32Array, BoolArray]:
        """Return the depth and the mask of a frame."""
        depth_m, labels, _ = self.read(index)
        return depth_m, labels > 0


@cache
def _body(number: int) -> ShapedBody:
    return load_body_model().shaped(_SHAPES[number])


def _label_of_part(labels: tuple[str, ...]) -> IntArray:
    """Return for each of `BODY_PART_NAMES` the label; the torso's where it has none."""
    torso = labels.index("torso")
    return np.array(
        [labels.index(name) if name in labels else torso for name in BODY_PART_NAMES], np.int64
    )
