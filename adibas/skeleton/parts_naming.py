"""Names for the joints in space by core and limbs, with the probability of each.

What the points could be is listed with its energy (minus log odds); the lowest one names, and the
share of each name in all that was listed is its confidence.
"""

import math
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import linear_sum_assignment

from adibas.arrays import FloatArray, IntArray
from adibas.shapes.labelling_search_kernels import assign_by_tree
from adibas.shapes.parts_crossing_kernels import rate_crossings
from adibas.shapes.parts_search_kernels import lay_anchors, search_parts
from adibas.shapes.parts_sight_kernels import rate_sight
from adibas.shapes.parts_types import Odds, Pool
from adibas.skeleton.given_names import OPEN, agrees, has_names, nothing_given
from adibas.skeleton.known import Known
from adibas.skeleton.labelling import Labelling
from adibas.skeleton.parts import LEGS, PartsModel
from adibas.skeleton.parts_odds import QUICK, THOROUGH, PartsOdds, expected_odds, hidden_costs
from adibas.skeleton.prepared import PreparedModel
from adibas.skeleton.second_opinion import names_of
from adibas.skeleton.seen_space import SeenSpace
from adibas.skeleton.side_odds import side_factor
from adibas.skeleton.standing_odds import rate_standing
from adibas.skeleton.starts import heading_of_turn, list_turns, log_radius

MOST_WAYS = 3000
MOST_NATS = 500.0
SETTLED = 0.99
"""Share of all names from which on the quick search is believed."""
HIPS_FACTOR, STEEPEST = 2.0, 0.5
"""How much nearer or farther apart than the usual ones hips may be, and how far out of level."""
MOST_POINTS = 40
"""Of a set that is searched by parts; more take seconds, and are no markers of one person."""


@dataclass(frozen=True, slots=True, eq=False)
class PartsFound:
    """What the points could be.

    Attributes
    ----------
    partners : (N,) int array
        The most probable: of each name its point, -1 for none.
    heading_rad : float
        Of the patient, 0 facing the camera.
    masses : (M, N + 1) array
        Probability of each name for each point; the last: of none.
    stands : float
        Probability that, if the partners are right, somebody stands still there.
    """

    partners: IntArray
    heading_rad: float
    masses: FloatArray
    stands: float


@dataclass(frozen=True, slots=True, eq=False)
class NamedByParts:
    """Names by core and limbs, and the probability that they are of somebody who stands still."""

    labelling: Labelling
    stands: float


def find_by_parts(
    model: PartsModel,
    prepared: PreparedModel,
    points_m: FloatArray,
    view: str,
    known: Known,
    odds: PartsOdds,
) -> PartsFound | None:
    """List what (M, 3) points could be; None where no core is found.

    Parameters
    ----------
    prepared : PreparedModel
        Of the same names: its tree of neighbours is where the search begins.
    view : str
        As declared; empty: unknown.
    known : Known
        Places alone decide what is listed, as far as it agrees with the given names.
    """
    if model.stance is None or not view:
        odds = replace(odds, stands=0.0)
    origin_m = points_m.mean(axis=0)
    points = np.ascontiguousarray(points_m - origin_m)
    known = replace(known, seen=known.seen.about(origin_m))
    label_odds = known.label_odds(len(model.names))
    expected = expected_odds(model, label_odds, view, odds, QUICK)
    turns, shifts = list_turns(prepared.model, view)
    free = _by_neighbours(prepared, points, shifts, expected)[:, model.core.labels]
    starts = np.concatenate([free, _forced(free, known.given, model.core.labels)])
    is_whole = len(points) == len(model.names)
    pool = _searched(model, points, starts, expected, known.given) if is_whole else None
    if pool is not None and len(pool.energies):
        found = _weighed(model, points, known, pool, expected, replace(odds, stands=0.0))
        is_usual = pool.energies.min() < -odds.usual
        if is_usual and _is_settled(found, len(model.names)):
            return found
    expected = expected_odds(model, label_odds, view, odds, THOROUGH)
    headings = np.array([heading_of_turn(turn) for turn in turns])
    laid = lay_anchors(points, headings, model.anchors, expected.log_room, odds.n_anchored)
    laid = np.concatenate([laid, _by_hips(points, model), _by_body(known, model)])
    forced = _forced(laid, known.given, model.core.labels)
    starts = np.concatenate([starts, laid, forced])
    pool = _searched(model, points, starts, expected, known.given)
    if not len(pool.energies):
        return None
    return _weighed(model, points, known, pool, expected, odds)


def _is_settled(found: PartsFound, n_names: int) -> bool:
    """Say whether every point surely has a name, and every name a point."""
    own = found.masses.max(axis=1)
    return bool((found.partners >= 0).all() and len(own) == n_names and own.min() >= SETTLED)


def _by_neighbours(
    prepared: PreparedModel, points: FloatArray, shifts: IntArray, expected: Odds
) -> IntArray:
    tree = prepared.model.tree
    radius_m = math.exp(log_radius(points))
    log_room = expected.log_room - 3.0 * math.log(radius_m)
    return assign_by_tree(
        points / radius_m, shifts, tree.edges, tree.log_lengths, prepared.wide_sds,
        tree.directions, log_room, 2.0 * expected.lone,
    )  # fmt: skip


def _by_hips(points: FloatArray, model: PartsModel) -> IntArray:
    """Return (S, C) cores of two points that may be both hips.

    Of some patients nothing of the trunk above them is seen.
    """
    hips = model.limbs.roots[LEGS]
    first_m, second_m = model.core.mean[hips]
    usual_m = np.linalg.norm(second_m - first_m)
    ways_m = points[None] - points[:, None]
    aparts_m = np.linalg.norm(ways_m, axis=2)
    may_be = (aparts_m > usual_m / HIPS_FACTOR) & (aparts_m < usual_m * HIPS_FACTOR)
    pairs = np.argwhere(may_be & (np.abs(ways_m[..., 1]) < STEEPEST * aparts_m))
    cores = np.full((len(pairs), len(model.core.labels)), -1)
    cores[:, hips] = pairs
    return cores


def _by_body(known: Known, model: PartsModel) -> IntArray:
    """Return the (1, C) core as where the body is tells it, or none where no body is known."""
    core = np.full((1, len(model.core.labels)), -1)
    if known.body_odds is None:
        return core[:0]
    gains = np.maximum(known.body_odds, 0.0)
    points, names = linear_sum_assignment(gains, maximize=True)
    is_likely = gains[points, names] > 0.0
    partners = np.full(len(model.names), -1)
    partners[names[is_likely]] = points[is_likely]
    core[0] = partners[model.core.labels]
    return core


def _forced(cores: IntArray, given: IntArray, labels: IntArray) -> IntArray:
    """Return the (S, C) cores with the points whose names are given in their places."""
    if not has_names(given):
        return cores[:0]
    points = np.flatnonzero(np.isin(given, labels))
    forced = cores.copy()
    forced[np.isin(forced, np.flatnonzero(given != OPEN))] = -1
    for point in points:
        forced[:, labels == given[point]] = point
    return forced


def _searched(
    model: PartsModel, points: FloatArray, starts: IntArray, expected: Odds, given: IntArray
) -> Pool:
    """Return what was found and agrees with the names that are given."""
    pool = Pool(
        np.empty(MOST_WAYS),
        np.empty(MOST_WAYS),
        np.empty((MOST_WAYS, len(model.names)), np.int64),
        np.zeros(1, np.int64),
    )
    starts = np.ascontiguousarray(starts)
    search_parts(points, starts, model.core, model.limbs, expected, pool)
    n = int(pool.n_filled[0])
    kept = agrees(pool.partners[:n], given) if has_names(given) else slice(None)
    return _each_once(
        Pool(
            pool.energies[:n][kept], pool.headings[:n][kept], pool.partners[:n][kept], pool.n_filled
        )
    )


def _each_once(pool: Pool) -> Pool:
    """Return each way once, with the odds of all that it is there (see `judge_core`)."""
    partners, first, which = np.unique(
        pool.partners, axis=0, return_index=True, return_inverse=True
    )
    if len(first) == len(pool.energies):
        return pool
    log_odds = np.full(len(first), -np.inf)
    np.logaddexp.at(log_odds, which.ravel(), -pool.energies)
    return Pool(-log_odds, pool.headings[first], partners, pool.n_filled)


def _weighed(
    model: PartsModel,
    points: FloatArray,
    known: Known,
    pool: Pool,
    expected: Odds,
    odds: PartsOdds,
) -> PartsFound:
    """Return the most probable names, and the share of each name in all ways.

    One way more is that all points are chance ones and all labels hidden: no person. It is the only
    one where the best way is not plausible, or leaves most points without a name.
    """
    n_points = len(points)
    rated = rate_standing(model, points, known, pool, expected, odds)
    pool, standing = rated.pool, rated.less
    by_sight = pool.energies + _sight(model, points, known.seen, pool, expected, odds)
    energies = by_sight + standing + _crossing(model, points, pool.partners, odds)
    energies -= known.size_odds_of(pool.partners)
    best = int(np.argmin(energies))
    weights = np.exp((energies[best] - energies) / odds.temperature)
    if math.isnan(expected.heading_rad):
        faces_away = np.cos(pool.headings - pool.headings[best]) < 0
        weights[faces_away] *= side_factor(
            float(weights[~faces_away].sum()), float(weights[faces_away].sum()), odds.side_divisor
        )
    lead = (expected.counts[-1] - energies[best]) / odds.temperature
    weights /= weights.sum() + math.exp(-max(lead, -MOST_NATS))
    n_named = np.count_nonzero(pool.partners[best] >= 0)
    is_likely = (
        pool.energies[best] <= -odds.plausible * n_named
        or by_sight[best] <= -odds.plausible_by_sight * n_named
    )
    if not is_likely or 2 * n_named < n_points:
        weights[:] = 0.0
    n_names = len(model.names)
    masses = np.zeros((n_points + 1, n_names + 1))
    np.add.at(
        masses,
        (pool.partners, np.arange(n_names)[None]),
        np.broadcast_to(weights[:, None], pool.partners.shape),
    )
    masses = masses[:n_points]
    masses[:, n_names] = np.maximum(1.0 - masses[:, :n_names].sum(axis=1), 0.0)
    stands = 1.0 - (1.0 - odds.stands) * math.exp(standing[best])
    return PartsFound(pool.partners[best].copy(), float(pool.headings[best]), masses, stands)


def _sight(
    model: PartsModel,
    points: FloatArray,
    seen: SeenSpace,
    pool: Pool,
    expected: Odds,
    odds: PartsOdds,
) -> FloatArray:
    """Return by how much ways are likelier as their missing labels are out of sight (negative)."""
    if not len(seen.normals):
        return np.zeros(len(pool.energies))
    costs = hidden_costs(len(model.names), odds)
    return rate_sight(
        points, pool.partners, model.core, model.limbs, expected, costs, seen.normals,
        seen.offsets_m,
    )  # fmt: skip


def _crossing(
    model: PartsModel, points: FloatArray, partners: IntArray, odds: PartsOdds
) -> FloatArray:
    roots = model.core.labels[model.limbs.roots[LEGS]]
    legs = np.concatenate([roots[:, None], model.limbs.labels[LEGS]], axis=1)
    return rate_crossings(
        points, partners, legs, odds.legs_apart_m, odds.legs_apart_sd_m, odds.legs_through
    )


def label_parts(
    model: PartsModel,
    prepared: PreparedModel,
    points_m: FloatArray,
    view: str = "",
    known: Known | None = None,
    odds: PartsOdds | None = None,
) -> NamedByParts | None:
    """Name (M, 3) points in metres, y down; None where no core is found.

    See `find_by_parts` for the parameters.
    """
    odds = odds or PartsOdds()
    known = known or Known(np.zeros(len(points_m)), nothing_given(len(points_m)))
    found = find_by_parts(model, prepared, points_m, view, known, odds)
    if found is None:
        return None
    n_points, n_names = len(points_m), len(model.names)
    index = np.full(n_points, n_names)
    has_point = found.partners >= 0
    index[found.partners[has_point]] = np.flatnonzero(has_point)
    names, guesses, confidences = names_of(
        index, found.masses, model.names, odds.sure, odds.side_sure
    )
    labelling = Labelling(names, guesses, confidences, found.heading_rad, found.masses)
    return NamedByParts(labelling, found.stands)
