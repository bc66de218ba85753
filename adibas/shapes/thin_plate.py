"""The thin-plate spline: the least bent map that takes some points to others.

Source: Bookstein, Principal warps: thin-plate splines and the decomposition of deformations, PAMI
11 (1989), for the plane; Wahba, Spline models for observational data (1990), sections 2.4 and 4.1,
for other dimensions (kernel -r in space) and for smoothing.
"""

from dataclasses import dataclass

import numpy as np

from adibas.arrays import FloatArray, check_shape, read_only


@dataclass(frozen=True, slots=True, eq=False)
class Warp:
    """An affine map and what bends beside it.

    Attributes
    ----------
    centres : (N, D) array
        The points that it was made of.
    weights : (N, D) array
        Of the kernel at each; 0 for an affine map.
    affine : (D + 1, D) array
        The constant, then the linear part.
    bending_energy : float
        0 for an affine map; it does not change with the size of both sets of points together.
    """

    centres: FloatArray
    weights: FloatArray
    affine: FloatArray
    bending_energy: float

    def __post_init__(self) -> None:
        for array in (self.centres, self.weights, self.affine):
            read_only(array)

    def apply(self, points: FloatArray) -> FloatArray:
        """Map (M, D) points."""
        bent = _kernel(points, self.centres) @ self.weights
        return np.asarray(bent + self.affine[0] + points @ self.affine[1:])


def fit_warp(target: FloatArray, source: FloatArray, smoothing: float = 0.0) -> Warp | None:
    """Find the map from `source` to `target`.

    Parameters
    ----------
    target, source : (N, D) arrays
        The same points, D of 2 or 3.
    smoothing : float
        0 passes through every point; the larger, the nearer to an affine map, whatever the size
        of the shape; infinite is the affine map itself.

    Returns
    -------
    warp : Warp or None
        None where the points do not fix an affine map: fewer than D + 1, or flat.
    """
    check_shape("source", source, (None, None))
    check_shape("target", target, source.shape)
    n_points, n_dimensions = source.shape
    plane = np.column_stack([np.ones(n_points), source])
    if np.linalg.matrix_rank(source - source.mean(axis=0)) < n_dimensions:
        return None
    if np.isinf(smoothing):
        affine = np.asarray(np.linalg.lstsq(plane, target, rcond=None)[0], float)
        return Warp(source.copy(), np.zeros_like(source), affine, 0.0)
    size = float(np.sqrt(((source - source.mean(axis=0)) ** 2).sum(axis=1).mean()))
    kernel = _kernel(source, source)
    power = 2 if n_dimensions == 2 else 1  # noqa: PLR2004  (the kernel's own dimension)
    system = np.zeros((n_points + n_dimensions + 1,) * 2)
    system[:n_points, :n_points] = kernel + smoothing * size**power * np.eye(n_points)
    system[:n_points, n_points:] = plane
    system[n_points:, :n_points] = plane.T
    right = np.concatenate([target, np.zeros((n_dimensions + 1, n_dimensions))])
    solved = np.asarray(np.linalg.solve(system, right), float)
    weights, affine = solved[:n_points], solved[n_points:]
    energy = float((weights * (kernel @ weights)).sum()) * size**power / size**2
    return Warp(source.copy(), weights, affine, max(energy, 0.0))


def _kernel(points: FloatArray, centres: FloatArray) -> FloatArray:
    """Return the (M, N) kernel: r^2 log r in the plane, -r in space."""
    r = np.linalg.norm(points[:, None] - centres[None], axis=-1)
    if centres.shape[1] == 2:  # noqa: PLR2004  (the plane)
        return np.asarray(r**2 * np.log(np.where(r > 0, r, 1.0)))
    return np.asarray(-r)
