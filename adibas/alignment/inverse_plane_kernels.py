"""Planes through the neighbourhood of each pixel, in inverse depth.

A plane is linear in 1/z over the normalised image, and a structured-light sensor's noise is the
same everywhere in 1/z: plain least squares is the best estimator there is, at any distance.
"""

import numpy as np

from adibas.arrays import Float32Array, FloatArray
from adibas.kernels import compiled

SMALLEST_PIVOT = 1e-12
N_MOMENTS = 9
"""1, x, y, xx, xy, yy, d, dx, dy of a window, where d is 1/z less its middle's."""


@compiled
def _gather(
    inverse_per_m: Float32Array,
    rays: Float32Array,
    middle: tuple[int, int],
    half_px: int,
    gate_per_m: float,
    moments: FloatArray,
) -> None:
    """Sum the moments of those pixels of a window that lie on the surface of its middle."""
    height, width = inverse_per_m.shape
    v0, u0 = middle
    level, x0, y0 = inverse_per_m[v0, u0], rays[v0, u0, 0], rays[v0, u0, 1]
    moments[:] = 0.0
    for v in range(max(v0 - half_px, 0), min(v0 + half_px + 1, height)):
        for u in range(max(u0 - half_px, 0), min(u0 + half_px + 1, width)):
            off = inverse_per_m[v, u] - level
            if not abs(off) <= gate_per_m:  # true for NaN
                continue
            x, y = rays[v, u, 0] - x0, rays[v, u, 1] - y0
            moments[0] += 1.0
            moments[1] += x
            moments[2] += y
            moments[3] += x * x
            moments[4] += x * y
            moments[5] += y * y
            moments[6] += off
            moments[7] += off * x
            moments[8] += off * y


@compiled
def _slopes(moments: FloatArray) -> tuple[float, float]:
    """Return how 1/z grows with x and y; NaN where the pixels lie on a line."""
    n, sx, sy, sxx, sxy, syy, sd, sdx, sdy = moments
    cxx, cxy, cyy = sxx - sx * sx / n, sxy - sx * sy / n, syy - sy * sy / n
    cdx, cdy = sdx - sd * sx / n, sdy - sd * sy / n
    pivot = cxx * cyy - cxy * cxy
    if not pivot > SMALLEST_PIVOT * cxx * cyy:
        return np.nan, np.nan
    return (cdx * cyy - cdy * cxy) / pivot, (cdy * cxx - cdx * cxy) / pivot


@compiled
def fit_planes(
    inverse_per_m: Float32Array,
    rays: Float32Array,
    half_px: int,
    step_px: int,
    gate_per_m: float,
    least_px: int,
) -> Float32Array:
    """Return (h, w, 3) planes (b, c, a) of ``1/z = a + b x + c y``, one for each `step_px` pixels.

    Read as a vector n they are planes ``n . P = 1`` of points P in the camera's axes.

    Parameters
    ----------
    inverse_per_m : (H, W) float32 array
        1/z; NaN where not measured.
    rays : (H, W, 2) float32 array
        Normalised image coordinates x, y.
    half_px : int
        The window has 2 half_px + 1 pixels a side.
    gate_per_m : float
        Pixels that differ by more from the middle one belong to another surface.
    least_px : int
        Of a window's pixels on the surface; fewer, and the plane is NaN.
    """
    height, width = inverse_per_m.shape
    n_rows, n_columns = height // step_px, width // step_px
    planes = np.full((n_rows, n_columns, 3), np.nan, np.float32)
    for row in range(n_rows):
        moments = np.empty(N_MOMENTS)
        v = row * step_px + step_px // 2
        for column in range(n_columns):
            u = column * step_px + step_px // 2
            if not np.isfinite(inverse_per_m[v, u]):
                continue
            _gather(inverse_per_m, rays, (v, u), half_px, gate_per_m, moments)
            if moments[0] < least_px:
                continue
            b, c = _slopes(moments)
            level = (
                inverse_per_m[v, u] + (moments[6] - b * moments[1] - c * moments[2]) / moments[0]
            )
            planes[row, column, 0] = b
            planes[row, column, 1] = c
            planes[row, column, 2] = level - b * rays[v, u, 0] - c * rays[v, u, 1]
    return planes


@compiled
def halved(inverse_per_m: Float32Array, gate_per_m: float) -> Float32Array:
    """Return (H / 2, W / 2): the mean of those of four pixels that lie on the nearest surface."""
    height, width = inverse_per_m.shape
    small = np.full((height // 2, width // 2), np.nan, np.float32)
    for row in range(height // 2):
        for column in range(width // 2):
            nearest = -np.inf
            for k in range(4):
                value = inverse_per_m[2 * row + k // 2, 2 * column + k % 2]
                nearest = value if value > nearest else nearest  # noqa: FURB136  (NaN must lose)
            total, n = 0.0, 0
            for k in range(4):
                value = inverse_per_m[2 * row + k // 2, 2 * column + k % 2]
                if nearest - value <= gate_per_m:
                    total += value
                    n += 1
            if n > 0:
                small[row, column] = total / n
    return small
