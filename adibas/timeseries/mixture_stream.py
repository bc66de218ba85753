"""Alignment with models of which every frame is a mixture of Gaussians.

Densities are taken relative to the highest peak of all models, so that the middle of the narrowest
component costs nothing, and wide ones have no advantage; the cost is the root of -2 log of the
mixture over the number of numbers. (The paper's exp(-P) orders frames alike, but is 1 for nearly
all of them in 84 numbers.)

Source: Bautista et al., A gesture recognition system for detecting behavioral patterns of ADHD,
IEEE Transactions on Cybernetics 46 (2016), section III.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from adibas.arrays import FloatArray, IntArray, check_shape
from adibas.timeseries.cost_stream_kernels import feed_costs
from adibas.timeseries.sloped_kernels import N_ROWS
from adibas.timeseries.stacking import LEAST_SEEN

FARTHEST = 700.0
"""Half a squared distance beyond which a component adds nothing to a sum of doubles."""


@dataclass(frozen=True, slots=True, eq=False)
class MixtureModel:
    """One gesture.

    Attributes
    ----------
    shares : (m, g) array
        Of the components of each frame; their sum is 1.
    means, variances : (m, g, d) arrays
    """

    shares: FloatArray
    means: FloatArray
    variances: FloatArray

    def __post_init__(self) -> None:
        check_shape("means", self.means, (*self.shares.shape, None))
        check_shape("variances", self.variances, self.means.shape)
        if not (self.variances > 0).all():
            raise ValueError("variances must be above zero")


class MixtureStream:
    """Aligns several models with one stream at once, as `StreamAligner` does with sequences.

    Raises
    ------
    ValueError
        A model has less than 2 frames, or they differ in numbers a frame.
    """

    def __init__(self, models: Sequence[MixtureModel]) -> None:
        if not models or min(len(model.shares) for model in models) < 2:  # noqa: PLR2004
            raise ValueError("there must be models, each of two frames at least")
        n_most = max(model.shares.shape[1] for model in models)
        shares = _joined([model.shares for model in models], n_most, 0.0)
        means = _joined([model.means for model in models], n_most, 0.0)
        variances = _joined([model.variances for model in models], n_most, 1.0)
        self.lengths = np.array([len(model.shares) for model in models])
        self._offsets = np.concatenate([[0], np.cumsum(self.lengths)]).astype(np.int64)
        self._dimension = means.shape[2]
        spread = np.log(variances).sum(axis=2)
        narrowest = spread[shares > 0].min()
        with np.errstate(divide="ignore"):
            self._log_shares = np.log(shares) - 0.5 * (spread - narrowest)
        flat = (shares.size, self._dimension)
        self._inverse = np.ascontiguousarray((1.0 / variances).reshape(flat).T)
        self._linear = np.ascontiguousarray((means / variances).reshape(flat).T)
        self._square = np.ascontiguousarray((means**2 / variances).reshape(flat).T)
        self.reset()

    def reset(self) -> None:
        """Forget the stream so far."""
        self._memory = np.full((N_ROWS, int(self._offsets[-1])), np.inf)
        self._n_seen = 0

    def feed(self, frames: FloatArray) -> tuple[FloatArray, IntArray]:
        """Take the next frames (n, d); return costs and starts (n, k) as `StreamAligner.feed`."""
        check_shape("frames", frames, (None, self._dimension))
        costs = np.empty((len(frames), len(self.lengths)))
        starts = np.empty_like(costs)
        local = np.ascontiguousarray(self.local_costs(frames))
        feed_costs(local, self._offsets, self._n_seen, self._memory, costs, starts)
        self._n_seen += len(frames)
        starts[~np.isfinite(costs)] = 0
        return costs / self.lengths, starts.astype(np.int64)

    def local_costs(self, frames: FloatArray) -> FloatArray:
        """Return (n, M): the cost of each frame against each frame of the models."""
        seen = np.isfinite(frames)
        known = np.where(seen, frames, 0.0)
        squared = (
            (known**2) @ self._inverse
            - 2.0 * known @ self._linear
            + seen.astype(np.float64) @ self._square
        ).reshape(len(frames), *self._log_shares.shape)
        n_seen = seen.sum(axis=1)
        # Scaled up to all numbers, as a distance is where something was not seen.
        scale = self._dimension / np.maximum(n_seen, 1)
        half = -0.5 * np.maximum(squared, 0.0) * scale[:, None, None] + self._log_shares
        best = half.max(axis=2)
        near = np.exp(np.maximum(half - best[:, :, None], -FARTHEST)).sum(axis=2)
        found = np.sqrt(np.maximum(-2.0 * (best + np.log(near)), 0.0) / self._dimension)
        found[n_seen < LEAST_SEEN * self._dimension] = np.inf
        return np.asarray(found)


def _joined(arrays: Sequence[FloatArray], n_components: int, filling: float) -> FloatArray:
    """Return arrays (m_k, g_k, ...) one behind the other, all with as many components."""
    return np.concatenate(
        [
            np.pad(
                array,
                [(0, 0), (0, n_components - array.shape[1]), *[(0, 0)] * (array.ndim - 2)],
                constant_values=filling,
            )
            for array in arrays
        ]
    )
