"""What tells an X-corner from any other saddle: Harris' response, and the ring around it."""

import math

import numpy as np

from adibas.arrays import Float32Array, FloatArray
from adibas.kernels import compiled

N_RING = 32
N_FIELDS = 7
U, V, FIRST_RAD, SECOND_RAD, CONTRAST, MEAN, SCALE = range(N_FIELDS)
"""Columns of a corner: pixel, its two edges as angles in [0, pi) where the image, going round
with u towards v, turns from dark to bright (FIRST) and from bright to dark (SECOND), bright minus
dark, their mean, and pixels of the image per pixel of the level it was found in.
"""

BORDER = 6
CIRCLE = (0, 4), (2, 4), (3, 3), (4, 2), (4, 0), (4, -2), (3, -3), (2, -4)
"""Half a circle of pixels (down, right); the other half is its point reflection."""
HARRIS_WEIGHT = 0.04
HARRIS_WINDOW = np.exp(-(np.arange(-2, 3) ** 2) / 4.0)
RING_U = np.cos(2.0 * np.pi * np.arange(N_RING) / N_RING)
RING_V = np.sin(2.0 * np.pi * np.arange(N_RING) / N_RING)
CLEARLY = 1.5
N_EDGES = 4
"""Four edges leave an X-corner, and the ring crosses each once."""
NARROWEST_ARC = 1.5
"""In steps of the ring: an edge seen so obliquely has no square beside it."""
CLIMBED = 0.75
MOST_STRIDE = 2.0
"""In pixels, of the climb to a saddle: nearer it is there, and no step goes farther."""
MOST_SHIFT = 1.5


@compiled
def bilinear(image: Float32Array, u: float, v: float) -> float:
    """Return the value between pixels; the caller keeps (u, v) inside."""
    column, row = int(u), int(v)
    right, down = u - column, v - row
    above = image[row, column] * (1.0 - right) + image[row, column + 1] * right
    below = image[row + 1, column] * (1.0 - right) + image[row + 1, column + 1] * right
    return float(above * (1.0 - down) + below * down)


@compiled
def looks_like_x(level: Float32Array, column: int, row: int) -> bool:
    """Return whether the circle around a pixel is like itself after half a turn, not a quarter.

    Source: the sum and difference responses of Bennett and Lasenby, ChESS, CVIU 118 (2014).
    """
    half, quarter = 0.0, 0.0
    for k in range(4):
        down, right = CIRCLE[k]
        first, third = level[row + down, column + right], level[row - down, column - right]
        down, right = CIRCLE[k + 4]
        second, fourth = level[row + down, column + right], level[row - down, column - right]
        half += abs(first - third) + abs(second - fourth)
        quarter += abs(first + third - second - fourth)
    return bool(quarter > CLEARLY * half)


@compiled
def harris(level: Float32Array, column: int, row: int) -> float:
    """Return R of the 5 x 5 gradients around a pixel, divided by the squared trace.

    With both edges equally strong it is 0.25 - `HARRIS_WEIGHT`; at an edge or a line it is
    negative. Source: thesis, equations 4.16 and 4.17; Harris and Stephens 1988.
    """
    uu = uv = vv = 0.0
    for i in range(-2, 3):
        for j in range(-2, 3):
            weight = HARRIS_WINDOW[i + 2] * HARRIS_WINDOW[j + 2]
            along_u = level[row + i, column + j + 1] - level[row + i, column + j - 1]
            along_v = level[row + i + 1, column + j] - level[row + i - 1, column + j]
            uu += weight * along_u * along_u
            uv += weight * along_u * along_v
            vv += weight * along_v * along_v
    trace = uu + vv
    if trace <= 0.0:
        return -HARRIS_WEIGHT
    return (uu * vv - uv * uv) / (trace * trace) - HARRIS_WEIGHT


@compiled
def saddle_shift(level: Float32Array, column: int, row: int) -> tuple[bool, float, float]:
    """Return whether the quadratic surface of 5 x 5 pixels is a saddle, and where (u, v).

    Source: thesis, equations 4.18 and 4.19.
    """
    s_uu = s_uv = s_vv = s_u = s_v = 0.0
    for i in range(-2, 3):
        for j in range(-2, 3):
            value = float(level[row + i, column + j])
            s_u += j * value
            s_v += i * value
            s_uv += i * j * value
            s_uu += (j * j - 2) * value
            s_vv += (i * i - 2) * value
    # Sums of squares of these orthogonal polynomials over the 25 pixels: 50, 50, 100, 70, 70.
    a, b, c, d, e = s_uu / 70.0, s_uv / 100.0, s_vv / 70.0, s_u / 50.0, s_v / 50.0
    determinant = 4.0 * a * c - b * b
    if determinant >= 0.0:
        return False, 0.0, 0.0
    return True, (b * e - 2.0 * c * d) / determinant, (b * d - 2.0 * a * e) / determinant


@compiled
def read_ring(level: Float32Array, u: float, v: float, radius: float, ring: FloatArray) -> None:
    """Fill `ring` (N_RING,) with the values around (u, v), each the mean of three neighbours."""
    raw = np.empty(N_RING)
    for k in range(N_RING):
        raw[k] = bilinear(level, u + radius * RING_U[k], v + radius * RING_V[k])
    for k in range(N_RING):
        ring[k] = (raw[k - 1] + raw[k] + raw[(k + 1) % N_RING]) / 3.0


@compiled
def crossings(ring: FloatArray, middle: float, steps: FloatArray) -> int:
    """Fill `steps` (4,) with where the ring crosses `middle`; return how often it does.

    In steps of the ring; the first is a rise. More than four are not told from five.
    """
    n = 0
    start = 0
    while start < N_RING and not (ring[start - 1] < middle <= ring[start]):
        start += 1
    if start == N_RING:
        return 0
    for k in range(start, start + N_RING):
        before, here = ring[(k - 1) % N_RING], ring[k % N_RING]
        if (before < middle) == (here < middle):
            continue
        if n == N_EDGES:
            return N_EDGES + 1
        steps[n] = k - 1 + (middle - before) / (here - before)
        n += 1
    return n


@compiled
def judge_ring(ring: FloatArray, corner: FloatArray) -> float:
    """Fill angles, contrast and mean of `corner`; return how unlike an X the ring is (0-1).

    The ring has two bright and two dark arcs, opposite ones alike, and edges that go straight
    through. Source for the ring: Bennett and Lasenby, ChESS, CVIU 118 (2014), section 3.
    """
    steps = np.empty(N_EDGES)
    low, high = ring.min(), ring.max()
    if crossings(ring, 0.5 * (low + high), steps) != N_EDGES:
        return 1.0
    half = N_RING // 2
    bend = max(abs(steps[2] - steps[0] - half), abs(steps[3] - steps[1] - half))
    narrowest = min(steps[1] - steps[0], steps[2] - steps[1])
    if bend > N_RING / 8 or narrowest < NARROWEST_ARC:
        return 1.0
    means = np.zeros(N_EDGES)
    for arc in range(N_EDGES):
        end = steps[(arc + 1) % N_EDGES] + (N_RING if arc == N_EDGES - 1 else 0)
        means[arc] = _arc_mean(ring, steps[arc], end)
    bright, dark = 0.5 * (means[0] + means[2]), 0.5 * (means[1] + means[3])
    contrast = bright - dark
    if contrast <= 0.0:
        return 1.0
    corner[FIRST_RAD] = (0.5 * (steps[0] + steps[2] - half) * 2.0 * math.pi / N_RING) % math.pi
    corner[SECOND_RAD] = (0.5 * (steps[1] + steps[3] - half) * 2.0 * math.pi / N_RING) % math.pi
    corner[CONTRAST], corner[MEAN] = contrast, 0.5 * (bright + dark)
    unlike = max(abs(means[0] - means[2]), abs(means[1] - means[3])) / contrast
    return float(min(max(unlike, bend / (N_RING / 4)), 1.0))


@compiled
def _arc_mean(ring: FloatArray, start: float, end: float) -> float:
    """Return the mean of the middle half of an arc, of the nearest sample at least."""
    total, n = 0.0, 0
    quarter = 0.25 * (end - start)
    for k in range(math.ceil(start + quarter), math.floor(end - quarter) + 1):
        total += ring[k % N_RING]
        n += 1
    if n == 0:
        return float(ring[round(0.5 * (start + end)) % N_RING])
    return float(total / n)


@compiled
def is_inside(level: Float32Array, u: float, v: float, margin: float) -> bool:
    """Return whether everything within `margin` of (u, v) lies between pixels of `level`."""
    height, width = level.shape
    return bool(margin <= u < width - 1 - margin and margin <= v < height - 1 - margin)


@compiled
def examine(
    level: Float32Array, u: float, v: float, limits: FloatArray, corner: FloatArray
) -> bool:
    """Fill `corner` (N_FIELDS, in pixels of `level`) from what is near (u, v); False: no X-corner.

    `limits`: radius of the ring in pixels, least contrast in grey levels, largest unlikeness of
    opposite arcs, least Harris response.
    """
    if not is_inside(level, u, v, BORDER):
        return False
    column, row = round(u), round(v)
    if not looks_like_x(level, column, row) or harris(level, column, row) < limits[3]:
        return False
    is_saddle, right, down = saddle_shift(level, column, row)
    if not is_saddle or max(abs(right), abs(down)) > MOST_SHIFT:
        return False
    corner[U], corner[V] = column + right, row + down
    if not is_inside(level, corner[U], corner[V], limits[0] + 0.5):
        return False
    ring = np.empty(N_RING)
    read_ring(level, corner[U], corner[V], limits[0], ring)
    unlikeness = judge_ring(ring, corner)
    centre = bilinear(level, corner[U], corner[V])
    return bool(
        unlikeness <= limits[2]
        and corner[CONTRAST] >= limits[1]
        and abs(centre - corner[MEAN]) <= 0.3 * corner[CONTRAST]
    )


@compiled
def examine_all(
    level: Float32Array, pixels: Float32Array, limits: FloatArray, scale: float
) -> FloatArray:
    """Return (N, N_FIELDS) corners among `pixels` of `level`, in pixels of the whole image."""
    found = np.empty((len(pixels), N_FIELDS))
    n_found = 0
    for i in range(len(pixels)):
        corner = found[n_found]
        if examine(level, float(pixels[i, 0]), float(pixels[i, 1]), limits, corner):
            corner[U] *= scale
            corner[V] *= scale
            corner[SCALE] = scale
            n_found += 1
    return found[:n_found].copy()


@compiled
def seek(level: Float32Array, place: FloatArray, limits: FloatArray, corner: FloatArray) -> bool:
    """Like `examine`, but climb to the saddle from a `place` (u, v) a few pixels away."""
    u, v = place[0], place[1]
    for _ in range(4):
        if not is_inside(level, u, v, 3.0):
            return False
        column, row = round(u), round(v)
        is_saddle, right, down = saddle_shift(level, column, row)
        if not is_saddle:
            return False
        right = min(max(right, -MOST_STRIDE), MOST_STRIDE)
        down = min(max(down, -MOST_STRIDE), MOST_STRIDE)
        u, v = column + right, row + down
        if max(abs(right), abs(down)) <= CLIMBED:
            break
    corner[U], corner[V] = u, v
    if not is_inside(level, u, v, limits[0] + 0.5):
        return False
    ring = np.empty(N_RING)
    read_ring(level, u, v, limits[0], ring)
    return bool(judge_ring(ring, corner) <= limits[2] and corner[CONTRAST] >= limits[1])


@compiled
def seek_all(
    level: Float32Array, places: FloatArray, limits: FloatArray, scale: float
) -> FloatArray:
    """Return (N, N_FIELDS) the X-corner near each of `places` (N, 3): u, v and radius of the ring.

    All in pixels of the whole image; NaN where there is none. `limits` as for `examine`.
    """
    found = np.full((len(places), N_FIELDS), np.nan)
    own_limits = limits.copy()
    for i in range(len(places)):
        corner = found[i]
        own_limits[0] = min(limits[0], places[i, 2] / scale)
        if seek(level, places[i, :2] / scale, own_limits, corner):
            corner[U] *= scale
            corner[V] *= scale
            corner[SCALE] = scale
        else:
            corner[:] = np.nan
    return found
