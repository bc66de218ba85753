"""Small rotations for posing bones: about an axis, onto a direction, part of the way."""

import math

import numpy as np

from adibas.arrays import FloatArray


def unit(vector: FloatArray) -> FloatArray:
    """Return `vector` (3,) at length 1."""
    length = math.sqrt(float(vector @ vector))
    if not length > 0:
        raise ValueError("a direction must not be zero")
    return vector / length


def cross(a: FloatArray, b: FloatArray) -> FloatArray:
    """Return the vector product of two (3,) vectors; much faster than numpy's for one pair."""
    return np.array(
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    )


def about(axis: FloatArray, angle_rad: float) -> FloatArray:
    """Return the (3, 3) rotation about `axis` (any length) by the right-hand rule.

    Source: Rodrigues' formula.
    """
    x, y, z = unit(axis)
    skew = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    turn: FloatArray = (
        np.eye(3) + math.sin(angle_rad) * skew + (1 - math.cos(angle_rad)) * (skew @ skew)
    )
    return turn


def onto(start: FloatArray, end: FloatArray) -> FloatArray:
    """Return the smallest (3, 3) rotation that turns direction `start` onto `end`."""
    a, b = unit(start), unit(end)
    axis = cross(a, b)
    sine = math.sqrt(float(axis @ axis))
    cosine = float(a @ b)
    if sine < 1e-9:  # noqa: PLR2004  (parallel to rounding)
        return np.eye(3) if cosine > 0 else about(any_normal(a), math.pi)
    return about(axis, math.atan2(sine, cosine))


def any_normal(direction: FloatArray) -> FloatArray:
    """Return some unit vector at right angles to `direction`."""
    return unit(cross(direction, np.eye(3)[np.argmin(np.abs(direction))]))


def frame(direction: FloatArray, beside: FloatArray) -> FloatArray:
    """Return the rotation whose columns are `direction`, `beside` made normal to it, and theirs."""
    first = unit(direction)
    second = unit(beside - first * (beside @ first))
    return np.stack([first, second, cross(first, second)], axis=1)


def part_way(start: FloatArray, end: FloatArray, share: float) -> FloatArray:
    """Return the rotation that lies `share` of the way from `start` to `end`.

    Half a turn between the two has no single shortest way; the axis is then any of those.
    """
    turn = end @ start.T
    axis = np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]])
    sine = 0.5 * math.sqrt(float(axis @ axis))
    angle = math.atan2(sine, 0.5 * (float(np.trace(turn)) - 1.0))
    if sine < 1e-9:  # noqa: PLR2004  (no turn, or half a turn)
        if angle < 1.0:
            return start
        symmetric = turn + np.eye(3)
        axis = symmetric[:, np.argmax(np.diag(symmetric))]
    return about(axis, share * angle) @ start


def turn_about(axis: FloatArray, rotation: FloatArray) -> float:
    """Return the signed angle of a `rotation` about the unit vector `axis`, radians."""
    sine = 0.5 * float(
        axis[0] * (rotation[2, 1] - rotation[1, 2])
        + axis[1] * (rotation[0, 2] - rotation[2, 0])
        + axis[2] * (rotation[1, 0] - rotation[0, 1])
    )
    return math.atan2(sine, 0.5 * (float(np.trace(rotation)) - 1.0))
