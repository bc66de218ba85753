"""What the report of a movement says in lines of name and value."""

import math

from adibas.data.movement import Movement
from adibas.data.protocol_measures import INSTRUMENT_ONLY, VERTICAL_TEXTS, VerticalOrigin
from adibas.reports.facts import analysed, intended_use
from adibas.texts import Message, decimal_text, message
from adibas.texts import translate as _

Pairs = list[tuple[str, str | float]]

ORIGINS: dict[str, Message] = {
    "markers": message(
        "markers on the skin: angles are between them, not between the centres of the joints"
    ),
    "markerless": message("markerless: joints estimated from the depth, never as sure as markers"),
    "unknown": message("a file of joints that does not say how they were found"),
}
SURE = 1.96


def movement_facts(movement: Movement) -> Pairs:
    """Return what was measured, how, and what the reader must know."""
    duration_s = float(movement.times_s[-1] - movement.times_s[0])
    told: Pairs = [
        (_("Patient (pseudonym)"), movement.patient),
        (_("Joints from"), _(ORIGINS[movement.origin])),
        (_("Duration [s]"), decimal_text(duration_s, 1)),
        (_("Frames a second"), _rate_text(movement)),
        (_("Vertical"), _vertical_text(movement)),
        (_("Smoothing"), smoothing_text(movement)),
        (_("Random error"), _error_text()),
        (_("Intervals of measures"), _(INSTRUMENT_ONLY) if rests_on_markers(movement) else ""),
    ]
    told = [(name, value) for name, value in told if value]
    return [*told, *((_("Notice"), notice.text) for notice in movement.notices)]


def rests_on_markers(movement: Movement) -> bool:
    """Return whether where markers sit may be part of the error: all but markerless joints."""
    return movement.origin != "markerless"


def general_facts(movement: Movement) -> Pairs:
    """Return where the numbers come from."""
    provenance = movement.provenance
    return [
        (_("Software version"), provenance.version),
        (_("Intended use"), intended_use()),
        (_("Recording (SHA-256)"), provenance.recording_sha256),
        (_("Calibration"), provenance.calibration or _("none")),
        analysed(provenance),
    ]


def smoothing_text(movement: Movement) -> str:
    """Return the filter in words."""
    return _(
        "Joints: Butterworth low-pass of {cutoff} Hz, second order, run both ways (no lag); gaps "
        "up to {gap} s are bridged."
    ).format(
        cutoff=decimal_text(movement.smoothing["cutoff_hz"], 1),
        gap=decimal_text(movement.smoothing["longest_gap_s"], 2),
    )


def _rate_text(movement: Movement) -> str:
    return "" if math.isnan(movement.rate_hz) else decimal_text(movement.rate_hz, 1)


def _vertical_text(movement: Movement) -> str:
    if movement.is_up_measured:
        return _("measured: the trunk's angles are against it")
    return _(VERTICAL_TEXTS[VerticalOrigin.UNKNOWN])


def _error_text() -> str:
    return _(
        "Plus or minus values are 95 % of what noise leaves in one extreme. Where a marker or a "
        "joint lies wrongly all the time is not in them."
    )
