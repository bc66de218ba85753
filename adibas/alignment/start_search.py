"""Where a source lies without any guess: three pairs of features at a time, the best of many.

Source: thesis, section 5.2.1; Fischler & Bolles (1981); Horn (1987) for three pairs.
"""

from dataclasses import dataclass

import numpy as np

from adibas.alignment.features import Features
from adibas.alignment.sights import Sight
from adibas.arrays import BoolArray, FloatArray, IntArray
from adibas.geometry.rigid import RigidTransform, fit_rigid

N_DRAWN = 3
N_REFINEMENTS = 3


@dataclass(frozen=True, slots=True)
class StartParams:
    """How a start is searched for.

    Attributes
    ----------
    n_tries : int
        Triples of pairs: 1,000 finds one good triple at 15 % good pairs with 97 %.
    reach_px : float
        A moved point must be seen so near to its partner: 4.
    reach_share : float
        And at the partner's distance from the camera, within this share of it: 0.03.
    fewest : int
        Pairs that must agree: 8.
    least_side_m : float
        Triples whose points are nearer together fix no rotation: 0.1.
    seed : int
        Of the draw: 0.
    """

    n_tries: int = 1000
    reach_px: float = 4.0
    reach_share: float = 0.03
    fewest: int = 8
    least_side_m: float = 0.1
    seed: int = 0


@dataclass(frozen=True, slots=True, eq=False)
class Start:
    """A start, and the pairs that agree with it.

    Attributes
    ----------
    target_from_source : RigidTransform
    agree : (N,) bool array
        Of the pairs given.
    """

    target_from_source: RigidTransform
    agree: BoolArray


def search_start(
    target: Sight,
    goal_features: Features,
    own_features: Features,
    pairs: tuple[IntArray, IntArray],
    params: StartParams | None = None,
) -> Start | None:
    """Find the motion with which most pairs agree; None where too few do.

    Parameters
    ----------
    pairs : two (N,) arrays
        Indices into the target's and the source's features, from `pair_features`.
    """
    params = params or StartParams()
    goals_m, own_m = goal_features.points_m[pairs[0]], own_features.points_m[pairs[1]]
    pixels = goal_features.pixels[pairs[0]]
    if len(goals_m) < params.fewest:
        return None
    triples = _triples(goals_m, own_m, params)
    if not len(triples):
        return None
    rotations, shifts = fit_triples(goals_m[triples], own_m[triples])
    moved = np.einsum("tij,nj->tni", rotations, own_m) + shifts[:, None]
    agree = _agree(target, moved, goals_m, pixels, params)
    best = agree[int(agree.sum(axis=1).argmax())]
    start = None
    for _ in range(N_REFINEMENTS):
        motion = _refined(goals_m[best], own_m[best], params.fewest)
        if motion is None:
            return None
        best = _agree(target, motion.apply(own_m)[None], goals_m, pixels, params)[0]
        start = Start(motion, best)
    return start if best.sum() >= params.fewest else None


def fit_triples(to_m: FloatArray, from_m: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return (T, 3, 3) rotations and (T, 3) shifts that bring (T, N, 3) points to others best."""
    mean_to, mean_from = to_m.mean(axis=1), from_m.mean(axis=1)
    spread = np.einsum("tni,tnj->tij", to_m - mean_to[:, None], from_m - mean_from[:, None])
    left, _, right = np.linalg.svd(spread)
    left[:, :, 2] *= np.sign(np.linalg.det(left) * np.linalg.det(right))[:, None]
    rotations = left @ right
    shifts: FloatArray = mean_to - np.einsum("tij,tj->ti", rotations, mean_from)
    return rotations, shifts


def _triples(goals_m: FloatArray, own_m: FloatArray, params: StartParams) -> IntArray:
    """Draw triples of pairs whose triangles are alike in both moments, and not tiny."""
    rng = np.random.default_rng(params.seed)
    drawn = np.argsort(rng.random((params.n_tries, len(goals_m))), axis=1)[:, :N_DRAWN]
    triangles = (goals_m[drawn], own_m[drawn])
    sides = [np.linalg.norm(one - np.roll(one, 1, axis=1), axis=2) for one in triangles]
    far_m = np.maximum(goals_m[drawn][..., 2].max(axis=1), own_m[drawn][..., 2].max(axis=1))
    is_alike = (np.abs(sides[0] - sides[1]) < 2 * params.reach_share * far_m[:, None]).all(axis=1)
    is_wide = np.minimum(*sides).min(axis=1) > params.least_side_m
    kept: IntArray = drawn[is_alike & is_wide]
    return kept


def _agree(
    target: Sight, moved_m: FloatArray, goals_m: FloatArray, pixels: FloatArray, params: StartParams
) -> BoolArray:
    """Say of (T, N) moved points whether they are seen where their partners are."""
    n = moved_m.shape[1]
    seen = target.pixels_of(moved_m.reshape(-1, 3)).reshape(-1, n, 2)
    with np.errstate(invalid="ignore"):
        is_near = np.linalg.norm(seen - pixels, axis=2) < params.reach_px
        deep = np.abs(moved_m[..., 2] - goals_m[:, 2]) < params.reach_share * goals_m[:, 2]
    agree: BoolArray = is_near & deep
    return agree


def _refined(goals_m: FloatArray, own_m: FloatArray, fewest: int) -> RigidTransform | None:
    """Fit all that agree; far points count less, as they are known less."""
    if len(goals_m) < fewest:
        return None
    try:
        return fit_rigid(goals_m, own_m, 1.0 / goals_m[:, 2] ** 4)
    except ValueError:  # on one line
        return None
