"""Girths and volumes of a standing body by horizontal slices.

A girth is what a tape measures: the tape spans hollows, so it is the convex hull of the slice. A
volume is the area inside the outline, summed over the slices. Places of the outline that no view
saw, such as the inner side of a calf, are bridged by an arc: a chord would lose a hundredth of a
girth.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import median_filter
from scipy.spatial import ConvexHull, QhullError

from adibas.arrays import FloatArray
from adibas.surface.merging import BodySurface
from adibas.surface.parts_from_above import parts_from_above

N_GROWN = 2
N_SECTORS = 48
N_AGREEING = 3
BEHIND = 0.7
"""Of a part's width, so much lies behind another that both are one."""
FLANKS_DEG = 15.0, 75.0
"""From straight aside; beyond lie the furrow of the spine, the cleft and the breast."""
_ANGLES = 2.0 * np.pi * (np.arange(N_SECTORS) + 0.5) / N_SECTORS
_WAYS = np.stack([np.cos(_ANGLES), np.sin(_ANGLES)])
"""To the middle of each sector."""


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
    deepest_m : float
        Hollow between a flank and what lies beside it that a body alone has: 15 mm. Of 24
        simulated bodies no slice of the trunk alone had more, of the legs 7 mm at the most, and
        arms that touch have.
    near_touch_m : float
        Slices so near to one with a deeper hollow are left out too: 12 mm, the next one.
    """

    half_m: float = 0.008
    step_m: float = 0.01
    cell_m: float = 0.004
    least_share: float = 0.7
    least_area_m2: float = 0.002
    deepest_m: float = 0.015
    near_touch_m: float = 0.012


Seen = tuple[list["SlicePart"], int]
"""Slices that may be measured, and how many are left out since an arm or a hand lies there."""


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
    hollow_m : float
        Depth of the deepest hollow beside the flanks, under the hull: of a trunk that an arm or a
        hand touches there is one before and behind it.
    """

    height_m: float
    middle_x_m: float
    girth_m: float
    area_m2: float
    seen_share: float
    hollow_m: float


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


def volume_m3(parts: list[SlicePart], low_m: float, high_m: float, step_m: float) -> float:
    """Return the volume between two heights; areas of slices that lack are interpolated."""
    heights_m = np.arange(low_m, high_m, step_m) + step_m / 2
    areas_m2 = np.interp(
        heights_m, [part.height_m for part in parts], [part.area_m2 for part in parts]
    )
    return float(areas_m2.mean() * (high_m - low_m))


def steady_girths_m(parts: list[SlicePart]) -> FloatArray:
    """Return the girths from below, each the median of itself and its neighbours.

    A slice in which a finger was taken for the trunk has none that agree with it.
    """
    return np.asarray(median_filter([part.girth_m for part in parts], N_AGREEING, mode="nearest"))


def trunk_slices(
    surface: BodySurface, low_m: float, high_m: float, params: SliceParams | None = None
) -> Seen:
    """Return the largest part of each slice between two heights, where its outline was seen."""
    params = params or SliceParams()
    seen = []
    for height_m in np.arange(low_m, high_m, params.step_m):
        parts = slice_parts(surface, float(height_m), params)
        whole = [part for part in parts if part.seen_share >= params.least_share]
        if whole:
            seen.append(max(whole, key=lambda part: part.area_m2))
    return _free(seen, params)


def leg_slices(
    surface: BodySurface, low_m: float, high_m: float, params: SliceParams | None = None
) -> tuple[Seen, Seen]:
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
    return _free(left, params), _free(right, params)


def _free(parts: list[SlicePart], params: SliceParams) -> Seen:
    """Leave out slices that something touches, and those beside."""
    heights_m = np.array([part.height_m for part in parts])
    touched_m = heights_m[[part.hollow_m > params.deepest_m for part in parts]]
    near = np.abs(heights_m[:, None] - touched_m[None, :]).min(axis=1, initial=np.inf)
    free = near > params.near_touch_m
    return [part for part, is_free in zip(parts, free, strict=True) if is_free], int((~free).sum())


def _groups(flat_m: FloatArray, params: SliceParams) -> Iterator[FloatArray]:
    """Yield the points of each part: what hangs together in a picture from above."""
    parts = parts_from_above(flat_m, params.cell_m, N_GROWN)
    for number in range(int(parts.max()) + 1):
        yield flat_m[parts == number]


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
    middle = _centroid(flat_m[hull.vertices])
    way = flat_m - middle
    turn = np.arctan2(way[:, 1], way[:, 0]) / (2.0 * np.pi) % 1.0
    sectors = np.minimum((turn * N_SECTORS).astype(int), N_SECTORS - 1)
    counts = np.bincount(sectors, minlength=N_SECTORS)
    sums = np.bincount(sectors, np.hypot(*way.T), N_SECTORS)
    seen = np.flatnonzero(counts)
    radii_m = np.interp(np.arange(N_SECTORS), seen, sums[seen] / counts[seen], period=N_SECTORS)
    bridges_m = middle + (radii_m * _WAYS).T[counts == 0]
    wedge = 0.5 * float(np.sin(2.0 * np.pi / N_SECTORS))
    return SlicePart(
        height_m,
        float(middle[0]),
        float(ConvexHull(np.concatenate([flat_m, bridges_m])).area),
        wedge * float((radii_m * np.roll(radii_m, 1)).sum()),
        len(seen) / N_SECTORS,
        _hollow_m(hull, middle, turn, np.hypot(*way.T)),
    )


def _centroid(corners: FloatArray) -> FloatArray:
    """Return the centre of gravity of a convex polygon: that of its triangles from one corner.

    The mean of the corners would lie where most of them are.
    """
    one, other = corners[1:-1] - corners[0], corners[2:] - corners[0]
    areas = one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0]
    return np.asarray(corners[0] + areas @ (one + other) / (3.0 * areas.sum()))


def _hollow_m(hull: ConvexHull, middle: FloatArray, turn: FloatArray, radii_m: FloatArray) -> float:
    """Return how far the outline lies under the hull where flanks end: not before, behind, aside.

    Parameters
    ----------
    turn, radii_m : (N,) arrays
        Of each point from the middle; 0 and 0.5 lie aside.
    """
    sectors = np.minimum((turn * N_SECTORS).astype(int), N_SECTORS - 1)
    outer_m = np.full(N_SECTORS, -np.inf)
    np.maximum.at(outer_m, sectors, radii_m)
    outward = hull.equations[:, :2] @ _WAYS
    room_m = -(hull.equations[:, :2] @ middle + hull.equations[:, 2])
    with np.errstate(divide="ignore"):
        hull_m = np.where(outward > 0.0, room_m[:, None] / outward, np.inf).min(axis=0)
    aside = np.degrees(np.arcsin(np.abs(_WAYS[1])))
    low, high = FLANKS_DEG
    looked_at = (aside >= low) & (aside <= high) & np.isfinite(outer_m)
    return float((hull_m - outer_m)[looked_at].max(initial=0.0))
