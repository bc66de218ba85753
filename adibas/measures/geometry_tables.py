"""The distance of every pair of markers, and the angle at every vertex of every triplet."""

import math
from collections.abc import Sequence
from itertools import combinations, permutations
from typing import NamedTuple

import numpy as np

from adibas.arrays import FloatArray, IntArray
from adibas.data.markers import Marker
from adibas.data.measures import AngleMeasure, DistanceMeasure
from adibas.geometry.uncertainty import independent, uncertain_angles, uncertain_distances


def all_distances(markers: Sequence[Marker]) -> tuple[DistanceMeasure, ...]:
    """Measure the distance of every pair.

    Parameters
    ----------
    markers : sequence of Marker
        Those without a position are left out. Their errors are independent but for the part that
        `Marker.shared_m` says they share.

    Returns
    -------
    distances : tuple of DistanceMeasure
        In the markers' order: the first with each later one, then the second, and so on.
    """
    placed, positions_m, errors = _positions(markers)
    pairs = np.array(list(combinations(range(len(placed)), 2)), np.int64).reshape(-1, 2)
    found = uncertain_distances(positions_m[pairs], errors.joint(pairs))
    return tuple(
        DistanceMeasure(placed[a].label, placed[b].label, value_m, (low_m, high_m))
        for (a, b), value_m, (low_m, high_m) in zip(
            pairs.tolist(), found.values.tolist(), found.intervals.tolist(), strict=True
        )
    )


def all_angles(markers: Sequence[Marker]) -> tuple[AngleMeasure, ...]:
    """Measure the angle at each of the three vertices of every triplet.

    Parameters
    ----------
    markers : sequence of Marker
        Those without a position are left out. Their errors are independent but for the part that
        `Marker.shared_m` says they share.

    Returns
    -------
    angles : tuple of AngleMeasure
        Triplets in the markers' order; of each the angle at its first, second and third marker.
        Where two markers coincide there is no angle.
    """
    placed, positions_m, errors = _positions(markers)
    triplets = np.array(
        [
            corners
            for i, j, k in combinations(range(len(placed)), 3)
            for corners in ((j, i, k), (i, j, k), (i, k, j))
        ],
        np.int64,
    ).reshape(-1, 3)
    found = uncertain_angles(positions_m[triplets], errors.joint(triplets))
    return tuple(
        AngleMeasure(
            placed[a].label, placed[vertex].label, placed[c].label, value, (low, high), bias
        )
        for (a, vertex, c), value, (low, high), bias in zip(
            triplets.tolist(),
            found.values.tolist(),
            found.intervals.tolist(),
            found.biases.tolist(),
            strict=True,
        )
        if not math.isnan(value)
    )


class _Errors(NamedTuple):
    """(N, 3, 3) covariances of N markers, and the (N, 3, n) moves under causes they share."""

    covariances_m2: FloatArray
    shared_m: FloatArray

    def joint(self, groups: IntArray) -> FloatArray:
        """Return the (n, 3 m, 3 m) covariances of n groups of m markers."""
        joint = independent(*(self.covariances_m2[members] for members in groups.T))
        n_members = groups.shape[1]
        for i, j in permutations(range(n_members), 2):
            shared_m2 = self.shared_m[groups[:, i]] @ self.shared_m[groups[:, j]].swapaxes(1, 2)
            joint[:, 3 * i : 3 * i + 3, 3 * j : 3 * j + 3] = shared_m2
        return joint


def _positions(markers: Sequence[Marker]) -> tuple[list[Marker], FloatArray, _Errors]:
    """Return the markers that have a position, their (N, 3) positions and errors."""
    placed = [marker for marker in markers if marker.position_m is not None]
    positions_m = np.array([marker.position_m for marker in placed], float).reshape(-1, 3)
    covariances_m2 = np.array([marker.covariance_m2 for marker in placed], float)
    return placed, positions_m, _Errors(covariances_m2.reshape(-1, 3, 3), _shared(placed))


def _shared(placed: Sequence[Marker]) -> FloatArray:
    """Return the (N, 3, n) shared moves; none where they are unknown or not of one calibration."""
    moves_m = [marker.shared_m for marker in placed]
    known = [move_m for move_m in moves_m if move_m is not None]
    if len(known) < len(placed) or len({move_m.shape for move_m in known}) != 1:
        return np.zeros((len(placed), 3, 0))
    return np.stack(known)
