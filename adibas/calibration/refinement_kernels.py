"""The loops of the joint refinement, compiled.

The normal equations of all views have an arrow's shape: a block A of the camera, a 6 x 6 block C
for each pose, and B between them. A pose moves as ``R <- exp(w) R``, ``t <- t + dt``, so that a
point p of the camera's frame moves by ``w x (p - t) + dt``.

Source: Triggs et al., Bundle adjustment, a modern synthesis (2000), section 6.1 (Schur
complement); Holland & Welsch 1977 (iterated weights).
"""

import math
from typing import NamedTuple

import numpy as np

from adibas.arrays import FloatArray, IntArray
from adibas.geometry.projection_kernels import project_with_slopes
from adibas.kernels import compiled

PLAIN, HUBER, TUKEY = 0, 1, 2
N_CAMERA = 17
N_POSE = 6


class Views(NamedTuple):
    """What was seen: (P, 3) points, (V, P, 2) pixels, (V, P) standard deviations.

    The last are infinite where a corner is hidden.
    """

    points_m: FloatArray
    pixels: FloatArray
    sigmas_px: FloatArray


class Guess(NamedTuple):
    """A camera (17,), and (V, 3, 3) and (V, 3) of its boards' poses."""

    camera: FloatArray
    rotations: FloatArray
    translations_m: FloatArray


class Arrow(NamedTuple):
    """Normal equations J'WJ and J'W residual of each view: (V, m, m), (V, m, 6), (V, 6, 6).

    Then (V, m) and (V, 6). To the solution only the sums of the first and the fourth matter.
    """

    a: FloatArray
    b: FloatArray
    c: FloatArray
    slope_a: FloatArray
    slope_c: FloatArray


class Corner(NamedTuple):
    """Room for one corner: its place from the board's origin and in space, and derivatives."""

    turned: FloatArray
    point: FloatArray
    by_camera: FloatArray
    by_point: FloatArray
    row: FloatArray


@compiled
def loss_and_weight(residual: float, kind: int, cut: float) -> tuple[float, float]:
    """Return 2 rho(residual) and rho' / residual; residual >= 0 and limit in sigmas."""
    if kind == HUBER:
        if residual <= cut:
            return residual * residual, 1.0
        return cut * (2.0 * residual - cut), cut / residual
    if kind == TUKEY:
        if residual >= cut:
            return cut * cut / 3.0, 0.0
        share = 1.0 - (residual / cut) ** 2
        return cut * cut / 3.0 * (1.0 - share**3), share * share
    return residual * residual, 1.0


@compiled
def room(m: int) -> Corner:
    """Return room for one corner and m unknowns of the camera."""
    return Corner(
        np.empty(3),
        np.empty(3),
        np.empty((2, N_CAMERA)),
        np.empty((2, 3)),
        np.empty(m + N_POSE),
    )


@compiled
def place(view: int, corner: int, views: Views, guess: Guess, into: Corner) -> None:
    """Move a corner of the board into the camera's frame."""
    for i in range(3):
        into.turned[i] = 0.0
        for j in range(3):
            into.turned[i] += guess.rotations[view, i, j] * views.points_m[corner, j]
        into.point[i] = into.turned[i] + guess.translations_m[view, i]


@compiled
def residuals_of(views: Views, guess: Guess) -> FloatArray:
    """Return (V, P, 2) observed minus projected pixels; NaN where hidden or behind the camera."""
    n_views, n_corners = views.sigmas_px.shape
    residuals = np.full((n_views, n_corners, 2), np.nan)
    at = room(0)
    for v in range(n_views):
        for p in range(n_corners):
            place(v, p, views, guess, at)
            if at.point[2] > 0.0:
                u_px, v_px = project_with_slopes(at.point, guess.camera, at.by_camera, at.by_point)
                residuals[v, p, 0] = views.pixels[v, p, 0] - u_px
                residuals[v, p, 1] = views.pixels[v, p, 1] - v_px
    return residuals


@compiled
def add_corner(
    at: Corner,
    free: IntArray,
    weight: float,
    errors_px: tuple[float, float],
    block: FloatArray,
    slope: FloatArray,
) -> None:
    """Add both coordinates of a corner to a view's lower triangle and slope."""
    m, row, turned = free.size, at.row, at.turned
    for axis in range(2):
        for i in range(m):
            row[i] = at.by_camera[axis, free[i]]
        x, y, z = at.by_point[axis, 0], at.by_point[axis, 1], at.by_point[axis, 2]
        row[m] = z * turned[1] - y * turned[2]
        row[m + 1] = x * turned[2] - z * turned[0]
        row[m + 2] = y * turned[0] - x * turned[1]
        row[m + 3] = x
        row[m + 4] = y
        row[m + 5] = z
        for i in range(m + N_POSE):
            scaled = weight * row[i]
            slope[i] += scaled * errors_px[axis]
            for j in range(i + 1):
                block[i, j] += scaled * row[j]


@compiled
def store_view(v: int, block: FloatArray, slope: FloatArray, arrow: Arrow) -> None:
    """Put a view's lower triangle and slope into the arrow."""
    m = arrow.a.shape[1]
    for i in range(m):
        arrow.slope_a[v, i] = slope[i]
        for j in range(i + 1):
            arrow.a[v, i, j] = block[i, j]
            arrow.a[v, j, i] = block[i, j]
    for i in range(N_POSE):
        arrow.slope_c[v, i] = slope[m + i]
        for j in range(m):
            arrow.b[v, j, i] = block[m + i, j]
        for j in range(i + 1):
            arrow.c[v, i, j] = block[m + i, m + j]
            arrow.c[v, j, i] = block[m + i, m + j]


@compiled
def accumulate(
    views: Views, guess: Guess, free: IntArray, kind: int, cut: float, arrow: Arrow
) -> float:
    """Fill the arrow and return the loss, infinite where a seen point is not in front."""
    m = free.size
    at = room(m)
    block = np.empty((m + N_POSE, m + N_POSE))
    slope = np.empty(m + N_POSE)
    total = 0.0
    for v in range(views.pixels.shape[0]):
        block[:] = 0.0
        slope[:] = 0.0
        for p in range(views.pixels.shape[1]):
            sigma_px = views.sigmas_px[v, p]
            if math.isinf(sigma_px):
                continue
            place(v, p, views, guess, at)
            if not at.point[2] > 0.0:
                return math.inf
            u_px, v_px = project_with_slopes(at.point, guess.camera, at.by_camera, at.by_point)
            errors_px = (views.pixels[v, p, 0] - u_px, views.pixels[v, p, 1] - v_px)
            size = math.sqrt(errors_px[0] ** 2 + errors_px[1] ** 2) / sigma_px
            loss, weight = loss_and_weight(size, kind, cut)
            total += loss
            if weight > 0.0:
                add_corner(at, free, weight / (sigma_px * sigma_px), errors_px, block, slope)
        store_view(v, block, slope, arrow)
    return total


@compiled
def factorise(matrix: FloatArray) -> bool:
    """Replace the lower triangle by Cholesky's factor; return False where it is not positive."""
    n = matrix.shape[0]
    for j in range(n):
        for k in range(j):
            matrix[j, j] -= matrix[j, k] * matrix[j, k]
        if not matrix[j, j] > 0.0:
            return False
        matrix[j, j] = math.sqrt(matrix[j, j])
        for i in range(j + 1, n):
            for k in range(j):
                matrix[i, j] -= matrix[i, k] * matrix[j, k]
            matrix[i, j] /= matrix[j, j]
    return True


@compiled
def substitute(factor: FloatArray, vector: FloatArray) -> None:
    """Solve with the factor of `factorise`, in place."""
    n = vector.size
    for i in range(n):
        for k in range(i):
            vector[i] -= factor[i, k] * vector[k]
        vector[i] /= factor[i, i]
    for i in range(n - 1, -1, -1):
        for k in range(i + 1, n):
            vector[i] -= factor[k, i] * vector[k]
        vector[i] /= factor[i, i]


@compiled
def pose_factor(damping: float, pose: FloatArray, factor: FloatArray) -> bool:
    """Fill the factor of a pose's damped block; return False where it is not positive."""
    factor[:] = pose
    for i in range(N_POSE):
        factor[i, i] *= 1.0 + damping
    return factorise(factor)


@compiled
def eliminate_pose(
    view: int, arrow: Arrow, factor: FloatArray, reduced: FloatArray, step_a: FloatArray
) -> None:
    """Take what a pose explains from the camera's lower triangle and slope."""
    kept = arrow.slope_c[view].copy()
    substitute(factor, kept)
    solved = np.empty(N_POSE)
    for i in range(step_a.size):
        solved[:] = arrow.b[view, i]
        substitute(factor, solved)
        for k in range(N_POSE):
            step_a[i] -= arrow.b[view, i, k] * kept[k]
        for j in range(i + 1):
            for k in range(N_POSE):
                reduced[i, j] -= solved[k] * arrow.b[view, j, k]


@compiled
def follow(
    view: int, arrow: Arrow, factor: FloatArray, step_a: FloatArray, step: FloatArray
) -> None:
    """Fill the step of a pose that goes with the camera's."""
    for k in range(N_POSE):
        step[k] = arrow.slope_c[view, k]
        for i in range(step_a.size):
            step[k] -= arrow.b[view, i, k] * step_a[i]
    substitute(factor, step)


@compiled
def solve_arrow(
    damping: float, arrow: Arrow, reduced: FloatArray, step_a: FloatArray, step_c: FloatArray
) -> bool:
    """Solve the damped normal equations (diagonals times 1 + damping); False where singular.

    `reduced` (m, m) becomes the factor of the Schur complement over the poses.
    """
    factor = np.empty((N_POSE, N_POSE))
    reduced[:] = 0.0
    step_a[:] = 0.0
    for v in range(step_c.shape[0]):
        reduced += arrow.a[v]
        step_a += arrow.slope_a[v]
    for i in range(step_a.size):
        reduced[i, i] *= 1.0 + damping
    for v in range(step_c.shape[0]):
        if not pose_factor(damping, arrow.c[v], factor):
            return False
        eliminate_pose(v, arrow, factor, reduced, step_a)
    if not factorise(reduced):
        return False
    substitute(reduced, step_a)
    for v in range(step_c.shape[0]):
        pose_factor(damping, arrow.c[v], factor)
        follow(v, arrow, factor, step_a, step_c[v])
    return True


@compiled
def turn(
    rotations: FloatArray, translations_m: FloatArray, step: FloatArray, turned: FloatArray
) -> FloatArray:
    """Fill `turned` with exp(w) R for (V, 6) steps (w, dt); return the moved translations.

    Source: Rodrigues' formula.
    """
    moved = np.empty_like(translations_m)
    move = np.empty((3, 3))
    for v in range(rotations.shape[0]):
        x, y, z = step[v, 0], step[v, 1], step[v, 2]
        angle2 = x * x + y * y + z * z
        angle = math.sqrt(angle2)
        first = math.sin(angle) / angle if angle2 > 0.0 else 1.0
        half = math.sin(0.5 * angle) / (0.5 * angle) if angle2 > 0.0 else 1.0
        second = 0.5 * half * half
        move[0, 0] = 1.0 - second * (y * y + z * z)
        move[1, 1] = 1.0 - second * (x * x + z * z)
        move[2, 2] = 1.0 - second * (x * x + y * y)
        move[0, 1], move[1, 0] = second * x * y - first * z, second * x * y + first * z
        move[0, 2], move[2, 0] = second * x * z + first * y, second * x * z - first * y
        move[1, 2], move[2, 1] = second * y * z - first * x, second * y * z + first * x
        for i in range(3):
            moved[v, i] = translations_m[v, i] + step[v, 3 + i]
            for j in range(3):
                turned[v, i, j] = 0.0
                for k in range(3):
                    turned[v, i, j] += move[i, k] * rotations[v, k, j]
    return moved
