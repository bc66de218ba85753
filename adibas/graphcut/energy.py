"""The energy of a labelling, in whole numbers so that cuts are exact.

Source: thesis, equations 6.19-6.25. Equation 6.24 is printed the wrong way round: Omega_1 is 0 for
equal labels and 1 for others. Tables here are symmetric.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from adibas.arrays import AnyArray, Float32Array, FloatArray, Int32Array, check_shape
from adibas.graphcut.move_kernels import energy_of
from adibas.graphcut.neighbors import PixelGraph

MOST_LABELS = 127
MOST_AT_A_PIXEL = 1 << 30
"""What arcs and costs of one pixel may sum up to, so that 32 bits hold every flow."""
TOO_HEAVY = "the weights must not be negative, and smaller: 32 bits must hold them"


@dataclass(frozen=True, slots=True)
class EnergyParams:
    """How labels and boundaries are weighed.

    Attributes
    ----------
    smoothness : float
        Lambda of equation 6.19; 50 in the thesis.
    least_probability : float
        Smaller probabilities count as this: a label that no tree has seen stays possible.
    units_per_nat : int
        Whole units of energy for one nat (a factor e in probability): rounding changes an energy
        by less than half a unit a pixel and a pair.
    """

    smoothness: float = 50.0
    least_probability: float = 1e-5
    units_per_nat: int = 1000

    def __post_init__(self) -> None:
        if not self.smoothness >= 0:
            raise ValueError(f"smoothness must not be negative: {self.smoothness}")
        if not 0 < self.least_probability < 1:
            raise ValueError(f"least_probability must be in (0, 1): {self.least_probability}")
        if self.units_per_nat < 1:
            raise ValueError(f"units_per_nat must be positive: {self.units_per_nat}")


@dataclass(frozen=True, slots=True, eq=False)
class LabelEnergy:
    """What each labelling of N pixels with L labels costs.

    Attributes
    ----------
    graph : PixelGraph
        With K arcs a pixel.
    costs : (L, N) int32 array
        Of each label at each pixel.
    weights : (N, K) int32 array
        Of the pairs, the same in both directions; 0 where there is no neighbour.
    penalties : (L, L) int32 array
        Omega: symmetric, 0 for equal labels, not negative.
    """

    graph: PixelGraph
    costs: Int32Array
    weights: Int32Array
    penalties: Int32Array

    def __post_init__(self) -> None:
        n_labels, n_pixels = len(self.penalties), self.graph.n_pixels
        check_shape("costs", self.costs, (n_labels, n_pixels))
        check_shape("weights", self.weights, self.graph.neighbors.shape)
        check_penalties(self.penalties)
        heaviest = float(self.weights.max(initial=0)) * float(self.penalties.max())
        most = 2 * float(np.abs(self.costs).max(initial=0)) + 2 * self.weights.shape[1] * heaviest
        if most > MOST_AT_A_PIXEL or self.weights.min(initial=0) < 0:
            raise ValueError(TOO_HEAVY)

    @property
    def is_metric(self) -> bool:
        """Say whether Omega obeys the triangle inequality, as alpha-expansion needs it."""
        direct = self.penalties.astype(np.int64)
        detour = (direct[:, :, None] + direct[None, :, :]).min(axis=1)
        return bool((direct <= detour).all())

    def arcs(self) -> Int32Array:
        """Return the (2, N, K) table of `pair_kernels`."""
        table = np.empty((2, *self.weights.shape), np.int32)
        table[0] = self.graph.neighbors
        table[1] = self.weights
        return table

    def of(self, labels: AnyArray) -> int:
        """Return the energy of (N,) labels, in units."""
        check_shape("labels", labels, (self.graph.n_pixels,))
        small = np.array(labels, dtype=np.int8)
        return int(energy_of(self.arcs(), self.penalties, self.costs, small))


def label_energy(
    graph: PixelGraph,
    probabilities: FloatArray | Float32Array,
    boundary: FloatArray,
    penalties: Int32Array,
    params: EnergyParams | None = None,
) -> LabelEnergy:
    """Return the energy ``-ln P + lambda B Omega`` in whole units.

    Parameters
    ----------
    graph : PixelGraph
        N pixels.
    probabilities : (N, L) array
        Of the labels at each pixel (equation 6.18); rows need not sum to 1.
    boundary : (N, K) array
        From `boundary_weights`.
    penalties : (L, L) int32 array
        From `equal_penalties` or `penalty_table`.
    params : EnergyParams or None
        None takes the thesis'.

    Raises
    ------
    ValueError
        A shape does not fit, a probability is NaN, or lambda is too large for 32 bits.
    """
    chosen = params or EnergyParams()
    check_shape("probabilities", probabilities, (graph.n_pixels, len(penalties)))
    check_shape("boundary", boundary, graph.neighbors.shape)
    floored = np.maximum(probabilities.T, chosen.least_probability)
    if np.isnan(floored).any():
        raise ValueError("probabilities must not be NaN")
    costs = np.rint(np.log(floored) * -chosen.units_per_nat).astype(np.int32)
    weights = boundary * (chosen.smoothness * chosen.units_per_nat)
    if weights.max(initial=0.0) > MOST_AT_A_PIXEL:
        raise ValueError(TOO_HEAVY)
    # numba compiles anew for arrays that cannot be written: tables are copied.
    table = np.array(penalties, dtype=np.int32)
    whole = np.rint(weights).astype(np.int32)
    return LabelEnergy(graph, np.ascontiguousarray(costs), whole, table)


def equal_penalties(n_labels: int) -> Int32Array:
    """Return Omega_1: 0 for equal labels, 1 for others (equation 6.24, set right)."""
    return penalty_table(n_labels, {})


def penalty_table(n_labels: int, pairs: Mapping[tuple[int, int], int]) -> Int32Array:
    """Return Omega_2: 1 for different labels but for some pairs (equation 6.25).

    Parameters
    ----------
    n_labels : int
        1 to 127.
    pairs : mapping of (label, label) to penalty
        In either order: the table is symmetric.
    """
    if not 1 <= n_labels <= MOST_LABELS:
        raise ValueError(f"there can be 1 to {MOST_LABELS} labels, got {n_labels}")
    table = np.ones((n_labels, n_labels), np.int32)
    np.fill_diagonal(table, 0)
    for (first, second), penalty in pairs.items():
        table[first, second] = table[second, first] = penalty
    check_penalties(table)
    return table


def check_penalties(penalties: Int32Array) -> None:
    """Raise ValueError unless Omega is symmetric, 0 for equal labels, and nowhere negative."""
    check_shape("penalties", penalties, (len(penalties), len(penalties)))
    if not 1 <= len(penalties) <= MOST_LABELS:
        raise ValueError(f"there can be 1 to {MOST_LABELS} labels, got {len(penalties)}")
    is_fit = (penalties == penalties.T).all() and penalties.min() >= 0
    if not is_fit or penalties.diagonal().any():
        raise ValueError("penalties must be symmetric, 0 for equal labels and never negative")
