"""Names of the points of a movement: what a point is called before and after counts, too.

Points are followed (`PointTracks`), in a recording forwards and backwards; each gathers what every
frame says of its name, so that one clear frame names it also in those where it is ambiguous.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np

from adibas.arrays import FloatArray
from adibas.shapes.assignment_kernels import assign
from adibas.skeleton.body_marks import BodyOdds
from adibas.skeleton.followed_view import FollowedView
from adibas.skeleton.labelling import Labelling
from adibas.skeleton.namer import Namer
from adibas.skeleton.point_tracks import PointTracks, TrackingParams, shares_of, words_of
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


class NamesSoFar:
    """Names of points that are seen live: what frames before said of each counts, too.

    A name is carried on, and not made up of many frames none of which was sure: those of somebody
    who holds still all say the same.

    Parameters
    ----------
    names : tuple of str
        That points can get.
    params : TrackingParams or None
    """

    def __init__(self, names: tuple[str, ...], params: TrackingParams | None = None) -> None:
        self._names, self._params = names, params or TrackingParams()
        self._tracks = PointTracks(self._params)
        self._sure_s: dict[tuple[int, str], float] = {}

    def hear(self, points_m: FloatArray, time_s: float, labelling: Labelling) -> TrackedNames:
        """Go on to the (M, D) points of the next frame; `labelling` is what it says of them."""
        words = words_of(labelling.masses, self._params)
        followed = self._tracks.follow(points_m, time_s, words)
        called = list(zip(followed.numbers, labelling.names, strict=True))
        self._sure_s |= {(number, name): time_s for number, name in called if name is not None}
        since_s = time_s - self._params.memory_s
        self._sure_s = {key: seen_s for key, seen_s in self._sure_s.items() if seen_s >= since_s}
        named = _named(followed.gathered + words, self._names, self._params.sure)
        names = tuple(
            name if name is not None and (number, name) in self._sure_s else None
            for number, name in zip(followed.numbers, named.names, strict=True)
        )
        return replace(named, names=names)


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
    onward, backward = PointTracks(params), PointTracks(params)
    seen_from = FollowedView(view)
    said = []
    before = []
    for frame in frames:
        words = words_of(_labelling(namer, frame, seen_from).masses, params)
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


def _labelling(namer: Namer, frame: MovingPoints, seen_from: FollowedView) -> Labelling:
    """Return what a frame alone says of its points, and go on to the view that it shows."""
    if frame.points_m.shape[1] == SPACE:  # in a plane nobody turns
        seen_from.go_to(frame.time_s)
    body = None
    if frame.body is not None and seen_from.is_square and len(frame.points_m):
        body = frame.body(seen_from.view)
    teller = namer if body is None else namer.who_sees(body)
    labelling = teller.label(frame.points_m, seen_from.view, given=frame.given)
    seen_from.learn(labelling)
    return labelling


def _named(evidence: FloatArray, names: tuple[str, ...], sure: float) -> TrackedNames:
    """Give each name to the point that has gathered most for it."""
    if not len(evidence):
        return TrackedNames((), (), np.zeros(0))
    chosen = assign(np.ascontiguousarray(evidence[:, -1:] - evidence[:, :-1]))
    # -1, no name, is the last one as well.
    confidences = shares_of(evidence)[np.arange(len(evidence)), chosen]
    guesses = tuple(names[i] if i >= 0 else None for i in chosen)
    given = tuple(
        guess if c >= sure else None for guess, c in zip(guesses, confidences, strict=True)
    )
    return TrackedNames(given, guesses, confidences)
