"""Names that last from frame to frame: what a point was called counts for what it is called.

Points are followed by where they would be next; each followed point gathers what every frame says
of its name, so that one clear frame names it also in those where it is ambiguous. A point that
comes back within a second where it was expected goes on with what had been gathered.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np

from adibas.arrays import FloatArray, IntArray
from adibas.shapes.assignment_kernels import assign
from adibas.skeleton.labelling import Labelling
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


@dataclass(frozen=True, slots=True)
class TrackedNames:
    """Names of the points of one frame.

    Attributes
    ----------
    names : tuple of str or None
        None where it is not sure.
    confidences : tuple of float
        Of the most probable names.
    labelling : Labelling
        What this frame alone says.
    evidence : (M, N + 1) array
        What was gathered for each point: logarithms, up to a constant of the point.
    """

    names: tuple[str | None, ...]
    confidences: tuple[float, ...]
    labelling: Labelling
    evidence: FloatArray


@dataclass(slots=True)
class NameTracker:
    """Names the points of a movement, one frame after the other.

    Attributes
    ----------
    namer : Namer
    view : str
        As declared; empty: inferred.
    """

    namer: Namer
    view: str = ""
    params: TrackingParams = field(default_factory=TrackingParams)
    _tracks: list[_Track] = field(default_factory=list)

    def follow(
        self, points_m: FloatArray, time_s: float, labelling: Labelling | None = None
    ) -> TrackedNames:
        """Name (M, D) points in metres, y down, of a frame later than the last one.

        `labelling` is what the frame alone says, where that is known already.
        """
        labelling = labelling or self.namer.label(points_m, self.view)
        self._tracks = [t for t in self._tracks if time_s - t.seen_s <= self.params.lost_s]
        owners = self._linked(points_m, time_s)
        said = np.log(np.maximum(labelling.masses, self.params.least_mass))
        tracks = []
        for point_m, owner, words in zip(points_m, owners, said, strict=True):
            if owner < 0:
                track = _Track(point_m, time_s, np.zeros_like(point_m), words)
                self._tracks.append(track)
            else:
                track = self._tracks[owner]
                passed_s = time_s - track.seen_s
                weight = min(1.0, passed_s * self.params.evidence_per_s)
                fade = math.exp(-passed_s / self.params.memory_s)
                track.evidence = fade * track.evidence + weight * words
                track.see(point_m, time_s)
            tracks.append(track)
        evidence = np.stack([track.evidence for track in tracks]) if tracks else said
        return _named(evidence, labelling, self.namer.names, self.params.sure)

    def _linked(self, points_m: FloatArray, time_s: float) -> IntArray:
        """Return for each point the index of its track, -1 for a new one."""
        if not self._tracks or not len(points_m):
            return np.full(len(points_m), -1)
        expected = np.stack([track.expected_m(time_s) for track in self._tracks])
        since = np.array([time_s - track.seen_s for track in self._tracks])
        reach = self.params.reach_m + self.params.speed_m_per_s * since
        apart = np.linalg.norm(points_m[:, None] - expected[None], axis=-1)
        return assign(np.ascontiguousarray((apart / reach) ** 2 - 1.0))


def name_movement(
    namer: Namer,
    frames_m: Sequence[FloatArray],
    times_s: Sequence[float],
    view: str = "",
    params: TrackingParams | None = None,
) -> Iterator[TrackedNames]:
    """Name the points of a whole recording: later frames say what earlier ones were, too.

    Parameters
    ----------
    frames_m : sequence of (M, D) arrays
        Of each frame, metres, y down; M may differ.
    times_s : sequence of float
        Ascending.
    """
    params = params or TrackingParams()
    onward = NameTracker(namer, view, params)
    first = [onward.follow(*frame) for frame in zip(frames_m, times_s, strict=True)]
    backward = NameTracker(namer, view, params)
    frames = list(zip(frames_m, times_s, first, strict=True))
    second = [
        backward.follow(points_m, -time_s, one.labelling)
        for points_m, time_s, one in reversed(frames)
    ]
    for before, after in zip(first, reversed(second), strict=True):
        evidence = before.evidence + after.evidence
        yield _named(evidence, before.labelling, namer.names, params.sure)


def _named(
    evidence: FloatArray, labelling: Labelling, names: tuple[str, ...], sure: float
) -> TrackedNames:
    """Give each name to the point that has gathered most for it."""
    if not len(evidence):
        return TrackedNames((), (), labelling, evidence)
    chosen = assign(np.ascontiguousarray(evidence[:, -1:] - evidence[:, :-1]))
    chosen = np.where(chosen < 0, len(names), chosen)
    shares = np.exp(evidence - evidence.max(axis=1, keepdims=True))
    shares /= shares.sum(axis=1, keepdims=True)
    confidences = shares[np.arange(len(evidence)), chosen]
    given = tuple(
        names[i] if i < len(names) and c >= sure else None
        for i, c in zip(chosen, confidences, strict=True)
    )
    return TrackedNames(given, tuple(float(c) for c in confidences), labelling, evidence)
