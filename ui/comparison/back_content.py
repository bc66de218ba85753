"""What the page of the back shows; without Qt."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from adibas.arrays import FloatArray
from adibas.data.body_measures import BodyMeasure

if TYPE_CHECKING:
    from adibas.pipeline.back import Back

STEP_M = 0.004


@dataclass(frozen=True, slots=True, eq=False)
class SeenBack:
    """One back, lengths across and to the back in millimetres, heights in metres.

    Attributes
    ----------
    asymmetry_mm : (H, W) array
        Rows from the top down, columns to the patient's right; NaN where it is not known.
    left_mm, right_mm, bottom_m, top_m : float
        Its edges.
    height_m : (N,) array
        Of the places along the line of the spine, which the next three tell of.
    aside_mm, profile_mm, rotation_deg : (N,) array
        To the right; to the back of its lowest turn, or of its lower end; right side further back.
    turns : tuple of (name, profile_mm, height_m)
        The turns and apices of the profile.
    measures : tuple of BodyMeasure
    """

    asymmetry_mm: FloatArray
    left_mm: float
    right_mm: float
    bottom_m: float
    top_m: float
    height_m: FloatArray
    aside_mm: FloatArray
    profile_mm: FloatArray
    rotation_deg: FloatArray
    turns: tuple[tuple[str, float, float], ...]
    measures: tuple[BodyMeasure, ...]


@dataclass(frozen=True, slots=True)
class Backs:
    """The backs of two sessions; None where one could not be measured, as a sentence says."""

    earlier: SeenBack | None = None
    later: SeenBack | None = None
    sentences: tuple[str, ...] = ()


def seen_back(back: "Back") -> SeenBack:
    """Return what is drawn of a back."""
    from adibas.surface.asymmetry import asymmetry_m

    grid, profile, shape = back.grid, back.profile, back.shape
    half_m = grid.cell_m / 2.0
    height_m = profile.heights_m(STEP_M)
    origin_m = profile.bottom_m if shape is None else shape.ils_m
    origin_back_m = float(profile.back_m(np.array([origin_m]))[0])
    places = () if shape is None else shape.places
    return SeenBack(
        asymmetry_mm=1e3 * asymmetry_m(grid, back.line),
        left_mm=1e3 * (float(grid.x_m[0]) - half_m),
        right_mm=1e3 * (float(grid.x_m[-1]) + half_m),
        bottom_m=float(grid.y_m[-1]) - half_m,
        top_m=float(grid.y_m[0]) + half_m,
        height_m=height_m,
        aside_mm=1e3 * back.line.at(height_m),
        profile_mm=1e3 * (profile.back_m(height_m) - origin_back_m),
        rotation_deg=np.degrees(profile.rotation_rad(height_m)),
        turns=tuple(
            (name, 1e3 * (float(profile.back_m(np.array([at_m]))[0]) - origin_back_m), at_m)
            for name, at_m, _is_turn in places
        ),
        measures=back.measures,
    )
