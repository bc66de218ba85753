"""Where in a recording the scene stands still long enough for a burst.

Depth tells it: of two images of a scene at rest only noise differs. A board that is turned a
little, or moved in its own plane, changes few pixels, so that its corners are compared as well
where they are looked for.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from adibas.arrays import BoolArray, FloatArray, UInt16Array

EVERY_PX = 4
QUIET_QUANTILE = 0.1


@dataclass(frozen=True, slots=True)
class StillParams:
    """What counts as still.

    Attributes
    ----------
    n_frames : int
        Of a burst: 30, a second.
    least_frames : int
        A shorter rest is taken as well, down to 20.
    change_per_m : float
        Change of 1/z, 1/metres, by which a pixel is another surface: 0.012, four steps of
        disparity of a structured-light sensor (5 cm at 2 m).
    moving_share : float
        Pixels that change beyond the quietest frames' share: 0.004.
    apart_frames : int
        In a long rest, bursts begin so many frames apart: 90.
    """

    n_frames: int = 30
    least_frames: int = 20
    change_per_m: float = 0.012
    moving_share: float = 0.004
    apart_frames: int = 90


@dataclass(frozen=True, slots=True)
class Moment:
    """A burst: frames `first` to `last`, the last one not included."""

    first: int
    last: int

    @property
    def middle(self) -> int:
        """The frame in its middle."""
        return (self.first + self.last) // 2


class ChangeMeter:
    """Says of each depth image how much of it is another surface than in the one before."""

    def __init__(self, depth_unit_m: float, params: StillParams) -> None:
        self._unit_m = depth_unit_m
        self._limit_per_m = params.change_per_m
        self._before: FloatArray | None = None

    def share(self, depth_raw: UInt16Array) -> float:
        """Return the share of the pixels measured in both; 1 for the first image."""
        raw = depth_raw[::EVERY_PX, ::EVERY_PX].astype(float)
        with np.errstate(divide="ignore"):
            inverse = np.where(raw > 0, 1.0 / (raw * self._unit_m), np.nan)
        before, self._before = self._before, inverse
        if before is None or before.shape != inverse.shape:
            return 1.0
        change = np.abs(inverse - before)
        is_known = np.isfinite(change)
        if not is_known.any():
            return 1.0
        return float((change[is_known] > self._limit_per_m).mean())


def still_moments(shares: Sequence[float], params: StillParams) -> tuple[Moment, ...]:
    """Return the bursts of a recording.

    Parameters
    ----------
    shares : sequence of float
        Of every frame: see `ChangeMeter`; NaN for a frame without depth, which ends a rest.
    """
    values = np.asarray(shares, float)
    if not np.isfinite(values).any():
        return ()
    quiet = float(np.nanquantile(values, QUIET_QUANTILE))
    # The first frame of a rest differs from the one before it.
    with np.errstate(invalid="ignore"):
        is_still = values <= quiet + params.moving_share
    return tuple(
        moment for first, last in _runs(is_still) for moment in _bursts(first - 1, last, params)
    )


def _runs(is_still: BoolArray) -> list[tuple[int, int]]:
    """Return the (first, one after last) of every run of True."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], is_still, [False]]).astype(int)))
    return [(int(first), int(last)) for first, last in zip(edges[::2], edges[1::2], strict=True)]


def _bursts(first: int, last: int, params: StillParams) -> list[Moment]:
    first = max(first, 0)
    if last - first < params.least_frames:
        return []
    if last - first < params.apart_frames + params.n_frames:
        # The hands come to rest after they arrive, and leave before the change is seen.
        spare = max(last - first - params.n_frames, 0)
        begin = first + spare // 2
        return [Moment(begin, min(begin + params.n_frames, last))]
    begins = range(first, last - params.n_frames + 1, params.apart_frames)
    return [Moment(begin, begin + params.n_frames) for begin in begins]
