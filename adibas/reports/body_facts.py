"""What the report on a body says in lines and rows."""

from adibas.data.body_measures import BodyMeasure
from adibas.data.landmark_texts import landmark_text
from adibas.pipeline.body import MeasuredBody
from adibas.reports.body_files import measures_of
from adibas.reports.body_numbers import DIGITS_TO_READ, on_paper
from adibas.reports.facts import Pairs, analysed, intended_use, view_name
from adibas.texts import Message, decimal_text, message
from adibas.texts import translate as _

BACK_HEADING = message("Report on the back")
BODY_HEADING = message("Report on the body")


def heading_of(body: MeasuredBody) -> Message:
    """Return what the report is called."""
    return BODY_HEADING if body.back is None else BACK_HEADING


def has_looks(body: MeasuredBody) -> bool:
    """Say whether the surface is drawn: a back alone has pictures of its own."""
    return body.back is None or len(body.n_frames) > 1


def body_facts(body: MeasuredBody) -> Pairs:
    """Return what was measured, how, and what the reader must know."""
    told: Pairs = [(_("Patient (pseudonym)"), body.patient)] if body.patient else []
    told.append(
        (
            _("Views"),
            ", ".join(f"{view_name(view)} ({count})" for view, count in body.n_frames.items()),
        )
    )
    if body.stature_m is not None:
        told.append((_("Stature [mm]"), decimal_text(1e3 * body.stature_m, 0)))
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


def landmark_rows(body: MeasuredBody) -> list[tuple[str, str, str, str, str, str]]:
    """Return name, place in millimetres, views and how far these are apart of each landmark."""
    rows = []
    for mark in body.landmarks:
        right, height, back = (1e3 * value for value in mark.fused.position_m.tolist())
        views = ", ".join(view_name(view) for view in mark.places_m)
        apart = "" if mark.apart_m is None else decimal_text(1e3 * mark.apart_m, 1)
        place = decimal_text(right, 1), decimal_text(height, 1), decimal_text(back, 1)
        rows.append((landmark_text(mark.name), *place, views, apart))
    return rows


def _row(measure: BodyMeasure) -> tuple[str, str, str, str, str, str]:
    definition = measure.definition
    value, interval, unit = on_paper(measure)
    meaning = _(definition.meaning)
    if value is None:
        reason = _(measure.reason) if measure.reason else ""
        return _(definition.name), meaning, "", reason, _(unit), definition.source
    digits = DIGITS_TO_READ[definition.quantity]
    between = "" if interval is None else " … ".join(decimal_text(end, digits) for end in interval)
    return (
        _(definition.name),
        meaning,
        decimal_text(value, digits),
        between,
        _(unit),
        definition.source,
    )
