"""How likely ways to name points are where people may stand still as those of the training."""

import math

import numpy as np

from adibas.arrays import FloatArray
from adibas.shapes.parts_types import Odds, Pool
from adibas.skeleton.parts import PartsModel
from adibas.skeleton.parts_odds import PartsOdds
from adibas.skeleton.stance import stance_log_densities
from adibas.skeleton.starts import turn_back

MOST_RATED, NEAR_NATS = 500, 20.0
"""Of so many ways, and so far above the best, it is asked whether somebody stands there."""


def rate_standing(
    model: PartsModel, points: FloatArray, pool: Pool, expected: Odds, odds: PartsOdds
) -> FloatArray:
    """Return by how much ways are less likely as people stand still `odds.stands` of the times.

    Negative: they are likelier.

    Parameters
    ----------
    points : (M, 3) array
        Centred, metres, y down.
    pool : Pool
        Ways to name them.
    expected : Odds
        With the heading that was declared, where `odds.stands` is not 0.

    Returns
    -------
    less : (P,) array
    """
    less = np.zeros(len(pool.energies))
    if model.stance is None or not odds.stands:
        return less
    less -= math.log1p(-odds.stands)
    order = np.argsort(pool.energies)[:MOST_RATED]
    near = order[pool.energies[order] < pool.energies[order[0]] + NEAR_NATS]
    partners = pool.partners[near]
    n_named = (partners >= 0).sum(axis=1)
    likely = math.log(odds.stands) + stance_log_densities(
        model.stance, points @ turn_back(-expected.heading_rad), partners, odds.room_m3,
        [odds.arm_elsewhere] * 2 + [odds.leg_elsewhere] * 2,
    )  # fmt: skip
    likely += n_named * expected.log_room - expected.counts[len(model.names) - n_named]
    less[near] -= np.logaddexp(0.0, likely + pool.energies[near] + less[near])
    return less
