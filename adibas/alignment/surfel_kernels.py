"""Hot loops of the surfel map: which surfel a pixel sees, and what a pixel adds to it."""

from typing import NamedTuple

import numpy as np

from adibas.alignment.projective_kernels import Goal, cell_of
from adibas.arrays import Float32Array, FloatArray, Int32Array, UInt8Array
from adibas.data.discs import HALF_DIAGONAL, LEAST_FACING
from adibas.kernels import compiled

PLACE, NORMAL, COLOR, RADIUS, CONFIDENCE, FACING, MISSES = 0, 3, 6, 9, 10, 11, 12
N_COLUMNS = 13
"""Of a surfel: place (3), normal (3), colour (3), radius, confidence, how squarely the frame of its
colour saw it, and how often it was seen through."""


NEAREST_M = 0.1
"""Nearer than any sensor sees."""


class Shot(NamedTuple):
    """A frame as the map takes it.

    ``goal`` has its planes; ``rays`` (H, W, 2) are of all pixels; ``colors`` (h, w, 3) uint8, one
    for each plane; ``pose`` (3, 4) world from camera.
    """

    goal: Goal
    rays: Float32Array
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
def find_surfels(
    surfels: Float32Array, n: int, shot: Shot, limits: tuple[float, float]
) -> tuple[Int32Array, int]:
    """Return the (h, w) number of the surfel nearest to the camera in each cell, -1 for none.

    A surfel that lies before what the cell sees was seen through, which is counted; the second
    number is of those that were seen through too often now. They are there no more.

    Parameters
    ----------
    limits : (float, float)
        ``gate_per_m`` and ``most_misses`` of `SurfelParams`.
    """
    gate_per_m, most_misses = limits
    n_missed = 0
    height, width, _ = shot.goal.planes.shape
    seen = np.full((height, width), -1, np.int32)
    nearest = np.zeros((height, width), np.float32)
    for i in range(n):
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
    surfels: Float32Array, n: int, shot: Shot, seen: Int32Array, limits: tuple[float, float]
) -> int:
    """Fuse what a frame sees into the map, and return how many surfels there are then.

    Parameters
    ----------
    surfels : (capacity, 13) float32 array
        Changed in place; what does not fit any more is left out.
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
            elif facing > limits[0] and n < len(surfels):
                surfels[n] = fresh
                n += 1
    return n
