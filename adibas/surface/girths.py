"""Girths and volumes by name, from slices at shares of the stature.

The heights are our own: no source of the clinic's was at hand that tells them for a surface
without palpation, so these names say no more than what is measured.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from adibas.arrays import FloatArray
from adibas.data.body_measures import BodyMeasure, Definition
from adibas.surface.merging import BodySurface
from adibas.surface.sagittal import Estimate
from adibas.surface.slices import (
    Seen,
    SliceParams,
    leg_slices,
    steady_girths_m,
    trunk_slices,
    volume_m3,
)
from adibas.texts import Message, message

OWN = "ADiBAS, docs/body-surface.md"
NOT_ROUND = message("The views do not show it from all sides.")
NOT_APART = message(
    "The thighs touch, or the views do not show them from all sides. Stand with the feet apart."
)
TOUCHED = message("Arms or hands lie at the body there. Hold them away from it.")
LOIN, SEAT = (0.56, 0.70), (0.46, 0.56)
TRUNK = (0.53, 0.65)
CALF = (0.14, 0.27)
THIGH = (0.30, 0.38)
"""Above the knee-cap, below where hands hang."""
LEAST_SHARE = 0.8
"""Of a segment's slices whose outline must be seen, for it to have a volume."""
ERROR_SD = {
    "GIRTH.TRUNK.LEAST": 0.0113,
    "GIRTH.SEAT.GREATEST": 0.007,
    "GIRTH.THIGH.LEFT": 0.013,
    "GIRTH.THIGH.RIGHT": 0.013,
    "GIRTH.CALF.LEFT": 0.016,
    "GIRTH.CALF.RIGHT": 0.016,
    "VOLUME.TRUNK": 0.009,
    "VOLUME.THIGH.LEFT": 0.023,
    "VOLUME.THIGH.RIGHT": 0.023,
    "VOLUME.CALF.LEFT": 0.034,
    "VOLUME.CALF.RIGHT": 0.034,
}
"""Shares of the value by which it errs, standard deviations: the root mean square of 24 simulated
bodies, other ones than the benchmark's, in four views with sway, against slices of their meshes
without arms."""
LEAST_FREE = 0.5
"""Of the slices whose outline is seen, that no arm may touch for a girth to be known."""

GIRTH_LOIN = Definition(
    "GIRTH.TRUNK.LEAST",
    message("Least girth of the trunk"),
    message("as a tape spans it, between 56 and 70 % of the stature"),
    "length",
    OWN,
)
GIRTH_SEAT = Definition(
    "GIRTH.SEAT.GREATEST",
    message("Greatest girth of the seat"),
    message("as a tape spans it, between 46 and 56 % of the stature"),
    "length",
    OWN,
)
GIRTH_LEFT_THIGH = Definition(
    "GIRTH.THIGH.LEFT",
    message("Greatest girth of the left thigh"),
    message("between 30 and 38 % of the stature"),
    "length",
    OWN,
)
GIRTH_RIGHT_THIGH = Definition(
    "GIRTH.THIGH.RIGHT",
    message("Greatest girth of the right thigh"),
    message("between 30 and 38 % of the stature"),
    "length",
    OWN,
)
GIRTH_LEFT_CALF = Definition(
    "GIRTH.CALF.LEFT",
    message("Greatest girth of the left calf"),
    message("between 14 and 27 % of the stature"),
    "length",
    OWN,
)
GIRTH_RIGHT_CALF = Definition(
    "GIRTH.CALF.RIGHT",
    message("Greatest girth of the right calf"),
    message("between 14 and 27 % of the stature"),
    "length",
    OWN,
)
VOLUME_TRUNK = Definition(
    "VOLUME.TRUNK",
    message("Volume of the trunk"),
    message("between 53 and 65 % of the stature"),
    "volume",
    OWN,
)
VOLUME_LEFT_THIGH = Definition(
    "VOLUME.THIGH.LEFT",
    message("Volume of the left thigh"),
    message("between 30 and 38 % of the stature"),
    "volume",
    OWN,
)
VOLUME_RIGHT_THIGH = Definition(
    "VOLUME.THIGH.RIGHT",
    message("Volume of the right thigh"),
    message("between 30 and 38 % of the stature"),
    "volume",
    OWN,
)
VOLUME_LEFT_CALF = Definition(
    "VOLUME.CALF.LEFT",
    message("Volume of the left calf"),
    message("between 14 and 27 % of the stature"),
    "volume",
    OWN,
)
VOLUME_RIGHT_CALF = Definition(
    "VOLUME.CALF.RIGHT",
    message("Volume of the right calf"),
    message("between 14 and 27 % of the stature"),
    "volume",
    OWN,
)
DEFINITIONS = (
    GIRTH_LOIN,
    GIRTH_SEAT,
    GIRTH_LEFT_THIGH,
    GIRTH_RIGHT_THIGH,
    GIRTH_LEFT_CALF,
    GIRTH_RIGHT_CALF,
    VOLUME_TRUNK,
    VOLUME_LEFT_THIGH,
    VOLUME_RIGHT_THIGH,
    VOLUME_LEFT_CALF,
    VOLUME_RIGHT_CALF,
)


def slice_measures(
    surface: BodySurface, stature_m: float, params: SliceParams | None = None
) -> tuple[BodyMeasure, ...]:
    """Return girths and volumes; those of what was not seen all around have a reason."""
    params = params or SliceParams()

    def between(shares: tuple[float, float]) -> tuple[float, float]:
        return shares[0] * stature_m, shares[1] * stature_m

    loin, seat, trunk = (
        trunk_slices(surface, *between(one), params) for one in (LOIN, SEAT, TRUNK)
    )
    thighs = leg_slices(surface, *between(THIGH), params)
    calves = leg_slices(surface, *between(CALF), params)
    return (
        _girth(GIRTH_LOIN, loin, np.min),
        _girth(GIRTH_SEAT, seat, np.max),
        _girth(GIRTH_LEFT_THIGH, thighs[0], np.max, NOT_APART),
        _girth(GIRTH_RIGHT_THIGH, thighs[1], np.max, NOT_APART),
        _girth(GIRTH_LEFT_CALF, calves[0], np.max),
        _girth(GIRTH_RIGHT_CALF, calves[1], np.max),
        _volume(VOLUME_TRUNK, trunk, _Span(*between(TRUNK), params.step_m)),
        _volume(VOLUME_LEFT_THIGH, thighs[0], _Span(*between(THIGH), params.step_m), NOT_APART),
        _volume(VOLUME_RIGHT_THIGH, thighs[1], _Span(*between(THIGH), params.step_m), NOT_APART),
        _volume(VOLUME_LEFT_CALF, calves[0], _Span(*between(CALF), params.step_m)),
        _volume(VOLUME_RIGHT_CALF, calves[1], _Span(*between(CALF), params.step_m)),
    )


def no_measures(reason: Message) -> tuple[BodyMeasure, ...]:
    """Return all of them without a value."""
    return tuple(BodyMeasure(one, None, reason=reason) for one in DEFINITIONS)


class _Span(NamedTuple):
    """Of slices: from where to where, and how far apart."""

    low_m: float
    high_m: float
    step_m: float


def _girth(
    definition: Definition,
    seen: Seen,
    chosen: Callable[[FloatArray], np.float64],
    unseen: Message = NOT_ROUND,
) -> BodyMeasure:
    parts, n_touched = seen
    if n_touched and len(parts) < LEAST_FREE * (len(parts) + n_touched):
        return BodyMeasure(definition, None, reason=TOUCHED)
    if not parts:
        return BodyMeasure(definition, None, reason=unseen)
    return _known(definition, float(chosen(steady_girths_m(parts))))


def _volume(
    definition: Definition, seen: Seen, span: _Span, unseen: Message = NOT_ROUND
) -> BodyMeasure:
    parts, n_touched = seen
    if len(parts) < LEAST_SHARE * (span.high_m - span.low_m) / span.step_m:
        return BodyMeasure(definition, None, reason=TOUCHED if n_touched else unseen)
    return _known(definition, volume_m3(parts, *span))


def _known(definition: Definition, value: float) -> BodyMeasure:
    error_sd = ERROR_SD[definition.measure_id] * value
    return BodyMeasure(definition, value, Estimate(value, error_sd).interval)
