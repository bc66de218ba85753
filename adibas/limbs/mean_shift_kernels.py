"""Loops of the joint proposals: pixels gathered into points, and modes of their density.

Points are rows of x, y, z (metres) and weight (square metres that face the camera, times the
probability). The density of a part falls from each point as (1 - (d / h)^2)^2; where a joint lies
between two parts, it is the product of both densities.

Source: Comaniciu & Meer, Mean shift, PAMI 24 (2002), section 2; Shotton et al., Real-time human
pose recognition in parts from single depth images, CVPR 2011, section 3.3, equations 7 and 8.
"""

import math

import numpy as np

from adibas.arrays import AnyArray, Float32Array, FloatArray, Int32Array, IntArray
from adibas.kernels import compiled, compiled_parallel, parallel_range

N_STEPS = 12
MOST_STARTS = 64
STILL_M2 = 1e-8
"""A step of a tenth of a millimetre, squared: the mode is reached."""
X, Y, Z, WEIGHT = 0, 1, 2, 3


@compiled
def gather_cells(
    depth_m: Float32Array,
    index: IntArray,
    rays: Float32Array,
    probabilities: Float32Array,
    chosen: AnyArray,
    settings: FloatArray,
) -> FloatArray:
    """Sum pixels in small squares of the image, label by label.

    `index` (N,) are their rising numbers in the flat image, `chosen` (H, W) the labels after the
    cut, -1 where there is none; `settings` are the width of a square in pixels, the share of the
    cut's word in a pixel's probability, and for how many pixels each one stands.

    Returns
    -------
    sums : (C, L, 4) array
        Of each square and label: weighted x, y, z, and the weight.
    """
    height, width = depth_m.shape
    cell_px = int(settings[0])
    number = np.full((height // cell_px + 1, width // cell_px + 1), -1, np.int32)
    n_cells = _number_cells(number, index, width, cell_px)
    sums = np.zeros((n_cells, probabilities.shape[1], 4))
    pixel_area = abs((rays[0, 1, 0] - rays[0, 0, 0]) * (rays[1, 0, 1] - rays[0, 0, 1]))
    pixel_area *= settings[2]
    for pixel in range(index.size):
        row, column = index[pixel] // width, index[pixel] % width
        z = float(depth_m[row, column])
        if z > 0.0:
            cell = sums[number[row // cell_px, column // cell_px]]
            x, y = rays[row, column, 0] * z, rays[row, column, 1] * z
            place = (x, y, z, pixel_area * z * z)
            _add_pixel(cell, place, probabilities[pixel], chosen[row, column], settings)
    return sums


@compiled
def _number_cells(number: Int32Array, index: IntArray, width: int, cell_px: int) -> int:
    """Give each square with one of the pixels a number in `number`; return how many there are."""
    n_cells = 0
    for pixel in index:
        row, column = pixel // width // cell_px, pixel % width // cell_px
        if number[row, column] < 0:
            number[row, column] = n_cells
            n_cells += 1
    return n_cells


@compiled
def _add_pixel(
    cell: FloatArray,
    place: tuple[float, float, float, float],
    probabilities: Float32Array,
    chosen: int,
    settings: FloatArray,
) -> None:
    cut_share = settings[1]
    for label in range(probabilities.shape[0]):
        share = (1.0 - cut_share) * probabilities[label]
        if chosen == label:
            share += cut_share
        if share > 0.0:
            weight = share * place[WEIGHT]
            of = cell[label]
            of[X] += weight * place[X]
            of[Y] += weight * place[Y]
            of[Z] += weight * place[Z]
            of[WEIGHT] += weight


@compiled
def over_labels(sums: FloatArray) -> FloatArray:
    """Return (C, 4) sums over the labels of (C, L, 4); numpy takes twenty times as long."""
    total = np.zeros((sums.shape[0], 4))
    for cell in range(sums.shape[0]):
        for label in range(sums.shape[1]):
            for column in range(4):
                total[cell, column] += sums[cell, label, column]
    return total


@compiled
def list_points(sums: FloatArray, least: float) -> tuple[FloatArray, IntArray]:
    """Return the points of each label: squares of which it has at least that share.

    Returns
    -------
    points : (M, 4) array
        x, y, z and weight, label after label.
    starts : (L + 1,) array
        Where the points of each label begin.
    """
    n_cells, n_labels = sums.shape[:2]
    starts = np.zeros(n_labels + 1, np.int64)
    points = np.empty((n_cells * n_labels, 4))
    at = 0
    for label in range(n_labels):
        for cell in range(n_cells):
            weight = sums[cell, label, WEIGHT]
            if weight > 0.0 and weight >= least * sums[cell, :, WEIGHT].sum():
                for axis in range(3):
                    points[at, axis] = sums[cell, label, axis] / weight
                points[at, WEIGHT] = weight
                at += 1
        starts[label + 1] = at
    return points[:at].copy(), starts


@compiled
def find_middles(points: FloatArray, starts: IntArray) -> FloatArray:
    """Return (L, 3) weighted means of the points of each label; NaN where there are none."""
    middles_m = np.zeros((len(starts) - 1, 3))
    for label in range(len(starts) - 1):
        total = 0.0
        for i in range(starts[label], starts[label + 1]):
            total += points[i, WEIGHT]
            for axis in range(3):
                middles_m[label, axis] += points[i, WEIGHT] * points[i, axis]
        for axis in range(3):
            middles_m[label, axis] = middles_m[label, axis] / total if total > 0.0 else np.nan
    return middles_m


@compiled
def _density(points: FloatArray, x: float, y: float, z: float, width_m: float) -> float:
    total, inverse = 0.0, 1.0 / (width_m * width_m)
    for i in range(points.shape[0]):
        dx, dy, dz = points[i, 0] - x, points[i, 1] - y, points[i, 2] - z
        rest = 1.0 - (dx * dx + dy * dy + dz * dz) * inverse
        if rest > 0.0:
            total += points[i, 3] * rest * rest
    return total


@compiled
def _pulled(
    points: FloatArray, at: FloatArray, width_m: float, share: float, into: FloatArray
) -> None:
    """Add the points near `at`, by the slope of their density times `share`, to `into`."""
    inverse = 1.0 / (width_m * width_m)
    for i in range(points.shape[0]):
        dx, dy, dz = points[i, 0] - at[0], points[i, 1] - at[1], points[i, 2] - at[2]
        rest = 1.0 - (dx * dx + dy * dy + dz * dz) * inverse
        if rest > 0.0:
            pull = share * points[i, 3] * rest
            into[0] += pull * points[i, 0]
            into[1] += pull * points[i, 1]
            into[2] += pull * points[i, 2]
            into[3] += pull


@compiled
def _shifted(first: FloatArray, second: FloatArray, width_m: float, at: FloatArray) -> float:
    """Move `at` to the mode near it; return the density there.

    The slope of log(d1 d2) is the sum of both slopes, each over its own density.
    """
    moved = np.empty(4)
    is_pair = second.shape[0] > 0
    for _step in range(N_STEPS):
        d1 = _density(first, at[0], at[1], at[2], width_m)
        d2 = _density(second, at[0], at[1], at[2], width_m) if is_pair else 1.0
        if d1 <= 0.0 or d2 <= 0.0:
            return 0.0
        moved[:] = 0.0
        _pulled(first, at, width_m, 1.0 / d1, moved)
        if is_pair:
            _pulled(second, at, width_m, 1.0 / d2, moved)
        gone = 0.0
        for axis in range(3):
            place = moved[axis] / moved[3]
            gone += (place - at[axis]) ** 2
            at[axis] = place
        if gone < STILL_M2:
            break
    d1 = _density(first, at[0], at[1], at[2], width_m)
    if not is_pair:
        return d1
    return math.sqrt(d1 * _density(second, at[0], at[1], at[2], width_m))


@compiled
def find_modes(first: FloatArray, second: FloatArray, width_m: float, modes: FloatArray) -> None:
    """Fill `modes` (K, 4): x, y, z and density of the highest modes, NaN and 0 where fewer.

    `second` is empty where the joint lies within one part.
    """
    modes[:, :3] = np.nan
    modes[:, 3] = 0.0
    # Starts in the first part alone: a mode of two parts is within reach of both.
    stride = max(1, first.shape[0] // MOST_STARTS)
    n_starts = (first.shape[0] + stride - 1) // stride
    heights = np.empty(n_starts)
    for i in range(n_starts):
        p = first[i * stride]
        heights[i] = _density(first, p[0], p[1], p[2], width_m)
        if second.shape[0] > 0 and heights[i] > 0.0:
            heights[i] = math.sqrt(heights[i] * _density(second, p[0], p[1], p[2], width_m))
    at = np.empty(3)
    for k in range(modes.shape[0]):
        if n_starts == 0:
            return
        best = int(np.argmax(heights))
        if heights[best] <= 0.0:
            return
        p = first[best * stride]
        at[:] = p[:3]
        height = _shifted(first, second, width_m, at)
        modes[k, :3] = at
        modes[k, 3] = height
        for i in range(n_starts):
            q = first[i * stride]
            d2 = (q[0] - at[0]) ** 2 + (q[1] - at[1]) ** 2 + (q[2] - at[2]) ** 2
            own = (q[0] - p[0]) ** 2 + (q[1] - p[1]) ** 2 + (q[2] - p[2]) ** 2
            if min(d2, own) < 1.44 * width_m * width_m:  # beyond its slope
                heights[i] = 0.0


@compiled_parallel
def find_modes_of_joints(
    points: FloatArray, starts: IntArray, pairs: IntArray, widths_m: FloatArray, n_modes: int
) -> FloatArray:
    """Return (J, n_modes, 4) what `find_modes` finds for each of J joints, on all cores.

    Parameters
    ----------
    points : (M, 4) array
    starts : (L + 1,) array
        Where the points of each part begin.
    pairs : (J, 2) array
        The parts of each joint; the second -1 where there is one alone.
    widths_m : (J,) array
    """
    modes = np.empty((pairs.shape[0], n_modes, 4))
    for joint in parallel_range(pairs.shape[0]):
        one, other = pairs[joint]
        first = points[starts[one] : starts[one + 1]]
        second = points[starts[other] : starts[other + 1]] if other >= 0 else points[:0]
        find_modes(first, second, widths_m[joint], modes[joint])
    return modes
