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
    around = _surround(boxes)
    for i in range(len(ways)):
        nearest = _through(origin, ways[i], boxes[0])[1]
        for number in range(1, len(boxes)):
            if not _may_meet(origin, ways[i], around[number]):
                continue
            near, far = _through(origin, ways[i], boxes[number])
            if near < far and 0.0 < near < nearest:
                nearest, owners[i] = near, number
        for number in range(len(spheres)):
            if not _may_meet(origin, ways[i], spheres[number]):
                continue
            near = _onto(origin, ways[i], spheres[number])
            if 0.0 < near < nearest:  # false for NaN
                nearest, owners[i] = near, len(boxes) + number
        depths[i] = nearest
    return depths, owners


@compiled
def _surround(boxes: FloatArray) -> FloatArray:
    """Return the (B, 4) spheres around boxes, a little too large."""
    around = np.empty((len(boxes), 4))
    around[:, :3] = boxes[:, :3]
    for number in range(len(boxes)):
        x, y, z = boxes[number, 3], boxes[number, 4], boxes[number, 5]
        around[number, 3] = 1.001 * np.sqrt(x * x + y * y + z * z)
    return around


@compiled
def _may_meet(origin: FloatArray, way: FloatArray, sphere: FloatArray) -> bool:
    """Return whether the line along a ray comes near a sphere; false only where it does not."""
    along, squared, apart = 0.0, 0.0, 0.0
    for k in range(3):
        off = sphere[k] - origin[k]
        along += off * way[k]
        squared += way[k] * way[k]
        apart += off * off
    beside = apart - 1.001 * sphere[3] * sphere[3]
    return beside <= 0.0 or (along > 0.0 and along * along >= beside * squared)


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
