"""The hot loops of colour: conversion and region growing."""

import numpy as np

from adibas.arrays import BoolArray, Float32Array, UInt8Array
from adibas.kernels import compiled


@compiled
def convert(
    color_rgb: UInt8Array, linear: Float32Array, companded: Float32Array, matrix: Float32Array
) -> Float32Array:
    """Convert (H, W, 3) sRGB to CIELAB with tables for the two curves."""
    height, width, _ = color_rgb.shape
    lab = np.empty((height, width, 3), np.float32)
    n_steps = np.float32(companded.shape[0] - 3)
    f = np.empty(3, np.float32)
    for row in range(height):
        for column in range(width):
            r = linear[color_rgb[row, column, 0]]
            g = linear[color_rgb[row, column, 1]]
            b = linear[color_rgb[row, column, 2]]
            for axis in range(3):
                t = matrix[axis, 0] * r + matrix[axis, 1] * g + matrix[axis, 2] * b
                place = t * n_steps
                step = int(place)
                part = place - np.float32(step)
                f[axis] = companded[step] + part * (companded[step + 1] - companded[step])
            lab[row, column, 0] = np.float32(116.0) * f[1] - np.float32(16.0)
            lab[row, column, 1] = np.float32(500.0) * (f[0] - f[1])
            lab[row, column, 2] = np.float32(200.0) * (f[1] - f[2])
    return lab


@compiled
def grow(lab: Float32Array, row: int, column: int, sensitivity: float) -> BoolArray:
    """Return the 4-connected component of ``|lab - seed| < sensitivity`` that holds the seed."""
    height, width, _ = lab.shape
    region = np.zeros((height, width), np.bool_)
    seed_l, seed_a, seed_b = lab[row, column, 0], lab[row, column, 1], lab[row, column, 2]
    limit = np.float32(sensitivity * sensitivity)
    # Every pixel is pushed once at most: it is marked when pushed.
    stack = np.empty(height * width, np.int32)
    stack[0] = row * width + column
    region[row, column] = True
    n_waiting = 1
    while n_waiting > 0:
        n_waiting -= 1
        here_row, here_column = divmod(stack[n_waiting], width)
        for side in range(4):
            next_row = here_row + (side == 0) - (side == 1)
            next_column = here_column + (side == 2) - (side == 3)  # noqa: PLR2004  (four sides)
            if next_row < 0 or next_column < 0 or next_row >= height or next_column >= width:
                continue
            if region[next_row, next_column]:
                continue
            difference_l = lab[next_row, next_column, 0] - seed_l
            difference_a = lab[next_row, next_column, 1] - seed_a
            difference_b = lab[next_row, next_column, 2] - seed_b
            squared = difference_l**2 + difference_a**2 + difference_b**2
            if squared < limit:
                region[next_row, next_column] = True
                stack[n_waiting] = next_row * width + next_column
                n_waiting += 1
    return region
