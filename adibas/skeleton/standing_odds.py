"""How likely ways to name points are where people may stand still as those of the training.

Core and limbs do not list every way: what they find unlikely, how all joints of people who stand
lie together may find likely (a hip ten centimetres from where two shoulders let expect it). So
ways by nothing but how people stand are asked about as well, and those that are a change away from
the likeliest one.
"""

import math
from dataclasses import dataclass

import numpy as np

from adibas.arrays import FloatArray, IntArray
from adibas.shapes.parts_types import Odds, Pool
from adibas.skeleton.changed_ways import not_listed, one_change_away
from adibas.skeleton.given_names import agrees, has_names
from adibas.skeleton.known import Known
from adibas.skeleton.parts import PartsModel
from adibas.skeleton.parts_odds import PartsOdds
from adibas.skeleton.stance import (
    Stance,
    components_of,
    place_log_densities,
    stance_log_densities,
)
from adibas.skeleton.stance_ways import ways_of_stance
from adibas.skeleton.starts import turn_back

MOST_RATED, NEAR_NATS = 500, 20.0
"""Of so many ways, and so far above the best, it is asked whether somebody stands there."""
MOST_ROUNDS = 3
"""The likeliest way is changed so often, as long as a changed one is likelier still."""


@dataclass(frozen=True, slots=True, eq=False)
class Rated:
    """Ways to name points.

    Attributes
    ----------
    pool : Pool
        With the energies that they have where nobody is known to stand.
    less : (P,) array
        By how much they are less likely as people stand still at times; negative: likelier.
    """

    pool: Pool
    less: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class _Case:
    """Points that somebody who stands may have; places in the axes of the stance."""

    stance: Stance
    places_m: FloatArray
    known: Known
    expected: Odds
    odds: PartsOdds


def rate_standing(
    model: PartsModel,
    points: FloatArray,
    known: Known,
    pool: Pool,
    expected: Odds,
    odds: PartsOdds,
) -> Rated:
    """Rate listed ways, and others, by how people stand still; `odds.stands` of them do.

    The others have the energy of who stands there, or that of the best way that is listed,
    whichever is higher: what they are where nobody stands was not asked, and is not better.

    Parameters
    ----------
    points : (M, 3) array
        Centred.
    pool : Pool
        Ways to name them, with their energies.
    expected : Odds
        Of the view that is declared.
    """
    if model.stance is None or not odds.stands:
        return Rated(pool, np.zeros(len(pool.energies)))
    places_m = points @ turn_back(-expected.heading_rad)
    case = _Case(model.stance, places_m, known, expected, odds)
    by_stance = ways_of_stance(case.stance, places_m, expected.log_room, expected.lone)
    rated = _with_ways(case, _rate_listed(case, pool), by_stance, expected.heading_rad)
    totals = _totals(case, rated)
    for _ in range(MOST_ROUNDS):
        best = int(np.argmin(totals))
        lowest = totals[best]
        changed = _promising(case, rated.pool.partners[best])
        rated = _with_ways(case, rated, changed, float(rated.pool.headings[best]))
        totals = _totals(case, rated)
        if totals.min() >= lowest:
            break
    return rated


def _rate_listed(case: _Case, pool: Pool) -> Rated:
    order = np.argsort(pool.energies)[:MOST_RATED]
    near = order[pool.energies[order] < pool.energies[order[0]] + NEAR_NATS]
    less = np.full(len(pool.energies), -math.log1p(-case.odds.stands))
    standing = _standing_energies(case, pool.partners[near])
    less[near] = _less_likely(case.odds, pool.energies[near], standing)
    return Rated(pool, less)


def _with_ways(case: _Case, rated: Rated, ways: IntArray, heading_rad: float) -> Rated:
    """Return the (V, N) ways as well that are not there, of patients with that heading."""
    pool = rated.pool
    if has_names(case.known.given):
        ways = ways[agrees(ways, case.known.given)]
    ways = not_listed(ways, pool.partners)
    standing = _standing_energies(case, ways)
    may_be = np.isfinite(standing)
    if not may_be.any():
        return rated
    ways, standing = ways[may_be], standing[may_be]
    energies = np.maximum(standing, pool.energies.min())
    more = Pool(
        np.append(pool.energies, energies),
        np.append(pool.headings, np.full(len(ways), heading_rad)),
        np.concatenate([pool.partners, ways]),
        pool.n_filled,
    )
    return Rated(more, np.append(rated.less, _less_likely(case.odds, energies, standing)))


def _standing_energies(case: _Case, partners: IntArray) -> FloatArray:
    """Return the (W,) energies of ways to name points, if somebody stands there."""
    odds = case.odds
    likely = stance_log_densities(
        case.stance, case.places_m, partners, odds.room_m3,
        [odds.arm_elsewhere] * 2 + [odds.leg_elsewhere] * 2,
    )  # fmt: skip
    return _of_counts(case, partners) - likely


def _of_counts(case: _Case, partners: IntArray) -> FloatArray:
    """Return the (W,) energies of so many hidden names and chance points, and by the body."""
    n_hidden = (partners < 0).sum(axis=1)
    n_named = partners.shape[1] - n_hidden
    of_counts = case.expected.counts[n_hidden] - n_named * case.expected.log_room
    return np.asarray(of_counts - case.known.body_odds_of(partners))


def _less_likely(odds: PartsOdds, energies: FloatArray, standing: FloatArray) -> FloatArray:
    """Return by how much both, who stands and who does not, are less likely than who does not."""
    others, stands = math.log1p(-odds.stands), math.log(odds.stands)
    return np.asarray(-np.logaddexp(others, stands + energies - standing))


def _totals(case: _Case, rated: Rated) -> FloatArray:
    """Return the (P,) energies by places, how people stand, and by sizes."""
    return rated.pool.energies + rated.less - case.known.size_odds_of(rated.pool.partners)


def _promising(case: _Case, way: IntArray) -> IntArray:
    """Return the (V, N) ways at one change from a way that are nearly as likely, or likelier.

    They are judged by the components that the way itself may be of, with no limb elsewhere, which
    takes a tenth of the time.
    """
    ways = np.concatenate([way[None], one_change_away(way, len(case.places_m))])
    components = components_of(case.stance, case.places_m, way)
    energies = _of_counts(case, ways) - case.known.size_odds_of(ways)
    energies -= place_log_densities(components, case.places_m, ways)
    return np.asarray(ways[1:][energies[1:] < energies[0] + case.odds.gap])
