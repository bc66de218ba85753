"""Girths and volumes by name, from slices at shares of the stature.

The heights are our own: no source of the clinic's was at hand that tells them for a surface
without palpation, so these names say no more than what is measured.
"""

from adibas.data.body_measures import BodyMeasure, Definition
from adibas.surface.merging import BodySurface
from adibas.surface.slices import (
    SliceParams,
    SlicePart,
    leg_slices,
    trunk_slices,
    volume_m3,
)
from adibas.texts import message

OWN = "ADiBAS, docs/body-surface.md"
NOT_ROUND = message("The views do not show it from all sides.")
LOIN, SEAT = (0.56, 0.70), (0.46, 0.56)
TRUNK = (0.53, 0.73)
CALF = (0.14, 0.27)
LEAST_SHARE = 0.8
"""Of a segment's slices whose outline must be seen, for it to have a volume."""

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
    message("between 53 and 73 % of the stature"),
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

    calves = leg_slices(surface, *between(CALF), params)
    return (
        _girth(GIRTH_LOIN, trunk_slices(surface, *between(LOIN), params), is_greatest=False),
        _girth(GIRTH_SEAT, trunk_slices(surface, *between(SEAT), params), is_greatest=True),
        _girth(GIRTH_LEFT_CALF, calves[0], is_greatest=True),
        _girth(GIRTH_RIGHT_CALF, calves[1], is_greatest=True),
        _volume(
            VOLUME_TRUNK, trunk_slices(surface, *between(TRUNK), params), between(TRUNK), params
        ),
    )


def _girth(definition: Definition, parts: list[SlicePart], *, is_greatest: bool) -> BodyMeasure:
    if not parts:
        return BodyMeasure(definition, None, reason=NOT_ROUND)
    girths_m = [part.girth_m for part in parts]
    return BodyMeasure(definition, max(girths_m) if is_greatest else min(girths_m))


def _volume(
    definition: Definition,
    parts: list[SlicePart],
    heights_m: tuple[float, float],
    params: SliceParams,
) -> BodyMeasure:
    n_wanted = (heights_m[1] - heights_m[0]) / params.step_m
    if len(parts) < LEAST_SHARE * n_wanted:
        return BodyMeasure(definition, None, reason=NOT_ROUND)
    # Slices that were not seen all around count as the others do on average.
    return BodyMeasure(definition, volume_m3(parts, params.step_m) * n_wanted / len(parts))
