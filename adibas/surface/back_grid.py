"""The back as a height field over the frontal plane: how far each place reaches to the back."""

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import gaussian_filter

from adibas.arrays import FloatArray, check_shape, read_only


@dataclass(frozen=True, slots=True)
class GridParams:
    """How points become a grid.

    Attributes
    ----------
    cell_m : float
        Side of a cell: 4 mm, about a pixel at 2 m.
    smoothing_m : float
        Standard deviation of the Gaussian that smooths: 8 mm, a quarter of the 9 x 7 pixels over
        which a structured-light sensor's noise is alike (Konolige & Mihelich 2011), at 2 m.
    least_weight : float
        A cell is known where so much of the Gaussian's weight holds points: 0.25.
    """

    cell_m: float = 0.004
    smoothing_m: float = 0.008
    least_weight: float = 0.25


@dataclass(frozen=True, slots=True, eq=False)
class BackGrid:
    """Height field in patient axes.

    Attributes
    ----------
    x_m : (W,) array
        Columns, to the patient's right.
    y_m : (H,) array
        Rows from the top down.
    back_m : (H, W) array
        z of the surface; NaN where it is not known.
    """

    x_m: FloatArray
    y_m: FloatArray
    back_m: FloatArray

    def __post_init__(self) -> None:
        check_shape("back_m", self.back_m, (len(self.y_m), len(self.x_m)))
        for array in (self.x_m, self.y_m, self.back_m):
            read_only(array)

    @property
    def cell_m(self) -> float:
        """Side of a cell."""
        return float(self.x_m[1] - self.x_m[0])


def grid_of(points_m: FloatArray, params: GridParams | None = None) -> BackGrid:
    """Return the smoothed height field of (N, 3) points in patient axes.

    Raises
    ------
    ValueError
        There are no points.
    """
    params = params or GridParams()
    check_shape("points_m", points_m, (None, 3))
    if not len(points_m):
        raise ValueError("a surface has points")
    cell_m = params.cell_m
    low = np.floor(points_m[:, :2].min(axis=0) / cell_m)
    columns, rows = (np.floor(points_m[:, :2] / cell_m) - low).astype(int).T
    shape = (int(rows.max()) + 1, int(columns.max()) + 1)
    at = rows * shape[1] + columns
    count = np.bincount(at, minlength=shape[0] * shape[1]).reshape(shape).astype(float)
    total = np.bincount(at, points_m[:, 2], minlength=shape[0] * shape[1]).reshape(shape)
    sd_cells = params.smoothing_m / cell_m
    has_point = (count > 0).astype(float)
    weight = gaussian_filter(has_point, sd_cells)
    mean = np.divide(total, count, out=np.zeros(shape), where=count > 0)
    with np.errstate(invalid="ignore", divide="ignore"):
        back = gaussian_filter(mean, sd_cells) / weight
    back[weight < params.least_weight] = np.nan
    x_m = (low[0] + 0.5 + np.arange(shape[1])) * cell_m
    y_m = (low[1] + 0.5 + np.arange(shape[0])) * cell_m
    return BackGrid(x_m, y_m[::-1].copy(), back[::-1].copy())
