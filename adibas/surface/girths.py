"""Girths and volumes by name, from slices at shares of the stature.

The heights are our own: no source of the clinic's was at hand that tells them for a surface
without palpation, so these names say no more than what is measured.
"""

from collections.abc import Callable

import numpy as np

from adibas.arrays import FloatArray
from adibas.data.body_measures import BodyMeasure, Definition
from adibas.surface.merging import BodySurface
from adibas.surface.sagittal import Estimate
from adibas.surface.slices import (
    SliceParams,
    SlicePart,
    leg_slices,
    steady_girths_m,
    trunk_slices,
    volume_m3,
)
from adibas.texts import message

OWN = "ADiBAS, docs/body-surface.md"
NOT_ROUND = message("The views do not show it from all sides.")
TOUCHED = message("Arms or hands lie at the trunk. Hold them away from it.")
LOIN, SEAT = (0.56, 0.70), (0.46, 0.56)
TRUNK = (0.53, 0.65)
CALF = (0.14, 0.27)
LEAST_SHARE = 0.8
"""Of a segment's slices whose outline must be seen, for it to have a volume."""
ERROR_SD = {
    "GIRTH.TRUNK.LEAST": 0.0105,
    "GIRTH.SEAT.GREATEST": 0.007,
    "GIRTH.CALF.LEFT": 0.016,
    "GIRTH.CALF.RIGHT": 0.016,
    "VOLUME.TRUNK": 0.009,
    "VOLUME.CALF.LEFT": 0.046,
    "VOLUME.CALF.RIGHT": 0.046,
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
    calves = leg_slices(surface, *between(CALF), params)
    return (
        _girth(GIRTH_LOIN, loin, np.min),
        _girth(GIRTH_SEAT, seat, np.max),
        _girth(GIRTH_LEFT_CALF, (calves[0], 0), np.max),
        _girth(GIRTH_RIGHT_CALF, (calves[1], 0), np.max),
        _volume(VOLUME_TRUNK, trunk, between(TRUNK), params),
        _volume(VOLUME_LEFT_CALF, (calves[0], 0), between(CALF), params),
        _volume(VOLUME_RIGHT_CALF, (calves[1], 0), between(CALF), params),
    )


def _girth(
    definition: Definition,
    seen: tuple[list[SlicePart], int],
    chosen: Callable[[FloatArray], np.float64],
) -> BodyMeasure:
    parts, n_touched = seen
    if n_touched and len(parts) < LEAST_FREE * (len(parts) + n_touched):
        return BodyMeasure(definition, None, reason=TOUCHED)
    if not parts:
        return BodyMeasure(definition, None, reason=NOT_ROUND)
    return _known(definition, float(chosen(steady_girths_m(parts))))


def _volume(
    definition: Definition,
    seen: tuple[list[SlicePart], int],
    heights_m: tuple[float, float],
    params: SliceParams,
) -> BodyMeasure:
    parts, n_touched = seen
    n_wanted = (heights_m[1] - heights_m[0]) / params.step_m
    if len(parts) < LEAST_SHARE * n_wanted:
        return BodyMeasure(definition, None, reason=TOUCHED if n_touched else NOT_ROUND)
    return _known(definition, volume_m3(parts, *heights_m, params.step_m))


def _known(definition: Definition, value: float) -> BodyMeasure:
    error_sd = ERROR_SD[definition.measure_id] * value
    return BodyMeasure(definition, value, Estimate(value, error_sd).interval)
