"""Where the fit of a limb begins, and how much surface speaks for what it found."""

import math

import numpy as np

from adibas.arrays import BoolArray, FloatArray, IntArray
from adibas.kernels import compiled

N_MIDDLES, MIDDLE_BAND, END_BAND = 4, 0.15, 0.3
"""Elbows or knees that are tried as starts, and how well lengths must fit for that."""
FARTHEST_SHARE = 0.05
"""Of the points, that the end of a stretched limb is the middle of."""
_LEAST_M = 1e-6


@compiled
def limb_points(
    places_m: FloatArray, weights: FloatArray, total: FloatArray, mean: float, radius_m: float
) -> tuple[FloatArray, FloatArray]:
    """Return the points of a limb, and for which of its two bones each speaks.

    Parameters
    ----------
    places_m : (N, 3) array
        On the surface; the bones lie `radius_m` behind it.
    weights : (N, 3) array
        Of the limb's three parts.
    total : (N,) array
        Of all three.
    mean : float
        Of `total`.

    Returns
    -------
    points : (N, 4) array
        x, y, z (metres), and the weight in that of a mean point.
    shares : (N, 2) array
        Of the upper part, and of both others.
    """
    points, shares = np.empty((total.size, 4)), np.empty((total.size, 2))
    for i in range(total.size):
        x, y, z = places_m[i, 0], places_m[i, 1], places_m[i, 2]
        stretch = 1.0 + radius_m / math.sqrt(x * x + y * y + z * z)
        points[i, 0], points[i, 1], points[i, 2] = x * stretch, y * stretch, z * stretch
        points[i, 3] = total[i] / mean
        shares[i, 0] = weights[i, 0] / total[i]
        shares[i, 1] = weights[i, 1] / total[i] + weights[i, 2] / total[i]
    return points, shares


@compiled
def limb_starts(
    points: FloatArray, joints_m: FloatArray, latest_m: FloatArray, lengths_m: FloatArray
) -> FloatArray:
    """Return (S, 3, 3) starts: stretched to the farthest points, as chosen, a moment ago, bent.

    Parameters
    ----------
    points : (N, 3 or more) array
        Within the limb, metres; N > 0.
    joints_m, latest_m : (3, 3) arrays
        From the root on, which is known; NaN where not seen.
    lengths_m : (2,) array
        Of the bones.
    """
    starts_m = np.empty((3 + N_MIDDLES, 3, 3))
    far_m = _gaps_m(points, joints_m[0])
    way = _way_to_farthest(points, far_m, joints_m[0])
    n_starts = 1
    starts_m[0, 0] = joints_m[0]
    starts_m[0, 1] = joints_m[0] + lengths_m[0] * way
    starts_m[0, 2] = joints_m[0] + (lengths_m[0] + lengths_m[1]) * way
    for known_m in (joints_m, latest_m):
        if np.isfinite(known_m[1, 0]) or np.isfinite(known_m[2, 0]):
            for joint in range(3):
                is_known = np.isfinite(known_m[joint, 0])
                starts_m[n_starts, joint] = known_m[joint] if is_known else starts_m[0, joint]
            n_starts += 1
    is_middle = np.abs(far_m - lengths_m[0]) < MIDDLE_BAND * lengths_m[0]
    for middle in _spread_out(points, is_middle):
        end = _end_beside(points, joints_m[0], points[middle, :3], lengths_m[1])
        if end >= 0:
            starts_m[n_starts, 0] = joints_m[0]
            starts_m[n_starts, 1] = points[middle, :3]
            starts_m[n_starts, 2] = points[end, :3]
            n_starts += 1
    return starts_m[:n_starts].copy()


@compiled
def _gaps_m(points: FloatArray, place_m: FloatArray) -> FloatArray:
    """Return (N,) distances of points from a place."""
    gaps_m = np.empty(points.shape[0])
    for i in range(gaps_m.size):
        x, y, z = points[i, 0] - place_m[0], points[i, 1] - place_m[1], points[i, 2] - place_m[2]
        gaps_m[i] = math.sqrt(x * x + y * y + z * z)
    return gaps_m


@compiled
def _way_to_farthest(points: FloatArray, far_m: FloatArray, root_m: FloatArray) -> FloatArray:
    """Return (3,) the direction from the root to the middle of the points farthest from it."""
    rank = math.ceil((1.0 - FARTHEST_SHARE) * (far_m.size - 1))
    least_m = np.sort(far_m)[rank]
    end_m, n_far = np.zeros(3), 0
    for i in range(far_m.size):
        if far_m[i] >= least_m:
            end_m += points[i, :3]
            n_far += 1
    away_m = end_m / n_far - root_m
    length_m = math.sqrt(away_m[0] ** 2 + away_m[1] ** 2 + away_m[2] ** 2)
    return away_m / max(length_m, _LEAST_M)


@compiled
def _spread_out(points: FloatArray, is_middle: BoolArray) -> IntArray:
    """Return up to `N_MIDDLES` of the middles, each as far as can be from those before."""
    chosen, n_chosen = np.empty(N_MIDDLES, np.int64), 0
    gap_m = np.where(is_middle, np.inf, -1.0)
    latest = gap_m.argmax()
    while n_chosen < N_MIDDLES and gap_m[latest] >= 0.0:
        chosen[n_chosen] = latest
        n_chosen += 1
        gap_m = np.minimum(gap_m, _gaps_m(points, points[latest]))
        gap_m[latest] = -1.0
        latest = gap_m.argmax()
    return chosen[:n_chosen]


@compiled
def _end_beside(
    points: FloatArray, root_m: FloatArray, middle_m: FloatArray, length_m: float
) -> int:
    """Return the point a bone away from the middle that is farthest from the upper bone's; -1."""
    from_middle_m = _gaps_m(points, middle_m)
    from_upper_m = _gaps_m(points, 0.5 * (root_m + middle_m))
    best = -1
    for i in range(from_middle_m.size):
        is_end = abs(from_middle_m[i] - length_m) < END_BAND * length_m
        if is_end and (best < 0 or from_upper_m[i] > from_upper_m[best]):
            best = i
    return best


@compiled
def limb_support(
    points: FloatArray, shares: FloatArray, joints_m: FloatArray, reach_m: float, apart_m: float
) -> FloatArray:
    """Return (3,) weights of points: near the middle joint, near the end, and the end's own.

    Its own are near the lower bone and, by place (`apart_m` from the upper one) or by their part,
    not the upper one's.

    Parameters
    ----------
    points : (N, 4) array
        x, y, z (metres) and weight.
    shares : (N, 2) array
        How much of the weight speaks for the upper and for the lower bone.
    joints_m : (3, 3) array
    """
    found = np.zeros(3)
    gaps_m = (_gaps_m(points, joints_m[1]), _gaps_m(points, joints_m[2]))
    for i in range(points.shape[0]):
        for joint in range(2):
            if gaps_m[joint][i] < reach_m:
                found[joint] += points[i, 3]
        if _from_bone_m(points, i, joints_m, 1) < reach_m:
            is_apart = _from_bone_m(points, i, joints_m, 0) > apart_m
            if is_apart or shares[i, 1] > shares[i, 0]:
                found[2] += points[i, 3]
    return found


@compiled
def _from_bone_m(points: FloatArray, i: int, joints_m: FloatArray, bone: int) -> float:
    """Return how far a point is from the bone that begins at joint `bone`."""
    squared, along = 0.0, 0.0
    for axis in range(3):
        step = joints_m[bone + 1, axis] - joints_m[bone, axis]
        squared += step * step
        along += (points[i, axis] - joints_m[bone, axis]) * step
    share = min(max(along / max(squared, 1e-9), 0.0), 1.0)
    gap = 0.0
    for axis in range(3):
        step = joints_m[bone + 1, axis] - joints_m[bone, axis]
        gap += (points[i, axis] - joints_m[bone, axis] - share * step) ** 2
    return math.sqrt(gap)
