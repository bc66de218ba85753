"""The tables of a report of behaviour: columns and rows, the same for every format."""

from collections.abc import Iterator, Sequence

import numpy as np

from adibas.arrays import FloatArray
from adibas.behaviour.activity import JointActivity, per_bin
from adibas.behaviour.bands import BandPower
from adibas.behaviour.budget import (
    Budget,
    bin_spans,
    budgets,
    conditions,
    time_bins,
    transitions,
)
from adibas.data.coding import MS_PER_S, Coding
from adibas.data.joints import JOINT_NAMES
from adibas.data.landmark_texts import landmark_text
from adibas.pipeline.behaviour import BehaviourAnalysis
from adibas.pipeline.behaviour_activity import subject_of
from adibas.reports.behaviour_texts import (
    behaviour_text,
    condition_text,
    subject_text,
)
from adibas.reports.sheets import Block, Column, Value
from adibas.texts import translate as _

ONE, TWO, THREE = "0.0", "0.00", "0.000"
NAME_WIDTH = 26.0
Rows = list[tuple[Value, ...]]


def activity_columns() -> list[Column]:
    """Return the columns of `activity_rows`."""
    return [
        Column(_("Condition"), 20),
        Column(_("Who"), 14),
        Column(_("Joint"), 18),
        Column(_("Observed [s]"), 11, ONE),
        Column(_("Seen [s]"), 11, ONE),
        Column(_("Moved [s]"), 11, ONE),
        Column(_("Moved [% of seen]"), 11, ONE),
        Column(_("Path [m]"), 11, TWO),
        Column(_("Path [m/min seen]"), 12, TWO),
        Column(_("Fast [m/s]"), 11, THREE),
        Column(_("Noise [mm]"), 10, ONE),
    ]


def activity_rows(analysis: BehaviourAnalysis) -> Rows:
    """Return each joint of each person: over the session, and under each condition."""
    rows: Rows = []
    for person in analysis.people:
        who = subject_text(subject_of(person.person))
        parts = [(_("whole session"), person.joints)]
        parts += [(condition_text(name), joints) for name, joints in person.by_condition]
        for name, joints in parts:
            for one, noise_m in zip(joints, person.steps.noise_m, strict=True):
                rows.append((name, who, *_activity(one), _known(1000.0 * float(noise_m))))
    return rows


def bin_columns() -> list[Column]:
    """Return the columns of `bin_rows`."""
    return [
        Column(_("From [s]"), 10, ONE),
        Column(_("To [s]"), 10, ONE),
        Column(_("Who"), 14),
        *(Column(f"{landmark_text(name)} [m]", 11, TWO) for name in JOINT_NAMES),
        Column(_("All joints [m]"), 12, TWO),
    ]


def bin_rows(analysis: BehaviourAnalysis) -> Rows:
    """Return the path of each joint in each bin; empty where it was not seen at all."""
    coding = analysis.detected
    spans = [
        (begin / MS_PER_S, end / MS_PER_S)
        for begin, end in bin_spans(coding.begin_ms, coding.end_ms, analysis.bin_ms)
    ]
    rows: Rows = []
    for person in analysis.people:
        who = subject_text(subject_of(person.person))
        path_m, _active_s, seen_s = per_bin(person.steps, spans)
        for span, path, seen in zip(spans, path_m, seen_s, strict=True):
            cells = [float(a) if b > 0 else None for a, b in zip(path, seen, strict=True)]
            rows.append((*span, who, *cells, float(path.sum()) if seen.any() else None))
    return rows


def budget_columns() -> list[Column]:
    """Return the columns of `budget_rows`."""
    return [
        Column(_("Observer"), 14),
        Column(_("Condition"), 20),
        Column(_("Who"), 16),
        Column(_("Behaviour"), NAME_WIDTH),
        Column(_("Observed [s]"), 11, ONE),
        Column(_("Count"), 8, "0"),
        Column(_("Per minute"), 9, TWO),
        Column(_("Total [s]"), 10, TWO),
        Column(_("Share [%]"), 9, TWO),
        Column(_("Mean duration [s]"), 13, TWO),
        Column(_("First after [s]"), 10, TWO),
    ]


def budget_rows(codings: Sequence[Coding]) -> Rows:
    """Return counts and durations over each session, and under each condition."""
    rows: Rows = []
    for coding in codings:
        parts = [(_("whole session"), budgets(coding))]
        parts += [(condition_text(one.name), one.budgets) for one in conditions(coding)]
        for name, some in parts:
            rows += [(coding.observer, name, *_budget(one)) for one in some]
    return rows


def behaviour_bin_columns() -> list[Column]:
    """Return the columns of `behaviour_bin_rows`."""
    return [
        Column(_("Observer"), 14),
        Column(_("From [s]"), 10, ONE),
        Column(_("To [s]"), 10, ONE),
        Column(_("Who"), 16),
        Column(_("Behaviour"), NAME_WIDTH),
        Column(_("Count"), 8, "0"),
        Column(_("Total [s]"), 10, TWO),
        Column(_("Share [%]"), 9, TWO),
    ]


def behaviour_bin_rows(codings: Sequence[Coding], bin_ms: int) -> Rows:
    """Return counts and durations in each bin, of what occurs anywhere in the session."""
    rows: Rows = []
    for coding in codings:
        occurring = {(one.subject, one.behaviour) for one in coding.occurrences}
        for part in time_bins(coding, bin_ms):
            begin_s, end_s = part.begin_ms / MS_PER_S, part.end_ms / MS_PER_S
            rows += [
                (coding.observer, begin_s, end_s, *_short(one))
                for one in part.budgets
                if (one.subject, one.behaviour) in occurring
            ]
    return rows


def event_columns() -> list[Column]:
    """Return the columns of `event_rows`."""
    return [
        Column(_("Observer"), 14),
        Column(_("From [s]"), 10, THREE),
        Column(_("To [s]"), 10, THREE),
        Column(_("Duration [s]"), 10, THREE),
        Column(_("Who"), 16),
        Column(_("Behaviour"), NAME_WIDTH),
        Column(_("Modifiers"), 18),
        Column(_("Comment"), 40),
    ]


def event_rows(codings: Sequence[Coding]) -> Rows:
    """Return everything that was seen, by time."""
    rows: Rows = []
    for coding in codings:
        for one in coding.occurrences:
            comments = " / ".join(text for text in (one.comment, one.end_comment) if text)
            rows.append(
                (
                    coding.observer,
                    one.begin_ms / MS_PER_S,
                    one.end_ms / MS_PER_S,
                    one.duration_ms / MS_PER_S,
                    subject_text(one.subject),
                    behaviour_text(one.behaviour),
                    "; ".join(text for text in one.modifiers if text),
                    comments,
                )
            )
    return sorted(rows, key=lambda row: (str(row[0]), row[1]))


def transition_blocks(codings: Sequence[Coding]) -> Iterator[Block]:
    """Yield for each subject how often one behaviour began after another."""
    for coding in codings:
        for table in transitions(coding):
            used = [
                place
                for place in range(len(table.behaviours))
                if any(table.counts[place]) or any(row[place] for row in table.counts)
            ]
            if used:
                names = [behaviour_text(table.behaviours[place]) for place in used]
                columns = [Column(_("before, then"), NAME_WIDTH)]
                columns += [Column(name, 14, "0") for name in names]
                rows: Rows = [
                    (name, *(float(table.counts[row][place]) for place in used))
                    for name, row in zip(names, used, strict=True)
                ]
                heading = f"{coding.observer}: {subject_text(table.subject)}"
                yield Block(heading, columns, rows, is_map=True)


def band_blocks(analysis: BehaviourAnalysis) -> Iterator[Block]:
    """Yield for each person the power of each joint's velocity in bands, and that of noise."""
    for person in analysis.people:
        who = subject_text(subject_of(person.person))
        columns = _band_columns(person.bands)
        yield Block(who, columns, _band_rows(person.bands, person.bands.power), is_map=True)
        heading = _("{who}: what the sensor's noise makes").format(who=who)
        yield Block(heading, columns, _band_rows(person.bands, person.bands.noise), is_map=True)


def _band_columns(bands: BandPower) -> list[Column]:
    edges = [int(edge) for edge in bands.edges_hz]
    return [
        Column(_("Joint"), NAME_WIDTH),
        *(Column(f"{low}-{low + 1} Hz", 9, "0.00E+00") for low in edges[:-1]),
    ]


def _band_rows(bands: BandPower, powers: FloatArray) -> Rows:
    return [
        (landmark_text(name), *(_known(float(power)) for power in row))
        for name, row in zip(JOINT_NAMES, powers, strict=True)
        if bands.power.shape[1]
    ]


def _activity(one: JointActivity) -> tuple[Value, ...]:
    share = one.active_share
    return (
        landmark_text(one.joint),
        one.observed_s,
        one.seen_s,
        one.active_s,
        None if share is None else 100.0 * share,
        one.path_m if one.seen_s else None,
        None if one.speed_m_s is None else 60.0 * one.speed_m_s,
        one.fast_m_s,
    )


def _budget(one: Budget) -> tuple[Value, ...]:
    return (
        subject_text(one.subject),
        behaviour_text(one.behaviour),
        one.observed_ms / MS_PER_S,
        float(one.count),
        one.per_minute,
        one.total_ms / MS_PER_S if one.is_state else None,
        None if one.share is None else 100.0 * one.share,
        None if one.mean_ms is None else one.mean_ms / MS_PER_S,
        None if one.latency_ms is None else one.latency_ms / MS_PER_S,
    )


def _short(one: Budget) -> tuple[Value, ...]:
    return (
        subject_text(one.subject),
        behaviour_text(one.behaviour),
        float(one.count),
        one.total_ms / MS_PER_S if one.is_state else None,
        None if one.share is None else 100.0 * one.share,
    )


def _known(value: float) -> float | None:
    return value if np.isfinite(value) else None
