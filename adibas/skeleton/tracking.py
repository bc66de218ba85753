"""Names of the points of a movement: what a point is called before and after counts, too.

Points are followed by where they would be next, forwards and backwards; each followed point gathers
what every frame says of its name, so that one clear frame names it also in those where it is
ambiguous. A point that comes back within a second where it was expected goes on with what had been
gathered.
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from adibas.arrays import FloatArray, IntArray
from adibas.shapes.assignment_kernels import assign
from adibas.skeleton.namer import Namer


@dataclass(frozen=True, slots=True)
class TrackingParams:
    """Settings of following.

    Attributes
    ----------
    reach_m : float
        From where a point is expected: 60 mm, and
    speed_m_per_s : float
        for each second since it was last seen so many metres more: 2.
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
    lost_s: float = 1.0
    memory_s: float = 2.0
    evidence_per_s: float = 10.0
    least_mass: float = 0.01
    sure: float = 0.75


@dataclass(slots=True)
class _Track:
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
class TrackedNames:
    """Names of the M points of one frame.

    Attributes
    ----------
    names : tuple of str or None
        None where it is not sure.
    guesses : tuple of str or None
        The most probable names, however unsure; None: most probably none of the model's.
    confidences : (M,) array
        Of the guesses, 0 to 1.
    """

    names: tuple[str | None, ...]
    guesses: tuple[str | None, ...]
    confidences: FloatArray


class _Tracks:
    """Points that are followed one way through time, and what was said of each."""

    def __init__(self, params: TrackingParams) -> None:
        self._params = params
        self._tracks: list[_Track] = []

    def follow(self, points_m: FloatArray, time_s: float, words: FloatArray) -> FloatArray:
        """Return what frames before said of (M, D) points: logarithms (M, N + 1), 0 of new ones.

        `words` is what this frame says of them.
        """
        params = self._params
        self._tracks = [t for t in self._tracks if time_s - t.seen_s <= params.lost_s]
        gathered = np.zeros_like(words)
        for i, owner in enumerate(self._linked(points_m, time_s)):
            if owner < 0:
                still = np.zeros_like(points_m[i])
                self._tracks.append(_Track(points_m[i], time_s, still, words[i]))
                continue
            track = self._tracks[owner]
            passed_s = time_s - track.seen_s
            gathered[i] = math.exp(-passed_s / params.memory_s) * track.evidence
            weight = min(1.0, passed_s * params.evidence_per_s)
            track.evidence = gathered[i] + weight * words[i]
            track.see(points_m[i], time_s)
        return gathered

    def _linked(self, points_m: FloatArray, time_s: float) -> IntArray:
        """Return for each point the index of its track, -1 for a new one."""
        if not self._tracks or not len(points_m):
            return np.full(len(points_m), -1)
        expected = np.stack([track.expected_m(time_s) for track in self._tracks])
        since = np.array([time_s - track.seen_s for track in self._tracks])
        reach = self._params.reach_m + self._params.speed_m_per_s * since
        apart = np.linalg.norm(points_m[:, None] - expected[None], axis=-1)
        return assign(np.ascontiguousarray((apart / reach) ** 2 - 1.0))


def name_movement(
    namer: Namer,
    frames_m: Iterable[FloatArray],
    times_s: Iterable[float],
    view: str = "",
    params: TrackingParams | None = None,
    given: Sequence[Sequence[str]] | None = None,
) -> tuple[TrackedNames, ...]:
    """Name the points of a whole recording: what earlier and later frames say of each counts.

    Parameters
    ----------
    frames_m : iterable of (M, D) arrays
        Of each frame, metres, y down; M may differ, and be 0.
    times_s : iterable of float
        Ascending.
    view : str
        As declared; empty: inferred.
    given : sequence of sequence of str, or None
        Of each point of each frame the name that it has already, or an empty one; see
        `Namer.label`.
    """
    params = params or TrackingParams()
    onward, backward = _Tracks(params), _Tracks(params)
    frames = []
    before = []
    for number, (points_m, time_s) in enumerate(zip(frames_m, times_s, strict=True)):
        known = () if given is None else given[number]
        masses = namer.label(points_m, view, given=known).masses
        words = np.log(np.maximum(masses, params.least_mass))
        frames.append((points_m, time_s, words))
        before.append(onward.follow(points_m, time_s, words))
    after = [backward.follow(points_m, -time_s, words) for points_m, time_s, words in frames[::-1]]
    return tuple(
        _named(earlier + words + later, namer.names, params.sure)
        for (_points, _time, words), earlier, later in zip(frames, before, after[::-1], strict=True)
    )


def _named(evidence: FloatArray, names: tuple[str, ...], sure: float) -> TrackedNames:
    """Give each name to the point that has gathered most for it."""
    if not len(evidence):
        return TrackedNames((), (), np.zeros(0))
    chosen = assign(np.ascontiguousarray(evidence[:, -1:] - evidence[:, :-1]))
    shares = np.exp(evidence - evidence.max(axis=1, keepdims=True))
    shares /= shares.sum(axis=1, keepdims=True)
    confidences = shares[np.arange(len(evidence)), chosen]  # -1, no name, is the last one as well
    guesses = tuple(names[i] if i >= 0 else None for i in chosen)
    given = tuple(
        guess if c >= sure else None for guess, c in zip(guesses, confidences, strict=True)
    )
    return TrackedNames(given, guesses, confidences)
