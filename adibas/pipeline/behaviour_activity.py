"""How each person of a session moved: over all of it, and under each of its conditions."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from adibas.behaviour.activity import ActivityParams, JointActivity, Steps, activity, steps_of
from adibas.behaviour.bands import BandPower, band_power
from adibas.behaviour.budget import Span, condition_spans
from adibas.data.coding import MS_PER_S, Section
from adibas.data.skeleton_track import SkeletonTrack


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
