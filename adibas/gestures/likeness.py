"""How much a segment overlaps with a gesture, learned from segments that were looked at.

Kernel ridge regression; the kernel is exp(-distance), the distance the alignment of positions plus
that of velocities, each over its median. Alignment gives no positive definite kernel: its negative
part is left out in the training.

Source: Saunders et al., Ridge regression learning algorithm in dual variables, 1998; Bahlmann et
al., On-line handwriting recognition with support vector machines - a kernel approach, 2002 (the
alignment as a kernel).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from adibas.arrays import BoolArray, FloatArray, IntArray
from adibas.gestures.descriptor import N_POSITIONS
from adibas.timeseries.dtw import cross_costs, pairwise_costs

LARGEST_BATCH = 256


@dataclass(frozen=True, slots=True)
class LikenessParams:
    """Of the regression; one choice for all sets.

    Attributes
    ----------
    width : float
        Of the kernel, as a share of the median distance.
    ridge : float
        Added to the kernel's diagonal; 1 is the similarity of a segment with itself.
    """

    width: float = 0.6
    ridge: float = 0.1


@dataclass(frozen=True, slots=True, eq=False)
class Likeness:
    """A fitted regression.

    Attributes
    ----------
    segments : (k, n, d) array
    coefficients : (k, labels) array
    scales : (2,) array
        Divisors of the costs of positions and of velocities.
    """

    segments: FloatArray
    coefficients: FloatArray
    scales: FloatArray

    def predict(self, segments: Sequence[FloatArray]) -> FloatArray:
        """Return (n, labels): about 1 for a segment that is the gesture, 0 for any other."""
        parts = [
            np.exp(-_summed(_costs_between(segments[at : at + LARGEST_BATCH], self.segments),
                            self.scales)) @ self.coefficients
            for at in range(0, len(segments), LARGEST_BATCH)
        ]  # fmt: skip
        return np.concatenate(parts) if parts else np.empty((0, self.coefficients.shape[1]))


@dataclass(frozen=True, slots=True, eq=False)
class LikenessTraining:
    """Segments with their targets, compared once: any part of them is fitted at little cost."""

    segments: FloatArray
    targets: FloatArray
    costs: tuple[FloatArray, ...]
    params: LikenessParams

    @classmethod
    def of(
        cls, segments: Sequence[FloatArray], targets: FloatArray, params: LikenessParams
    ) -> "LikenessTraining":
        """Compare all segments (n, d) of one length; `targets` is (k, labels)."""
        costs = tuple(pairwise_costs(part) for part in _parts(segments))
        return cls(np.stack(segments), targets, costs, params)

    def fitted(self, kept: BoolArray | None = None) -> Likeness:
        """Return the regression on the segments that are `kept` (k,), all if not given."""
        chosen = np.flatnonzero(np.ones(len(self.segments), bool) if kept is None else kept)
        costs = [cost[np.ix_(chosen, chosen)] for cost in self.costs]
        scales = self.scales(costs)
        kernel = np.exp(-_summed(costs, scales))
        values, vectors = np.linalg.eigh(kernel)
        gains = 1.0 / (np.maximum(values, 0.0) + self.params.ridge)
        coefficients = vectors @ (gains[:, None] * (vectors.T @ self.targets[chosen]))
        return Likeness(self.segments[chosen], coefficients, scales)

    def held_out(self, groups: IntArray) -> FloatArray:
        """Return (k, labels): what is predicted for each group by a fit without it."""
        predicted = np.empty_like(self.targets)
        for group in np.unique(groups):
            kept = groups != group
            fit = self.fitted(kept)
            between = [cost[np.ix_(~kept, kept)] for cost in self.costs]
            predicted[~kept] = np.exp(-_summed(between, fit.scales)) @ fit.coefficients
        return predicted

    def scales(self, costs: Sequence[FloatArray]) -> FloatArray:
        """Return the divisors, so that the summed cost of a typical pair is 1 / width."""
        medians = [_median(cost) for cost in costs]
        return np.array([median * len(costs) * self.params.width for median in medians])


def _median(costs: FloatArray) -> float:
    known = costs[np.isfinite(costs) & (costs > 0)]
    return float(np.median(known)) if known.size else 1.0


def _parts(segments: Sequence[FloatArray] | FloatArray) -> list[list[FloatArray]]:
    """Return positions, and velocities where there are any."""
    starts = range(0, segments[0].shape[1], N_POSITIONS)
    return [
        [np.ascontiguousarray(segment[:, at : at + N_POSITIONS]) for segment in segments]
        for at in starts
    ]


def _costs_between(
    segments: Sequence[FloatArray], others: Sequence[FloatArray] | FloatArray
) -> list[FloatArray]:
    return [
        cross_costs(mine, theirs)
        for mine, theirs in zip(_parts(segments), _parts(others), strict=True)
    ]


def _summed(costs: Sequence[FloatArray], scales: FloatArray) -> FloatArray:
    return np.asarray(sum(cost / scale for cost, scale in zip(costs, scales, strict=True)))
