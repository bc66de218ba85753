"""The timeline of a session: who did what when, and how much was moved."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from adibas.arrays import UInt8Array
from adibas.behaviour.activity import per_bin
from adibas.behaviour.budget import bin_spans
from adibas.data.coding import MS_PER_S, Coding
from adibas.pipeline.behaviour import BehaviourAnalysis
from adibas.pipeline.behaviour_activity import PersonActivity, subject_of
from adibas.reports.behaviour_lines import S_PER_MINUTE, EventLine, event_lines, time_axis
from adibas.reports.behaviour_texts import condition_text, subject_text
from adibas.reports.figure_pictures import picture_of
from adibas.reports.vector_figures import new_figure
from adibas.texts import translate as _

COLORS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00", "#000000")
INK, FAINT, SHADE = "#16212B", "#C3CCD4", "#EEF1F4"
FONT_PT, TITLE_PT = 6.0, 7.0
N_CURVE_BINS = 300
LINE_HEIGHT = 0.8


def timeline_figure(analysis: BehaviourAnalysis, width_pt: float, height_pt: float) -> Figure:
    """Draw a row for each behaviour that occurs, and below it the speed of each person."""
    figure = new_figure(width_pt, height_pt)
    rows = list(event_lines((analysis.observed, analysis.detected), COLORS))
    upper, lower = figure.subplots(
        2, 1, sharex=True, height_ratios=[max(len(rows), 2), 4.0], squeeze=True
    )
    scale_s, unit = time_axis(analysis.detected.duration_ms / MS_PER_S)
    _draw_rows(upper, analysis.detected, rows, scale_s)
    for place, person in enumerate(analysis.people):
        _draw_speed(lower, analysis.detected, person, scale_s, COLORS[place % len(COLORS)])
    lower.set_ylabel(_("Path of all joints [m/min]"), fontsize=FONT_PT)
    lower.set_xlabel(unit, fontsize=FONT_PT)
    lower.set_ylim(bottom=0.0)
    lower.grid(visible=True, color=FAINT, linewidth=0.3)
    if len(analysis.people) > 1:
        lower.legend(fontsize=FONT_PT, frameon=False)
    for axes in (upper, lower):
        axes.tick_params(labelsize=FONT_PT, length=2)
        for spine in axes.spines.values():
            spine.set_linewidth(0.4)
    return figure


def timeline_picture(analysis: BehaviourAnalysis, width_pt: float, height_pt: float) -> UInt8Array:
    """Return the same as (H, W, 3) pixels."""
    return picture_of(timeline_figure(analysis, width_pt, height_pt))


def _draw_rows(axes: Axes, coding: Coding, rows: Sequence[EventLine], scale_s: float) -> None:
    for section in coding.sections:
        begin, end = (time / MS_PER_S / scale_s for time in (section.begin_ms, section.end_ms))
        axes.axvspan(begin, end, color=SHADE, zorder=0)
        axes.text(
            begin, -0.75, condition_text(section.name), fontsize=FONT_PT, color=INK, va="center",
            clip_on=True, parse_math=False,
        )  # fmt: skip
    unit_ms = MS_PER_S * scale_s
    for place, row in enumerate(rows):
        low, high = place - LINE_HEIGHT / 2, place + LINE_HEIGHT / 2
        if row.is_state:
            bars = [(begin / unit_ms, (end - begin) / unit_ms) for begin, end in row.spans_ms]
            axes.broken_barh(bars, (low, LINE_HEIGHT), color=row.color)
        else:
            times = [begin / unit_ms for begin, _end in row.spans_ms]
            axes.vlines(times, low, high, color=row.color, linewidth=0.8)
    axes.set_yticks(range(len(rows)), [row.label for row in rows], parse_math=False)
    axes.set_ylim(max(len(rows), 1) - 0.5, -1.0 if coding.sections else -0.5)
    limits = (coding.begin_ms / MS_PER_S / scale_s, coding.end_ms / MS_PER_S / scale_s)
    if limits[0] < limits[1]:
        axes.set_xlim(limits)


def _draw_speed(
    axes: Axes, coding: Coding, person: PersonActivity, scale_s: float, color: str
) -> None:
    length_ms = max(coding.duration_ms // N_CURVE_BINS, MS_PER_S)
    spans = [
        (begin / MS_PER_S, end / MS_PER_S)
        for begin, end in bin_spans(coding.begin_ms, coding.end_ms, length_ms)
    ]
    path_m, _active_s, seen_s = per_bin(person.steps, spans)
    # The mean over joints that were seen, times all of them: hidden ones do not count as still.
    with np.errstate(invalid="ignore", divide="ignore"):
        speed = np.where(seen_s > 0, path_m / seen_s, np.nan)
        known = np.isfinite(speed).any(axis=1)
        per_minute = np.full(len(spans), np.nan)
        per_minute[known] = S_PER_MINUTE * speed.shape[1] * np.nanmean(speed[known], axis=1)
    middles = [0.5 * (begin + end) / scale_s for begin, end in spans]
    label = subject_text(subject_of(person.person))
    axes.plot(middles, per_minute, color=color, linewidth=0.7, label=label)
