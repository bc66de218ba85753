"""The loops behind `adibas.markers.position`: following a ray, and fitting the skin it meets.

Offsets are pixels divided by the patch radius, so that all terms of the quadratic are about 1.
"""

import math
from typing import NamedTuple

import numpy as np

from adibas.arrays import BoolArray, Float32Array, FloatArray, IntArray
from adibas.geometry.cholesky_kernels import factorise
from adibas.geometry.distortion_kernels import distort_point
from adibas.kernels import compiled
from adibas.markers.least_squares_kernels import solve_forward, solve_normal

N_TERMS = 6
N_SECTORS = 24
BIWEIGHT_CUT = 4.685
"""Of Tukey's biweight: 95 % efficient for normal noise."""
MAD_OF_NORMAL = 1.4826
N_ROBUST_ROUNDS = 5
MOST_PIXELS = 100
"""Neighbours share a matching window, so that a sample of a patch is as good as all of it."""
N_MEETINGS = 4
N_SETTLING = 6
GREATEST_REACH_PX = 12
NOTHING = -1.0


class Lens(NamedTuple):
    """A camera for the kernels; `k` are twelve distortion coefficients."""

    fx: float
    fy: float
    cx: float
    cy: float
    k: FloatArray


class Line(NamedTuple):
    """A colour pixel's ray in the depth camera's axes: origin + t * direction, metres."""

    origin_m: FloatArray
    direction: FloatArray


class Patch(NamedTuple):
    """`PositionParams` and its noise, for the kernels."""

    radius_rad: float
    greatest_radius_m: float
    close_m: float
    least_pixels: int
    least_share: float
    greatest_gap_rad: float
    nearest_m: float
    farthest_m: float
    step_m: float
    frame_sd_per_m: float
    quantum_per_m: float
    static_sd_per_m: float
    across_px: float
    down_px: float
    frames_per_sample: float
    relief_m: float
    relief_length_m: float


class Fit(NamedTuple):
    """Disparity (1/m) at a place, its slope a pixel in u and v, and its variance.

    A disparity of `NOTHING` means that there is no fit; `misfit` is the mean square of the whitened
    residuals, 1 where noise and model are as assumed, and `n_free` of them are independent.
    """

    disparity: float
    slope_u: float
    slope_v: float
    variance: float
    misfit: float
    n_free: int


@compiled
def point_on(line: Line, disparity: float) -> tuple[float, float, float]:
    """Return the point of the line at depth 1/disparity, metres."""
    z_m = 1.0 / disparity
    t = (z_m - line.origin_m[2]) / line.direction[2]
    x_m = line.origin_m[0] + t * line.direction[0]
    return x_m, line.origin_m[1] + t * line.direction[1], z_m


@compiled
def pixel_of(line: Line, disparity: float, lens: Lens) -> tuple[float, float]:
    """Return the depth pixel (u, v) of the line's point at depth 1/disparity."""
    x_m, y_m, z_m = point_on(line, disparity)
    distorted = distort_point(x_m / z_m, y_m / z_m, lens.k)
    return lens.fx * distorted[0] + lens.cx, lens.fy * distorted[1] + lens.cy


@compiled
def radius_at_m(disparity: float, patch: Patch) -> float:
    """Return how large the patch is at depth 1/disparity."""
    return min(patch.radius_rad / disparity, patch.greatest_radius_m)


@compiled
def _nearby(mean_per_m: Float32Array, u: float, v: float, reach: int) -> float:
    """Return the median disparity of the square about (u, v), `NOTHING` of fewer than 3."""
    height, width = mean_per_m.shape
    if not (-1.0 < u < width and -1.0 < v < height):
        return NOTHING
    column, row = math.floor(u + 0.5), math.floor(v + 0.5)
    found = np.empty((2 * reach + 1) ** 2)
    n_found = 0
    for r in range(max(row - reach, 0), min(row + reach + 1, height)):
        for c in range(max(column - reach, 0), min(column + reach + 1, width)):
            value = mean_per_m[r, c]
            if not math.isnan(value):
                found[n_found] = value
                n_found += 1
    if n_found < 3:  # noqa: PLR2004  (a median of fewer is one pixel)
        return NOTHING
    return float(np.median(found[:n_found]))


@compiled
def _seen_at(
    mean_per_m: Float32Array, line: Line, disparity: float, lens: Lens, patch: Patch
) -> float:
    """Return the disparity measured where the line's point would be seen, or close by."""
    u, v = pixel_of(line, disparity, lens)
    seen = _nearby(mean_per_m, u, v, 1)
    if seen != NOTHING:
        return seen
    reach = int(0.5 * patch.close_m * lens.fx * disparity)
    return _nearby(mean_per_m, u, v, min(max(reach, 2), GREATEST_REACH_PX))


@compiled
def _settle(
    mean_per_m: Float32Array, line: Line, disparity: float, lens: Lens, patch: Patch
) -> float:
    """Let line and surface meet; `NOTHING` where the line passes behind an outline."""
    for _ in range(N_SETTLING):
        seen = _seen_at(mean_per_m, line, disparity, lens, patch)
        if seen == NOTHING:
            return NOTHING
        change_m = abs(1.0 / seen - 1.0 / disparity)
        disparity = seen
        if change_m < 0.125 * patch.step_m:
            return disparity
    return NOTHING


@compiled
def follow(mean_per_m: Float32Array, line: Line, lens: Lens, patch: Patch) -> float:
    """Walk along the line to the first surface and return its disparity, or `NOTHING`."""
    first, last = 1.0 / patch.nearest_m, 1.0 / patch.farthest_m
    begin, end = pixel_of(line, first, lens), pixel_of(line, last, lens)
    length_px = math.hypot(begin[0] - end[0], begin[1] - end[1])
    if not length_px < 1e4:  # noqa: PLR2004  (also NaN: the ray leaves the depth camera's view)
        return NOTHING
    n_steps = 2 * int(length_px) + 4
    for i in range(n_steps):
        disparity = first + (last - first) * i / (n_steps - 1)
        if _seen_at(mean_per_m, line, disparity, lens, patch) >= disparity:
            settled = _settle(mean_per_m, line, disparity, lens, patch)
            if settled != NOTHING:
                return settled
    return NOTHING


@compiled
def _apart_m(du: float, dv: float, expected: float, middle: float, lens: Lens) -> float:
    """Return how far in space the surface at a pixel's offset is from the middle."""
    if expected <= 0.0:
        return math.inf
    along_m = 1.0 / expected - 1.0 / middle
    return math.hypot(math.hypot(du / lens.fx, dv / lens.fy) / expected, along_m)


@compiled
def _reading(
    mean_per_m: Float32Array, row: int, column: int, expected: float, step_m: float
) -> float:
    """Return the disparity of a pixel if it lies on the surface expected, else `NOTHING`."""
    height, width = mean_per_m.shape
    if not (0 <= row < height and 0 <= column < width):
        return NOTHING
    value = float(mean_per_m[row, column])
    is_on_surface = value > 0.0 and abs(1.0 / value - 1.0 / expected) < step_m
    return value if is_on_surface else NOTHING


@compiled
def _gather(
    mean_per_m: Float32Array, u0: float, v0: float, before: Fit, lens: Lens, patch: Patch
) -> tuple[FloatArray, FloatArray]:
    """Return the (N, N_TERMS + 1) terms and values of the pixels on the skin about (u0, v0).

    A pixel takes part if the surface fitted before passes it within the radius in space, and its
    own reading lies on that surface. Beside them the pixels (N, 2) themselves. Nothing (N = 0)
    where those close to the middle are too few or leave too wide a gap.
    """
    radius_m = radius_at_m(before.disparity, patch)
    radius_px = radius_m * lens.fx * before.disparity
    reach = int(radius_px) + 1
    rows = np.empty(((2 * reach + 3) ** 2, N_TERMS + 1))
    pixels = np.empty((rows.shape[0], 2))
    sectors = np.zeros(N_SECTORS, np.int64)
    n_close, n_taken = 0, 0
    for row in range(int(v0) - reach, int(v0) + reach + 2):
        for column in range(int(u0) - reach, int(u0) + reach + 2):
            du, dv = column - u0, row - v0
            expected = before.disparity + before.slope_u * du + before.slope_v * dv
            apart_m = _apart_m(du, dv, expected, before.disparity, lens)
            if apart_m > radius_m:
                continue
            n_close += apart_m <= patch.close_m
            value = _reading(mean_per_m, row, column, expected, patch.step_m)
            if value == NOTHING:
                continue
            sectors[_sector(du, dv)] += apart_m <= patch.close_m
            x, y = du / radius_px, dv / radius_px
            rows[n_taken] = np.array((1.0, x, y, x * x, x * y, y * y, value))
            pixels[n_taken, 0], pixels[n_taken, 1] = column, row
            n_taken += 1
    is_enough = sectors.sum() >= max(patch.least_pixels, patch.least_share * n_close)
    if not is_enough or _greatest_gap_rad(sectors > 0) > patch.greatest_gap_rad:
        n_taken = 0
    return rows[:n_taken], pixels[:n_taken]


@compiled
def _sector(du: float, dv: float) -> int:
    """Return in which of the sectors about the middle an offset is."""
    return int((math.atan2(dv, du) / (2.0 * math.pi) + 0.5) * N_SECTORS) % N_SECTORS


@compiled
def _greatest_gap_rad(sectors: BoolArray) -> float:
    """Return the widest run of empty sectors."""
    longest, run = 0, 0
    for i in range(2 * N_SECTORS):
        run = 0 if sectors[i % N_SECTORS] else run + 1
        longest = max(longest, run)
    return 2.0 * math.pi * min(longest, N_SECTORS) / N_SECTORS


@compiled
def _robust(rows: FloatArray, least_scale: float, kept: BoolArray) -> FloatArray:
    """Return the coefficients after some rounds of Tukey's biweight; mark the inliers in `kept`."""
    n = rows.shape[0]
    weighted = np.empty_like(rows)
    solution = np.zeros((N_TERMS, N_TERMS + 1))
    coefficients = np.zeros(N_TERMS)
    residuals = np.empty(n)
    weights = np.ones(n)
    kept[:] = True
    for _ in range(N_ROBUST_ROUNDS):
        for i in range(n):
            root = math.sqrt(weights[i])
            for j in range(N_TERMS + 1):
                weighted[i, j] = root * rows[i, j]
        if not solve_normal(weighted, solution):
            kept[:] = False
            break
        coefficients[:] = solution[:, N_TERMS]
        for i in range(n):
            residual = rows[i, N_TERMS]
            for j in range(N_TERMS):
                residual -= rows[i, j] * coefficients[j]
            residuals[i] = residual
        scale = max(least_scale, MAD_OF_NORMAL * float(np.median(np.abs(residuals))))
        for i in range(n):
            share = residuals[i] / (BIWEIGHT_CUT * scale)
            weights[i] = max(0.0, 1.0 - share * share) ** 2
            kept[i] = weights[i] > 0.0
    return coefficients


@compiled
def _sample(rows: FloatArray, pixels: FloatArray, kept: BoolArray) -> IntArray:
    """Return the indices of the inliers, or of about `MOST_PIXELS` of them spread evenly."""
    n_kept = int(kept.sum())
    every = 1 + (n_kept - 1) // MOST_PIXELS
    turn = max(1, int(0.618 * every + 0.5))
    chosen = np.empty(n_kept, np.int64)
    n_chosen = 0
    for i in range(rows.shape[0]):
        on_lattice = (int(pixels[i, 0]) + turn * int(pixels[i, 1])) % every == 0
        if kept[i] and on_lattice:
            chosen[n_chosen] = i
            n_chosen += 1
    return chosen[:n_chosen]


@compiled
def _noise(pixels: FloatArray, readings: FloatArray, patch: Patch) -> FloatArray:
    """Return the (N, N) covariance of the mean disparities of (N, 2) pixels.

    Two pixels share their matching windows in proportion to the overlap; rounding is each pixel's
    own. `readings` (N,) frames went into each mean.
    """
    n = pixels.shape[0]
    covariance = np.zeros((n, n))
    for i in range(n):
        samples_i = max(1.0, readings[i] / patch.frames_per_sample)
        for j in range(i + 1):
            across = 1.0 - abs(pixels[i, 0] - pixels[j, 0]) / patch.across_px
            down = 1.0 - abs(pixels[i, 1] - pixels[j, 1]) / patch.down_px
            if across > 0.0 and down > 0.0:
                samples_j = max(1.0, readings[j] / patch.frames_per_sample)
                random = patch.frame_sd_per_m**2 / math.sqrt(samples_i * samples_j)
                covariance[i, j] = across * down * (random + patch.static_sd_per_m**2)
        covariance[i, i] += patch.quantum_per_m**2 / 12.0 / samples_i
    return covariance


@compiled
def _alike(apart: float) -> float:
    """Return the correlation of Matern's process of order 3/2, `apart` in lengths by root 3.

    Source: Rasmussen & Williams 2006, equation 4.17.
    """
    return (1.0 + apart) * math.exp(-apart)


@compiled
def _add_relief(covariance: FloatArray, rows: FloatArray, disparity: float, patch: Patch) -> None:
    """Add to the (N, N) covariance what skin is beyond its quadratic.

    It is Matern's process, less its value in the middle: what is asked for is the skin there, and
    not a smoothed one. A depth that is off by d moves 1/z by d / z^2.
    """
    n = rows.shape[0]
    power = (patch.relief_m * disparity**2) ** 2
    per = math.sqrt(3.0) * radius_at_m(disparity, patch) / patch.relief_length_m
    middle = np.empty(n)
    for i in range(n):
        middle[i] = _alike(per * math.hypot(rows[i, 1], rows[i, 2]))
    for i in range(n):
        for j in range(i + 1):
            apart = per * math.hypot(rows[i, 1] - rows[j, 1], rows[i, 2] - rows[j, 2])
            covariance[i, j] += power * (1.0 + _alike(apart) - middle[i] - middle[j])


@compiled
def _generalised(
    rows: FloatArray,
    pixels: FloatArray,
    readings: FloatArray,
    disparity: float,
    radius_px: float,
    patch: Patch,
) -> Fit:
    """Fit with the covariance of noise and relief, so that the variance is honest."""
    factor = _noise(pixels, readings, patch)
    _add_relief(factor, rows, disparity, patch)
    solution = np.empty((N_TERMS, N_TERMS + 1))
    if rows.shape[0] < 2 * N_TERMS or not factorise(factor):
        return Fit(NOTHING, 0.0, 0.0, 0.0, 0.0, 0)
    whitened = rows.copy()
    solve_forward(factor, whitened)
    if not solve_normal(whitened, solution):
        return Fit(NOTHING, 0.0, 0.0, 0.0, 0.0, 0)
    squares = 0.0
    for i in range(rows.shape[0]):
        residual = whitened[i, N_TERMS]
        for j in range(N_TERMS):
            residual -= whitened[i, j] * solution[j, N_TERMS]
        squares += residual * residual
    variance = 0.0
    for j in range(N_TERMS):
        variance += solution[0, j] ** 2
    n_free = rows.shape[0] - N_TERMS
    return Fit(
        solution[0, N_TERMS],
        solution[1, N_TERMS] / radius_px,
        solution[2, N_TERMS] / radius_px,
        variance,
        squares / n_free,
        n_free,
    )


@compiled
def fit_skin(
    mean_per_m: Float32Array,
    n_readings: IntArray,
    line: Line,
    start_per_m: float,
    lens: Lens,
    patch: Patch,
) -> Fit:
    """Fit the skin about the place where the line meets it, first met near 1/`start_per_m`."""
    nothing = Fit(NOTHING, 0.0, 0.0, 0.0, 0.0, 0)
    fit = Fit(start_per_m, 0.0, 0.0, 0.0, 0.0, 0)
    for meeting in range(N_MEETINGS):
        u, v = pixel_of(line, fit.disparity, lens)
        if not (abs(u) < 1e5 and abs(v) < 1e5):  # noqa: PLR2004  (also NaN)
            return nothing
        rows, pixels = _gather(mean_per_m, u, v, fit, lens, patch)
        if rows.shape[0] < 2 * N_TERMS:
            return nothing
        radius_px = radius_at_m(fit.disparity, patch) * lens.fx * fit.disparity
        kept = np.empty(rows.shape[0], np.bool_)
        coefficients = _robust(rows, patch.frame_sd_per_m / 2.0, kept)
        if kept.sum() < 2 * N_TERMS or not coefficients[0] > 0.0:
            return nothing
        if meeting < N_MEETINGS - 1:
            slope_u, slope_v = coefficients[1] / radius_px, coefficients[2] / radius_px
            fit = Fit(coefficients[0], slope_u, slope_v, 0.0, 0.0, 0)
            continue
        chosen = _sample(rows, pixels, kept)
        readings = np.empty(chosen.shape[0])
        for i in range(chosen.shape[0]):
            column, row = pixels[chosen[i]]
            readings[i] = n_readings[int(row), int(column)]
        fit = _generalised(rows[chosen], pixels[chosen], readings, fit.disparity, radius_px, patch)
    return fit
