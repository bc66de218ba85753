"""What is known of one person at the end of a recording, and how sure it is which side was seen."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from adibas.data.sentence import Sentence
from adibas.data.skeleton_track import SkeletonTrack
from adibas.skeleton.following import ChosenJoints, PersonFollower
from adibas.skeleton.sides import SideParams, sideways
from adibas.texts import message

MOST_AGAINST = 0.1
"""Share of the frames with sides against the view that is thought likelier."""
SIDES_UNSURE = message(
    "Left and right of person {person} may be exchanged: it is not sure whether the front or the "
    "back is seen. Where you know it, say so: adibas pose --view anterior, or posterior."
)


@dataclass(frozen=True, slots=True)
class PersonFacts:
    """What is known of one person at the end.

    Attributes
    ----------
    stature_m : float
        By the lengths of the bones.
    front_share : float
        Of the frames in which the front was thought to be seen.
    view_confidence : float
        How probably that was so, front or back, mean over the frames; 1 where it was declared.
    against_share : float
        Of the frames in which left and right were given as of the view that is less likely.
    n_exchanged : int
        Frames in which the sides were exchanged back.
    """

    stature_m: float
    front_share: float
    view_confidence: float
    against_share: float
    n_exchanged: int

    @property
    def is_view_sure(self) -> bool:
        """Say whether it is sure enough which side is seen, and so which limbs are left."""
        least = SideParams().told_share
        return self.view_confidence >= least and self.against_share <= MOST_AGAINST


def facts_of(
    follower: PersonFollower, frames: Sequence[ChosenJoints], sides: SideParams
) -> PersonFacts:
    """Return what is known of somebody in some frames; axes of a camera that stands upright."""
    front = np.array([one.front_probability for one in frames])
    is_front = front > 0.5  # noqa: PLR2004  (more likely than not)
    shown = np.array([sideways(one.joints_m, sides.wide_share) for one in frames])
    return PersonFacts(
        follower.size.stature_m,
        float(is_front.mean()),
        float(np.maximum(front, 1.0 - front).mean()),
        float(((shown != 0) & ((shown > 0) != is_front)).mean()),
        follower.sides.n_exchanged,
    )


def unsure_sides(
    tracks: Sequence[SkeletonTrack], facts: Sequence[PersonFacts]
) -> tuple[Sentence, ...]:
    """Return a sentence for everybody of whom it is not sure which limbs are left."""
    pairs = zip(tracks, facts, strict=True)
    unsure = [track.person for track, one in pairs if not one.is_view_sure]
    return tuple(Sentence(SIDES_UNSURE, {"person": person}) for person in unsure)
