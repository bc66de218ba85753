"""Names for points that have none: the most probable ones, and how sure each is.

Several starts (headings and prototypes) are each given names in two ways: by neighbours alone, and
by one prototype with assignment and fit in turns. The few best are refined by exchanging points
under both energies. What else the points could be, with energies hardly higher, is the doubt.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np

from adibas.arrays import FloatArray, IntArray, check_shape, read_only
from adibas.data.joints import mirror_order
from adibas.shapes import labelling_exchange_kernels as exchanging
from adibas.shapes import labelling_search_kernels as search
from adibas.skeleton.model import PointModel
from adibas.skeleton.prepared import PoseSpread, PreparedModel
from adibas.skeleton.side_odds import side_factor
from adibas.skeleton.starts import heading_cost, heading_of_turn, list_turns, log_radius

LEAST_POINTS = 3
FARTHEST_LOG = 0.5
LEAST_SIZE_SD = 0.15
N_LAYINGS = 2


@dataclass(frozen=True, slots=True)
class LabelParams:
    """Settings of the search.

    Attributes
    ----------
    n_starts, n_refined : int
        Of prototypes and headings that are tried, and of the results that are refined: 6 and 4.
    n_rounds : int
        Most of assignment and fit in turns: 5.
    n_exchanges : int
        Most in a row: 12.
    missing_share, spurious_share : float
        How often a point is not there, or is none of the names: 0.03 each.
    incomplete_cost : float
        Of there being both a missing and a spurious point: 6.
    room_m : float
        Edge of the cube (square) in which any point may be: 1.5, a person's reach.
    tree_share : float
        Weight of the neighbours' energy against the prototype's: 0.7.
    view_kappa : float
        Concentration of a patient's heading about the declared view: 4, most within 30 degrees.
    side_divisor : float
        Of the log odds that left and right are exchanged: 7; without a view it is the shape alone
        that tells them, and real people differ more than simulated ones.
    sure : float
        Least confidence of a name that is given: 0.9.
    spread : PoseSpread
        How far a pose may be from its start.
    """

    n_starts: int = 6
    n_refined: int = 4
    n_rounds: int = 5
    n_exchanges: int = 12
    missing_share: float = 0.03
    spurious_share: float = 0.03
    incomplete_cost: float = 6.0
    room_m: float = 1.5
    tree_share: float = 0.7
    view_kappa: float = 4.0
    side_divisor: float = 7.0
    sure: float = 0.9
    spread: PoseSpread = field(default_factory=PoseSpread)

    @property
    def lone(self) -> float:
        """Return what a missing and a spurious point cost together, beside the room."""
        return -math.log(self.missing_share) - math.log(self.spurious_share)


@dataclass(frozen=True, slots=True, eq=False)
class Candidate:
    """One way to name the points.

    Attributes
    ----------
    partners : (N,) int array
        For each name the index of its point, -1 for none.
    energy : float
        Minus the log of its probability, up to a constant of the points.
    prototype : int
    turn : (D, D) array
        Prototype from points.
    scale : float
        Metres in a unit of the prototype.
    moved : (M, D) array
        The points in the prototype's frame.
    """

    partners: IntArray
    energy: float
    prototype: int
    turn: FloatArray
    scale: float
    moved: FloatArray

    def __post_init__(self) -> None:
        for array in (self.partners, self.turn, self.moved):
            read_only(array)


@dataclass(frozen=True, slots=True, eq=False)
class Labelling:
    """Names of M points.

    Attributes
    ----------
    names : tuple of str or None
        Of each point; None where it has none or the search is not sure.
    guesses : tuple of str or None
        The most probable name of each, however unsure; None: most probably none of the model's.
    confidences : (M,) array
        Of the guesses, 0 to 1.
    heading_rad : float
        Of the patient, 0 facing the camera; NaN where nothing was found, and in the plane.
    masses : (M, N + 1) array
        Probability of each name for each point; the last: of none. All alike where the search
        cannot tell: too few points, or nothing was found.
    """

    names: tuple[str | None, ...]
    guesses: tuple[str | None, ...]
    confidences: FloatArray
    heading_rad: float
    masses: FloatArray

    def __post_init__(self) -> None:
        check_shape("confidences", self.confidences, (len(self.names),))
        check_shape("masses", self.masses, (len(self.names), None))
        read_only(self.confidences)
        read_only(self.masses)


def label_points(
    models: Sequence[PreparedModel],
    points_m: FloatArray,
    view: str = "",
    params: LabelParams | None = None,
    temperature: float = 1.0,
) -> Labelling:
    """Name points.

    Parameters
    ----------
    models : sequence of PreparedModel
        At least one, all of the same names and of the points' dimensions; the best one names.
    points_m : (M, D) array
        In metres, y down, without NaN.
    view : str
        One of `HEADINGS_RAD` as it was declared; empty: unknown, and the sides are inferred.
    temperature : float
        See `SkeletonModel`.
    """
    params = params or LabelParams()
    if not models:
        raise ValueError("points are named by at least one model")
    check_shape("points_m", points_m, (None, models[0].model.n_dimensions))
    nobody = (None,) * len(points_m)
    n_outcomes = len(models[0].model.names) + 1
    masses = np.full((len(points_m), n_outcomes), 1.0 / n_outcomes)
    nothing = Labelling(nobody, nobody, np.zeros(len(points_m)), math.nan, masses)
    if len(points_m) < LEAST_POINTS:
        return nothing
    points = np.ascontiguousarray(points_m - points_m.mean(axis=0))
    found = [
        one
        for part in models
        for one in _Search(part, points, view, params).found(has_mirror=part is models[0])
    ]
    return _named(found, models[0].model, len(points), params, temperature) if found else nothing


def _named(
    found: Sequence["_Found"],
    model: PointModel,
    n_points: int,
    params: LabelParams,
    temperature: float,
) -> Labelling:
    """Return the names of the best candidate, doubted by all others."""
    best = min((one.candidate for one in found), key=lambda one: one.energy)
    masses = np.zeros((n_points, len(model.names) + 1))
    of_other_side = np.zeros_like(masses)
    seen: set[bytes] = set()
    for one in found:
        candidate = one.candidate
        if candidate.partners.tobytes() in seen:
            continue
        seen.add(candidate.partners.tobytes())
        is_other = _is_other_side(candidate.partners, best.partners, model.names)
        side = of_other_side if is_other else masses
        itself = np.array([candidate.energy])
        exchanging.weigh(side, candidate.partners[None], itself, best.energy, temperature)
        exchanging.weigh(side, one.others, one.energies, best.energy, temperature)
    # Each way to name gives every point its weight once.
    weights = float(masses[0].sum()), float(of_other_side[0].sum())
    masses += side_factor(*weights, params.side_divisor) * of_other_side
    masses /= masses.sum(axis=1, keepdims=True)
    index = np.full(n_points, len(model.names))
    index[best.partners[best.partners >= 0]] = np.flatnonzero(best.partners >= 0)
    confidences = masses[np.arange(n_points), index]
    guesses = tuple(None if i == len(model.names) else model.names[i] for i in index)
    names = tuple(
        guess if confidence >= params.sure else None
        for guess, confidence in zip(guesses, confidences, strict=True)
    )
    heading = heading_of_turn(best.turn) if model.n_dimensions == len("xyz") else math.nan
    return Labelling(names, guesses, confidences, heading, masses)


def _is_other_side(partners: IntArray, best: IntArray, names: tuple[str, ...]) -> bool:
    """Say whether at least two names of one are in the other those of the other side."""
    mirror = np.array(mirror_order(names))
    is_turned = (partners == best[mirror]) & (best[mirror] != best) & (partners >= 0)
    return bool(np.count_nonzero(is_turned) >= len("ab") + len("ab"))


@dataclass(frozen=True, slots=True, eq=False)
class _Found:
    """A candidate, and what differs from it by one exchange."""

    candidate: Candidate
    others: IntArray
    energies: FloatArray


class _Search:
    """One search: what all its steps share."""

    def __init__(
        self, model: PreparedModel, points: FloatArray, view: str, params: LabelParams
    ) -> None:
        self._model = model
        self._points = points
        self._view = view
        self._params = params
        logs = model.log_sizes
        off = np.clip(log_radius(points) - logs, -FARTHEST_LOG, FARTHEST_LOG)
        self._scales = np.exp(logs + off)
        self._alones = params.lone + model.model.n_dimensions * (
            math.log(params.room_m) - np.log(self._scales)
        )

    def found(self, *, has_mirror: bool) -> list[_Found]:
        """Return the best candidates after exchanges; the mirrored best where no view is told."""
        firsts: dict[bytes, Candidate] = {}
        for partners, turn in self._proposals():
            key = partners.tobytes()
            if key not in firsts and np.count_nonzero(partners >= 0) >= LEAST_POINTS:
                firsts[key] = self._laid(partners, turn, 0).candidate
        order = sorted(firsts.values(), key=lambda one: one.energy)
        found = [
            self._laid(one.partners, one.turn, self._params.n_exchanges)
            for one in order[: self._params.n_refined]
        ]
        if found and has_mirror and not self._view and self._model.model.is_upright:
            best = min((one.candidate for one in found), key=lambda one: one.energy)
            found.append(self._mirrored(best))
        return found

    def _proposals(self) -> Iterator[tuple[IntArray, FloatArray]]:
        """Give names and the turn (prototype from points) that they were found at."""
        model, params = self._model, self._params
        turns, shifts = list_turns(model.model, self._view)
        tree = model.model.tree
        radius_m = math.exp(log_radius(self._points))
        by_tree = search.assign_by_tree(
            self._points / radius_m,
            shifts,
            tree.edges,
            tree.log_lengths,
            model.wide_sds,
            tree.directions,
            model.model.n_dimensions * math.log(params.room_m / radius_m),
            params.lone,
        )
        yield from zip(by_tree, turns, strict=True)
        ratings = search.rate_starts(
            self._points,
            turns,
            model.means,
            model.whiteners,
            model.constants,
            self._scales,
            self._alones,
        )
        ratings = ratings + self._costs(self._scales)[:, None]
        for one in np.argsort(ratings, axis=None)[: params.n_starts]:
            k, r = divmod(int(one), len(turns))
            partners = search.assign_start(
                self._points,
                turns[r],
                float(self._scales[k]),
                model.means[k],
                model.spreads[k],
                model.loadings[k],
                model.noise[k],
                float(self._alones[k]),
                params.n_rounds,
            )
            yield partners, turns[r]

    def _costs(self, scales: FloatArray) -> FloatArray:
        """Return what each prototype costs before the points are looked at, at (K,) scales."""
        model = self._model
        off = (np.log(scales) - model.log_sizes) / np.maximum(model.log_size_sds, LEAST_SIZE_SD)
        return np.asarray(model.weight_costs + 0.5 * off**2)

    def _laid(self, partners: IntArray, turn: FloatArray, n_exchanges: int) -> _Found:
        """Choose the prototype that suits names best, find the pose, and exchange points."""
        model, params = self._model, self._params
        turned = np.ascontiguousarray(self._points @ turn.T)
        ratings = search.rate_models(
            turned,
            partners,
            model.means,
            model.whiteners,
            model.constants,
            self._scales,
            self._alones,
        )
        k = int(np.argmin(ratings + self._costs(self._scales)))
        energy, scale, moved = math.inf, float(self._scales[k]), turned
        for _ in range(N_LAYINGS):
            moved, turn, scale = search.lay(
                self._points,
                turn,
                scale,
                model.means[k],
                model.loadings[k],
                model.noise[k],
                model.pose_sd,
                partners,
                N_LAYINGS,
            )
            before = partners
            partners, energy, others, energies = self._exchanged(
                partners, moved, scale, k, n_exchanges
            )
            if (partners == before).all():
                break
        prior = float(self._costs(np.full(len(self._scales), scale))[k])
        prior += heading_cost(turn, self._view, params.view_kappa)
        candidate = Candidate(partners, energy + prior, k, turn, scale, moved)
        return _Found(candidate, others, energies + prior)

    def _exchanged(
        self, partners: IntArray, moved: FloatArray, scale: float, k: int, n_exchanges: int
    ) -> tuple[IntArray, float, IntArray, FloatArray]:
        model, params = self._model, self._params
        tree = model.model.tree
        return exchanging.exchange(
            moved,
            model.means[k],
            model.loadings[k],
            model.noise[k],
            partners,
            model.moves,
            tree.edges,
            tree.log_lengths,
            tree.log_length_sds,
            tree.directions,
            model.model.n_dimensions * math.log(params.room_m / scale),
            params.lone,
            params.incomplete_cost,
            params.tree_share,
            n_exchanges,
        )

    def _mirrored(self, one: Candidate) -> _Found:
        """Return the candidate with left and right exchanged, seen from the other side."""
        partners = one.partners[mirror_order(self._model.model.names)]
        turn = one.turn.copy()
        if self._model.model.n_dimensions > len("xy"):
            turn[[0, 2]] *= -1.0
        return self._laid(partners, turn, self._params.n_exchanges)
