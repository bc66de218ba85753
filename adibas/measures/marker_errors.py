"""Places of markers, and how their errors go together."""

from collections.abc import Sequence
from itertools import permutations
from typing import NamedTuple

import numpy as np

from adibas.arrays import FloatArray, IntArray
from adibas.data.markers import Marker
from adibas.geometry.uncertainty import independent


class MarkerErrors(NamedTuple):
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

    def of_all(self) -> FloatArray:
        """Return the (3N, 3N) covariance of all markers together."""
        moves_m = self.shared_m.reshape(3 * len(self.shared_m), self.shared_m.shape[-1])
        joint = moves_m @ moves_m.T
        for place, covariance_m2 in enumerate(self.covariances_m2):
            own = slice(3 * place, 3 * place + 3)
            joint[own, own] = covariance_m2
        return joint


def placed_markers(markers: Sequence[Marker]) -> tuple[list[Marker], FloatArray, MarkerErrors]:
    """Return the markers that have a position, their (N, 3) positions and errors."""
    placed = [marker for marker in markers if marker.position_m is not None]
    positions_m = np.array([marker.position_m for marker in placed], float).reshape(-1, 3)
    covariances_m2 = np.array([marker.covariance_m2 for marker in placed], float)
    return placed, positions_m, MarkerErrors(covariances_m2.reshape(-1, 3, 3), _shared(placed))


def _shared(placed: Sequence[Marker]) -> FloatArray:
    """Return the (N, 3, n) shared moves; none where they are unknown or not of one calibration."""
    moves_m = [marker.shared_m for marker in placed]
    known = [move_m for move_m in moves_m if move_m is not None]
    if len(known) < len(placed) or len({move_m.shape for move_m in known}) != 1:
        return np.zeros((len(placed), 3, 0))
    return np.stack(known)
