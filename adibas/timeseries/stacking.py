"""Sequences of different lengths in the one layout that the compiled loops read."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from adibas.arrays import FloatArray, IntArray

NOTHING_MISSING = np.empty((0, 0))
LEAST_SEEN = 0.5
"""Share of the (squared) weight that two frames must both show to be compared."""


@dataclass(frozen=True, slots=True, eq=False)
class Stack:
    """Weighted sequences one behind the other.

    Attributes
    ----------
    frames : (N, d) array
        All frames, multiplied by the weights; NaN where something was not seen.
    offsets : (k + 1,) integer array
        Where each sequence begins.
    shares : (d,) array
        Squared weights, their sum 1.
    """

    frames: FloatArray
    offsets: IntArray
    shares: FloatArray

    @property
    def has_gaps(self) -> bool:
        """Return whether anything was not seen."""
        return bool(np.isnan(self.frames).any())

    @property
    def columns(self) -> FloatArray:
        """Return (d, N): frames in columns."""
        return np.ascontiguousarray(self.frames.T)

    def column_shares(self) -> FloatArray:
        """Return (d, N): the share of the weight of each number."""
        return np.repeat(self.shares[:, None], len(self.frames), axis=1)


def stacked(sequences: Sequence[FloatArray], weights: FloatArray | None = None) -> Stack:
    """Return sequences (m_k, d) in one layout, multiplied by `weights` (d,), 1 if not given.

    Raises
    ------
    ValueError
        There is no sequence, one is empty, their frames differ in length, or no weight is above 0.
    """
    if not sequences or min(map(len, sequences)) == 0:
        raise ValueError("there must be sequences, each of one frame at least")
    dimension = sequences[0].shape[1]
    if any(sequence.ndim != 2 or sequence.shape[1] != dimension for sequence in sequences):  # noqa: PLR2004
        raise ValueError(f"all sequences must have {dimension} numbers a frame")
    factors = weights_of(weights, dimension)
    offsets = np.concatenate([[0], np.cumsum([len(sequence) for sequence in sequences])])
    frames = np.ascontiguousarray(np.concatenate(sequences), np.float64) * factors
    return Stack(frames, offsets.astype(np.int64), factors**2 / (factors**2).sum())


def weights_of(weights: FloatArray | None, dimension: int) -> FloatArray:
    """Return `weights` (d,) checked, or ones.

    Raises
    ------
    ValueError
        They have another length, or none is above 0.
    """
    factors = np.ones(dimension) if weights is None else np.asarray(weights, np.float64)
    if factors.shape != (dimension,) or (factors < 0).any() or not factors.any():
        raise ValueError(f"weights must be {dimension} numbers, none below and one above 0")
    return factors
