"""When a session is, and which times of it are told: conditions, and a time to be still in."""

from collections.abc import Sequence

import numpy as np

from adibas.behaviour.activity import Seconds
from adibas.behaviour.budget import Span
from adibas.data.coding import MS_PER_S, Coding, Section, whole_ms
from adibas.data.skeleton_track import SkeletonTrack
from adibas.errors import BehaviourError


def in_ms(span_s: Seconds) -> Span:
    """Return a span of time in whole milliseconds."""
    return whole_ms(span_s[0]), whole_ms(span_s[1])


def session_of(tracks: Sequence[SkeletonTrack], observed: Coding | None) -> Span:
    """Return the time that joints or the observer cover."""
    begin = min(float(track.times_s[0]) for track in tracks) * MS_PER_S
    end = max(float(track.times_s[-1]) for track in tracks) * MS_PER_S
    if observed is None:
        return int(np.floor(begin)), int(np.ceil(end))
    return min(int(np.floor(begin)), observed.begin_ms), max(int(np.ceil(end)), observed.end_ms)


def sections_of(
    told: Sequence[tuple[str, float, float]], observed: Coding | None, session_ms: Span
) -> tuple[Section, ...]:
    """Return what was told as (name, begin_s, end_s), and the observer's, in the order of time.

    Raises
    ------
    BehaviourError
        A section overlaps with another one, or lies outside the session.
    """
    named = [Section(name, *in_ms((begin, end))) for name, begin, end in told]
    found = sorted(
        [*named, *(() if observed is None else observed.sections)], key=lambda one: one.begin_ms
    )
    latest = session_ms[0]
    for one in found:
        if not latest <= one.begin_ms <= one.end_ms <= session_ms[1]:
            raise BehaviourError(
                "The section {name} from {begin} to {end} s overlaps with another one, or lies "
                "outside the recording ({first} to {last} s). Correct its times.",
                name=one.name,
                begin=one.begin_ms / MS_PER_S,
                end=one.end_ms / MS_PER_S,
                first=session_ms[0] / MS_PER_S,
                last=session_ms[1] / MS_PER_S,
            )
        latest = one.end_ms
    return tuple(found)


def check_still(still_s: Seconds, session_ms: Span) -> None:
    """See that nobody is to be still when nothing was recorded.

    Raises
    ------
    BehaviourError
        The still time lies outside the session.
    """
    begin_ms, end_ms = in_ms(still_s)
    if not session_ms[0] <= begin_ms <= end_ms <= session_ms[1]:
        raise BehaviourError(
            "The still time from {begin} to {end} s lies outside the recording ({first} to {last} "
            "s). Correct its times.",
            begin=begin_ms / MS_PER_S,
            end=end_ms / MS_PER_S,
            first=session_ms[0] / MS_PER_S,
            last=session_ms[1] / MS_PER_S,
        )
