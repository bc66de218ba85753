"""The trunk in a standing body: how tall the person is, and which points are the back's."""

from dataclasses import dataclass

import numpy as np

from adibas.arrays import BoolArray, FloatArray
from adibas.surface.back_grid import BackGrid
from adibas.surface.spine_profile import SpineProfile

LEAST_POINTS = 50
"""Of a part, for it to be in view."""


@dataclass(frozen=True, slots=True)
class TrunkParams:
    """Shares of the stature, from the bodies that the figures were found on.

    Attributes
    ----------
    top, bottom : float
        Of the back's points: 0.93, the nape, to 0.50, the seat.
    chest : (low, high)
        Where a body seen from behind is wider than deep: 0.70 to 0.80.
    least_width : float
        There, arms included: 0.20. From the side it is 0.13 to 0.18.
    sole, shin : (low, high)
        Heights of the foot's back and of the shin: 0.012 to 0.05, and 0.10 to 0.15.
    toes : float
        A foot that reaches that much farther to the sensor than the shin shows its toes: 0.045.
        From the front it is 0.08 to 0.09, from behind 0.01 at most, on simulated bodies.
    steepest : float
        A back is nowhere as steep as 1.2, 50 degrees; the border of an arm before it is.
    most_hidden : float
        Share of the back about the spine that may be unknown or as steep: 0.04.
    beside_m : float
        To either side of the spine that is looked at for that: 70 mm.
    """

    top: float = 0.93
    bottom: float = 0.50
    chest: tuple[float, float] = (0.70, 0.80)
    least_width: float = 0.20
    sole: tuple[float, float] = (0.012, 0.05)
    shin: tuple[float, float] = (0.10, 0.15)
    toes: float = 0.045
    steepest: float = 1.2
    most_hidden: float = 0.04
    beside_m: float = 0.07


def back_points(points_m: FloatArray, stature_m: float, params: TrunkParams) -> BoolArray:
    """Say of (N, 3) points in patient axes which are of the height of the back."""
    height = points_m[:, 1] / stature_m
    return np.asarray((height >= params.bottom) & (height <= params.top))


def chest_width_m(points_m: FloatArray, stature_m: float, params: TrunkParams) -> float:
    """Return how wide the body is at the chest, with the arms; 0 where nothing is seen there."""
    height = points_m[:, 1] / stature_m
    low, high = params.chest
    across_m = points_m[(height >= low) & (height <= high), 0]
    if not len(across_m):
        return 0.0
    left_m, right_m = np.quantile(across_m, (0.01, 0.99))
    return float(right_m - left_m)


def shows_toes(points_m: FloatArray, stature_m: float, params: TrunkParams) -> bool:
    """Say whether the toes point to where z points: the front is seen.

    False where feet or shins are not in view.
    """
    height = points_m[:, 1] / stature_m
    reach_m = []
    for low, high in (params.sole, params.shin):
        near_m = points_m[(height >= low) & (height <= high), 2]
        if len(near_m) < LEAST_POINTS:
            return False
        reach_m.append(float(np.quantile(near_m, 0.95)))
    return reach_m[0] - reach_m[1] > params.toes * stature_m


def hidden_share(
    grid: BackGrid, profile: SpineProfile, stature_m: float, params: TrunkParams
) -> float:
    """Return the share of the back about the spine that is unknown or too steep for a back."""
    rows = (grid.y_m >= 0.6 * stature_m) & (grid.y_m <= 0.8 * stature_m)
    if rows.sum() <= 1:
        return 1.0
    y_m = grid.y_m[rows]
    aside_m = grid.x_m[None, :] - profile.line.at(y_m)[:, None]
    about = np.abs(aside_m) <= params.beside_m
    back_m = grid.back_m[rows]
    down, across = np.gradient(back_m, grid.cell_m)
    with np.errstate(invalid="ignore"):
        hidden = ~(np.hypot(down, across) <= params.steepest)
    return float(hidden[about].mean()) if about.any() else 1.0
