"""What one moment of a body that moves would look like at another one."""

import math

import numpy as np

from adibas.alignment.projective_kernels import Goal, carried, place_in
from adibas.arrays import Float32Array, FloatArray
from adibas.kernels import compiled


@compiled
def moved_image(
    inverse_per_m: Float32Array, rays: Float32Array, goal: Goal, motion: FloatArray
) -> Float32Array:
    """Return the (H, W) 1/z of an image after a rigid motion; NaN where no pixel falls.

    Each pixel is moved with the plane of its own neighbourhood, and tells 1/z on the ray of the
    pixel that it falls into, not where it falls: a slanted surface stays where it is. Where
    several fall into one pixel the nearest wins.

    Parameters
    ----------
    inverse_per_m, rays : (H, W), (H, W, 2) float32 arrays
        Of the camera, which stands still.
    goal : Goal
        The planes of this same image, and the camera.
    motion : (3, 4) array
        Of what is seen, in the camera's axes.
    """
    height, width = inverse_per_m.shape
    image = np.full((height, width), np.float32(np.nan), np.float32)
    n_rows, n_columns, _ = goal.planes.shape
    for v in range(min(height, n_rows * goal.cell_px)):
        for u in range(min(width, n_columns * goal.cell_px)):
            plane = goal.planes[v // goal.cell_px, u // goal.cell_px]
            # Both comparisons fail for NaN.
            if inverse_per_m[v, u] > 0.0 and plane[0] == plane[0]:
                _draw(image, rays, goal, motion, (u, v), inverse_per_m[v, u])
    return image


@compiled
def _draw(
    image: Float32Array,
    rays: Float32Array,
    goal: Goal,
    motion: FloatArray,
    pixel: tuple[int, int],
    inverse_per_m: float,
) -> None:
    """Draw one pixel where it falls."""
    u, v = pixel
    z = 1.0 / inverse_per_m
    px, py, pz = carried(motion, rays[v, u, 0] * z, rays[v, u, 1] * z, z)
    if pz <= 0.0:
        return
    plane = goal.planes[v // goal.cell_px, u // goal.cell_px]
    a, b, c = plane[0], plane[1], plane[2]
    nx = motion[0, 0] * a + motion[0, 1] * b + motion[0, 2] * c
    ny = motion[1, 0] * a + motion[1, 1] * b + motion[1, 2] * c
    nz = motion[2, 0] * a + motion[2, 1] * b + motion[2, 2] * c
    # The plane through the point itself: its normal over `size` times any of its points is one.
    size = nx * px + ny * py + nz * pz
    if size <= 0.0:  # it would be seen from behind
        return
    x, y = px / pz, py / pz
    at_u, at_v = place_in(goal, x, y)
    column, row = math.floor(at_u), math.floor(at_v)
    height, width = image.shape
    if not (0 <= column < width and 0 <= row < height):
        return
    across, down = rays[row, column, 0] - x, rays[row, column, 1] - y
    found = np.float32(1.0 / pz + (nx * across + ny * down) / size)
    if found > 0.0 and not image[row, column] >= found:  # true for NaN
        image[row, column] = found
