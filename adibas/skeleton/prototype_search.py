"""The search for names by prototypes: starts, what is refined, and what it could be instead.

Several starts (headings and prototypes) are each given names in two ways: by neighbours alone, and
by one prototype with assignment and fit in turns. The few best are refined by exchanging points
under both energies.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from adibas.arrays import FloatArray, IntArray, read_only
from adibas.data.joints import mirror_order
from adibas.shapes import labelling_exchange_kernels as exchanging
from adibas.shapes import labelling_search_kernels as search
from adibas.skeleton.prepared import PoseSpread, PreparedModel
from adibas.skeleton.starts import heading_cost, list_turns, log_radius

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
class Found:
    """A candidate, and what differs from it by one exchange."""

    candidate: Candidate
    others: IntArray
    energies: FloatArray


class PrototypeSearch:
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

    def found(self, *, has_mirror: bool) -> list[Found]:
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

    def _laid(self, partners: IntArray, turn: FloatArray, n_exchanges: int) -> Found:
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
        return Found(candidate, others, energies + prior)

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

    def _mirrored(self, one: Candidate) -> Found:
        """Return the candidate with left and right exchanged, seen from the other side."""
        partners = one.partners[mirror_order(self._model.model.names)]
        turn = one.turn.copy()
        if self._model.model.n_dimensions > len("xy"):
            turn[[0, 2]] *= -1.0
        return self._laid(partners, turn, self._params.n_exchanges)
