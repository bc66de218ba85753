"""The line of the spinous processes: where the left and the right of the back are most alike.

At each height the surface beside a place is mirrored onto the other side. What differs after a
turn about the vertical is taken out (the surface's rotation there) is the asymmetry; the line that
crosses the back from top to bottom with the least asymmetry and without jumps is the symmetry line.

Source: the line of symmetry of the back, Drerup, Rasterstereographic measurement of scoliotic
deformity, Scoliosis 9:22 (2014); that asymmetry is counted between mirrored heights, with the
rotation held back, is our own choice.
"""

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import make_smoothing_spline
from scipy.ndimage import uniform_filter1d

from adibas.arrays import FloatArray, IntArray, check_shape, read_only
from adibas.surface.back_grid import BackGrid


@dataclass(frozen=True, slots=True)
class SymmetryParams:
    """Settings of the search.

    Attributes
    ----------
    reach_m : float
        To either side that is compared: 110 mm, what lies between the shoulder blades' outer
        borders and never the arms.
    noise_m : float
        Of a mirrored difference: 4 mm; differences beyond three times this count no more.
    rotation_sd_rad : float
        Expected of the surface's rotation: 4 degrees.
    slope_sd : float
        Expected slant of the line: 0.08, five degrees.
    farthest_m : float
        From the middle of the trunk that the line may lie: 60 mm.
    alike_m : float
        Heights nearer than this see the same noise: 24 mm, seven pixels at 2 m.
    marker_sd_m : float
        Of a marker on a spinous process from the line: 3 mm.
    valley_m : float
        To either side of the way that the asymmetry is looked at to find its lowest place: 16 mm.
    shortest_wave_m : float
        Bends of the line over less are halved: 0.2 m, less than half a scoliotic curve.
    least_share : float
        Of `reach_m` that must be known to both sides: 0.35, what a neck has.
    """

    reach_m: float = 0.11
    noise_m: float = 0.004
    rotation_sd_rad: float = 0.07
    slope_sd: float = 0.08
    farthest_m: float = 0.06
    alike_m: float = 0.024
    marker_sd_m: float = 0.003
    valley_m: float = 0.016
    shortest_wave_m: float = 0.2
    least_share: float = 0.35


@dataclass(frozen=True, slots=True, eq=False)
class SymmetryLine:
    """Where the line is at each height; rows from the top down.

    Attributes
    ----------
    y_m, x_m : (H,) arrays
        Patient axes.
    rotation_rad : (H,) array
        Of the surface about the vertical; positive where its right side lies further back.
    asymmetry_m : (H,) array
        Root mean square of the mirrored differences that are left.
    """

    y_m: FloatArray
    x_m: FloatArray
    rotation_rad: FloatArray
    asymmetry_m: FloatArray

    def __post_init__(self) -> None:
        for array in (self.y_m, self.x_m, self.rotation_rad, self.asymmetry_m):
            check_shape("line", array, (len(self.y_m),))
            read_only(array)

    def at(self, y_m: FloatArray) -> FloatArray:
        """Return x at heights, metres; the ends' beyond them."""
        return np.interp(y_m, self.y_m[::-1], self.x_m[::-1])


def find_symmetry_line(
    grid: BackGrid,
    markers_m: FloatArray | None = None,
    params: SymmetryParams | None = None,
) -> SymmetryLine | None:
    """Return the symmetry line; None where the surface is not known around any place.

    Parameters
    ----------
    grid : BackGrid
        Of the trunk alone, from the neck to the sacrum.
    markers_m : (N, 3) array or None
        On spinous processes, patient axes.
    """
    params = params or SymmetryParams()
    middle_m = trunk_middles_m(grid)
    within = np.abs(grid.x_m[None, :] - middle_m[:, None]) <= params.farthest_m
    costs, slopes, squares = _asymmetries(grid, params)
    costs[~within] = np.inf
    kept = np.isfinite(costs).any(axis=1)
    if not kept.any():
        return None
    first, last = np.flatnonzero(kept)[[0, -1]]
    chosen = slice(int(first), int(last) + 1)
    costs = costs[chosen] * (grid.cell_m / params.alike_m)
    y_m = grid.y_m[chosen]
    for x, y in [] if markers_m is None else np.asarray(markers_m, float)[:, :2]:
        row = int(np.abs(y_m - y).argmin())
        costs[row] += ((grid.x_m - x) / params.marker_sd_m) ** 2
    # A row without any known place takes the way of its neighbours.
    costs[~np.isfinite(costs).any(axis=1)] = 0.0
    columns = _cheapest_way(costs, grid.cell_m, params)
    x_m = _smoothed(costs, columns, (grid.x_m, y_m), params)
    nearest = np.clip(np.rint((x_m - grid.x_m[0]) / grid.cell_m).astype(int), 0, len(grid.x_m) - 1)
    rows = np.arange(len(nearest))
    return SymmetryLine(
        y_m.copy(),
        x_m,
        np.arctan(slopes[chosen][rows, nearest]),
        np.sqrt(squares[chosen][rows, nearest]),
    )


def trunk_middles_m(grid: BackGrid) -> FloatArray:
    """Return x of the middle of what is known in each row, evened over 0.2 m."""
    known = np.isfinite(grid.back_m)
    count = known.sum(axis=1)
    total = (known * grid.x_m).sum(axis=1)
    n_rows = 2 * round(0.1 / grid.cell_m) + 1
    total, counted = (
        uniform_filter1d(sums.astype(float), n_rows, mode="nearest") for sums in (total, count)
    )
    middle: FloatArray = total / np.maximum(counted, 1e-9)
    return middle


def _asymmetries(
    grid: BackGrid, params: SymmetryParams
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return cost, slope and mean square of what is left, (H, W) each; inf or NaN: not known."""
    n_steps = round(params.reach_m / grid.cell_m)
    offsets_m = grid.cell_m * np.arange(1, n_steps + 1)
    height, width = grid.back_m.shape
    padded = np.pad(grid.back_m, ((0, 0), (n_steps, n_steps)), constant_values=np.nan)
    differences = np.stack(
        [
            padded[:, n_steps + k : n_steps + k + width]
            - padded[:, n_steps - k : n_steps - k + width]
            for k in range(1, n_steps + 1)
        ],
        axis=-1,
    )
    prior = params.noise_m**2 / np.tan(params.rotation_sd_rad) ** 2
    known = np.isfinite(differences)
    slopes = np.zeros((height, width))
    weights = known.astype(float)
    values = np.where(known, differences, 0.0)
    for _ in range(3):
        along = 2.0 * offsets_m
        slopes = (weights * values) @ along / (weights @ along**2 + prior)
        left = values - slopes[..., None] * along
        # Tukey's weights: beyond three times the noise nothing counts.
        share = np.minimum(np.abs(left) / (3.0 * params.noise_m), 1.0)
        weights = known * (1.0 - share**2) ** 2
    limit = (3.0 * params.noise_m) ** 2
    squares = np.where(known, np.minimum(left**2, limit), 0.0)
    n_known = known.sum(axis=-1)
    enough = n_known >= params.least_share * n_steps
    mean = np.where(enough, squares.sum(axis=-1) / np.maximum(n_known, 1), np.nan)
    # Neighbours within `alike_m` see the same noise.
    n_free = params.reach_m / params.alike_m
    cost = n_free * mean / params.noise_m**2 + (slopes / np.tan(params.rotation_sd_rad)) ** 2
    return np.where(enough, cost, np.inf), slopes, mean


def _cheapest_way(costs: FloatArray, cell_m: float, params: SymmetryParams) -> IntArray:
    """Return the column in each row of the way down with the least cost (dynamic programming).

    A step aside costs by its length alone, so that a slanted way is no dearer than its steps.
    """
    height, width = costs.shape
    steps = np.arange(-1, 2)
    price = np.abs(steps) * cell_m / (params.slope_sd * params.alike_m)
    total = costs[0].copy()
    came = np.zeros((height, width), np.int64)
    for row in range(1, height):
        padded = np.pad(total, 1, constant_values=np.inf)
        options = np.stack([padded[1 + s : 1 + s + width] for s in steps]) + price[:, None]
        best = options.argmin(axis=0)
        came[row] = np.clip(np.arange(width) + steps[best], 0, width - 1)
        total = options[best, np.arange(width)] + costs[row]
    way = np.empty(height, np.int64)
    way[-1] = int(total.argmin())
    for row in range(height - 1, 0, -1):
        way[row - 1] = came[row, way[row]]
    return way


def _smoothed(
    costs: FloatArray,
    columns: IntArray,
    axes_m: tuple[FloatArray, FloatArray],
    params: SymmetryParams,
) -> FloatArray:
    """Return x of each row: a smoothing spline through the lowest places near the way."""
    x_m, y_m = axes_m
    cell_m = float(x_m[1] - x_m[0])
    half = round(params.valley_m / cell_m)
    rows = np.arange(len(columns))[:, None]
    near = np.clip(columns[:, None] + np.arange(-half, half + 1), 0, len(x_m) - 1)
    offsets_m = x_m[near] - x_m[columns][:, None]
    values = costs[rows, near]
    known = np.isfinite(values).all(axis=1)
    # A parabola through the valley: its curvature is how surely the row knows its place.
    bend, tilt, _ = np.polyfit(offsets_m[len(rows) // 2], np.where(known, values.T, 0.0), 2)
    sure = known & (bend > 0)
    bend = np.where(sure, bend, 0.0)
    lowest_m = np.where(sure, -tilt / (2.0 * np.where(sure, bend, 1.0)), 0.0)
    target_m = x_m[columns] + np.clip(lowest_m, -params.valley_m, params.valley_m)
    weights = np.maximum(bend, 1e-3 * max(float(bend.max()), 1.0))
    stiffness = float(np.median(weights)) / cell_m * (params.shortest_wave_m / (2 * np.pi)) ** 4
    spline = make_smoothing_spline(-y_m, target_m, weights, lam=stiffness)
    return np.asarray(spline(-y_m))
