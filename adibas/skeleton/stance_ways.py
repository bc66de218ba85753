"""Ways to name points by nothing but how all joints of people who stand lie together.

Core and limbs go astray where chance points make a better trunk than the patient's own.
"""

import numpy as np
from scipy.optimize import linear_sum_assignment

from adibas.arrays import FloatArray, IntArray
from adibas.shapes.gaussian_mixture import normal_log_densities
from adibas.skeleton.stance import Stance

ROUNDS = 4
"""Of names by places, and of the place of the body by names."""
FIRST_OFF_M, THEN_OFF_M = 0.1, 0.03
"""How well the place of the body is known before the first round, and before the others."""
FEWEST = 4
"""With fewer names it is not known where the body is."""
NEVER = 1e6


def ways_of_stance(stance: Stance, places_m: FloatArray, log_room: float, lone: float) -> IntArray:
    """Return the (V, N) most probable ways of single components, each joint for itself.

    Names are assigned to points at the least cost, and the body moved to the middle (median) of
    where its named points lie from their means, in turns, as in the fit of an active shape model
    (thesis, section 6.1.2, equations 6.12 to 6.15).

    Parameters
    ----------
    places_m : (M, 3) array
        In the axes of the stance.
    log_room : float
        Of the volume, in cubic metres, where a chance point may be.
    lone : float
        Nats that a name without a point costs.
    """
    n_names = stance.means.shape[1] // 3
    means_m = stance.means.reshape(-1, n_names, 3)
    spreads_m2 = _about_the_body(stance.covariances, n_names)
    ways = [
        _assigned(mean_m, spread_m2, places_m, log_room, lone)
        for mean_m, spread_m2 in zip(means_m, spreads_m2, strict=True)
    ]
    return np.unique(ways, axis=0)


def _about_the_body(covariances: FloatArray, n_names: int) -> FloatArray:
    """Return the (K, N, 3, 3) covariances of each joint about the middle of all."""
    blocks = covariances.reshape(-1, n_names, 3, n_names, 3)
    to_all = blocks.mean(axis=3)
    own = np.moveaxis(np.diagonal(blocks, axis1=1, axis2=3), -1, 1)
    shared = to_all + np.swapaxes(to_all, 2, 3)
    return np.asarray(own - shared + to_all.mean(axis=1, keepdims=True))


def _assigned(
    mean_m: FloatArray, spread_m2: FloatArray, places_m: FloatArray, log_room: float, lone: float
) -> IntArray:
    way = np.full(len(mean_m), -1)
    at_m, off_m = np.median(places_m, axis=0) - np.median(mean_m, axis=0), FIRST_OFF_M
    for _ in range(ROUNDS):
        spreads_m2 = spread_m2 + off_m**2 * np.eye(3)
        costs = -normal_log_densities(places_m, mean_m + at_m, spreads_m2).T - log_room
        without = np.where(np.eye(len(mean_m)) > 0, lone, NEVER)
        _, taken = linear_sum_assignment(np.concatenate([costs, without], axis=1))
        way = np.where(taken < len(places_m), taken, -1)
        has_point = way >= 0
        if np.count_nonzero(has_point) < FEWEST:
            break
        at_m = np.median(places_m[way[has_point]] - mean_m[has_point], axis=0)
        off_m = THEN_OFF_M
    return np.asarray(way)
