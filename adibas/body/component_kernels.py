"""Loops of the body mask: surfaces without a step, and what is known of each.

Compiled for float32 inverse depth (1/m, 0 where there is none) and int32 labels.
"""

import numpy as np

from adibas.arrays import Float32Array, FloatArray, Int32Array
from adibas.kernels import compiled, compiled_parallel, parallel_range

N_MOMENTS = 10
"""Columns of `moments`: weight, x, y, z, then xx, yy, zz, xy, xz, yz (metres)."""
N_PARTS = 4
"""Every fourth row is one part: always as many, whatever the number of cores."""


@compiled
def _root(parent: Int32Array, label: int) -> int:
    while parent[label] != label:
        parent[label] = parent[parent[label]]
        label = parent[label]
    return label


@compiled
def _joined(parent: Int32Array, first: int, second: int) -> int:
    if first == second:
        return first
    a, b = _root(parent, first), _root(parent, second)
    low, high = min(a, b), max(a, b)
    parent[high] = low
    return low


@compiled
def label_surfaces(
    inverse_depth: Float32Array, step_per_m: float, step_m: float
) -> tuple[Int32Array, int]:
    """Label the 4-connected regions whose neighbours differ by less than a step.

    A step is `step_per_m` in 1/z or `step_m` in z, whichever is more.

    Returns
    -------
    labels : (H, W) int32 array
        1, 2, ...; 0 where there is no depth.
    n_labels : int
        The highest label.
    """
    height, width = inverse_depth.shape
    labels = np.zeros((height, width), np.int32)
    parent = np.zeros(height * width + 1, np.int32)
    n_provisional = 0
    for row in range(height):
        for column in range(width):
            here = inverse_depth[row, column]
            if not here > 0:
                continue
            label = 0
            limit = max(step_per_m, step_m * here * here)
            for row_before, column_before in ((row, column - 1), (row - 1, column)):
                if row_before < 0 or column_before < 0:
                    continue
                step = inverse_depth[row_before, column_before] - here
                before = labels[row_before, column_before]
                if before > 0 and abs(step) < limit:
                    label = _joined(parent, label, before) if label > 0 else before
            if label == 0:
                n_provisional += 1
                parent[n_provisional] = n_provisional
                label = n_provisional
            labels[row, column] = label
    return _renumbered(labels, parent, n_provisional)


@compiled
def _renumbered(
    labels: Int32Array, parent: Int32Array, n_provisional: int
) -> tuple[Int32Array, int]:
    final = np.zeros(n_provisional + 1, np.int32)
    n_labels = 0
    for label in range(1, n_provisional + 1):
        if parent[label] == label:
            n_labels += 1
            final[label] = n_labels
        else:
            final[label] = final[_root(parent, label)]
    flat = labels.ravel()
    for index in range(flat.size):
        flat[index] = final[flat[index]]
    return labels, n_labels


@compiled_parallel
def surface_moments(
    labels: Int32Array, n_labels: int, inverse_depth: Float32Array, rays: Float32Array
) -> FloatArray:
    """Return (n_labels + 1, 10): area (m^2, facing the camera) and moments of each surface."""
    moments = np.zeros((N_PARTS, n_labels + 1, N_MOMENTS))
    pixel_area = abs((rays[0, 1, 0] - rays[0, 0, 0]) * (rays[1, 0, 1] - rays[0, 0, 1]))
    for part in parallel_range(N_PARTS):
        for row in range(part, labels.shape[0], N_PARTS):
            _add_row(moments[part], labels[row], inverse_depth[row], rays[row], pixel_area)
    total: FloatArray = moments.sum(axis=0)
    return total


@compiled
def _add_row(
    moments: FloatArray,
    labels: Int32Array,
    inverse_depth: Float32Array,
    rays: Float32Array,
    pixel_area: float,
) -> None:
    end = 0
    while end < labels.size:
        label, start = labels[end], end
        while end < labels.size and labels[end] == label:
            end += 1
        if label > 0:
            _add_run(moments[label], inverse_depth[start:end], rays[start:end], pixel_area)


@compiled
def _add_run(
    moments: FloatArray, inverse_depth: Float32Array, rays: Float32Array, pixel_area: float
) -> None:
    """Add pixels of a row to (10,) `moments`.

    The sums are kept in numbers of their own: sums in an array wait for what was just written, and
    take half as long again.
    """
    m = mx = my = mz = xx = yy = zz = xy = xz = yz = 0.0
    for i in range(inverse_depth.size):
        z = 1.0 / inverse_depth[i]
        x, y = rays[i, 0] * z, rays[i, 1] * z
        area = pixel_area * z * z
        ax, ay, az = area * x, area * y, area * z
        m, mx, my, mz = m + area, mx + ax, my + ay, mz + az
        xx, yy, zz = xx + ax * x, yy + ay * y, zz + az * z
        xy, xz, yz = xy + ax * y, xz + ax * z, yz + ay * z
    for column, added in enumerate((m, mx, my, mz, xx, yy, zz, xy, xz, yz)):
        moments[column] += added


@compiled
def gaps_to_body(
    labels: Int32Array, n_labels: int, body: int, inverse_depth: Float32Array, reach_px: int
) -> FloatArray:
    """Return (n_labels + 1, 2): how every surface borders on the one called `body`.

    Columns: length of the common border in pixels (a stretch without depth of up to `reach_px`
    counts as touching), and the mean distance in depth there (m, positive behind the body).
    """
    height, width = labels.shape
    border = np.zeros((n_labels + 1, 2))
    last_row = np.zeros(width, np.int64)
    label_above = np.zeros(width, np.int32)
    for row in range(height):
        last_column, label_before = 0, np.int32(0)
        for column in range(width):
            label = labels[row, column]
            if label == 0:
                continue
            # Nearly all neighbours are of one label: only the rest is looked at.
            if label != label_before and label_before > 0 and column - last_column <= reach_px:
                _note(border, labels, inverse_depth, body, (row, last_column, row, column))
            above = label_above[column]
            if label != above and above > 0 and row - last_row[column] <= reach_px:
                _note(border, labels, inverse_depth, body, (last_row[column], column, row, column))
            last_column, label_before = column, label
            last_row[column], label_above[column] = row, label
    border[:, 1] /= np.maximum(border[:, 0], 1.0)
    return border


@compiled
def _note(
    border: FloatArray,
    labels: Int32Array,
    inverse_depth: Float32Array,
    body: int,
    pair: tuple[int, int, int, int],
) -> None:
    first, second = labels[pair[0], pair[1]], labels[pair[2], pair[3]]
    if first == second or (first - body) * (second - body) != 0:
        return
    distance_m = 1.0 / inverse_depth[pair[2], pair[3]] - 1.0 / inverse_depth[pair[0], pair[1]]
    other = second
    if second == body:
        other, distance_m = first, -distance_m
    border[other, 0] += 1
    border[other, 1] += distance_m
