"""What the program measured in a recording, as tables and as content of plots. Without Qt."""

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Literal, TypeAlias, get_args

import numpy as np

from adibas.arrays import FloatArray
from adibas.behaviour.activity import per_bin
from adibas.behaviour.budget import Span, bin_spans
from adibas.data.coding import MS_PER_S, Coding
from adibas.data.joints import JOINT_NAMES
from adibas.data.landmark_texts import landmark_text
from adibas.pipeline.behaviour_activity import subject_of
from adibas.reports import behaviour_tables as tables
from adibas.reports.behaviour_lines import S_PER_MINUTE, event_lines
from adibas.reports.behaviour_texts import subject_text
from adibas.texts import translate as _
from ui.behaviour.rows import COLORS
from ui.behaviour.tables import TextTable, text_table

if TYPE_CHECKING:
    from adibas.pipeline.behaviour import BehaviourAnalysis

MeasuredKind: TypeAlias = Literal["joints", "paths", "bands", "detected"]
MEASURED: tuple[MeasuredKind, ...] = get_args(MeasuredKind)
People: TypeAlias = tuple[tuple[int, str], ...]
"""Numbers and names."""


@dataclass(frozen=True, slots=True)
class Raster:
    """Events over time, one row for each behaviour of each subject of each observer.

    Attributes
    ----------
    rows : tuple of str
    bars : tuple of (row, begin, end, colour)
        Seconds since the coded session's begin; a point event ends where it begins.
    sections : tuple of (name, begin, end)
        The same.
    duration_s : float
    """

    rows: tuple[str, ...]
    bars: tuple[tuple[int, float, float, str], ...]
    sections: tuple[tuple[str, float, float], ...]
    duration_s: float


@dataclass(frozen=True, slots=True, eq=False)
class HeatMap:
    """How much each joint moved in each time bin.

    Attributes
    ----------
    rows : tuple of str
    values : (rows, bins) array
        Metres a minute seen; NaN where the joint was not seen.
    bin_s : float
        Length of a bin; of the last one there may be less.
    sections : tuple of (name, begin, end)
        Seconds since the coded session's begin.
    duration_s : float
    """

    rows: tuple[str, ...]
    values: FloatArray = field(repr=False)
    bin_s: float
    sections: tuple[tuple[str, float, float], ...]
    duration_s: float


def people_of(analysis: "BehaviourAnalysis | None") -> People:
    """Return everybody whose joints were measured, where there are several to choose from."""
    people = () if analysis is None else analysis.people
    if len(people) <= 1:
        return ()
    return tuple((one.person, subject_text(subject_of(one.person))) for one in people)


def of_person(analysis: "BehaviourAnalysis", person: int) -> "BehaviourAnalysis":
    """Return the same analysis with one person alone."""
    return replace(analysis, people=tuple(p for p in analysis.people if p.person == person))


def measured_table(kind: MeasuredKind, analysis: "BehaviourAnalysis") -> TextTable:
    """Return what was measured of joints, or what the program saw, under each condition."""
    if kind == "joints":
        return text_table(tables.activity_columns(), tables.activity_rows(analysis))
    if kind == "paths":
        return text_table(tables.bin_columns(), tables.bin_rows(analysis))
    if kind == "detected":
        columns, rows = tables.budget_columns(), tables.budget_rows([analysis.detected])
        return text_table(columns[1:], (row[1:] for row in rows))
    return _bands(analysis)


def _bands(analysis: "BehaviourAnalysis") -> TextTable:
    """Return the band power of all people in one table, and below each that of noise."""
    lines: list[tuple[str, ...]] = []
    titles: tuple[str, ...] = ()
    for block in tables.band_blocks(analysis):
        part = text_table(block.columns, block.rows)
        titles = max(titles, (_("Who"), *part.titles), key=len)
        lines += [(block.heading, *line) for line in part.lines]
    whole = tuple((*line, *[""] * (len(titles) - len(line))) for line in lines)
    return TextTable(titles, whole, frozenset(range(2, len(titles))))


def raster(coding: Coding, detected: Coding | None) -> Raster:
    """Return what an observer coded, and below it what the program saw."""
    lines = list(event_lines((coding, detected), COLORS))
    bars = tuple(
        (row, *_seconds(span_ms, coding.begin_ms), line.color)
        for row, line in enumerate(lines)
        for span_ms in line.spans_ms
    )
    duration_s = coding.duration_ms / MS_PER_S
    return Raster(tuple(line.label for line in lines), bars, _sections(coding), duration_s)


def heat_map(analysis: "BehaviourAnalysis", coding: Coding, bin_ms: int) -> HeatMap:
    """Return how much each joint of each person moved, in bins of the coded session."""
    spans = [
        (begin / MS_PER_S, end / MS_PER_S)
        for begin, end in bin_spans(coding.begin_ms, coding.end_ms, bin_ms)
    ]
    rows: list[str] = []
    values = []
    for person in analysis.people:
        path_m, _active_s, seen_s = per_bin(person.steps, spans)
        seen = np.where(seen_s > 0, seen_s, np.nan)
        values.append((S_PER_MINUTE * path_m / seen).T)
        who = subject_text(subject_of(person.person))
        is_alone = len(analysis.people) == 1
        joints = [landmark_text(name) for name in JOINT_NAMES]
        rows += joints if is_alone else [f"{who}: {joint}" for joint in joints]
    duration_s = coding.duration_ms / MS_PER_S
    return HeatMap(
        tuple(rows), np.concatenate(values), bin_ms / MS_PER_S, _sections(coding), duration_s
    )


def _sections(coding: Coding) -> tuple[tuple[str, float, float], ...]:
    begin_ms = coding.begin_ms
    return tuple(
        (one.name, *_seconds((one.begin_ms, one.end_ms), begin_ms)) for one in coding.sections
    )


def _seconds(span_ms: Span, since_ms: int) -> tuple[float, float]:
    begin_ms, end_ms = span_ms
    return (begin_ms - since_ms) / MS_PER_S, (end_ms - since_ms) / MS_PER_S
