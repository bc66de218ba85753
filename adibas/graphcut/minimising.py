"""Labels of little energy, by moves that are each the best of their kind.

Source: Boykov, Veksler & Zabih, Fast approximate energy minimization via graph cuts, PAMI 23
(2001). Expansion needs a metric Omega; Omega_2 of the thesis (0, 1, 5, 10) is none, since
10 > 1 + 1, so its moves are swaps.
"""

import itertools
from dataclasses import dataclass

import numpy as np

from adibas.arrays import AnyArray, Int32Array, check_shape, read_only
from adibas.graphcut.energy import LabelEnergy
from adibas.graphcut.move_kernels import (
    begin_expansion,
    begin_swap,
    energy_of,
    find_borders,
    make_move,
)
from adibas.graphcut.pair_kernels import EXCESS, IS_LAID, STAY
from adibas.graphcut.start_kernels import settle_labels

MAX_CYCLES = 30
"""Through all labels, or pairs of them; real pictures need 2 to 5."""
START_SWEEPS = 20
STRONG_BORDERS = 20.0
"""Expansions begin from settled labels where borders cost so many times what the labels do."""
N_COUNTERS = 5
N_NODE_ROWS = 5
N_MARK_ROWS = 5
_KEPT = slice(IS_LAID, STAY + 1)
"""Rows of marks that an expansion goes on with: one follows the other."""


@dataclass(frozen=True, slots=True, eq=False)
class Labelling:
    """What a minimisation found.

    Attributes
    ----------
    labels : (N,) int8 array
        Of the graph's pixels.
    energy : int
        In units of the energy.
    n_cuts : int
        Binary cuts made.
    """

    labels: AnyArray
    energy: int
    n_cuts: int

    def __post_init__(self) -> None:
        read_only(self.labels)


@dataclass(frozen=True, slots=True)
class Move:
    """One binary cut.

    Attributes
    ----------
    value : int
        The energy of the cut less that where every pixel stays (in a swap: is ``alpha``).
    gain : int
        By how much the energy rises: 0 or less.
    """

    value: int
    gain: int


def minimise(energy: LabelEnergy, start: AnyArray | None = None) -> Labelling:
    """Lower the energy by expansions where Omega is a metric, else by swaps.

    Parameters
    ----------
    energy : LabelEnergy
        Of N pixels.
    start : (N,) integer array or None
        Labels to begin with; None takes `start_labels` for expansions, where with a strong lambda
        it spares up to half the time, and `cheapest_labels` for swaps, where settled ones spare a
        tenth and may end higher.

    Returns
    -------
    Labelling
        No single move of that kind lowers its energy. The same input gives the same labels.
    """
    return expand(energy, start) if energy.is_metric else swap(energy, start)


def expand(
    energy: LabelEnergy, start: AnyArray | None = None, max_cycles: int = MAX_CYCLES
) -> Labelling:
    """Lower the energy by alpha-expansion: label by label, until none gains.

    Raises
    ------
    ValueError
        Omega breaks the triangle inequality: use `swap`.
    """
    if not energy.is_metric:
        raise ValueError("alpha-expansion needs a metric table of penalties: use swap")
    moves = _Moves(energy, start_labels(energy) if start is None else start, keeps=True)
    n_labels = len(energy.penalties)
    n_idle = n_cuts = 0
    while n_idle < n_labels and n_cuts < max_cycles * n_labels:
        gain = moves.expand(n_cuts % n_labels).gain
        # A label that has just been expanded gains nothing more by itself.
        n_idle = n_idle + 1 if gain == 0 else 1
        n_cuts += 1
    return Labelling(moves.labels, energy.of(moves.labels), n_cuts)


def swap(
    energy: LabelEnergy, start: AnyArray | None = None, max_cycles: int = MAX_CYCLES
) -> Labelling:
    """Lower the energy by alpha-beta swap: pair by pair of labels, until none gains.

    What gains nothing for either goes to the label with more pixels, the first of equals: the
    cut then looks at few. A pair is left out where since its last swap nothing changed in or
    beside its pixels.
    """
    moves = _Moves(energy, cheapest_labels(energy) if start is None else start)
    n_labels = len(energy.penalties)
    touched_at = np.zeros(n_labels, np.int64)
    swapped_at = np.full((n_labels, n_labels), -1, np.int64)
    n_cuts = 0
    for _ in range(max_cycles):
        n_before = n_cuts
        for alpha, beta in itertools.combinations(range(n_labels), 2):
            if swapped_at[alpha, beta] < touched_at[[alpha, beta]].max():
                n_cuts += 1
                moves.swap(*moves.larger_first(alpha, beta))
                touched_at[moves.is_touched > 0] = n_cuts
                swapped_at[alpha, beta] = n_cuts
        if n_cuts == n_before:
            break
    return Labelling(moves.labels, energy.of(moves.labels), n_cuts)


def move(
    energy: LabelEnergy, labels: AnyArray, alpha: int, beta: int | None = None
) -> tuple[AnyArray, Move]:
    """Make one expansion of `alpha`, or one swap with `beta`; return the new (N,) labels."""
    moves = _Moves(energy, labels)
    made = moves.expand(alpha) if beta is None else moves.swap(alpha, beta)
    return moves.labels, made


def cheapest_labels(energy: LabelEnergy) -> AnyArray:
    """Return (N,) int8: the likeliest label of each pixel by itself, the first of equals."""
    labels: AnyArray = energy.costs.argmin(axis=0).astype(np.int8)
    return labels


def start_labels(energy: LabelEnergy) -> AnyArray:
    """Return (N,) int8: labels for expansions to begin with.

    The likeliest ones; where their borders cost more than `STRONG_BORDERS` times what the labels
    do, the same after each pixel has looked at its neighbours. From there the cuts are up to
    twice as fast. Where borders cost less that spares a tenth, and the expansions now and then
    end in another minimum than from the likeliest labels, now above theirs, now below.
    """
    labels = cheapest_labels(energy)
    arcs = energy.arcs()
    of_labels = int(energy.costs.min(axis=0).sum(dtype=np.int64))
    of_borders = int(energy_of(arcs, energy.penalties, energy.costs, labels)) - of_labels
    if of_borders > STRONG_BORDERS * of_labels:
        settle_labels(arcs, energy.penalties, energy.costs, labels, START_SWEEPS)
    return labels


class _Moves:
    """The tables of `pair_kernels` for one energy, and labels that moves change in place.

    With `keeps` the flow of each expansion is kept, for the next one of that label to go on with:
    most of what there is to do was done then.
    """

    def __init__(self, energy: LabelEnergy, start: AnyArray, *, keeps: bool = False) -> None:
        n_labels, n_pixels = energy.costs.shape
        n_kept = n_labels if keeps else 1
        self._energy = energy
        self._arcs = energy.arcs()
        # Of arcs that are never laid the computer's memory is never taken.
        self._left = np.empty((n_kept, *energy.weights.shape), np.int32)
        self._kept_excess = np.empty((n_kept, n_pixels), np.int32)
        self._kept_marks = np.empty((n_kept, 2, n_pixels), np.int8)
        self._is_kept, self._keeps = np.zeros(n_labels, np.bool_), keeps
        self._nodes = np.full((N_NODE_ROWS, n_pixels), -1, np.int32)
        self._marks = np.zeros((N_MARK_ROWS, n_pixels), np.int8)
        self._counters = np.zeros(N_COUNTERS, np.int64)
        self._is_border = np.zeros(n_pixels, np.int8)
        self.is_touched = np.zeros(n_labels, np.int8)
        self.labels = _checked(energy, start)
        find_borders(self._arcs, self.labels, self._is_border)

    def larger_first(self, alpha: int, beta: int) -> tuple[int, int]:
        n_alpha, n_beta = (np.count_nonzero(self.labels == label) for label in (alpha, beta))
        return (alpha, beta) if n_alpha >= n_beta else (beta, alpha)

    def expand(self, alpha: int) -> Move:
        """Let every pixel take `alpha`."""
        begin_expansion(self._marks, self.labels, alpha)
        if not self._keeps:
            return self._make(self._left[0], is_renewed=False)
        is_kept = bool(self._is_kept[alpha])
        if is_kept:
            self._nodes[EXCESS] = self._kept_excess[alpha]
            self._marks[_KEPT] = self._kept_marks[alpha]
        made = self._make(self._left[alpha], is_renewed=is_kept)
        self._kept_excess[alpha] = self._nodes[EXCESS]
        self._kept_marks[alpha] = self._marks[_KEPT]
        self._is_kept[alpha] = True
        return made

    def swap(self, alpha: int, beta: int) -> Move:
        """Let every pixel of either label take the other."""
        begin_swap(self._marks, self.labels, alpha, beta)
        return self._make(self._left[0], is_renewed=False)

    def _make(self, left: Int32Array, *, is_renewed: bool) -> Move:
        self.is_touched[:] = 0
        value, gain = make_move(
            self._arcs,
            left,
            self._nodes,
            self._marks,
            self._counters,
            self._energy.penalties,
            self._energy.costs,
            self.labels,
            self._is_border,
            self.is_touched,
            is_renewed,
        )
        return Move(int(value), int(gain))


def _checked(energy: LabelEnergy, start: AnyArray) -> AnyArray:
    check_shape("start", start, (energy.graph.n_pixels,))
    if start.size and not 0 <= start.min() <= start.max() < len(energy.penalties):
        raise ValueError(f"start must hold labels 0 to {len(energy.penalties) - 1}")
    labels: AnyArray = np.array(start, dtype=np.int8)
    return labels
