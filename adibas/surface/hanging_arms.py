"""Which points of a standing body are of arms: what hangs beside the trunk, apart from it."""

from dataclasses import dataclass

import numpy as np

from adibas.arrays import BoolArray, FloatArray
from adibas.surface.parts_from_above import parts_from_above

N_GROWN = 1


@dataclass(frozen=True, slots=True)
class ArmParams:
    """Settings.

    Attributes
    ----------
    lowest_share, highest_share : float
        Of the stature, between which arms hang beside the trunk: 0.5 and 0.85. Below, legs are
        apart as well.
    slice_m : float
        Height of a slice: 2 cm.
    cell_m : float
        Of a slice's picture from above: 5 mm. Points three cells apart still hang together.
    behind_share : float
        Of its width, so much of a part lies before or behind the trunk where it is the trunk's
        other side: 0.5.
    least_m : float
        Arms hang apart over such a height together, or it is not told of any: 0.1.
    trunk_share : float
        Of the whole width, the trunk has at least so much: 0.4. What falls apart since few points
        were seen are no arms.
    """

    lowest_share: float = 0.5
    highest_share: float = 0.85
    slice_m: float = 0.02
    cell_m: float = 0.005
    behind_share: float = 0.5
    least_m: float = 0.1
    trunk_share: float = 0.4


def are_of_arms(
    over_m: FloatArray, heights_m: FloatArray, stature_m: float, params: ArmParams | None = None
) -> BoolArray:
    """Say which points are of arms; where an arm touches the trunk, it is the trunk's.

    Parameters
    ----------
    over_m : (N, 2) array
        Places over the floor, along any two axes.
    heights_m : (N,) array
        Over the floor.
    stature_m : float
    """
    params = params or ArmParams()
    lowest_m, highest_m = params.lowest_share * stature_m, params.highest_share * stature_m
    beside = np.flatnonzero((heights_m >= lowest_m) & (heights_m < highest_m))
    are_arms = np.zeros(len(heights_m), np.bool_)
    if not len(beside):
        return are_arms
    across_m = _across(over_m[beside])
    numbers = ((heights_m[beside] - lowest_m) / params.slice_m).astype(np.int64)
    order = np.argsort(numbers, kind="stable")
    n_slices = 0
    for one in np.split(order, np.flatnonzero(np.diff(numbers[order])) + 1):
        is_apart = _apart(across_m[one], params)
        are_arms[beside[one]] = is_apart
        n_slices += bool(is_apart.any())
    if n_slices * params.slice_m < params.least_m:
        are_arms[:] = False
    return are_arms


def _across(over_m: FloatArray) -> FloatArray:
    """Return places with the first axis across the body, where it is widest."""
    centred = over_m - over_m.mean(axis=0)
    _, axes = np.linalg.eigh(centred.T @ centred)
    return np.asarray(centred @ axes[:, ::-1])


def _apart(flat_m: FloatArray, params: ArmParams) -> BoolArray:
    """Say which points (N, 2) of a slice are apart from the trunk, and aside of it."""
    parts = parts_from_above(flat_m, params.cell_m, N_GROWN)
    sides_m = [
        (float(flat_m[parts == one, 0].min()), float(flat_m[parts == one, 0].max()))
        for one in range(int(parts.max()) + 1)
    ]
    low_m, high_m = max(sides_m, key=lambda side: side[1] - side[0])  # the trunk is widest
    if high_m - low_m < params.trunk_share * np.ptp(flat_m[:, 0]):
        return np.zeros(len(flat_m), np.bool_)
    is_aside = [
        min(right, high_m) - max(left, low_m) < params.behind_share * (right - left)
        for left, right in sides_m
    ]
    return np.array(is_aside)[parts]
