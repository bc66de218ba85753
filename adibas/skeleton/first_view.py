"""From which side somebody is seen at first, where nobody declared it: the markers' names tell.

A frame alone seldom tells left from right; of a movement some do. Each of these tells a heading,
and how far the points turned since the first frame, whatever they are called, what it was then.
"""

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass

from adibas.skeleton.followed_view import nearest_view, turn_about_vertical
from adibas.skeleton.namer import Namer
from adibas.skeleton.point_tracks import PointTracks, TrackingParams, words_of
from adibas.skeleton.told_heading import tells_heading
from adibas.skeleton.tracking import MovingPoints

LEAST_TELLING, AGREED = 3, 0.9
"""So many frames must tell it, and this share of all that tell any side."""


@dataclass(frozen=True, slots=True)
class FirstView:
    """The side that is seen in the first of some frames.

    Attributes
    ----------
    view : str
        One of `HEADINGS_RAD`.
    n_telling : int
        In how many frames the names tell it.
    """

    view: str
    n_telling: int


def first_view(namer: Namer, frames: Iterable[MovingPoints]) -> FirstView | None:
    """Return from which side somebody is seen at first; None where the names do not tell surely.

    Parameters
    ----------
    namer : Namer
        Of names with sides.
    frames : iterable of MovingPoints
        In space, in the order of time, about a tenth of a second apart.
    """
    params = TrackingParams()
    tracks, turned_rad = PointTracks(params), 0.0
    told: Counter[str] = Counter()
    for frame in frames:
        labelling = namer.label(frame.points_m, given=frame.given)
        words = words_of(labelling.masses, params)
        followed = tracks.follow(frame.points_m, frame.time_s, words)
        turn = turn_about_vertical(followed.before_m, frame.points_m)
        turned_rad += 0.0 if turn is None else turn.angle_rad
        if tells_heading(labelling):
            told[nearest_view(labelling.heading_rad - turned_rad)] += 1
    if not told:
        return None
    ((view, n_telling),) = told.most_common(1)
    is_sure = n_telling >= max(LEAST_TELLING, AGREED * told.total())
    return FirstView(view, n_telling) if is_sure else None
