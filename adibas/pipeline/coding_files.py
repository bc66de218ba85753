"""Codings of other programs beside a recording, on its clock, and back."""

from dataclasses import replace
from pathlib import Path

from adibas.behaviour.budget import Span
from adibas.data.coding import Coding, Occurrence, Section, problems_of
from adibas.data.ethogram import Ethogram
from adibas.errors import BehaviourError
from adibas.recordings.codings import read_codings

SINCE_BEGIN = (".boris", ".tsv", ".eaf")
"""Programs of observers count from the video's begin."""


def read_for(path: Path, name: str, observed_ms: Span, ethogram: Ethogram | None = None) -> Coding:
    """Read the coding of a recording: that of its name, else the first of the file.

    Parameters
    ----------
    path : Path
    name : str
        Of the recording.
    observed_ms : (int, int)
        From when to when the recording lasts, on its clock.
    ethogram : Ethogram, optional
        In place of the file's own.

    Raises
    ------
    BehaviourError
        The file cannot be used, holds no session, or an event lies outside the recording.
    """
    found = read_codings(path, ethogram)
    if not found:
        raise BehaviourError("{file} holds no session.", file=path.name)
    chosen = next((one for one in found if one.name == name), found[0])
    begin_ms, end_ms = observed_ms
    lasts_ms = end_ms - begin_ms
    is_since_begin = path.suffix.lower() in SINCE_BEGIN or chosen.end_ms <= min(lasts_ms, begin_ms)
    if is_since_begin:
        chosen = shifted(chosen, begin_ms)
    for problem in problems_of(chosen.ethogram, chosen.occurrences, observed_ms):
        raise BehaviourError("{file}: {problem}", file=path.name, problem=problem.sentence.text)
    sections = tuple(
        Section(one.name, max(one.begin_ms, begin_ms), min(one.end_ms, end_ms))
        for one in chosen.sections
        if one.begin_ms < end_ms and one.end_ms > begin_ms
    )
    return replace(chosen, begin_ms=begin_ms, end_ms=end_ms, sections=sections)


def for_file(coding: Coding, path: Path) -> Coding:
    """Return a coding with the times that the program of such a file expects."""
    if path.suffix.lower() in SINCE_BEGIN:
        return shifted(coding, -coding.begin_ms)
    return coding


def shifted(coding: Coding, by_ms: int) -> Coding:
    """Return a coding whose times are all so much later."""

    def later(one: Occurrence) -> Occurrence:
        return replace(one, begin_ms=one.begin_ms + by_ms, end_ms=one.end_ms + by_ms)

    sections = tuple(
        replace(one, begin_ms=one.begin_ms + by_ms, end_ms=one.end_ms + by_ms)
        for one in coding.sections
    )
    return replace(
        coding,
        begin_ms=coding.begin_ms + by_ms,
        end_ms=coding.end_ms + by_ms,
        occurrences=tuple(map(later, coding.occurrences)),
        sections=sections,
    )
