"""Names of markers of which the picture shows a band: a patient too near to be seen whole.

Simulated people whom the training did not see, 1 to 2.2 m from the depth camera of a first Kinect,
whose picture is as high as any part of the body; five markers or more are in it, and one or more
are not. Once the program knows what the cameras see, once it does not.
"""

import math
from collections.abc import Iterator

import numpy as np

from adibas.arrays import FloatArray
from adibas.data.joints import JOINT_NAMES
from adibas.pipeline.skeleton_labelling import shipped_namer
from adibas.simulation.device import DEPTH_SIZE
from adibas.skeleton.seen_space import EVERYWHERE, SeenSpace
from adibas.skeleton.starts import HEADINGS_RAD, turn_back
from benchmarks.table import Row

DISTANCES_M = (1.0, 1.2, 1.5, 1.8, 2.2)
N_SETS = 150
FOCAL_PX = 580.0
VIEW_OFF_RAD, ASIDE_M, MARKER_SD_M = 0.35, 0.15, 0.004
LOW, HIGH = 20.0, 80.0
"""Percentiles of the markers' heights between which the middle of the picture lies."""
LEAST_SEEN = 5


def depth_picture() -> SeenSpace:
    """Return what a depth camera sees, in its own axes."""
    height, width = DEPTH_SIZE
    right, down = 0.5 * width / FOCAL_PX, 0.5 * height / FOCAL_PX
    normals = np.array([[1, 0, right], [-1, 0, right], [0, 1, down], [0, -1, down]], float)
    return SeenSpace(normals / np.linalg.norm(normals, axis=1)[:, None], np.zeros(4))


def band_rows(shapes_m: FloatArray, told: str, seed: int, share: int) -> Iterator[Row]:
    """Name bands of (S, 15, 3) shapes that face the camera, each turned to a view that is told."""
    for distance_m in DISTANCES_M:
        rng = np.random.default_rng([seed, round(10 * distance_m)])
        bands = list(_bands(shapes_m, distance_m, max(N_SETS // share, 4), rng))
        for seen, known in ((depth_picture(), "known"), (EVERYWHERE, "not known")):
            yield from _rows(
                bands, seen, f"{told}, part of them seen at {distance_m} m, picture {known}"
            )


def _bands(
    shapes_m: FloatArray, distance_m: float, n_sets: int, rng: np.random.Generator
) -> Iterator[tuple[FloatArray, tuple[str, ...], str]]:
    """Give the places, names and view of what is seen of people of whom not all is."""
    space, views = depth_picture(), list(HEADINGS_RAD)
    for number in range(n_sets):
        view = views[number % len(views)]
        heading_rad = HEADINGS_RAD[view] + rng.uniform(-VIEW_OFF_RAD, VIEW_OFF_RAD)
        points_m = shapes_m[number % len(shapes_m)] @ turn_back(heading_rad)
        points_m = points_m + rng.normal(scale=MARKER_SD_M, size=points_m.shape)
        middle_m = np.array(
            [
                points_m[:, 0].mean() + rng.uniform(-ASIDE_M, ASIDE_M),
                rng.uniform(*np.percentile(points_m[:, 1], (LOW, HIGH))),
                np.median(points_m[:, 2]) - distance_m,
            ]
        )
        points_m = points_m - middle_m
        is_seen = (points_m @ space.normals.T >= space.offsets_m).all(axis=1)
        if not LEAST_SEEN <= is_seen.sum() < len(points_m):
            continue
        order = rng.permutation(np.flatnonzero(is_seen))
        yield points_m[order], tuple(JOINT_NAMES[i] for i in order), view


def _rows(
    bands: list[tuple[FloatArray, tuple[str, ...], str]], seen: SeenSpace, told: str
) -> Iterator[Row]:
    namer = shipped_namer().holding_still()
    n_right = n_wrong = n_whole = n_points = 0
    for points_m, truth, view in bands:
        names = namer.label(points_m, view, seen=seen).names
        right = [name == own for name, own in zip(names, truth, strict=True)]
        n_right += sum(right)
        n_wrong += sum(name is not None for name in names) - sum(right)
        n_whole += all(right)
        n_points += len(truth)
    told = f"{told}, {len(bands)} sets of {n_points} markers"
    for name, n, of in (
        ("right names", n_right, n_points),
        ("wrong names", n_wrong, n_points),
        ("entirely right", n_whole, len(bands)),
    ):
        yield Row(f"{told}: {name}", 100 * n / of if of else math.nan, "%")
