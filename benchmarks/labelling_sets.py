"""Sets of unordered markers whose names are known: people turned to a view, and what goes wrong.

Points are hidden at random; spurious ones lie anywhere in the box about the person, 0.3 m wider.
Where sizes are measured, those have any from 4 to 60 mm, as the search for markers lets pass, and
markers 9 mm with the spread of simulated stickers.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from adibas.arrays import FloatArray
from adibas.data.joints import JOINT_NAMES
from adibas.skeleton.starts import HEADINGS_RAD, turn_back

VIEW_OFF_RAD = 0.35
MARKER_SD_M = 0.005
DIAMETER_M, DIAMETER_LOG_SD = 0.009, 0.09
SPURIOUS_DIAMETERS_M = (0.004, 0.060)
BESIDE_M = 0.3


@dataclass(frozen=True, slots=True, eq=False)
class MarkerSet:
    """M points of one person.

    Attributes
    ----------
    points_m : (M, 3) array
    truth : tuple of str or None
        The name of each; None: spurious.
    view : str
        Which the camera sees, within `VIEW_OFF_RAD`.
    sizes_m : (M,) array
        Diameters as they are measured.
    room_m3 : float
        In which spurious points lie.
    """

    points_m: FloatArray
    truth: tuple[str | None, ...]
    view: str
    sizes_m: FloatArray
    room_m3: float


def marker_sets(
    shapes_m: FloatArray, n_sets: int, n_changed: int, seed: int
) -> Iterator[MarkerSet]:
    """Give sets of (S, 15, 3) shapes that face the camera, the views in turn.

    `n_changed` points are hidden, and as many are spurious.
    """
    rng = np.random.default_rng(seed)
    of_sizes = np.random.default_rng([seed, 1])
    views = list(HEADINGS_RAD)
    for number in range(n_sets):
        view = views[number % len(views)]
        heading_rad = HEADINGS_RAD[view] + rng.uniform(-VIEW_OFF_RAD, VIEW_OFF_RAD)
        points_m = shapes_m[number % len(shapes_m)] @ turn_back(heading_rad)
        points_m = points_m + rng.normal(scale=MARKER_SD_M, size=points_m.shape)
        low, high = points_m.min(axis=0) - BESIDE_M, points_m.max(axis=0) + BESIDE_M
        kept = rng.permutation(len(points_m))[n_changed:]
        spurious_m = rng.uniform(low, high, (n_changed, 3))
        points_m = np.concatenate([points_m[kept], spurious_m])
        truth = [*(JOINT_NAMES[i] for i in kept), *[None] * n_changed]
        order = rng.permutation(len(points_m))
        sizes_m = _sizes_m(of_sizes, len(kept), n_changed)[order]
        named = tuple(truth[i] for i in order)
        yield MarkerSet(points_m[order], named, view, sizes_m, float(np.prod(high - low)))


def _sizes_m(rng: np.random.Generator, n_markers: int, n_spurious: int) -> FloatArray:
    """Return diameters as they are measured."""
    markers_m = DIAMETER_M * np.exp(rng.normal(scale=DIAMETER_LOG_SD, size=n_markers))
    least_m, greatest_m = SPURIOUS_DIAMETERS_M
    spurious_m = np.exp(rng.uniform(math.log(least_m), math.log(greatest_m), n_spurious))
    return np.concatenate([markers_m, spurious_m])
