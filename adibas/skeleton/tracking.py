"""Names of the points of a movement: what a point is called before and after counts, too.

Points are followed by where they would be next, forwards and backwards, and by what they are
called; each followed point gathers what every frame says of its name, so that one clear frame names
it also in those where it is ambiguous. A point that comes back within a second where it was
expected goes on with what had been gathered.
"""

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from adibas.arrays import FloatArray, IntArray
from adibas.shapes.assignment_kernels import assign
from adibas.skeleton.body_marks import BodyOdds
from adibas.skeleton.followed_view import FollowedView
from adibas.skeleton.namer import Namer
from adibas.skeleton.starts import SPACE

SeenFrom: TypeAlias = Callable[[str], BodyOdds | None]
"""Takes the view from which somebody is seen; returns what the body tells, None where nothing."""


@dataclass(frozen=True, slots=True, eq=False)
class MovingPoints:
    """The points of one frame.

    Attributes
    ----------
    points_m : (M, D) array
        Upright, y down; M may be 0.
    time_s : float
    given : sequence of str
        The name that each point has already, or an empty one; see `Namer.label`.
    body : callable or None
        Tells what is known of the body; None: nothing.
    """

    points_m: FloatArray
    time_s: float
    given: Sequence[str] = ()
    body: SeenFrom | None = None


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


TOO_FAR = 1.0
"""What it costs to take a point for one that cannot be it; a new point costs nothing."""


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


@dataclass(frozen=True, slots=True, eq=False)
class _Followed:
    """Of the M points of a frame: what frames before said of them, and where they were.

    `gathered`: logarithms (M, N + 1), 0 of new points; `before_m`: (M, D) in the frame right
    before, NaN where they were not seen.
    """

    gathered: FloatArray
    before_m: FloatArray


class _Tracks:
    """Points that are followed one way through time, and what was said of each."""

    def __init__(self, params: TrackingParams) -> None:
        self._params = params
        self._tracks: list[_Track] = []
        self._latest_s = math.nan

    def follow(self, points_m: FloatArray, time_s: float, words: FloatArray) -> _Followed:
        """Go on to the (M, D) points of the next frame; `words` is what it says of them."""
        params = self._params
        self._tracks = [t for t in self._tracks if time_s - t.seen_s <= params.lost_s]
        gathered, before_m = np.zeros_like(words), np.full_like(points_m, np.nan)
        for i, owner in enumerate(self._linked(points_m, time_s, words)):
            if owner < 0:
                still = np.zeros_like(points_m[i])
                self._tracks.append(_Track(points_m[i], time_s, still, words[i]))
                continue
            track = self._tracks[owner]
            if track.seen_s == self._latest_s:
                before_m[i] = track.position_m
            gathered[i] = self._left_of(track, time_s)
            weight = min(1.0, (time_s - track.seen_s) * params.evidence_per_s)
            track.evidence = gathered[i] + weight * words[i]
            track.see(points_m[i], time_s)
        self._latest_s = time_s
        return _Followed(gathered, before_m)

    def _left_of(self, track: _Track, time_s: float) -> FloatArray:
        """Return what is left of all that was said of a point."""
        return math.exp(-(time_s - track.seen_s) / self._params.memory_s) * track.evidence

    def _linked(self, points_m: FloatArray, time_s: float, words: FloatArray) -> IntArray:
        """Return for each point the index of its track, -1 for a new one.

        The likeliest assignment: the odds that a point is one of before are those of its place
        (Cauchy's distribution in three dimensions), and of what both are called: the sum of
        p(n) q(n) / prior(n) over names, all names alike probable before.
        """
        if not self._tracks or not len(points_m):
            return np.full(len(points_m), -1)
        params = self._params
        expected = np.stack([track.expected_m(time_s) for track in self._tracks])
        since = np.array([time_s - track.seen_s for track in self._tracks])
        apart_m = np.linalg.norm(points_m[:, None] - expected[None], axis=-1)
        said = _shares(np.stack([self._left_of(track, time_s) for track in self._tracks]))
        alike = np.log(_shares(words) @ said.T * words.shape[1])
        odds = params.nearness - 2.0 * np.log1p((apart_m / params.spread_m) ** 2)
        odds += params.agreement * alike
        is_in_reach = apart_m < params.reach_m + params.speed_m_per_s * since
        return assign(np.where(is_in_reach, -odds, TOO_FAR))


def _shares(logs: FloatArray) -> FloatArray:
    """Return (M, N) logarithms as shares of one in each row."""
    shares = np.exp(logs - logs.max(axis=1, keepdims=True))
    return np.asarray(shares / shares.sum(axis=1, keepdims=True))


def name_movement(
    namer: Namer,
    frames: Iterable[MovingPoints],
    view: str = "",
    params: TrackingParams | None = None,
) -> tuple[TrackedNames, ...]:
    """Name the points of a whole recording: what earlier and later frames say of each counts.

    Parameters
    ----------
    frames : iterable of MovingPoints
        In the order of time; each is asked for its body before the next one is taken.
    view : str
        Which side is seen in the first frame, as declared; empty: inferred in each.
    """
    params = params or TrackingParams()
    onward, backward = _Tracks(params), _Tracks(params)
    seen_from = FollowedView(view)
    said = []
    before = []
    for frame in frames:
        words = np.log(np.maximum(_masses(namer, frame, seen_from), params.least_mass))
        said.append((frame.points_m, frame.time_s, words))
        followed = onward.follow(frame.points_m, frame.time_s, words)
        seen_from.turn(followed.before_m, frame.points_m)
        before.append(followed.gathered)
    after = [
        backward.follow(points_m, -time_s, words).gathered for points_m, time_s, words in said[::-1]
    ]
    return tuple(
        _named(earlier + words + later, namer.names, params.sure)
        for (_points, _time, words), earlier, later in zip(said, before, after[::-1], strict=True)
    )


def _masses(namer: Namer, frame: MovingPoints, seen_from: FollowedView) -> FloatArray:
    """Return what a frame says of its points, and go on to the view that it shows."""
    if frame.points_m.shape[1] == SPACE:  # in a plane nobody turns
        seen_from.go_to(frame.time_s)
    body = None
    if frame.body is not None and seen_from.is_square and len(frame.points_m):
        body = frame.body(seen_from.view)
    teller = namer if body is None else namer.who_sees(body)
    labelling = teller.label(frame.points_m, seen_from.view, given=frame.given)
    seen_from.learn(labelling)
    return labelling.masses


def _named(evidence: FloatArray, names: tuple[str, ...], sure: float) -> TrackedNames:
    """Give each name to the point that has gathered most for it."""
    if not len(evidence):
        return TrackedNames((), (), np.zeros(0))
    chosen = assign(np.ascontiguousarray(evidence[:, -1:] - evidence[:, :-1]))
    # -1, no name, is the last one as well.
    confidences = _shares(evidence)[np.arange(len(evidence)), chosen]
    guesses = tuple(names[i] if i >= 0 else None for i in chosen)
    given = tuple(
        guess if c >= sure else None for guess, c in zip(guesses, confidences, strict=True)
    )
    return TrackedNames(given, guesses, confidences)
