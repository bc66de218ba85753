"""A judge of names that knows the simulator: how much places and sizes of points can tell at all.

It knows how people of one kind of posture lie (a mixture of normal distributions over all 45
coordinates, learned from thousands of them), how large markers are, and in which room spurious
points lie. It need not search: the right names are told among all those that are one or two changes
away, and it has to say which are the likeliest. No namer that has to know all kinds of people, and
to search, is expected to do better.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations, permutations

import numpy as np

from adibas.arrays import FloatArray, IntArray
from adibas.data.joints import JOINT_NAMES
from adibas.pipeline.skeleton_simulator import simulate_shapes
from adibas.shapes.gaussian_mixture import Mixture, fit_mixture
from adibas.skeleton.parts_odds import PartsOdds
from adibas.skeleton.stance import place_log_densities
from adibas.skeleton.starts import HEADINGS_RAD, turn_back
from benchmarks.labelling_sets import (
    DIAMETER_LOG_SD,
    DIAMETER_M,
    SPURIOUS_DIAMETERS_M,
    VIEW_OFF_RAD,
    MarkerSet,
)

N_JOINTS = len(JOINT_NAMES)
NO_POINT = -1
SHIFT_M = 0.5
"""By which a shape's middle may be beside that of the points that are seen."""
FLOOR_M = 0.005
COMPLETE = PartsOdds().complete
"""How often nothing is hidden, or spurious; of the rest, one more halves it."""


@dataclass(frozen=True, slots=True, eq=False)
class Ways:
    """W ways to name M points, the right one first.

    Attributes
    ----------
    points : (W, 15) int array
        Of each joint its point, `NO_POINT` for none.
    log_odds : (W,) array
        Of the places and of how many are hidden and spurious, whatever the sizes.
    log_sizes : (W,) array
        Of the sizes, to be added.
    """

    points: IntArray
    log_odds: FloatArray
    log_sizes: FloatArray

    @property
    def is_as_many(self) -> FloatArray:
        """Return (W,) 0 for as many hidden points as there are, minus infinity for others."""
        n_named = (self.points != NO_POINT).sum(axis=1)
        return np.where(n_named == n_named[0], 0.0, -np.inf)


class Judge:
    """Rates ways to name the points of people of one kind of posture.

    Parameters
    ----------
    kind : str
        Of `KIND_SHARES`.
    n_people, n_poses, n_components, seed : int
        What it learns from, and how finely.
    """

    def __init__(
        self, kind: str, n_people: int, n_poses: int, n_components: int, seed: int
    ) -> None:
        people = simulate_shapes(n_people, n_poses, seed, lambda _done, _all: None, {kind: 1.0})
        rng = np.random.default_rng(seed)
        turns_rad = rng.uniform(-VIEW_OFF_RAD, VIEW_OFF_RAD, len(people.shapes_m))
        turned = np.stack([
            one @ turn_back(turn_rad)
            for one, turn_rad in zip(people.shapes_m, turns_rad, strict=True)
        ])  # fmt: skip
        rows = (turned - turned.mean(axis=1, keepdims=True)).reshape(len(turned), -1)
        mixture = fit_mixture(rows, n_components, np.full(rows.shape[1], FLOOR_M**2), rng)
        shifts = np.tile(np.eye(3), N_JOINTS) * SHIFT_M
        covariances = mixture.covariances + shifts.T @ shifts
        self._mixture = Mixture(mixture.weights, mixture.means, covariances)

    def weigh(self, one: MarkerSet) -> Ways:
        """Rate the right way to name the points, and those near to it."""
        points_m = one.points_m @ turn_back(-HEADINGS_RAD[one.view])
        points_m = points_m - points_m.mean(axis=0)
        ways = ways_near(_right(one), len(points_m))
        n_named = (ways != NO_POINT).sum(axis=1)
        n_spurious = len(points_m) - n_named
        log_priors = [
            _log_prior(n_hidden, n)
            for n_hidden, n in zip((N_JOINTS - n_named).tolist(), n_spurious.tolist(), strict=True)
        ]
        log_odds = place_log_densities(self._mixture, points_m, ways) + log_priors
        log_odds -= n_spurious * math.log(one.room_m3)
        of_sizes = np.append(_log_size_odds(one.sizes_m), 0.0)
        return Ways(ways, log_odds, of_sizes[ways].sum(axis=1))


def probabilities(log_odds: FloatArray) -> FloatArray:
    """Return what the ways are worth, in shares of 1."""
    shares = np.exp(log_odds - log_odds.max())
    return np.asarray(shares / shares.sum())


def ways_near(right: IntArray, n_points: int) -> IntArray:
    """Return the (W, 15) ways at one or two changes from the right one, which is the first.

    A joint loses its point or takes a spurious one, two do, or one takes the point of another that
    gets a spurious one or none; two or three joints exchange their points.
    """
    spurious = np.setdiff1d(np.arange(n_points), right)
    ways = {*_taking(right, spurious), *_exchanging(right)}
    return np.array([right.tolist(), *sorted(ways)])


def _taking(right: IntArray, spurious: IntArray) -> Iterator[tuple[int, ...]]:
    """Give the ways in which joints get other points, or none."""
    free = [int(point) for point in spurious]
    named = [int(joint) for joint in np.flatnonzero(right != NO_POINT)]
    changes = [{joint: point} for joint in range(N_JOINTS) for point in free]
    changes += [{joint: NO_POINT} for joint in named]
    changes += [
        {first: one, second: other}
        for first, second in combinations(range(N_JOINTS), 2)
        for one, other in permutations(free, 2)
    ]
    changes += [
        {hidden: int(right[joint]), joint: point}
        for hidden in np.flatnonzero(right == NO_POINT).tolist()
        for joint in named
        for point in (*free, NO_POINT)
    ]
    for change in changes:
        yield tuple(change.get(joint, int(right[joint])) for joint in range(N_JOINTS))


def _exchanging(right: IntArray) -> Iterator[tuple[int, ...]]:
    """Give the ways in which two or three joints have each other's points."""
    named = [int(joint) for joint in np.flatnonzero(right != NO_POINT)]
    for n_joints, turns in ((2, ((1, 0),)), (3, ((1, 2, 0), (2, 0, 1)))):
        for joints in combinations(named, n_joints):
            for turn in turns:
                way = right.copy()
                way[list(joints)] = right[[joints[i] for i in turn]]
                yield tuple(way.tolist())


def _right(one: MarkerSet) -> IntArray:
    points = {name: point for point, name in enumerate(one.truth) if name is not None}
    return np.array([points.get(name, NO_POINT) for name in JOINT_NAMES])


def _log_prior(n_hidden: int, n_spurious: int) -> float:
    """Return the log probability of one choice of hidden joints and of spurious points."""
    return (
        _log_count(n_hidden)
        - math.log(math.comb(N_JOINTS, n_hidden))
        + _log_count(n_spurious)
        + math.lgamma(n_spurious + 1)
    )


def _log_count(n: int) -> float:
    return math.log(COMPLETE if n == 0 else (1.0 - COMPLETE) * 0.5**n)


def _log_size_odds(sizes_m: FloatArray) -> FloatArray:
    """Return the (M,) log odds that points of such sizes are markers, whose size is known."""
    off = np.log(sizes_m / DIAMETER_M) / DIAMETER_LOG_SD
    least_m, greatest_m = SPURIOUS_DIAMETERS_M
    log_spread = math.log(DIAMETER_LOG_SD * math.sqrt(2 * math.pi))
    return np.asarray(math.log(math.log(greatest_m / least_m)) - log_spread - 0.5 * off**2)
