"""The loop that finds which way the surface of a grid of points looks."""

import math

import numpy as np

from adibas.arrays import FloatArray
from adibas.kernels import compiled

REACH = 2
"""Rows and columns to the neighbours that a normal is taken from."""


@compiled
def grid_normals(points_m: FloatArray) -> FloatArray:
    """Return (h, w, 3) unit normals of an (h, w, 3) grid of points; NaN where one is unknown.

    A normal is the cross product of the way down and the way across, so that it points to a
    camera that looks along z with y down.
    """
    height, width = points_m.shape[:2]
    normals = np.full((height, width, 3), np.nan)
    for row in range(REACH, height - REACH):
        for column in range(REACH, width - REACH):
            above, below = points_m[row - REACH, column], points_m[row + REACH, column]
            left, right = points_m[row, column - REACH], points_m[row, column + REACH]
            down_x, down_y, down_z = below[0] - above[0], below[1] - above[1], below[2] - above[2]
            along_x, along_y, along_z = right[0] - left[0], right[1] - left[1], right[2] - left[2]
            x = down_y * along_z - down_z * along_y
            y = down_z * along_x - down_x * along_z
            z = down_x * along_y - down_y * along_x
            length = math.sqrt(x * x + y * y + z * z)
            if length > 0.0:
                normals[row, column, 0] = x / length
                normals[row, column, 1] = y / length
                normals[row, column, 2] = z / length
    return normals
