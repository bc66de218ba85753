"""Labels of one frame carried over to the next: nearest in space, borders settled by the cut.

Every pixel of the next frame asks the labelled pixels of the frame before that are nearest to it in
space. A first look tells how far each limb went; a second one looks where the limb is by then.
What they say becomes probabilities, and the graph cut of the live chain draws the borders at the
depth edges.
"""

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from adibas.arrays import BoolArray, Float32Array, FloatArray, IntArray, UInt8Array, check_shape
from adibas.graphcut.boundary import boundary_weights
from adibas.graphcut.energy import EnergyParams, equal_penalties, label_energy
from adibas.graphcut.minimising import minimise
from adibas.graphcut.neighbors import connect_pixels


@dataclass(frozen=True, slots=True)
class PropagationParams:
    """How labels are carried over.

    Attributes
    ----------
    reach_m : float
        A pixel asks labelled pixels within this distance: 0.15, a hand's way in a thirtieth of a
        second at 4.5 m/s.
    width_m : float
        Of the density by which near ones count more: 0.02.
    n_neighbors : int
        How many are asked.
    n_rounds : int
        How often it is looked how far each limb went; 0: limbs stay where they were.
    smoothness : float
        Lambda of the cut, as in `LimbParams`.
    """

    reach_m: float = 0.15
    width_m: float = 0.02
    n_neighbors: int = 8
    n_rounds: int = 4
    smoothness: float = 4.0


@dataclass(frozen=True, slots=True, eq=False)
class SeenPerson:
    """A person in one depth image.

    Attributes
    ----------
    points_m : (H, W, 3) array
        What each pixel sees, camera axes; NaN where not measured.
    mask : (H, W) bool array
    """

    points_m: Float32Array
    mask: BoolArray

    def __post_init__(self) -> None:
        check_shape("points_m", self.points_m, (*self.mask.shape, 3))

    @property
    def known(self) -> BoolArray:
        """Return the person's pixels with depth."""
        return np.asarray(self.mask & np.isfinite(self.points_m).all(axis=2))


def carry_labels(
    before: SeenPerson,
    labels: UInt8Array,
    after: SeenPerson,
    params: PropagationParams | None = None,
) -> UInt8Array:
    """Return (H, W) labels of the next frame; 0 outside of its mask, and where none is near.

    Parameters
    ----------
    before : SeenPerson
        Its mask counts for nothing: what has a label counts.
    labels : (H, W) uint8 array
        Of that frame, 1 to L; 0 = none.
    after : SeenPerson
    params : PropagationParams or None
    """
    params = params or PropagationParams()
    check_shape("labels", labels, before.mask.shape)
    carried = np.zeros(after.mask.shape, np.uint8)
    given = (labels > 0) & np.isfinite(before.points_m).all(axis=2)
    known = after.known
    if not given.any() or not known.any():
        return carried
    old_m, old = _points(before, given), labels[given].astype(np.int64)
    new_m = _points(after, known)
    moved_m = old_m + _moves(old_m, old, new_m, params)[old]
    votes = _votes(moved_m, old, new_m, params)
    is_near = votes.any(axis=1)
    pixels = known.copy()
    pixels[known] = is_near
    carried[pixels] = _cut(after, pixels, votes[is_near], params)
    return carried


def _points(person: SeenPerson, chosen: BoolArray) -> FloatArray:
    return np.asarray(person.points_m[chosen], np.float64)


def _moves(
    old_m: FloatArray, old: IntArray, new_m: FloatArray, params: PropagationParams
) -> FloatArray:
    """Return (L + 1, 3): how far each limb went, by the pixels that are nearest to its own."""
    n_labels = int(old.max()) + 1
    moves_m = np.zeros((n_labels, 3))
    tree = cKDTree(new_m)
    counts = np.bincount(old, minlength=n_labels)
    for _ in range(params.n_rounds):
        here_m = old_m + moves_m[old]
        distance_m, nearest = _nearest(tree, here_m, 1, params.reach_m)
        distance_m, nearest = distance_m[:, 0], nearest[:, 0]
        found = np.isfinite(distance_m)
        step_m = np.zeros_like(here_m)
        step_m[found] = new_m[nearest[found]] - here_m[found]
        for axis in range(3):
            total_m = np.bincount(old, weights=step_m[:, axis], minlength=n_labels)
            moves_m[:, axis] += total_m / np.maximum(counts, 1)
    return moves_m


def _votes(
    old_m: FloatArray, old: IntArray, new_m: FloatArray, params: PropagationParams
) -> FloatArray:
    """Return (N, L): how much each label is near each pixel; a row of 0 where none is."""
    k = min(params.n_neighbors, len(old_m))
    distance_m, nearest = _nearest(cKDTree(old_m), new_m, k, params.reach_m)
    found = np.isfinite(distance_m)
    nearest[~found] = 0
    least_m = np.where(found[:, :1], distance_m[:, :1], 0.0)
    weight = np.where(found, np.exp(-(((distance_m - least_m) / params.width_m) ** 2)), 0.0)
    votes = np.zeros((len(new_m), int(old.max())))
    for column in range(k):
        np.add.at(votes, (np.arange(len(new_m)), old[nearest[:, column]] - 1), weight[:, column])
    return votes


def _nearest(
    tree: cKDTree, points_m: FloatArray, k: int, reach_m: float
) -> tuple[FloatArray, IntArray]:
    """Return (N, k) distances, infinite beyond reach, and which points these are."""
    distance_m, nearest = tree.query(points_m, np.arange(1, k + 1), distance_upper_bound=reach_m)
    return np.asarray(distance_m, np.float64), np.asarray(nearest, np.int64)


def _cut(
    after: SeenPerson, pixels: BoolArray, votes: FloatArray, params: PropagationParams
) -> UInt8Array:
    graph = connect_pixels(pixels, 8)
    depth_m = np.ascontiguousarray(after.points_m[..., 2], np.float32)
    share = votes / votes.sum(axis=1, keepdims=True)
    probabilities = np.ascontiguousarray(0.02 / votes.shape[1] + 0.98 * share, np.float32)
    energy = label_energy(
        graph,
        probabilities,
        boundary_weights(graph, depth_m),
        equal_penalties(votes.shape[1]),
        EnergyParams(params.smoothness),
    )
    return np.asarray(minimise(energy).labels + 1, np.uint8)
