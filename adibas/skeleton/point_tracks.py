"""Points that are followed from frame to frame, and what was said of the name of each.

A point is taken for one of before by where that one would be now, and by what both are called; it
goes on with what had been gathered. One that comes back within a second where it was expected does,
too.
"""

import math
from dataclasses import dataclass

import numpy as np

from adibas.arrays import FloatArray
from adibas.shapes.assignment_kernels import assign


@dataclass(frozen=True, slots=True)
class TrackingParams:
    """Settings of following; most were chosen on simulated films (docs/skeleton.md).

    Attributes
    ----------
    reach_m : float
        No point is taken for one that was expected farther away: 60 mm, and
    speed_m_per_s : float
        for each second since it was last seen so many metres more: 2.
    spread_m : float
        Of the way to where it was expected: 30 mm; far ones are more frequent than a normal
        distribution has them.
    nearness : float
        Log odds of being the same that a point tells which is where one was expected: 5.
    agreement : float
        How much it counts that both are called the same: 0.7.
    lost_s : float
        After which a point is forgotten: 1.
    memory_s : float
        Time in which what was gathered fades to a third: 2.
    evidence_per_s : float
        How many frames' words count in a second: 10; frames close to one another say the same.
    least_mass : float
        A frame never says less than this of a name: 0.01.
    sure : float
        Least confidence of a name that is given: 0.75.
    """

    reach_m: float = 0.06
    speed_m_per_s: float = 2.0
    spread_m: float = 0.03
    nearness: float = 5.0
    agreement: float = 0.7
    lost_s: float = 1.0
    memory_s: float = 2.0
    evidence_per_s: float = 10.0
    least_mass: float = 0.01
    sure: float = 0.75


SOMEBODY = 0.5
"""A frame in which no point has a name more probably than this shows nobody."""
TOO_FAR = 1.0
"""What it costs to take a point for one that cannot be it; a new point costs nothing."""


@dataclass(slots=True)
class _Track:
    number: int
    position_m: FloatArray
    seen_s: float
    velocity_m_per_s: FloatArray
    evidence: FloatArray

    def expected_m(self, time_s: float) -> FloatArray:
        """Return where it would be; its speed is believed for a tenth of a second."""
        ahead_s = min(time_s - self.seen_s, 0.1)
        return np.asarray(self.position_m + self.velocity_m_per_s * ahead_s)

    def see(self, position_m: FloatArray, time_s: float) -> None:
        """Go on to where it is now."""
        passed_s = max(time_s - self.seen_s, 1e-6)
        self.velocity_m_per_s = (position_m - self.position_m) / passed_s
        self.position_m, self.seen_s = position_m, time_s


@dataclass(frozen=True, slots=True, eq=False)
class Followed:
    """Of the M points of a frame: what frames before said of them, and where they were.

    Attributes
    ----------
    numbers : tuple of int
        A point has the same one in every frame.
    gathered : (M, N + 1) array
        Logarithms, 0 of new points.
    before_m : (M, D) array
        Where they were in the frame right before, NaN where they were not seen.
    """

    numbers: tuple[int, ...]
    gathered: FloatArray
    before_m: FloatArray


class PointTracks:
    """Points that are followed one way through time, and what was said of each."""

    def __init__(self, params: TrackingParams) -> None:
        self._params = params
        self._tracks: list[_Track] = []
        self._n_begun = 0
        self._latest_s = math.nan

    def follow(self, points_m: FloatArray, time_s: float, words: FloatArray) -> Followed:
        """Go on to the (M, D) points of the next frame; `words` is what it says of them."""
        params = self._params
        self._tracks = [t for t in self._tracks if time_s - t.seen_s <= params.lost_s]
        numbers, gathered, before_m = [], np.zeros_like(words), np.full_like(points_m, np.nan)
        for i, track in enumerate(self._owners(points_m, time_s, words)):
            if track is None:
                numbers.append(self._begin(points_m[i], time_s, words[i]))
                continue
            numbers.append(track.number)
            if track.seen_s == self._latest_s:
                before_m[i] = track.position_m
            gathered[i] = self._left_of(track, time_s)
            weight = min(1.0, (time_s - track.seen_s) * params.evidence_per_s)
            track.evidence = gathered[i] + weight * words[i]
            track.see(points_m[i], time_s)
        self._latest_s = time_s
        return Followed(tuple(numbers), gathered, before_m)

    def _begin(self, position_m: FloatArray, time_s: float, words: FloatArray) -> int:
        """Follow a new point; return its number."""
        number = self._n_begun
        self._n_begun += 1
        self._tracks.append(_Track(number, position_m, time_s, np.zeros_like(position_m), words))
        return number

    def _left_of(self, track: _Track, time_s: float) -> FloatArray:
        """Return what is left of all that was said of a point."""
        return math.exp(-(time_s - track.seen_s) / self._params.memory_s) * track.evidence

    def _owners(
        self, points_m: FloatArray, time_s: float, words: FloatArray
    ) -> list[_Track | None]:
        """Return for each point its track, None for a new one.

        The likeliest assignment: the odds that a point is one of before are those of its place
        (Cauchy's distribution in three dimensions), and of what both are called: the sum of
        p(n) q(n) / prior(n) over names, all names alike probable before.
        """
        if not self._tracks or not len(points_m):
            return [None] * len(points_m)
        params = self._params
        expected = np.stack([track.expected_m(time_s) for track in self._tracks])
        since = np.array([time_s - track.seen_s for track in self._tracks])
        apart_m = np.linalg.norm(points_m[:, None] - expected[None], axis=-1)
        said = shares_of(np.stack([self._left_of(track, time_s) for track in self._tracks]))
        alike = np.log(shares_of(words) @ said.T * words.shape[1])
        odds = params.nearness - 2.0 * np.log1p((apart_m / params.spread_m) ** 2)
        odds += params.agreement * alike
        is_in_reach = apart_m < params.reach_m + params.speed_m_per_s * since
        owners = assign(np.where(is_in_reach, -odds, TOO_FAR)).tolist()
        return [self._tracks[owner] if owner >= 0 else None for owner in owners]


def shares_of(logs: FloatArray) -> FloatArray:
    """Return (M, N) logarithms as shares of one in each row."""
    shares = np.exp(logs - logs.max(axis=1, keepdims=True))
    return np.asarray(shares / shares.sum(axis=1, keepdims=True))


def words_of(masses: FloatArray, params: TrackingParams) -> FloatArray:
    """Return the logarithms (M, N + 1) of what a frame says of each name, and of none.

    Where nobody is found among the points it says nothing: they are still what they were before.
    """
    is_somebody = (masses[:, :-1].sum(axis=1) > SOMEBODY).any()
    if not is_somebody:
        return np.zeros_like(masses)
    return np.log(np.maximum(masses, params.least_mass))
