"""A track as the recognition sees it, at a steady rate: all of it, or what is asked for."""

from dataclasses import dataclass
from typing import Generic, Protocol, TypeVar

import numpy as np

from adibas.arrays import FloatArray
from adibas.data.joints import JOINT_NAMES
from adibas.data.skeleton_track import SkeletonTrack
from adibas.gestures.descriptor import (
    LONGEST_HIDDEN_S,
    NECK,
    SHOULDERS,
    DescriptorParams,
    averaged,
    described,
    differences,
    facing_vectors,
    limb_lengths,
    necks,
    resampled,
    size_of_limbs,
    smoothed,
)

BLOCK = 2048
"""Frames that are described at once."""
MARGIN = 2
"""Frames beside a piece that smoothing and differences look at."""


class Frames(Protocol):
    """Descriptors of a stream, of which pieces are asked for."""

    def __len__(self) -> int: ...
    def __getitem__(self, part: slice, /) -> FloatArray: ...


FramesT_co = TypeVar("FramesT_co", bound=Frames, covariant=True)


@dataclass(frozen=True, slots=True, eq=False)
class DescribedTrack(Generic[FramesT_co]):
    """A track as the recognition sees it.

    Attributes
    ----------
    begin_s : float
        Time of the first frame on the recording's clock.
    rate_hz : float
    frames : (n, d) array, or what gives pieces of it
        Descriptors, NaN where not seen.
    """

    begin_s: float
    rate_hz: float
    frames: FramesT_co

    def index_at(self, time_s: float) -> int:
        """Return the frame nearest to `time_s`, within the track."""
        index = round((time_s - self.begin_s) * self.rate_hz)
        return min(max(index, 0), len(self.frames) - 1)

    def time_s(self, index: int) -> float:
        """Return when frame `index` was."""
        return self.begin_s + index / self.rate_hz

    def cut(self, begin_s: float, end_s: float) -> FloatArray:
        """Return the descriptors from `begin_s` to `end_s`, both included."""
        return self.frames[self.index_at(begin_s) : self.index_at(end_s) + 1]


def describe(track: SkeletonTrack, params: DescriptorParams) -> DescribedTrack[FloatArray]:
    """Return the descriptors of a track at a steady rate.

    Raises
    ------
    ValueError
        The track has no frames.
    """
    frames = FramesOnDemand(track, params)[:]
    return DescribedTrack(float(track.times_s[0]), params.rate_hz, frames)


def described_in_pieces(
    track: SkeletonTrack, params: DescriptorParams
) -> DescribedTrack["FramesOnDemand"]:
    """Return the same as `describe`, each piece made when it is asked for; see `FramesOnDemand`."""
    frames = FramesOnDemand(track, params)
    return DescribedTrack(float(track.times_s[0]), params.rate_hz, frames)


class FramesOnDemand:
    """Descriptors of hours, in little more memory than the track itself takes.

    Parameters
    ----------
    track : SkeletonTrack
        Of one frame at least.
    params : DescriptorParams
    """

    def __init__(self, track: SkeletonTrack, params: DescriptorParams) -> None:
        if not len(track):
            raise ValueError("a track without frames cannot be described")
        self._joints_m = track.joints_m
        self._times_s = track.times_s - track.times_s[0]
        self._params = params
        self._length = int(self._times_s[-1] * params.rate_hz + 1e-6) + 1
        whole = slice(0, self._length)
        self._necks_m = necks(
            self._at_rate(whole, [NECK])[:, 0],
            self._at_rate(whole, list(SHOULDERS)),
            round(LONGEST_HIDDEN_S * params.rate_hz),
        )
        limbs_m, facing = [], []
        for at in range(0, self._length, BLOCK):
            joints_m = self._all_joints(slice(at, min(at + BLOCK, self._length)))
            limbs_m.append(limb_lengths(joints_m))
            facing.append(facing_vectors(joints_m))
        self._size = size_of_limbs(np.concatenate(limbs_m))
        self._facing = None
        if params.facing_s:
            n_averaged = round(params.facing_s * params.rate_hz)
            self._facing = averaged(np.concatenate(facing), n_averaged)
        self._latest: tuple[int, FloatArray] = (-1, np.empty((0, params.n_numbers)))

    def __len__(self) -> int:
        return self._length

    def __getitem__(self, part: slice) -> FloatArray:
        begin, end, _step = part.indices(self._length)
        first, last = begin // BLOCK, max(end - 1, 0) // BLOCK
        if first != last:
            return self._described(begin, end)
        if self._latest[0] != first:
            self._latest = (first, self._described(first * BLOCK, (first + 1) * BLOCK))
        return self._latest[1][begin - first * BLOCK : max(end - first * BLOCK, 0)]

    def _described(self, begin: int, end: int) -> FloatArray:
        """Return what smoothing and differences over the neighbours make of the frames."""
        first, last = max(begin - MARGIN, 0), min(end + MARGIN, self._length)
        facing = None if self._facing is None else self._facing[first:last]
        joints_m = self._all_joints(slice(first, last))
        frames = smoothed(described(joints_m, self._size, facing))
        if self._params.velocity_s:
            factor = self._params.velocity_s * self._params.rate_hz
            frames = np.concatenate([frames, factor * differences(frames)], axis=1)
        return frames[begin - first : end - first]

    def _all_joints(self, part: slice) -> FloatArray:
        joints_m = self._at_rate(part, list(range(len(JOINT_NAMES))))
        joints_m[:, NECK] = self._necks_m[part]
        return joints_m

    def _at_rate(self, part: slice, joints: list[int]) -> FloatArray:
        """Return (n, joints, 3): some joints in frames of the steady rate."""
        wanted_s = np.arange(part.start, part.stop) / self._params.rate_hz
        reach_s = 2.0 * self._params.longest_gap_s
        bounds_s = wanted_s[0] - reach_s, wanted_s[-1] + reach_s
        begin, end = np.searchsorted(self._times_s, bounds_s)
        near_s, near_m = self._times_s[begin:end], self._joints_m[begin:end]
        longest_s = self._params.longest_gap_s
        found = [resampled(near_s, near_m[:, joint], wanted_s, longest_s) for joint in joints]
        return np.stack(found, axis=1)
