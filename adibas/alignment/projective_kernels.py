"""One step of alignment: what every source pixel says about a small motion."""

from typing import NamedTuple

import numpy as np

from adibas.alignment.registration_kernels import Coefficients, distorted
from adibas.arrays import Float32Array, FloatArray
from adibas.kernels import compiled

N_SUMS = 33
"""Of a row: 21 of the upper triangle, 6 of the right side, then these:"""
SQUARES, WEIGHTS, KNOWN, USED, FACED, BEFORE = 27, 28, 29, 30, 31, 32
N_MOTION = 6


class Goal(NamedTuple):
    """What a target offers to a kernel.

    ``planes`` (h, w, 3) from `fit_planes`, one for every ``cell_px`` pixels of the full image;
    ``lens`` fx, fy, cx, cy; ``coefficients`` of its distortion.
    """

    planes: Float32Array
    cell_px: int
    lens: tuple[float, float, float, float]
    coefficients: Coefficients
    is_distorted: bool


@compiled
def carried(motion: FloatArray, x: float, y: float, z: float) -> tuple[float, float, float]:
    """Return a point after a (3, 4) motion."""
    return (
        motion[0, 0] * x + motion[0, 1] * y + motion[0, 2] * z + motion[0, 3],
        motion[1, 0] * x + motion[1, 1] * y + motion[1, 2] * z + motion[1, 3],
        motion[2, 0] * x + motion[2, 1] * y + motion[2, 2] * z + motion[2, 3],
    )


@compiled
def place_in(goal: Goal, x: float, y: float) -> tuple[float, float]:
    """Return where a ray (x, y, 1) is seen: pixel u begins at u and ends before u + 1."""
    if goal.is_distorted:
        x, y = distorted(x, y, goal.coefficients)
    fx, fy, cx, cy = goal.lens
    return fx * x + cx + 0.5, fy * y + cy + 0.5


@compiled
def cell_of(goal: Goal, x: float, y: float, z: float) -> tuple[int, int]:
    """Return the row and column of the plane that is seen at a point; (-1, -1) beside the image."""
    if z <= 0.0:
        return -1, -1
    u, v = place_in(goal, x / z, y / z)
    column, row = u / goal.cell_px, v / goal.cell_px
    height, width, _ = goal.planes.shape
    if not (0.0 <= column < width and 0.0 <= row < height):
        return -1, -1
    return int(row), int(column)


@compiled
def _add(sums: FloatArray, gradient: FloatArray, weight: float, error: float) -> None:
    place = 0
    for i in range(N_MOTION):
        weighted = weight * gradient[i]
        for j in range(i, N_MOTION):
            sums[place] += weighted * gradient[j]
            place += 1
        sums[21 + i] -= weighted * error
    sums[SQUARES] += weight * error * error
    sums[WEIGHTS] += weight
    sums[USED] += 1.0


@compiled
def _set_gradient(gradient: FloatArray, normal: Float32Array, x: float, y: float, z: float) -> None:
    """Set how an error changes with a turn (first three) and a shift of a moved point."""
    nx, ny, nz = normal[0], normal[1], normal[2]
    gradient[0] = (y * nz - z * ny) / z
    gradient[1] = (z * nx - x * nz) / z
    gradient[2] = (x * ny - y * nx) / z
    gradient[3] = nx / z
    gradient[4] = ny / z
    gradient[5] = nz / z


@compiled
def sum_steps(
    inverse_per_m: Float32Array,
    rays: Float32Array,
    stride_px: int,
    goal: Goal,
    motion: FloatArray,
    scale_per_m: float,
) -> FloatArray:
    """Return the (rows, 33) sums of the normal equations of a twist, one for each row of pixels.

    A source pixel at ``p`` lies, moved, at ``p'``; the target's plane at the pixel where ``p'`` is
    seen says ``n . P = 1``. Its error in inverse depth is ``(n . p' - 1) / z'``, and changes with
    a turn w and shift t of ``p'`` by ``(p' x n) / z'`` and ``n / z'``. Weights are Tukey's.

    Parameters
    ----------
    inverse_per_m, rays : (H, W), (H, W, 2) float32 arrays
        Of the source.
    stride_px : int
        Every so many pixels take part.
    goal : Goal
        The target.
    motion : (3, 4) array
        Target from source.
    scale_per_m : float
        Errors beyond this count nothing.
    """
    height, width = inverse_per_m.shape
    n_rows = height // stride_px
    sums = np.zeros((n_rows, N_SUMS))
    for row in range(n_rows):
        v = row * stride_px + stride_px // 2
        gradient = np.empty(N_MOTION)
        for u in range(stride_px // 2, width, stride_px):
            inverse = inverse_per_m[v, u]
            if not inverse > 0.0:
                continue
            sums[row, KNOWN] += 1.0
            z = 1.0 / inverse
            px, py, pz = carried(motion, rays[v, u, 0] * z, rays[v, u, 1] * z, z)
            at_row, at_column = cell_of(goal, px, py, pz)
            if at_row < 0 or not np.isfinite(goal.planes[at_row, at_column, 0]):
                continue
            normal = goal.planes[at_row, at_column]
            error = (normal[0] * px + normal[1] * py + normal[2] * pz - 1.0) / pz
            sums[row, FACED] += 1.0
            if abs(error) < scale_per_m:
                _set_gradient(gradient, normal, px, py, pz)
                _add(sums[row], gradient, (1.0 - (error / scale_per_m) ** 2) ** 2, error)
            elif error < 0.0:
                sums[row, BEFORE] += 1.0
    return sums


def normal_equations(sums: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the (6, 6) matrix and the (6,) right side of all rows of `sum_steps`."""
    total = sums.sum(axis=0)
    matrix = np.zeros((N_MOTION, N_MOTION))
    matrix[np.triu_indices(N_MOTION)] = total[:21]
    matrix = matrix + np.triu(matrix, 1).T
    return matrix, total[21:27].copy()
