"""The loops behind `adibas.geometry.distortion`, compiled; coefficients are always twelve here.

The map is inverted by Newton's method whose steps are halved until they stay where the model is
one-to-one. Newton's flow keeps the direction of the residual, so that a start inside this region
leads to the root inside it, never to one beyond the fold.
"""

import math

import numpy as np

from adibas.arrays import BoolArray, FloatArray
from adibas.kernels import compiled

N_RADII = 1024
WIDEST_RAD = math.radians(86.0)
N_GUESSES = 1024
# The limit is tabulated by direction; within this share of it the sign of the determinant decides.
LIMIT_SLACK = 1.01
MAX_STEPS = 40
SMALLEST_STEP = 1.0 / 128.0
NEARLY_DONE = 1e-13
ACCEPTED = 2e-14


@compiled
def distort_point(
    x: float, y: float, k: FloatArray
) -> tuple[float, float, float, float, float, float, float]:
    """Return (x'', y''), the Jacobian (xx, xy, yx, yy) and the denominator of the radial part."""
    r2 = x * x + y * y
    numerator = 1.0 + r2 * (k[0] + r2 * (k[1] + r2 * k[4]))
    denominator = 1.0 + r2 * (k[5] + r2 * (k[6] + r2 * k[7]))
    if denominator == 0.0:
        denominator = math.nan
    radial = numerator / denominator
    numerator_slope = k[0] + r2 * (2.0 * k[1] + r2 * 3.0 * k[4])
    denominator_slope = k[5] + r2 * (2.0 * k[6] + r2 * 3.0 * k[7])
    # Twice the slope by r^2, since the slope of r^2 by x is 2 x.
    slope = 2.0 * (numerator_slope - radial * denominator_slope) / denominator
    p1, p2 = k[2], k[3]
    prism_x = 2.0 * (k[8] + 2.0 * k[9] * r2)
    prism_y = 2.0 * (k[10] + 2.0 * k[11] * r2)
    out_x = x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x) + r2 * (k[8] + k[9] * r2)
    out_y = y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y + r2 * (k[10] + k[11] * r2)
    cross = x * y * slope + 2.0 * p1 * x + 2.0 * p2 * y
    xx = radial + x * x * slope + 2.0 * p1 * y + 6.0 * p2 * x + prism_x * x
    yy = radial + y * y * slope + 6.0 * p1 * y + 2.0 * p2 * x + prism_y * y
    return out_x, out_y, xx, cross + prism_x * y, cross + prism_y * x, yy, denominator


@compiled
def distort_points(points: FloatArray, k: FloatArray) -> FloatArray:
    """Distort (N, 2) normalised points."""
    distorted = np.empty_like(points)
    for i in range(points.shape[0]):
        result = distort_point(points[i, 0], points[i, 1], k)
        distorted[i, 0] = result[0]
        distorted[i, 1] = result[1]
    return distorted


@compiled
def is_regular(x: float, y: float, k: FloatArray) -> bool:
    """Say whether the map keeps its orientation at (x, y), short of any pole."""
    _, _, xx, xy, yx, yy, denominator = distort_point(x, y, k)
    return denominator > 0.0 and xx * yy - xy * yx > 0.0


@compiled
def first_fold(direction_rad: float, k: FloatArray) -> float:
    """Return the radius at which a ray from the axis first meets a fold or pole, or the widest."""
    c, s = math.cos(direction_rad), math.sin(direction_rad)
    inside = 0.0
    for i in range(1, N_RADII + 1):
        outside = math.tan(WIDEST_RAD * i / N_RADII)
        if not is_regular(outside * c, outside * s, k):
            break
        inside = outside
    if inside == outside:
        return inside
    while True:
        middle = 0.5 * (inside + outside)
        if middle in (inside, outside):
            return inside
        if is_regular(middle * c, middle * s, k):
            inside = middle
        else:
            outside = middle


@compiled
def fold_radii(n_directions: int, k: FloatArray) -> FloatArray:
    """Return the radius of the first fold for evenly spread directions, from 0 on."""
    radii = np.empty(n_directions)
    for i in range(n_directions):
        radii[i] = first_fold(2.0 * math.pi * i / n_directions, k)
    return radii


@compiled
def is_within(x: float, y: float, folds: FloatArray, smallest_fold: float) -> bool:
    """Say whether (x, y) is nearer than the fold in its direction, with the slack of the table."""
    radius = math.sqrt(x * x + y * y)
    if radius <= smallest_fold or not math.isfinite(radius):
        return math.isfinite(radius)
    turn = (math.atan2(y, x) / (2.0 * math.pi)) % 1.0 * folds.size
    low = int(turn)
    share = turn - low
    limit = folds[low % folds.size] * (1.0 - share) + folds[(low + 1) % folds.size] * share
    return bool(radius <= limit * LIMIT_SLACK)


@compiled
def invert_point(  # noqa: PLR0913, PLR0917  (kernel: a params object would be boxed at every call)
    target_x: float,
    target_y: float,
    x: float,
    y: float,
    k: FloatArray,
    folds: FloatArray,
    smallest_fold: float,
) -> tuple[float, float]:
    """Return the point that distorts into the target, sought from (x, y); NaN if there is none."""
    fx, fy, xx, xy, yx, yy, _ = distort_point(x, y, k)
    ex, ey = target_x - fx, target_y - fy
    error = math.sqrt(ex * ex + ey * ey)
    scale = 1.0 + math.sqrt(target_x * target_x + target_y * target_y)
    for _ in range(MAX_STEPS):
        determinant = xx * yy - xy * yx
        if not determinant > 0.0:
            break
        step_x = (yy * ex - xy * ey) / determinant
        step_y = (xx * ey - yx * ex) / determinant
        is_last = error < NEARLY_DONE * scale
        shortest = 1.0 if is_last else SMALLEST_STEP
        length = 1.0
        while length >= shortest:
            new_x, new_y = x + length * step_x, y + length * step_y
            fx, fy, xx, xy, yx, yy, denominator = distort_point(new_x, new_y, k)
            ex, ey = target_x - fx, target_y - fy
            new_error = math.sqrt(ex * ex + ey * ey)
            is_better = new_error <= (1.0 - 0.25 * length) * error
            is_sound = denominator > 0.0 and xx * yy - xy * yx > 0.0
            if is_better and is_sound and is_within(new_x, new_y, folds, smallest_fold):
                break
            length *= 0.5
        if length < shortest:
            break
        x, y, error = new_x, new_y, new_error
        if is_last:
            break
    if error <= ACCEPTED * scale:
        return x, y
    return math.nan, math.nan


@compiled
def invert_points(
    points: FloatArray,
    k: FloatArray,
    folds: FloatArray,
    guesses: FloatArray,
    farthest: float,
) -> FloatArray:
    """Undistort (N, 2) points; NaN where nothing inside the folds distorts into them.

    `guesses` holds the radius before distortion, by the radial terms alone, for distorted radii r
    that are evenly spread in r / (1 + r); none distorts into more than `farthest`.
    """
    found = np.full_like(points, np.nan)
    smallest_fold = folds.min()
    for i in range(points.shape[0]):
        target_x, target_y = points[i, 0], points[i, 1]
        radius = math.sqrt(target_x * target_x + target_y * target_y)
        if not radius <= farthest:
            continue
        guess = guesses[int(radius / (1.0 + radius) * guesses.size)]
        ratio = guess / radius if radius > 0.0 else 0.0
        x, y = invert_point(
            target_x, target_y, target_x * ratio, target_y * ratio, k, folds, smallest_fold
        )
        if math.isnan(x):
            x, y = invert_point(target_x, target_y, 0.0, 0.0, k, folds, smallest_fold)
        found[i, 0] = x
        found[i, 1] = y
    return found


@compiled
def are_one_to_one(points: FloatArray, k: FloatArray, folds: FloatArray) -> BoolArray:
    """Say of (N, 2) undistorted points whether they lie inside the folds; False for NaN."""
    inside = np.empty(points.shape[0], np.bool_)
    smallest_fold = folds.min()
    for i in range(points.shape[0]):
        x, y = points[i, 0], points[i, 1]
        inside[i] = is_within(x, y, folds, smallest_fold) and is_regular(x, y, k)
    return inside
