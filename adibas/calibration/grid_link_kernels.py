"""Neighbours on a chessboard among X-corners: along an edge, with the colours swapped.

A corner sends out four rays along its edges, counted round from the FIRST edge with u towards v;
the image brightens across rays 0 and 2 and darkens across 1 and 3. A neighbour's ray back is of
the other kind, because its squares have the other colours.
"""

import math

import numpy as np

from adibas.arrays import Float32Array, FloatArray, Int32Array
from adibas.calibration.corner_saddle_kernels import (
    CONTRAST,
    FIRST_RAD,
    SCALE,
    SECOND_RAD,
    U,
    V,
    bilinear,
    is_inside,
)
from adibas.kernels import compiled

SMALLEST_STEP_PX = 4.0
ALONG_RAD = math.radians(18.0)
"""Largest angle between an edge and the way to the next corner: the rays' noise and the lens."""
ALONG_TANGENT = math.tan(ALONG_RAD)
SWING_RAD = math.radians(30.0)
"""Largest angle between the crossing edges of two neighbours: perspective, and their noise."""
MOST_ALIKE = 40
"""A neighbour is among so many of like contrast nearest to a corner; clutter ends the search."""


@compiled
def merge_levels(corners: FloatArray) -> FloatArray:
    """Keep each corner once, from the finest level that shows it with most of its contrast.

    `corners` (N, fields) come finest first.
    """
    is_kept = np.ones(len(corners), np.bool_)
    order = np.argsort(corners[:, V])
    coarsest = corners[:, SCALE].max() if len(corners) else 1.0
    for a in range(len(order)):
        for b in range(a + 1, len(order)):
            first, second = min(order[a], order[b]), max(order[a], order[b])
            reach = 1.5 * max(corners[first, SCALE], corners[second, SCALE]) + 1.0
            if corners[order[b], V] - corners[order[a], V] > 1.5 * coarsest + 1.0:
                break
            if not (is_kept[first] and is_kept[second]):
                continue
            right = abs(corners[first, U] - corners[second, U])
            if right > reach or abs(corners[first, V] - corners[second, V]) > reach:
                continue
            is_fine = corners[first, CONTRAST] >= 0.6 * corners[second, CONTRAST]
            is_kept[second if is_fine else first] = False
    return corners[is_kept]


@compiled
def ray_rad(corner: FloatArray, ray: int) -> float:
    """Return the direction of ray 0-3 of a corner."""
    if ray % 2 == 0:
        return float(corner[FIRST_RAD] + 0.5 * ray * math.pi)
    turn = math.pi if corner[SECOND_RAD] < corner[FIRST_RAD] else 0.0
    return float(corner[SECOND_RAD] + turn + 0.5 * (ray - 1) * math.pi)


@compiled
def angle_between(first_rad: float, second_rad: float) -> float:
    """Return the angle between two directions, 0 to pi."""
    return abs((first_rad - second_rad + math.pi) % (2.0 * math.pi) - math.pi)


@compiled
def ray_back(here: FloatArray, ray: int, there: FloatArray) -> int:
    """Return the ray of `there` that answers `ray` of `here`; -1 if they are no neighbours."""
    way_rad = math.atan2(there[V] - here[V], there[U] - here[U])
    if angle_between(way_rad, ray_rad(here, ray)) > ALONG_RAD:
        return -1
    for step in range(2):
        back = (ray + 1 + 2 * step) % 4
        if angle_between(way_rad + math.pi, ray_rad(there, back)) <= ALONG_RAD:
            swing = angle_between(ray_rad(here, (ray + 1) % 4), ray_rad(there, (back + 3) % 4))
            return back if swing <= SWING_RAD else -1
    return -1


@compiled
def is_edge(level: Float32Array, here: FloatArray, there: FloatArray, ray: int) -> bool:
    """Return whether bright and dark lie on their sides all the way between two corners."""
    right, down = there[U] - here[U], there[V] - here[V]
    length = math.hypot(right, down)
    aside = max(1.5 * max(here[SCALE], there[SCALE]), 0.1 * length)
    across_u, across_v = -down / length * aside, right / length * aside
    sign = 1.0 if ray % 2 == 0 else -1.0
    least = 0.25 * min(here[CONTRAST], there[CONTRAST])
    for quarter in range(1, 4):
        u, v = here[U] + 0.25 * quarter * right, here[V] + 0.25 * quarter * down
        if not is_inside(level, u, v, aside + 1.0):
            return False
        after = bilinear(level, u + across_u, v + across_v)
        before = bilinear(level, u - across_u, v - across_v)
        if sign * (after - before) < least:
            return False
    return True


@compiled
def _bins(corners: FloatArray, size_px: float) -> tuple[Int32Array, Int32Array]:
    """Return the first corner of each bin (-1: none), and at i + 1 the one after corner i."""
    n_rows = int(corners[:, V].max() / size_px) + 1
    n_columns = int(corners[:, U].max() / size_px) + 1
    heads = np.full((n_rows, n_columns), -1, np.int32)
    chain = np.full(len(corners) + 1, -1, np.int32)
    for i in range(len(corners)):
        row, column = int(corners[i, V] / size_px), int(corners[i, U] / size_px)
        chain[i + 1] = heads[row, column]
        heads[row, column] = i
    return heads, chain


@compiled
def ray_vectors(corners: FloatArray) -> FloatArray:
    """Return (N, 4, 2) unit vectors along the rays."""
    vectors = np.empty((len(corners), 4, 2))
    for i in range(len(corners)):
        for ray in range(4):
            angle_rad = ray_rad(corners[i], ray)
            vectors[i, ray] = math.cos(angle_rad), math.sin(angle_rad)
    return vectors


@compiled
def _ray_towards(vectors: FloatArray, here: FloatArray, there: FloatArray) -> int:
    """Return the ray of `here` within reach of the way to `there`; -1 if there is none."""
    right, down = there[U] - here[U], there[V] - here[V]
    for ray in range(4):
        along = right * vectors[ray, 0] + down * vectors[ray, 1]
        across = right * vectors[ray, 1] - down * vectors[ray, 0]
        if along > 0.0 and abs(across) <= ALONG_TANGENT * along:
            return ray
    return -1


@compiled
def _offer(
    corners: FloatArray, vectors: FloatArray, level: Float32Array, pair: tuple[int, int]
) -> int:
    """Return the ray along which the second of `pair` may be the first's neighbour, or -1."""
    here, there = corners[pair[0]], corners[pair[1]]
    ray = _ray_towards(vectors[pair[0]], here, there)
    if ray < 0 or ray_back(here, ray, there) < 0 or not is_edge(level, here, there, ray):
        return -1
    return ray


@compiled
def _link_one(
    corners: FloatArray,
    vectors: FloatArray,
    level: Float32Array,
    nearby: tuple[int, Int32Array],
    links: Int32Array,
    lengths: FloatArray,
) -> int:
    """Offer corner i every one of a bin, `nearby` being (i, first) and the chain of the next.

    Returns how many had a contrast like its own.
    """
    i, chain = nearby
    j = chain[0]
    n_alike = 0
    while j >= 0:
        length = math.hypot(corners[j, U] - corners[i, U], corners[j, V] - corners[i, V])
        contrasts = corners[i, CONTRAST], corners[j, CONTRAST]
        is_alike = j != i and min(contrasts) >= 0.4 * max(contrasts)
        if is_alike and length >= SMALLEST_STEP_PX:
            n_alike += 1
            if length < lengths.max():
                ray = _offer(corners, vectors, level, (i, j))
                if ray >= 0 and length < lengths[ray]:
                    links[ray], lengths[ray] = j, length
        j = chain[j + 1]
    return n_alike


@compiled
def link_all(corners: FloatArray, level: Float32Array, longest_px: float) -> Int32Array:
    """Return (N, 4) nearest neighbours along the rays of each corner that choose each other.

    -1 where there is none within `longest_px`. `level` is the finest of the pyramid.
    """
    n = len(corners)
    links = np.full((n, 4), -1, np.int32)
    if n == 0:
        return links
    size_px = max(8.0, math.sqrt(level.size / n))
    heads, chain = _bins(corners, size_px)
    vectors = ray_vectors(corners)
    for i in range(n):
        row, column = int(corners[i, V] / size_px), int(corners[i, U] / size_px)
        lengths = np.full(4, longest_px)
        ring, n_alike = 0, 0
        while (ring - 1) * size_px <= lengths.max() and n_alike < MOST_ALIKE:
            if ring >= max(heads.shape):
                break
            for r in range(max(row - ring, 0), min(row + ring + 1, heads.shape[0])):
                step = 1 if abs(r - row) == ring else 2 * ring
                for c in range(column - ring, column + ring + 1, max(step, 1)):
                    if 0 <= c < heads.shape[1] and heads[r, c] >= 0:
                        chain[0] = heads[r, c]
                        n_alike += _link_one(corners, vectors, level, (i, chain), links[i], lengths)
            ring += 1
    return _mutual(corners, links)


@compiled
def _mutual(corners: FloatArray, links: Int32Array) -> Int32Array:
    result = np.full(links.shape, -1, np.int32)
    for i in range(len(links)):
        for ray in range(4):
            j = links[i, ray]
            if j >= 0:
                back = ray_back(corners[i], ray, corners[j])
                if links[j, back] == i:
                    result[i, ray] = j
    return result


@compiled
def label_grids(corners: FloatArray, links: Int32Array) -> Int32Array:
    """Return (N, 4): number of the grid (-1: none), row, column, and turn of each corner.

    Rays 0-3 of a corner point along +column, +row, -column, -row after `turn` steps.
    """
    labels = np.full((len(corners), 4), -1, np.int32)
    queue = np.empty(len(corners), np.int32)
    n_grids = 0
    for seed in range(len(corners)):
        if labels[seed, 0] >= 0 or links[seed].max() < 0:
            continue
        labels[seed] = (n_grids, 0, 0, 0)
        queue[0] = seed
        n_queued, next_one = 1, 0
        while next_one < n_queued:
            here = queue[next_one]
            next_one += 1
            for ray in range(4):
                there = links[here, ray]
                if there >= 0 and labels[there, 0] < 0:
                    _label_next(corners, labels, (here, ray, there))
                    queue[n_queued] = there
                    n_queued += 1
        n_grids += 1
    return labels


@compiled
def _label_next(corners: FloatArray, labels: Int32Array, link: tuple[int, int, int]) -> None:
    here, ray, there = link
    way = (ray + labels[here, 3]) % 4
    back = ray_back(corners[here], ray, corners[there])
    down = (0, 1, 0, -1)[way]
    right = (1, 0, -1, 0)[way]
    labels[there, 0] = labels[here, 0]
    labels[there, 1] = labels[here, 1] + down
    labels[there, 2] = labels[here, 2] + right
    labels[there, 3] = (way + 2 - back) % 4
