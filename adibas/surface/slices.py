"""Girths and volumes of a standing body by horizontal slices.

A girth is what a tape measures: the tape spans hollows, so it is the convex hull of the slice. A
volume is the area inside the outline, summed over the slices; places of the outline that no view
saw are bridged.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import binary_dilation, label
from scipy.spatial import ConvexHull, QhullError

from adibas.arrays import FloatArray
from adibas.surface.merging import BodySurface

N_GROWN = 2
N_SECTORS = 48
BEHIND = 0.7
"""Of a part's width, so much lies behind another that both are one."""
ALL_NEIGHBOURS = np.ones((3, 3), int)


@dataclass(frozen=True, slots=True)
class SliceParams:
    """Settings.

    Attributes
    ----------
    half_m : float
        Of a slice's height: 8 mm, two rows of what a view sees at 2 m.
    step_m : float
        Between slices: 10 mm.
    cell_m : float
        Of the picture in which a slice falls apart into parts: 4 mm; points four cells apart
        still hang together.
    least_share : float
        Of the directions from a part's middle in which its outline must be seen: 0.7.
    least_area_m2 : float
        Smaller parts are hands or nothing: 20 square centimetres.
    """

    half_m: float = 0.008
    step_m: float = 0.01
    cell_m: float = 0.004
    least_share: float = 0.7
    least_area_m2: float = 0.002


@dataclass(frozen=True, slots=True)
class SlicePart:
    """One closed outline of a slice.

    Attributes
    ----------
    height_m : float
        Over the floor.
    middle_x_m : float
        To the patient's right.
    girth_m, area_m2 : float
    seen_share : float
        Of the directions around its middle in which the outline was seen, 0 to 1.
    """

    height_m: float
    middle_x_m: float
    girth_m: float
    area_m2: float
    seen_share: float


def slice_parts(
    surface: BodySurface, height_m: float, params: SliceParams | None = None
) -> tuple[SlicePart, ...]:
    """Return the parts of one slice, from the patient's left to the right."""
    params = params or SliceParams()
    points_m = surface.points_m
    near = np.abs(points_m[:, 1] - height_m) <= params.half_m
    flat_m = points_m[near][:, [0, 2]]
    if len(flat_m) < 3:  # noqa: PLR2004  (no outline)
        return ()
    found = [
        part
        for group in _joined(list(_groups(flat_m, params)))
        if (part := _part(group, height_m, params)) is not None
    ]
    return tuple(sorted(found, key=lambda part: part.middle_x_m))


def volume_m3(parts: list[SlicePart], step_m: float) -> float:
    """Return the volume of slices that lie `step_m` apart."""
    return float(sum(part.area_m2 for part in parts) * step_m)


def trunk_slices(
    surface: BodySurface, low_m: float, high_m: float, params: SliceParams | None = None
) -> list[SlicePart]:
    """Return the largest part of each slice between two heights, where its outline was seen."""
    params = params or SliceParams()
    chosen = []
    for height_m in np.arange(low_m, high_m, params.step_m):
        parts = slice_parts(surface, float(height_m), params)
        whole = [part for part in parts if part.seen_share >= params.least_share]
        if whole:
            chosen.append(max(whole, key=lambda part: part.area_m2))
    return chosen


def leg_slices(
    surface: BodySurface, low_m: float, high_m: float, params: SliceParams | None = None
) -> tuple[list[SlicePart], list[SlicePart]]:
    """Return the slices of the left and of the right leg, where they are two."""
    params = params or SliceParams()
    left, right = [], []
    for height_m in np.arange(low_m, high_m, params.step_m):
        parts = slice_parts(surface, float(height_m), params)
        whole = [part for part in parts if part.seen_share >= params.least_share]
        largest = sorted(whole, key=lambda part: part.area_m2)[-2:]
        if len(largest) == 2 and largest[0].area_m2 > 0.4 * largest[1].area_m2:  # noqa: PLR2004
            one, other = sorted(largest, key=lambda part: part.middle_x_m)
            left.append(one)
            right.append(other)
    return left, right


def _groups(flat_m: FloatArray, params: SliceParams) -> Iterator[FloatArray]:
    """Yield the points of each part: what hangs together in a picture from above."""
    cells = np.floor((flat_m - flat_m.min(axis=0)) / params.cell_m).astype(int) + N_GROWN
    picture = np.zeros(cells.max(axis=0) + N_GROWN + 1, np.bool_)
    picture[tuple(cells.T)] = True
    numbers, count = label(binary_dilation(picture, ALL_NEIGHBOURS > 0, N_GROWN), ALL_NEIGHBOURS)
    for number in range(1, count + 1):
        yield flat_m[numbers[tuple(cells.T)] == number]


def _joined(groups: list[FloatArray]) -> list[FloatArray]:
    """Put front and back of one part together: what lies behind one another belongs together.

    Arms that hang hide the flanks from the side, so that a trunk falls into two.
    """
    rest = sorted(groups, key=len, reverse=True)
    whole: list[FloatArray] = []
    for group in rest:
        low, high = group[:, 0].min(), group[:, 0].max()
        for number, other in enumerate(whole):
            shared = min(high, other[:, 0].max()) - max(low, other[:, 0].min())
            if shared > BEHIND * (high - low):
                whole[number] = np.concatenate([other, group])
                break
        else:
            whole.append(group)
    return whole


def _part(flat_m: FloatArray, height_m: float, params: SliceParams) -> SlicePart | None:
    try:
        hull = ConvexHull(flat_m)
    except (QhullError, ValueError):
        return None  # fewer than three points, or all on one line
    if hull.volume < params.least_area_m2:
        return None
    middle = flat_m[hull.vertices].mean(axis=0)
    way = flat_m - middle
    turn = np.arctan2(way[:, 1], way[:, 0]) / (2.0 * np.pi) % 1.0
    sectors = np.minimum((turn * N_SECTORS).astype(int), N_SECTORS - 1)
    counts = np.bincount(sectors, minlength=N_SECTORS)
    sums = np.bincount(sectors, np.hypot(*way.T), N_SECTORS)
    seen = np.flatnonzero(counts)
    radii_m = np.interp(np.arange(N_SECTORS), seen, sums[seen] / counts[seen], period=N_SECTORS)
    wedge = 0.5 * float(np.sin(2.0 * np.pi / N_SECTORS))
    return SlicePart(
        height_m,
        float(middle[0]),
        float(hull.area),
        wedge * float((radii_m * np.roll(radii_m, 1)).sum()),
        len(seen) / N_SECTORS,
    )
