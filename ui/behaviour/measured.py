"""What the program measured in a recording, as tables and as content of plots. Without Qt."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Literal, TypeAlias, get_args

import numpy as np

from adibas.arrays import FloatArray
from adibas.behaviour.activity import per_bin
from adibas.behaviour.budget import bin_spans
from adibas.data.coding import MS_PER_S, Coding, Section
from adibas.data.joints import JOINT_NAMES
from adibas.data.landmark_texts import landmark_text
from adibas.reports import behaviour_tables as tables
from adibas.reports.behaviour_texts import behaviour_text, subject_text
from adibas.texts import translate as _
from ui.behaviour.rows import COLORS
from ui.behaviour.tables import TextTable, text_table

if TYPE_CHECKING:
    from adibas.pipeline.behaviour import BehaviourAnalysis

MeasuredKind: TypeAlias = Literal["joints", "paths", "bands", "detected"]
MEASURED: tuple[MeasuredKind, ...] = get_args(MeasuredKind)
S_PER_MINUTE = 60.0


@dataclass(frozen=True, slots=True)
class Raster:
    """Events over time, one row for each behaviour of each subject of each observer.

    Attributes
    ----------
    rows : tuple of str
    bars : tuple of (row, begin, end, colour)
        Minutes since the session's begin; a point event ends where it begins.
    sections : tuple of (name, begin, end)
        The same.
    end_min : float
    """

    rows: tuple[str, ...]
    bars: tuple[tuple[int, float, float, str], ...]
    sections: tuple[tuple[str, float, float], ...]
    end_min: float


@dataclass(frozen=True, slots=True, eq=False)
class HeatMap:
    """How much each joint moved in each time bin.

    Attributes
    ----------
    rows : tuple of str
    values : (rows, bins) array
        Metres a minute seen; NaN where the joint was not seen.
    sections : tuple of (name, begin, end)
        Minutes since the session's begin.
    end_min : float
    """

    rows: tuple[str, ...]
    values: FloatArray = field(repr=False)
    sections: tuple[tuple[str, float, float], ...]
    end_min: float


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
    rows: list[str] = []
    bars: list[tuple[int, float, float, str]] = []
    for one in (coding, detected):
        for row, (label, color, spans) in enumerate(_events(one), len(rows)):
            rows.append(label)
            bars += [(row, begin, end, color) for begin, end in spans]
    return Raster(tuple(rows), tuple(bars), _sections(coding), _minutes(coding, coding.end_ms))


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
        who = subject_text(f"person {person.person}")
        is_alone = len(analysis.people) == 1
        joints = [landmark_text(name) for name in JOINT_NAMES]
        rows += joints if is_alone else [f"{who}: {joint}" for joint in joints]
    end_min = _minutes(coding, coding.end_ms)
    return HeatMap(tuple(rows), np.concatenate(values), _sections(coding), end_min)


def _events(coding: Coding | None) -> Iterator[tuple[str, str, list[tuple[float, float]]]]:
    if coding is None:
        return
    for subject in coding.subjects:
        for place, behaviour in enumerate(coding.ethogram.behaviours):
            spans = [
                (_minutes(coding, one.begin_ms), _minutes(coding, one.end_ms))
                for one in coding.of(behaviour.name, subject)
            ]
            if spans:
                who = ", ".join(part for part in (subject_text(subject), coding.observer) if part)
                label = f"{behaviour_text(behaviour.name)} ({who})"
                yield label, behaviour.color or COLORS[place % len(COLORS)], spans


def _sections(coding: Coding) -> tuple[tuple[str, float, float], ...]:
    def told(one: Section) -> tuple[str, float, float]:
        return one.name, _minutes(coding, one.begin_ms), _minutes(coding, one.end_ms)

    return tuple(map(told, coding.sections))


def _minutes(coding: Coding, time_ms: int) -> float:
    return (time_ms - coding.begin_ms) / MS_PER_S / S_PER_MINUTE
