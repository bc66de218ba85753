"""Points of several views as one surface: one mean point for each cell of space."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from adibas.arrays import FloatArray, IntArray, check_shape, read_only


@dataclass(frozen=True, slots=True)
class MergeParams:
    """Settings.

    Attributes
    ----------
    cell_m : float
        Side of a cell: 5 mm, a pixel and a half at 2 m.
    least_cosine : float
        Points seen at a greater slant are left out: 0.34, 70 degrees.
    """

    cell_m: float = 0.005
    least_cosine: float = 0.34


@dataclass(frozen=True, slots=True, eq=False)
class BodySurface:
    """Points of a body in patient axes.

    Attributes
    ----------
    points_m, normals : (N, 3) arrays
        Normals point outward, unit length.
    weights : (N,) array
        How squarely and from how near the point was seen, summed over what was averaged.
    n_views : (N,) array
        How many views saw it.
    colors : (N, 3) array
        Of the view that saw the place most squarely and nearest; NaN where none is known.
    """

    points_m: FloatArray
    normals: FloatArray
    weights: FloatArray
    n_views: FloatArray
    colors: FloatArray

    def __post_init__(self) -> None:
        check_shape("points_m", self.points_m, (None, 3))
        check_shape("normals", self.normals, self.points_m.shape)
        check_shape("weights", self.weights, (len(self.points_m),))
        check_shape("n_views", self.n_views, (len(self.points_m),))
        check_shape("colors", self.colors, self.points_m.shape)
        for array in (self.points_m, self.normals, self.weights, self.n_views, self.colors):
            read_only(array)


@dataclass(frozen=True, slots=True, eq=False)
class SeenPoints:
    """What one view gives, patient axes.

    Attributes
    ----------
    points_m, normals : (N, 3) arrays
    cosines : (N,) array
        Of the angle between normal and line of sight.
    distances_m : (N,) array
        From the camera.
    colors : (N, 3) array
        Red, green and blue, 0 to 255; NaN where no colour was seen.
    """

    points_m: FloatArray
    normals: FloatArray
    cosines: FloatArray
    distances_m: FloatArray
    colors: FloatArray


def merge_points(views: Sequence[SeenPoints], params: MergeParams | None = None) -> BodySurface:
    """Average what lies in one cell, by how squarely and from how near it was seen.

    Raises
    ------
    ValueError
        No point is seen squarely enough.
    """
    params = params or MergeParams()
    kept = [view.cosines >= params.least_cosine for view in views]
    points_m, normals, cosines, distances_m, colors = (
        np.concatenate([getattr(view, name)[mask] for view, mask in zip(views, kept, strict=True)])
        for name in ("points_m", "normals", "cosines", "distances_m", "colors")
    )
    if not len(points_m):
        raise ValueError("no point is seen squarely enough")
    number = np.repeat(np.arange(len(views)), [int(mask.sum()) for mask in kept])
    # A structured-light sensor's error grows with the square of the distance.
    weights = cosines**2 / distances_m**4
    cells = np.floor(points_m / params.cell_m).astype(np.int64)
    _, place = np.unique(cells, axis=0, return_inverse=True)
    place = place.ravel()
    n_cells = int(place.max()) + 1
    total = np.bincount(place, weights, n_cells)

    def mean(values: FloatArray) -> FloatArray:
        columns = [np.bincount(place, weights * column, n_cells) for column in values.T]
        return np.stack(columns, axis=1) / total[:, None]

    normal = mean(normals)
    length = np.linalg.norm(normal, axis=1)
    seen = np.zeros((n_cells, len(views)), bool)
    seen[place, number] = True
    # Opposite sides that meet in a cell have no direction of their own.
    fine = length > 0.5  # noqa: PLR2004
    return BodySurface(
        mean(points_m)[fine],
        normal[fine] / length[fine, None],
        total[fine],
        seen[fine].sum(axis=1).astype(float),
        _best(colors, place, weights, n_cells)[fine],
    )


def _best(values: FloatArray, place: IntArray, weights: FloatArray, n_cells: int) -> FloatArray:
    """Return of each cell the (3,) values of its heaviest point that knows them."""
    best = np.full((n_cells, values.shape[1]), np.nan)
    known = np.flatnonzero(np.isfinite(values).all(axis=1))
    rising = known[np.argsort(weights[known], kind="stable")]
    best[place[rising]] = values[rising]  # the last of those that share a cell stays
    return best
