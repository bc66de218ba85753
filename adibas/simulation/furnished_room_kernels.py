"""Hot loop of the furnished room: what each ray meets first."""

import numpy as np

from adibas.arrays import FloatArray, IntArray
from adibas.kernels import compiled


@compiled
def cast_rays(
    origin: FloatArray, ways: FloatArray, boxes: FloatArray, spheres: FloatArray
) -> tuple[FloatArray, IntArray]:
    """Return how far along each way the nearest surface lies, and whose it is.

    Parameters
    ----------
    origin : (3,) array
        Of all rays.
    ways : (N, 3) array
    boxes : (B, 8) array
        Middle, half sides, cosine and sine of the turn about the vertical. The first is the room
        itself, seen from inside.
    spheres : (S, 4) array
        Middle and radius.

    Returns
    -------
    depths : (N,) array
        In lengths of the way.
    owners : (N,) array
        0 for the room, then boxes and spheres in their order.
    """
    depths = np.empty(len(ways))
    owners = np.zeros(len(ways), np.int64)
    for i in range(len(ways)):
        nearest = _through(origin, ways[i], boxes[0])[1]
        for number in range(1, len(boxes)):
            near, far = _through(origin, ways[i], boxes[number])
            if near < far and 0.0 < near < nearest:
                nearest, owners[i] = near, number
        for number in range(len(spheres)):
            near = _onto(origin, ways[i], spheres[number])
            if 0.0 < near < nearest:  # false for NaN
                nearest, owners[i] = near, len(boxes) + number
        depths[i] = nearest
    return depths, owners


@compiled
def _through(origin: FloatArray, way: FloatArray, box: FloatArray) -> tuple[float, float]:
    """Return where a ray enters and leaves a box (slab method; outside: enter > leave)."""
    c, s = box[6], box[7]
    x, y, z = origin[0] - box[0], origin[1] - box[1], origin[2] - box[2]
    place = (c * x - s * z, y, s * x + c * z)
    turned = (c * way[0] - s * way[2], way[1], s * way[0] + c * way[2])
    enter, leave = -np.inf, np.inf
    for k in range(3):
        half = box[3 + k]
        if turned[k] == 0.0:
            if abs(place[k]) > half:
                return np.inf, -np.inf
            continue
        one, other = (-half - place[k]) / turned[k], (half - place[k]) / turned[k]
        enter, leave = max(enter, min(one, other)), min(leave, max(one, other))
    return enter, leave


@compiled
def _onto(origin: FloatArray, way: FloatArray, sphere: FloatArray) -> float:
    """Return where a ray meets a sphere first; NaN where it does not."""
    a, b, c = 0.0, 0.0, -sphere[3] * sphere[3]
    for k in range(3):
        off = origin[k] - sphere[k]
        a += way[k] * way[k]
        b += way[k] * off
        c += off * off
    under = b * b - a * c
    return (-b - np.sqrt(under)) / a if under >= 0.0 else np.nan
