"""What the report on a body says in lines and rows."""

from adibas.data.body_measures import BodyMeasure
from adibas.pipeline.body import MeasuredBody
from adibas.reports.body_files import measures_of
from adibas.reports.body_numbers import DIGITS_TO_READ, on_paper
from adibas.reports.facts import Pairs, analysed, intended_use, view_name
from adibas.texts import decimal_text, message
from adibas.texts import translate as _

HEADING = message("Report on the back")


def body_facts(body: MeasuredBody) -> Pairs:
    """Return what was measured, how, and what the reader must know."""
    told: Pairs = [(_("Patient (pseudonym)"), body.patient)] if body.patient else []
    told.append(
        (
            _("Views"),
            ", ".join(f"{view_name(view)} ({count})" for view, count in body.n_frames.items()),
        )
    )
    if body.back is not None:
        told.append((_("Stature [mm]"), decimal_text(1e3 * body.back.stature_m, 0)))
    if body.whole.joined is not None:
        rms_mm = 1e3 * body.whole.joined.rms_m
        told.append((_("Distance between the views [mm]"), decimal_text(rms_mm, 2)))
    told.append(
        (
            _("Interval (95 %)"),
            _("of the instrument alone: not of the stance, nor of where a marker was stuck"),
        )
    )
    return [*told, *((_("Notice"), notice.text) for notice in body.notices)]


def general_facts(body: MeasuredBody) -> Pairs:
    """Return where the numbers come from."""
    told: Pairs = [(_("Intended use"), intended_use())]
    for view, provenance in body.provenances.items():
        told += [
            (f"{_('Recording (SHA-256)')}, {view_name(view)}", provenance.recording_sha256),
            (_("Calibration"), provenance.calibration),
            (_("Software version"), provenance.version),
            analysed(provenance),
        ]
    return told


def measure_rows(body: MeasuredBody) -> list[tuple[str, str, str, str, str, str]]:
    """Return name, meaning, value, interval, unit and source of each measure."""
    return [_row(measure) for measure in measures_of(body)]


def _row(measure: BodyMeasure) -> tuple[str, str, str, str, str, str]:
    definition = measure.definition
    value, interval, unit = on_paper(measure)
    meaning = _(definition.meaning)
    if value is None:
        reason = _(measure.reason) if measure.reason else ""
        return _(definition.name), meaning, "", reason, unit, definition.source
    digits = DIGITS_TO_READ[definition.quantity]
    between = "" if interval is None else " … ".join(decimal_text(end, digits) for end in interval)
    return (
        _(definition.name),
        meaning,
        decimal_text(value, digits),
        between,
        unit,
        definition.source,
    )
