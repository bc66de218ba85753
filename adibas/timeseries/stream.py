"""Where in an endless stream do models begin and end? In constant memory, frame by frame.

Source: thesis, section 7.1.1 and table 7.1 (free steps); Sakoe & Chiba 1978 (limited slope).
"""

from collections.abc import Sequence
from typing import Literal, TypeAlias

import numpy as np

from adibas.arrays import FloatArray, IntArray, check_shape
from adibas.timeseries.free_kernels import PAD, feed_free
from adibas.timeseries.sloped_kernels import N_ROWS, feed_sloped
from adibas.timeseries.stacking import LEAST_SEEN, NOTHING_MISSING, stacked, weights_of

Steps: TypeAlias = Literal["sloped", "free"]
SHORTEST_SLOPED = 2


class StreamAligner:
    """Aligns several models with one stream at once.

    The start of every path travels with its sum, so that tracing a path back to its beginning
    needs no memory of the stream: each frame costs the models' total length, for ever.

    Parameters
    ----------
    models : sequence of (m_k, d) arrays
        NaN where something was not seen.
    weights : (d,) array, optional
        Factor of each number (7.6); 1 if not given.
    steps : {'sloped', 'free'}
        Half to twice the model's speed, or the unlimited steps of table 7.1.

    Raises
    ------
    ValueError
        A model has less than 2 frames (sloped) or none.
    """

    def __init__(
        self,
        models: Sequence[FloatArray],
        weights: FloatArray | None = None,
        steps: Steps = "sloped",
    ) -> None:
        stack = stacked(models, weights)
        self._factors = weights_of(weights, stack.frames.shape[1])
        self._is_weighted = bool((self._factors != 1.0).any())
        self._columns, self._offsets = stack.columns, stack.offsets
        self._has_gaps, self._shares = stack.has_gaps, stack.column_shares()
        self._is_sloped = steps == "sloped"
        self.lengths = np.diff(stack.offsets)
        if self._is_sloped and self.lengths.min() < SHORTEST_SLOPED:
            raise ValueError(f"a model needs {SHORTEST_SLOPED} frames at least")
        self.reset()

    def reset(self) -> None:
        """Forget the stream so far: no path crosses this moment. The next frame has number 0."""
        width = self._columns.shape[1] + (0 if self._is_sloped else 2 * PAD)
        self._memory = np.full((N_ROWS, width), np.inf)
        self._n_seen = 0

    def feed(self, frames: FloatArray) -> tuple[FloatArray, IntArray]:
        """Take the next frames.

        Parameters
        ----------
        frames : (n, d) array
            NaN where something was not seen.

        Returns
        -------
        costs : (n, k) array
            For each frame and model the sum of distances over the best path of the whole model
            that ends with the frame, divided by the model's length; infinite where there is none.
        starts : (n, k) array
            The number of the frame where that path begins, counted from the last `reset`.
        """
        check_shape("frames", frames, (None, len(self._factors)))
        weighted = np.ascontiguousarray(frames * self._factors if self._is_weighted else frames)
        gaps = self._has_gaps or bool(np.isnan(weighted).any())
        shares = self._shares if gaps else NOTHING_MISSING
        costs = np.empty((len(frames), len(self.lengths)))
        starts = np.empty_like(costs)
        kernel = feed_sloped if self._is_sloped else feed_free
        kernel(
            weighted, self._columns, shares, LEAST_SEEN, self._offsets,
            self._n_seen, self._memory, costs, starts,
        )  # fmt: skip
        self._n_seen += len(frames)
        starts[~np.isfinite(costs)] = 0
        return costs / self.lengths, starts.astype(np.int64)
