"""The loop that finds neighbours within a mask."""

import numpy as np

from adibas.arrays import BoolArray, Int32Array
from adibas.kernels import compiled


@compiled
def link(mask: BoolArray, steps: Int32Array) -> tuple[Int32Array, Int32Array]:
    """Give numbers to the pixels of a (T, H, W) mask and find the neighbours of each.

    Returns
    -------
    pixels : (N,) int32 array
        Flat indices.
    neighbors : (N, 2 * len(steps)) int32 array
        At 2 k the pixel one of `steps` further, at 2 k + 1 the one as far back; -1 = outside.
    """
    n_images, height, width = mask.shape
    n_steps = steps.shape[0]
    number = np.full((n_images, height, width), -1, np.int32)
    pixels = np.empty(np.count_nonzero(mask), np.int32)
    neighbors = np.full((pixels.size, 2 * n_steps), -1, np.int32)
    n = 0
    for image in range(n_images):
        for row in range(height):
            for column in range(width):
                if not mask[image, row, column]:
                    continue
                number[image, row, column] = n
                pixels[n] = (image * height + row) * width + column
                for k in range(n_steps):
                    i, r, c = image - steps[k, 0], row - steps[k, 1], column - steps[k, 2]
                    if i >= 0 and r >= 0 and 0 <= c < width and number[i, r, c] >= 0:
                        before = number[i, r, c]
                        neighbors[n, 2 * k + 1] = before
                        neighbors[before, 2 * k] = n
                n += 1
    return pixels, neighbors
