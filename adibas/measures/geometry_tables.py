"""The distance of every pair of markers, and the angle at every vertex of every triplet."""

import math
from collections.abc import Sequence
from itertools import combinations

import numpy as np

from adibas.data.markers import Marker
from adibas.data.measures import AngleMeasure, DistanceMeasure
from adibas.geometry.uncertainty import uncertain_angles, uncertain_distances
from adibas.measures.marker_errors import placed_markers


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
    placed, positions_m, errors = placed_markers(markers)
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
    placed, positions_m, errors = placed_markers(markers)
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
