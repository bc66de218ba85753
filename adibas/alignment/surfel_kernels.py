"""Hot loops of the surfel map: which surfel a pixel sees, and what a pixel adds to it."""

from typing import NamedTuple

import numpy as np

from adibas.alignment.projective_kernels import Goal, cell_of
from adibas.arrays import Float32Array, FloatArray, Int32Array, IntArray, UInt8Array
from adibas.data.discs import HALF_DIAGONAL, LEAST_FACING
from adibas.kernels import compiled

PLACE, NORMAL, COLOR, RADIUS, CONFIDENCE, FACING, MISSES = 0, 3, 6, 9, 10, 11, 12
N_COLUMNS = 13
"""Of a surfel: place (3), normal (3), colour (3), radius, confidence, how squarely the frame of its
colour saw it, and how often it was seen through."""

BLOCK = 256
"""Rows of the map that have a box together (`surfel_blocks`)."""
NEAREST_M = 0.1
"""Nearer than any sensor sees."""
SLACK_M = 1e-3
"""Of a box, against rounding."""


class Shot(NamedTuple):
    """A frame as the map takes it.

    ``goal`` has its planes; ``rays`` (H, W, 2) are of all pixels; ``sides`` are the least and
    largest x/z, and y/z, that it shows; ``colors`` (h, w, 3) uint8, one for each plane; ``pose``
    (3, 4) world from camera.
    """

    goal: Goal
    rays: Float32Array
    sides: tuple[float, float, float, float]
    colors: UInt8Array
    pose: FloatArray


@compiled
def into_camera(pose: FloatArray, surfel: Float32Array) -> tuple[float, float, float]:
    """Return a surfel's place in the camera."""
    x, y, z = surfel[0] - pose[0, 3], surfel[1] - pose[1, 3], surfel[2] - pose[2, 3]
    return (
        pose[0, 0] * x + pose[1, 0] * y + pose[2, 0] * z,
        pose[0, 1] * x + pose[1, 1] * y + pose[2, 1] * z,
        pose[0, 2] * x + pose[1, 2] * y + pose[2, 2] * z,
    )


@compiled
def _may_show(shot: Shot, box: Float32Array) -> bool:
    """Say whether the picture may show something of a box: of the ball about it, to be quick."""
    radius = SLACK_M
    middle = np.empty(3, np.float32)
    squares = 0.0
    for k in range(3):
        if box[k] > box[k + 3]:
            return False
        middle[k] = 0.5 * (box[k] + box[k + 3])
        squares += (0.5 * (box[k + 3] - box[k])) ** 2
    radius += np.sqrt(squares)
    x, y, z = into_camera(shot.pose, middle)
    left, right, top, bottom = shot.sides
    return bool(
        z + radius > NEAREST_M
        and x - left * z >= -radius * np.sqrt(1.0 + left * left)
        and right * z - x >= -radius * np.sqrt(1.0 + right * right)
        and y - top * z >= -radius * np.sqrt(1.0 + top * top)
        and bottom * z - y >= -radius * np.sqrt(1.0 + bottom * bottom)
    )


@compiled
def _hold(box: Float32Array, surfel: Float32Array) -> None:
    """Make a box hold a surfel."""
    for k in range(3):
        box[k] = min(box[k], surfel[PLACE + k])
        box[k + 3] = max(box[k + 3], surfel[PLACE + k])


@compiled
def find_surfels(
    surfels: Float32Array,
    boxes: Float32Array,
    n: int,
    shot: Shot,
    limits: tuple[float, float],
) -> tuple[Int32Array, int]:
    """Return the (h, w) number of the surfel nearest to the camera in each cell, -1 for none.

    A surfel that lies before what the cell sees was seen through, which is counted; the second
    number is of those that were seen through too often now. They are there no more.

    Parameters
    ----------
    boxes : (M, 6) float32 array
        Of the blocks of surfels.
    limits : (float, float)
        ``gate_per_m`` and ``most_misses`` of `SurfelParams`.
    """
    gate_per_m, most_misses = limits
    n_missed = 0
    height, width, _ = shot.goal.planes.shape
    seen = np.full((height, width), -1, np.int32)
    nearest = np.zeros((height, width), np.float32)
    for first in range(0, n, BLOCK):
        if not _may_show(shot, boxes[first // BLOCK]):
            continue
        for i in range(first, min(first + BLOCK, n)):
            x, y, z = into_camera(shot.pose, surfels[i])
            if z <= NEAREST_M or surfels[i, MISSES] >= most_misses:
                continue
            row, column = cell_of(shot.goal, x, y, z)
            if row < 0:
                continue
            plane = shot.goal.planes[row, column]
            off = 1.0 / z - (plane[0] * x / z + plane[1] * y / z + plane[2])
            if off > gate_per_m:
                surfels[i, MISSES] += 1.0
                n_missed += surfels[i, MISSES] >= most_misses
            elif off > -gate_per_m and 1.0 / z > nearest[row, column]:
                nearest[row, column] = 1.0 / z
                seen[row, column] = i
    return seen, n_missed


@compiled
def arrange(surfels: Float32Array, order: IntArray) -> None:
    """Put row ``order[i]`` in place i, for all rows of (N, 13) surfels; nothing is copied whole."""
    moved = np.zeros(len(order), np.bool_)
    held = np.empty(N_COLUMNS, np.float32)
    for begin in range(len(order)):
        if moved[begin]:
            continue
        held[:] = surfels[begin]
        place = begin
        while not moved[place]:
            moved[place] = True
            source = order[place]
            surfels[place] = held if source == begin else surfels[source]
            place = source


@compiled
def _measure(shot: Shot, row: int, column: int, fresh: Float32Array) -> float:
    """Write the surfel that a cell sees; return how squarely it faces, 0 where there is none."""
    cell_px = shot.goal.cell_px
    v, u = row * cell_px + cell_px // 2, column * cell_px + cell_px // 2
    plane = shot.goal.planes[row, column]
    a, b, c = plane[0], plane[1], plane[2]
    ray_x, ray_y = shot.rays[v, u, 0], shot.rays[v, u, 1]
    inverse = a * ray_x + b * ray_y + c
    if not inverse > 0.0:
        return 0.0
    length = np.sqrt(a * a + b * b + c * c)
    facing = inverse / (length * np.sqrt(1.0 + ray_x * ray_x + ray_y * ray_y))
    z = 1.0 / inverse
    pose = shot.pose
    for k in range(3):
        fresh[PLACE + k] = pose[k, 3] + z * (pose[k, 0] * ray_x + pose[k, 1] * ray_y + pose[k, 2])
        fresh[NORMAL + k] = -(pose[k, 0] * a + pose[k, 1] * b + pose[k, 2] * c) / length
        fresh[COLOR + k] = shot.colors[row, column, k]
    fresh[RADIUS] = HALF_DIAGONAL * z * cell_px / (shot.goal.lens[0] * max(facing, LEAST_FACING))
    fresh[CONFIDENCE] = facing * facing * inverse * inverse
    fresh[FACING] = facing
    fresh[MISSES] = 0.0
    return float(facing)


@compiled
def _fuse(known: Float32Array, fresh: Float32Array) -> None:
    """Average places and normals by confidence; colour comes from the squarest look."""
    total = known[CONFIDENCE] + fresh[CONFIDENCE]
    share = fresh[CONFIDENCE] / total
    length = 0.0
    for k in range(3):
        known[PLACE + k] += share * (fresh[PLACE + k] - known[PLACE + k])
        known[NORMAL + k] += share * (fresh[NORMAL + k] - known[NORMAL + k])
        length += known[NORMAL + k] ** 2
    for k in range(3):
        known[NORMAL + k] /= np.sqrt(length)
    if fresh[FACING] > known[FACING]:
        for k in range(3):
            known[COLOR + k] = fresh[COLOR + k]
        known[FACING] = fresh[FACING]
    known[RADIUS] = min(known[RADIUS], fresh[RADIUS])
    known[CONFIDENCE] = total
    known[MISSES] = 0.0


@compiled
def _is_alike(one: Float32Array, other: Float32Array, least_cosine: float) -> bool:
    cosine = 0.0
    for k in range(3):
        cosine += one[NORMAL + k] * other[NORMAL + k]
    return cosine > least_cosine


@compiled
def add_shot(
    surfels: Float32Array,
    boxes: Float32Array,
    n: int,
    shot: Shot,
    seen: Int32Array,
    limits: tuple[float, float],
) -> int:
    """Fuse what a frame sees into the map, and return how many surfels there are then.

    Parameters
    ----------
    surfels : (capacity, 13) float32 array
        Changed in place; what does not fit any more is left out.
    boxes : (M, 6) float32 array
        Of their blocks, changed in place.
    limits : (float, float)
        Cosine of the angle to the ray up to which surfels are added, and of that between normals
        up to which they are one surface.
    """
    fresh = np.empty(N_COLUMNS, np.float32)
    height, width = seen.shape
    for row in range(height):
        for column in range(width):
            facing = _measure(shot, row, column, fresh)
            if facing <= 0.0:
                continue
            number = seen[row, column]
            if number >= 0:
                if _is_alike(surfels[number], fresh, limits[1]):
                    _fuse(surfels[number], fresh)
                    _hold(boxes[number // BLOCK], surfels[number])
            elif facing > limits[0] and n < len(surfels):
                surfels[n] = fresh
                _hold(boxes[n // BLOCK], fresh)
                n += 1
    return n
