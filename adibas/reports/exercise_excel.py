"""The Excel report of an exercise: repetitions, ranges, symmetry, and deviation over time."""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from openpyxl import Workbook

from adibas.arrays import UInt8Array
from adibas.pipeline.exercise import ExerciseCheck
from adibas.reports.exercise_rows import range_rows, symmetry_rows
from adibas.reports.facts import analysed, intended_use
from adibas.reports.figure_pictures import picture_of
from adibas.reports.memory_workbook import write_in_memory
from adibas.reports.movement_facts import ORIGINS
from adibas.reports.movement_texts import JOINT_MOTIONS, angle_text
from adibas.reports.sheets import Column, Part, Value, add_parts, add_table
from adibas.reports.vector_figures import new_figure
from adibas.texts import decimal_text
from adibas.texts import translate as _

PICTURE_PT = (540.0, 600.0)
ONE, TWO = "0.0", "0.00"
FONT_PT, TITLE_PT = 6.0, 7.0
MODEL, FAINT, INK = "#16212B", "#C3CCD4", "#16212B"
COLORS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00")
MOST_PLOTS = 6
Rows = list[tuple[Value, ...]]


def write_exercise_workbook(check: ExerciseCheck, path: Path, language: str) -> None:
    """Write the sheets Summary, Repetitions, Ranges, Symmetry and Deviation.

    Raises
    ------
    FileError
        The disk is full, or the folder cannot be written.
    """
    write_in_memory(path, language, lambda workbook: _add_sheets(workbook, check))


def _add_sheets(workbook: Workbook, check: ExerciseCheck) -> None:
    footer = _("For research, education and documentation")
    parts = [
        Part("", _facts(check)),
        Part(_("Beside the therapist"), [], exercise_picture(check, *PICTURE_PT)),
    ]
    add_parts(workbook, _("Summary"), _("Exercise report"), parts, footer)
    add_table(workbook, _("Repetitions"), _repetition_columns(), _repetitions(check), footer)
    add_table(workbook, _("Ranges"), _range_columns(), _ranges(check), footer)
    symmetries = _symmetries(check)
    if symmetries:
        add_table(workbook, _("Symmetry"), _symmetry_columns(), symmetries, footer)
    columns = [Column(_("Repetition"), 10, "0"), Column(_("Therapist's time [s]"), 12, TWO)]
    columns += [Column(f"{angle_text(name)} [°]", 18, ONE) for name in check.model.angles.names]
    add_table(workbook, _("Deviation"), columns, _deviations(check), footer)


def _facts(check: ExerciseCheck) -> list[tuple[str, Value]]:
    n = len(check.repetitions)
    angles = ", ".join(angle_text(name) for name in check.model.angles.names)
    facts: list[tuple[str, Value]] = [
        (_("Patient (pseudonym)"), check.patient),
        (_("Joints from"), _(ORIGINS[check.done_origin])),
        (_("Joints of the therapist from"), _(ORIGINS[check.shown_origin])),
        (_("Repetitions"), str(n)),
        (_("Therapist's repetition [s]"), decimal_text(check.model.duration_s, 2)),
        (_("Angles that take part"), angles),
        (
            _("Distance"),
            _("0 is the therapist's movement, 1 is standing still in its first position."),
        ),
        (_("Software version"), check.provenance.version),
        (_("Intended use"), intended_use()),
        (_("Recording (SHA-256)"), check.provenance.recording_sha256),
        analysed(check.provenance),
    ]
    told = [(name, value) for name, value in facts if value]
    return [*told, *((_("Notice"), notice.text) for notice in check.notices)]


def _repetition_columns() -> list[Column]:
    return [
        Column(_("Repetition"), 10, "0"),
        Column(_("From [s]"), 10, TWO),
        Column(_("To [s]"), 10, TWO),
        Column(_("Duration [s]"), 10, TWO),
        Column(_("Times the therapist's"), 12, TWO),
        Column(_("Way out [s]"), 10, TWO),
        Column(_("Held [s]"), 10, TWO),
        Column(_("Way back [s]"), 10, TWO),
        Column(_("Distance"), 10, TWO),
    ]


def _repetitions(check: ExerciseCheck) -> Rows:
    first, last = check.model.hold
    rate_hz, n_frames = check.model.angles.rate_hz, len(check.model.angles.deg)
    shown = (first / rate_hz, (last - first) / rate_hz, (n_frames - 1 - last) / rate_hz)
    rows: Rows = [(_("therapist"), None, None, check.model.duration_s, 1.0, *shown, 0.0)]
    rows += [
        (
            float(number),
            one.begin_s,
            one.end_s,
            one.duration_s,
            one.duration_s / check.model.duration_s,
            *one.phases_s,
            one.cost,
        )
        for number, one in enumerate(check.repetitions, 1)
    ]
    return rows


def _range_columns() -> list[Column]:
    return [
        Column(_("Repetition"), 10, "0"),
        Column(_("Joint angle"), 42),
        Column(_("Range [deg]"), 11, ONE),
        Column(_("Therapist [deg]"), 11, ONE),
        Column(_("Reached [%]"), 11, ONE),
        Column(_("Deviation, root mean square [deg]"), 16, ONE),
        Column(_("Greatest deviation [deg]"), 13, ONE),
        Column(_("After [% of the repetition]"), 14, ONE),
    ]


def _ranges(check: ExerciseCheck) -> Rows:
    return [
        (
            float(row.number),
            angle_text(row.angle),
            row.range_deg,
            row.model_deg,
            None if row.share is None else 100.0 * row.share,
            row.deviation_deg,
            row.worst_deg,
            None if row.worst_at is None else 100.0 * row.worst_at,
        )
        for row in range_rows(check)
    ]


def _symmetry_columns() -> list[Column]:
    return [
        Column(_("Repetition"), 10, "0"),
        Column(_("Joint angle"), 42),
        Column(_("Range left [deg]"), 12, ONE),
        Column(_("Range right [deg]"), 12, ONE),
        Column(_("Symmetry index [%]"), 12, ONE),
    ]


def _symmetries(check: ExerciseCheck) -> Rows:
    return [
        (
            float(row.number) if row.number else _("therapist"),
            _(JOINT_MOTIONS[row.motion]),
            row.left_deg,
            row.right_deg,
            row.index_percent,
        )
        for row in symmetry_rows(check)
    ]


def _deviations(check: ExerciseCheck) -> Rows:
    rate_hz = check.model.angles.rate_hz
    return [
        (
            float(number),
            frame / rate_hz,
            *(value if np.isfinite(value) else None for value in row),
        )
        for number, one in enumerate(check.repetitions, 1)
        for frame, row in enumerate(one.deviation_deg.tolist())
    ]


def exercise_figure(check: ExerciseCheck, width_pt: float, height_pt: float) -> Figure:
    """Draw the angles that move most: the therapist's, and the patient's beside his time."""
    figure = new_figure(width_pt, height_pt)
    model = check.model.angles
    ranges = np.ptp(model.deg, axis=0)
    columns = np.argsort(-ranges)[:MOST_PLOTS]
    rows = figure.subplots(len(columns), 2, sharex=True, squeeze=False)
    times_s = np.arange(len(model.deg)) / model.rate_hz
    for (left, right), column in zip(rows, columns, strict=True):
        left.plot(times_s, model.deg[:, column], color=MODEL, linewidth=1.6, label=_("therapist"))
        right.axhline(0.0, color=MODEL, linewidth=0.8)
        for number, one in enumerate(check.repetitions):
            color = COLORS[number % len(COLORS)]
            deviation = one.deviation_deg[:, column]
            left.plot(times_s, model.deg[:, column] + deviation, color=color, linewidth=0.7)
            right.plot(times_s, deviation, color=color, linewidth=0.7, label=str(number + 1))
        left.set_title(f"{angle_text(model.names[column])} [°]", fontsize=TITLE_PT, color=INK)
        right.set_title(_("patient minus therapist [°]"), fontsize=TITLE_PT, color=INK)
        for axes in (left, right):
            axes.grid(visible=True, color=FAINT, linewidth=0.3)
            axes.tick_params(labelsize=FONT_PT, length=2)
    for axes in rows[-1]:
        axes.set_xlabel(_("Therapist's time [s]"), fontsize=FONT_PT)
    if check.repetitions:
        rows[0, 1].legend(fontsize=FONT_PT, frameon=False, ncols=4, title_fontsize=FONT_PT)
    return figure


def exercise_picture(check: ExerciseCheck, width_pt: float, height_pt: float) -> UInt8Array:
    """Return the same as (H, W, 3) pixels."""
    return picture_of(exercise_figure(check, width_pt, height_pt))
