"""How each person of a session moved: over all of it, and under each of its conditions."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from adibas.behaviour.activity import (
    ActivityParams,
    JointActivity,
    Steps,
    activity,
    steps_of,
    tells_noise,
)
from adibas.behaviour.bands import BandPower, band_power
from adibas.behaviour.budget import Span, condition_spans
from adibas.data.coding import MS_PER_S, Section
from adibas.data.joints import JOINT_NAMES
from adibas.data.sentence import Sentence
from adibas.data.skeleton_track import SkeletonTrack
from adibas.texts import message

UNSEEN_WHILE_STILL = message(
    "These joints of person {person} were seen too shortly in the still time, or not at all: "
    "{joints}. Their noise is told without it."
)


@dataclass(frozen=True, slots=True, eq=False)
class PersonActivity:
    """How one person moved.

    Attributes
    ----------
    person : int
    steps : Steps
    joints : tuple of JointActivity
        Over the whole session.
    bands : BandPower
    by_condition : tuple of (name, tuple of JointActivity)
        The untagged rest as an empty name; nothing where no section is tagged.
    """

    person: int
    steps: Steps
    joints: tuple[JointActivity, ...]
    bands: BandPower
    by_condition: tuple[tuple[str, tuple[JointActivity, ...]], ...]


def subject_of(person: int) -> str:
    """Return the subject that a person of a recording is."""
    return f"person {person}"


def activity_of(
    track: SkeletonTrack, sections: Sequence[Section], session_ms: Span, params: ActivityParams
) -> PersonActivity:
    """Return how one person moved in a session with sections."""
    steps = steps_of(track, params)
    bands = band_power(track, steps.noise_m)
    by_condition = _by_condition(steps, sections, session_ms)
    return PersonActivity(track.person, steps, activity(steps), bands, by_condition)


def unseen_while_still(person: PersonActivity, params: ActivityParams) -> list[Sentence]:
    """Say for which joints the still time is of no use; those that never appear have no noise."""
    if params.still_s is None:
        return []
    is_untold = person.steps.seen.any(axis=0) & ~tells_noise(person.steps, params.still_s)
    names = [JOINT_NAMES[joint].replace("_", " ") for joint in np.flatnonzero(is_untold)]
    told = {"person": person.person, "joints": ", ".join(names)}
    return [Sentence(UNSEEN_WHILE_STILL, told)] if names else []


def under_conditions(
    person: PersonActivity, sections: Sequence[Section], session_ms: Span
) -> PersonActivity:
    """Return the same movement, divided by other sections."""
    return replace(person, by_condition=_by_condition(person.steps, sections, session_ms))


def _by_condition(
    steps: Steps, sections: Sequence[Section], session_ms: Span
) -> tuple[tuple[str, tuple[JointActivity, ...]], ...]:
    return tuple(
        (name, activity(steps, [(begin / MS_PER_S, end / MS_PER_S) for begin, end in some]))
        for name, some in condition_spans(sections, session_ms).items()
    )
