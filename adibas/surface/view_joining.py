"""Four standing views of one body as one: where each view lies with respect to the first.

Neighbouring views share what both see at a slant. Each point takes the nearest of its neighbour's
with a like normal; the distances along the mean of both normals are made small for all views at
once, with robust weights, so that arms that moved count little.

Source: Chen & Medioni, Object modelling by registration of multiple range images, 1992, for the
distance to the plane; Rusinkiewicz, A symmetric objective function for ICP, 2019, for the mean
normal; Pulli, Multiview registration for large data sets, 1999, for solving all views together.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from scipy.spatial import cKDTree

from adibas.arrays import FloatArray, IntArray, check_shape, read_only
from adibas.geometry.rigid import RigidTransform, rotation_from_vector

N_UNKNOWNS = 6
TUKEY_SDS = 4.685
"""95 % efficiency for normal errors (Huber 1981)."""


@dataclass(frozen=True, slots=True)
class JoinParams:
    """Settings.

    Attributes
    ----------
    gates_m : tuple of float
        Pairs that are farther apart count nothing, in each round of steps: from 60 mm, what the
        guess may be off, to 15 mm.
    steps : int
        In each round: 10.
    least_alike : float
        Cosine between the normals of a pair: 0.8, 37 degrees.
    least_pairs : int
        Of two views, for these to hold each other: 150.
    tilt_sd_rad, lift_sd_m : float
        Expected change of the body's lean and of its height over the floor between views: 1
        degree and 5 mm, the sway of the benchmark.
    noise_m : float
        Least standard deviation of a distance: 1 mm.
    alike_px : float
        Points whose errors are as good as one: 16, the sensor's window of 63 pixels at one point
        for every four.
    most_points : int
        Of a view that look for partners: 6,000.
    """

    gates_m: tuple[float, ...] = (0.06, 0.03, 0.015)
    steps: int = 10
    least_alike: float = 0.8
    least_pairs: int = 150
    tilt_sd_rad: float = 0.0175
    lift_sd_m: float = 0.005
    noise_m: float = 0.001
    alike_px: float = 16.0
    most_points: int = 6000


@dataclass(frozen=True, slots=True, eq=False)
class OrientedPoints:
    """(N, 3) points in metres and their outward (N, 3) unit normals, patient axes as guessed."""

    points_m: FloatArray
    normals: FloatArray

    def __post_init__(self) -> None:
        check_shape("points_m", self.points_m, (None, 3))
        check_shape("normals", self.normals, self.points_m.shape)
        read_only(self.points_m)
        read_only(self.normals)

    def moved(self, motion: RigidTransform) -> "OrientedPoints":
        """Return them after a motion."""
        return OrientedPoints(motion.apply(self.points_m), self.normals @ motion.rotation.T)


@dataclass(frozen=True, slots=True, eq=False)
class JoinedViews:
    """How the views lie.

    Attributes
    ----------
    motions : tuple of RigidTransform
        After the guess; the first is none.
    covariance : (6 (V - 1), 6 (V - 1)) array
        Of a small turn (radians) and shift (metres) of each further view.
    rms_m : float
        Of the distances of pairs that count.
    n_pairs : int
        In the last step.
    """

    motions: tuple[RigidTransform, ...]
    covariance: FloatArray
    rms_m: float
    n_pairs: int

    def __post_init__(self) -> None:
        read_only(self.covariance)


@dataclass(frozen=True, slots=True, eq=False)
class _Pairs:
    """Partners of two views: indices of the views, then arrays over the pairs."""

    source: int
    target: int
    middle_m: FloatArray
    normals: FloatArray
    off_m: FloatArray


def join_views(
    views: Sequence[OrientedPoints], params: JoinParams | None = None
) -> JoinedViews | None:
    """Join views that are guessed to lie in the same axes; None where some hold no other.

    Raises
    ------
    ValueError
        There are fewer than two.
    """
    params = params or JoinParams()
    if len(views) <= 1:
        raise ValueError("to join takes two views")
    motions = [RigidTransform(np.eye(3), np.zeros(3)) for _ in views]
    rms_m, n_pairs, matrix = 0.0, 0, np.eye(N_UNKNOWNS)
    for gate_m in params.gates_m:
        for _ in range(params.steps):
            moved = [view.moved(motion) for view, motion in zip(views, motions, strict=True)]
            trees = [cKDTree(view.points_m) for view in moved]
            found = [
                pairs
                for first, second in combinations(range(len(views)), 2)
                for source, target in ((first, second), (second, first))
                if (pairs := _partners(moved, trees, (source, target), gate_m, params)) is not None
            ]
            if not _holds_all(found, len(views)):
                return None
            matrix, right, rms_m = _equations(found, motions, params)
            step: FloatArray = np.asarray(np.linalg.solve(matrix, right), float)
            for number in range(1, len(views)):
                twist = step[N_UNKNOWNS * (number - 1) : N_UNKNOWNS * number]
                motions[number] = _twisted(twist) @ motions[number]
            n_pairs = sum(len(pairs.off_m) for pairs in found)
            if np.abs(step).max() < 1e-5:  # noqa: PLR2004  (10 micrometres)
                break
    return JoinedViews(tuple(motions), np.asarray(np.linalg.inv(matrix), float), rms_m, n_pairs)


def _twisted(twist: FloatArray) -> RigidTransform:
    return RigidTransform(rotation_from_vector(twist[:3]), twist[3:])


def _partners(
    views: Sequence[OrientedPoints],
    trees: Sequence[cKDTree],
    which: tuple[int, int],
    gate_m: float,
    params: JoinParams,
) -> _Pairs | None:
    """Return the pairs of two views; None where there are too few."""
    source, target = views[which[0]], views[which[1]]
    every = max(len(source.points_m) // params.most_points, 1)
    points_m, normals = source.points_m[::every], source.normals[::every]
    asked = trees[which[1]].query(points_m, distance_upper_bound=gate_m)
    apart_m, nearest = np.asarray(asked[0]), np.asarray(asked[1], np.int64)
    met = np.flatnonzero(np.isfinite(apart_m))
    partner: IntArray = nearest[met]
    alike = (normals[met] * target.normals[partner]).sum(axis=1) >= params.least_alike
    met, partner = met[alike], partner[alike]
    if len(met) < params.least_pairs:
        return None
    mean = normals[met] + target.normals[partner]
    mean /= np.linalg.norm(mean, axis=1, keepdims=True)
    way_m = points_m[met] - target.points_m[partner]
    return _Pairs(
        *which,
        0.5 * (points_m[met] + target.points_m[partner]),
        mean,
        (way_m * mean).sum(axis=1),
    )


def _holds_all(found: Sequence[_Pairs], n_views: int) -> bool:
    """Say whether every view hangs together with the first."""
    held = {0}
    for _ in range(n_views):
        held |= {
            number
            for pairs in found
            if {pairs.source, pairs.target} & held
            for number in (pairs.source, pairs.target)
        }
    return len(held) == n_views


def _equations(
    found: Sequence[_Pairs], motions: Sequence[RigidTransform], params: JoinParams
) -> tuple[FloatArray, FloatArray, float]:
    """Return matrix and right side for the twists of all views but the first, and the rms."""
    everything = np.concatenate([pairs.off_m for pairs in found])
    sd_m = max(1.4826 * float(np.median(np.abs(everything))), params.noise_m)
    n = N_UNKNOWNS * len(motions)
    matrix, right = np.zeros((n, n)), np.zeros(n)
    squares = total = 0.0
    for pairs in found:
        share = np.minimum(np.abs(pairs.off_m) / (TUKEY_SDS * sd_m), 1.0)
        weights = (1.0 - share**2) ** 2 / (sd_m**2 * params.alike_px)
        slope = np.hstack([np.cross(pairs.middle_m, pairs.normals), pairs.normals])
        gram = (slope * weights[:, None]).T @ slope
        pull = slope.T @ (weights * pairs.off_m)
        own, other = (
            slice(N_UNKNOWNS * number, N_UNKNOWNS * (number + 1))
            for number in (pairs.source, pairs.target)
        )
        matrix[own, own] += gram
        matrix[other, other] += gram
        matrix[own, other] -= gram
        matrix[other, own] -= gram
        right[own] -= pull
        right[other] += pull
        squares += float((weights * pairs.off_m**2).sum())
        total += float(weights.sum())
    _add_floor(matrix, right, motions, params)
    first = N_UNKNOWNS
    return matrix[first:, first:], right[first:], float(np.sqrt(squares / max(total, 1e-12)))


def _add_floor(
    matrix: FloatArray, right: FloatArray, motions: Sequence[RigidTransform], params: JoinParams
) -> None:
    """Hold the views to the floor: up is y, turns about x and z and shifts along y are small."""
    for number, motion in enumerate(motions):
        begin = N_UNKNOWNS * number
        turned_up = motion.rotation[:, 1]
        # A small turn after the motion changes where up points: x by -rz, z by rx.
        for at, off, sd in (
            (begin, turned_up[2], params.tilt_sd_rad),
            (begin + 2, -turned_up[0], params.tilt_sd_rad),
            (begin + 4, motion.translation_m[1], params.lift_sd_m),
        ):
            matrix[at, at] += 1.0 / sd**2
            right[at] -= off / sd**2
        matrix[begin + 1, begin + 1] += 1e-6
        for axis in (3, 5):
            matrix[begin + axis, begin + axis] += 1e-6
