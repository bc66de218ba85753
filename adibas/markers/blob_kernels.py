"""The loops of blobs: which pixels hang together, and how much of a core each pixel near it holds.

A group is told by its pixels; `starts` says where in the lists of rows and columns
each group begins, and where the last one ends.
"""

import math

import numpy as np

from adibas.arrays import BoolArray, Float32Array, FloatArray, Int32Array, IntArray, UInt8Array
from adibas.kernels import compiled
from adibas.markers.border_kernels import (
    median_color,
    shares_beside_two,
    two_sides,
    unexplained,
)
from adibas.markers.faint_kernels import NEAR, RING, middle_and_about
from adibas.markers.quantile_kernels import quantile

NEAR_PX = 2
"""About the group: pixels that may hold some of the core."""
LEAST_SHARE = 0.12
GREATEST_SHARE = 1.2
LEAST_AREA_PX = 1e-6
N_NUMBERS = 8
"""Of a blob: u, v, area, short and long variance, cov_uu, cov_uv, cov_vv."""
N_LOOKS = 5
"""Of a group: noise, prominence, unexplained, middle, against."""


@compiled
def group_pixels(
    labels: Int32Array, n_labels: int, taken: BoolArray
) -> tuple[IntArray, IntArray, IntArray]:
    """Sort the pixels by label (0 is background); leave out labels that touch a taken pixel."""
    starts, place = _places(labels, n_labels, taken)
    rows, columns = np.empty(starts[-1], np.int64), np.empty(starts[-1], np.int64)
    for row in range(labels.shape[0]):
        for column in range(labels.shape[1]):
            label = labels[row, column]
            if label > 0 and place[label] >= 0:
                rows[place[label]], columns[place[label]] = row, column
                place[label] += 1
    return rows, columns, starts


@compiled
def _places(labels: Int32Array, n_labels: int, taken: BoolArray) -> tuple[IntArray, IntArray]:
    """Return where the groups begin, and each label's first place (-1: left out)."""
    sizes = np.zeros(n_labels, np.int64)
    is_free = np.ones(n_labels, np.bool_)
    for row in range(labels.shape[0]):
        for column in range(labels.shape[1]):
            label = labels[row, column]
            sizes[label] += 1
            if taken[row, column]:
                is_free[label] = False
    is_free[0] = False
    starts = np.zeros(is_free.sum() + 1, np.int64)
    place = np.full(n_labels, -1, np.int64)
    starts[1:] = np.cumsum(sizes[is_free])
    place[is_free] = starts[:-1]
    return starts, place


@compiled
def join_groups(
    groups: tuple[IntArray, IntArray, IntArray], n_speck_px: int, reach: int
) -> tuple[IntArray, IntArray, IntArray]:
    """Make one group of specks (fewer pixels than `n_speck_px`) within `reach` rows and columns.

    Pixels of each group come in raster order; a joined group stands where its first one stood.
    """
    rows, columns, starts = groups
    n_groups = len(starts) - 1
    root = np.arange(n_groups)
    tops = rows[starts[:-1]]
    downwards = np.argsort(tops)
    for place in range(n_groups):
        i = downwards[place]
        if starts[i + 1] - starts[i] >= n_speck_px:
            continue
        last_row = rows[starts[i] : starts[i + 1]].max() + reach
        for j in downwards[place + 1 :]:
            if tops[j] > last_row:
                break
            if starts[j + 1] - starts[j] < n_speck_px and _are_near(
                rows, columns, (starts[i], starts[i + 1], starts[j], starts[j + 1]), reach
            ):
                _unite(root, i, j)
    return _gathered(rows, columns, starts, root)


@compiled
def _are_near(
    rows: IntArray, columns: IntArray, ends: tuple[int, int, int, int], reach: int
) -> bool:
    for one in range(ends[0], ends[1]):
        for other in range(ends[2], ends[3]):
            away = max(abs(rows[one] - rows[other]), abs(columns[one] - columns[other]))
            if away <= reach:
                return True
    return False


@compiled
def _unite(root: IntArray, one: int, other: int) -> None:
    """Give both and all that hang on them the first of their groups as root."""
    first, second = min(root[one], root[other]), max(root[one], root[other])
    for i in range(len(root)):
        if root[i] == second:
            root[i] = first


@compiled
def _gathered(
    rows: IntArray, columns: IntArray, starts: IntArray, root: IntArray
) -> tuple[IntArray, IntArray, IntArray]:
    """Return the groups by their roots."""
    sizes = np.zeros(len(root), np.int64)
    for i in range(len(root)):
        sizes[root[i]] += starts[i + 1] - starts[i]
    is_left = sizes > 0
    new_starts = np.zeros(is_left.sum() + 1, np.int64)
    new_starts[1:] = np.cumsum(sizes[is_left])
    place = np.zeros(len(root), np.int64)
    place[is_left] = new_starts[:-1]
    new_rows, new_columns = np.empty_like(rows), np.empty_like(columns)
    for i in range(len(root)):
        for pixel in range(starts[i], starts[i + 1]):
            at = place[root[i]]
            new_rows[at], new_columns[at] = rows[pixel], columns[pixel]
            place[root[i]] += 1
    return new_rows, new_columns, new_starts


@compiled
def look_at_groups(
    values: Float32Array,
    distance: Float32Array,
    groups: tuple[IntArray, IntArray, IntArray],
    percentile: float,
    weights: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """Return (N, 5), how every group of pixels looks, and (N, 2, C), its two colours.

    See `adibas.markers.blobs.look_at`; the colours are the surround's and the core's.
    """
    rows, columns, starts = groups
    looks = np.empty((len(starts) - 1, N_LOOKS))
    colors = np.empty((len(looks), 2, values.shape[2]))
    for i in range(len(looks)):
        part = slice(starts[i], starts[i + 1])
        pixels = rows[part], columns[part]
        _look(values, distance, pixels, percentile, weights, (looks[i], colors[i]))
    return looks, colors


@compiled
def unmix_groups(
    values: Float32Array,
    distance: Float32Array,
    groups: tuple[IntArray, IntArray, IntArray],
    percentile: float,
    weights: FloatArray,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return (N, 8), the numbers of every group of pixels, and what `look_at_groups` returns.

    See `adibas.markers.blobs.measure_blobs`.
    """
    rows, columns, starts = groups
    numbers = np.empty((len(starts) - 1, N_NUMBERS))
    looks = np.empty((len(numbers), N_LOOKS))
    colors = np.empty((len(numbers), 2, values.shape[2]))
    for i in range(len(numbers)):
        part = slice(starts[i], starts[i + 1])
        pixels = rows[part], columns[part]
        local, shares, zones, ring, corner = _look(
            values, distance, pixels, percentile, weights, (looks[i], colors[i])
        )
        _unmix(local, shares, zones, ring, colors[i], numbers[i])
        numbers[i, 0] += corner[1]
        numbers[i, 1] += corner[0]
        if numbers[i, 2] == LEAST_AREA_PX:  # nothing stands out from the noise of its surround
            numbers[i, 0], numbers[i, 1] = columns[part].mean(), rows[part].mean()
    return numbers, looks, colors


@compiled
def _look(
    values: Float32Array,
    distance: Float32Array,
    pixels: tuple[IntArray, IntArray],
    percentile: float,
    weights: FloatArray,
    into: tuple[FloatArray, FloatArray],
) -> tuple[Float32Array, FloatArray, UInt8Array, FloatArray, tuple[int, int]]:
    """Fill in one group's looks and colours; return what they were found in.

    Returns
    -------
    tuple
        The (H, W, C) colours about the group, the core's (H, W) share in them, the zones, the
        (C, N) colours of the ring, and row and column of the first pixel.
    """
    (rows, columns), (looks, colors) = pixels, into
    reach = max(3, round(0.8 * math.sqrt(len(rows))))
    top = max(rows.min() - reach - NEAR_PX, 0)
    left = max(columns.min() - reach - NEAR_PX, 0)
    bottom = min(rows.max() + reach + NEAR_PX + 1, distance.shape[0])
    right = min(columns.max() + reach + NEAR_PX + 1, distance.shape[1])
    local, far = values[top:bottom, left:right], distance[top:bottom, left:right]
    zones = _zones(rows - top, columns - left, (bottom - top, right - left), reach)
    ring, ring_far = _ring(local, far, zones)
    surround = median_color(ring, np.ones(len(ring_far), np.bool_))
    around = quantile(ring_far, 0.01 * percentile)
    core, nearest = _core(values, distance, rows, columns)
    colors[0], colors[1] = surround, core
    shares = _shares(local, surround, core - surround)
    looks[0] = _noise(shares, zones)  # of everything about it, be it of two colours or not
    looks[1] = 1.0 - nearest / max(around, 1e-6)
    looks[2] = unexplained(ring, surround, core)
    at = round(rows.mean()) - top, round(columns.mean()) - left
    looks[3], looks[4] = middle_and_about(local, zones, at, surround, core, weights)
    return local, shares, zones, ring, (top, left)


@compiled
def _unmix(
    local: Float32Array,
    shares: FloatArray,
    zones: UInt8Array,
    ring: FloatArray,
    colors: FloatArray,
    numbers: FloatArray,
) -> None:
    """Fill in the numbers of one group, of which `_look` told the rest."""
    surround, core = colors[0], colors[1]
    sides, are_two = two_sides(ring, surround, core)
    if are_two:
        shares = shares_beside_two(local, sides, core)
    _moments(shares, zones, _noise(shares, zones), numbers)


@compiled
def _zones(rows: IntArray, columns: IntArray, shape: tuple[int, int], reach: int) -> UInt8Array:
    """Mark the group, what is near it (a square of 5 pixels) and the ring of `reach` about that."""
    group = np.zeros(shape, np.uint8)
    for i in range(len(rows)):
        group[rows[i], columns[i]] = 1
    near = _widened(group, NEAR_PX)
    zones = _widened(near, reach)
    for row in range(shape[0]):
        for column in range(shape[1]):
            zones[row, column] += near[row, column] + group[row, column]
    return zones


@compiled
def _widened(mask: UInt8Array, reach: int) -> UInt8Array:
    """Dilate by a square: every pixel within `reach` rows and columns of a pixel that is 1."""
    upright = _widened_across(mask, reach).T.copy()
    return _widened_across(upright, reach).T.copy()


@compiled
def _widened_across(mask: UInt8Array, reach: int) -> UInt8Array:
    height, width = mask.shape
    widened = np.zeros((height, width), np.uint8)
    for row in range(height):
        done = 0
        for column in range(width):
            if mask[row, column]:
                end = min(column + reach + 1, width)
                widened[row, max(done, column - reach) : end] = 1
                done = end
    return widened


@compiled
def _ring(
    local: Float32Array, far: Float32Array, zones: UInt8Array
) -> tuple[FloatArray, FloatArray]:
    """Return the (C, N) colours of the ring, and their (N,) distances to the model."""
    n_channels = local.shape[2]
    colors, distances = np.empty((n_channels, zones.size)), np.empty(zones.size)
    n_ring = 0
    for row in range(zones.shape[0]):
        for column in range(zones.shape[1]):
            if zones[row, column] == RING:
                distances[n_ring] = far[row, column]
                for channel in range(n_channels):
                    colors[channel, n_ring] = local[row, column, channel]
                n_ring += 1
    return colors[:, :n_ring].copy(), distances[:n_ring].copy()


@compiled
def _core(
    values: Float32Array, distance: Float32Array, rows: IntArray, columns: IntArray
) -> tuple[FloatArray, float]:
    """Return the mean colour of the third nearest to the model, and its mean distance."""
    distances = np.empty(len(rows), np.float32)
    for i in range(len(rows)):
        distances[i] = distance[rows[i], columns[i]]
    n_core = max(1, len(rows) // 3)
    core = np.zeros(values.shape[2])
    nearest = 0.0
    for i in np.argsort(distances)[:n_core]:
        nearest += distances[i] / n_core
        for channel in range(values.shape[2]):
            core[channel] += values[rows[i], columns[i], channel] / n_core
    return core, nearest


@compiled
def _shares(local: Float32Array, surround: FloatArray, axis: FloatArray) -> FloatArray:
    """Return how much of the core every pixel holds: 0 like the surround, 1 like the core."""
    contrast = 0.0
    for channel in range(len(axis)):
        contrast += axis[channel] ** 2
    contrast = max(contrast, 1e-6)
    shares = np.zeros(local.shape[:2])
    for row in range(local.shape[0]):
        for column in range(local.shape[1]):
            for channel in range(len(axis)):
                difference = local[row, column, channel] - surround[channel]
                shares[row, column] += difference * axis[channel] / contrast
    return shares


@compiled
def _noise(shares: FloatArray, zones: UInt8Array) -> float:
    """Return the standard deviation of the ring's shares, from their median."""
    ring = np.empty(zones.size)
    n_ring = 0
    for row in range(zones.shape[0]):
        for column in range(zones.shape[1]):
            if zones[row, column] == RING:
                ring[n_ring] = abs(shares[row, column])
                n_ring += 1
    return 1.4826 * quantile(ring[:n_ring], 0.5)


@compiled
def _moments(shares: FloatArray, zones: UInt8Array, noise: float, numbers: FloatArray) -> None:
    """Fill in centre, area, spread and the centre's covariance; the share is the weight."""
    area, at_u, at_v = 0.0, 0.0, 0.0
    least = max(LEAST_SHARE, noise)
    height, width = shares.shape
    for row in range(height):
        for column in range(width):
            share = shares[row, column]
            weight = min(share, GREATEST_SHARE) if share > least else 0.0
            weight = weight if zones[row, column] >= NEAR else 0.0
            shares[row, column] = weight
            area += weight
            at_u += weight * column
            at_v += weight * row
    area = max(area, LEAST_AREA_PX)
    centre_u, centre_v = at_u / area, at_v / area
    spread, support = np.zeros(3), np.zeros(3)
    for row in range(height):
        for column in range(width):
            weight = shares[row, column]
            if weight > 0.0:
                u, v = column - centre_u, row - centre_v
                products = (u * u, u * v, v * v)
                for i in range(3):
                    spread[i] += weight * products[i] / area
                    support[i] += products[i]
    # One pixel spreads by 1/12: without it a few pixels in a row look like a line.
    mean = 0.5 * (spread[0] + spread[2]) + 1.0 / 12.0
    half_range = math.hypot(0.5 * (spread[0] - spread[2]), spread[1])
    numbers[:5] = (centre_u, centre_v, area, mean - half_range, mean + half_range)
    numbers[5:] = noise**2 * support / area**2


@compiled
def median_depth(depth_m: Float32Array, row: int, column: int, reach: int) -> float:
    """Return the median of the known depths within `reach` of a pixel; NaN where none is known."""
    top, left = max(row - reach, 0), max(column - reach, 0)
    near = depth_m[top : row + reach + 1, left : column + reach + 1].copy().ravel()
    return float(np.nanmedian(near))
