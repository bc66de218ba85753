"""A limb of two bones laid into the surface of its parts, where the parts are told apart badly.

A forest knows a leg as a leg better than it knows where the knee is. So the pixels of all parts of
a limb are explained by two bones of known length: points and bones are matched by distance and by
the parts' probabilities, then the joints are moved by least squares, in turns (expectation and
maximisation on points, as in Corazza et al., IJCV 87 (2010), section 3, for whole surfaces).
"""

import math

import numpy as np

from adibas.arrays import FloatArray
from adibas.kernels import compiled

N_ROUNDS = 8
LEAST = 1e-9


@compiled
def fit_limb(
    points: FloatArray, shares: FloatArray, start: FloatArray, pulls: FloatArray, sizes: FloatArray
) -> float:
    """Move `start` (3, 3), the joints of a limb from its root on; return the cost.

    Parameters
    ----------
    points : (N, 4) array
        Within the limb: x, y, z (metres) and weight.
    shares : (N, 2) array
        How much of the weight speaks for the upper and for the lower bone.
    start : (3, 3) array
        Shoulder, elbow, hand, or hip, knee, foot; changed in place.
    pulls : (3, 4) array
        x, y, z and weight of where each joint was proposed; weight 0: nowhere.
    sizes : (5,) array
        Lengths of both bones, their weight, the width of the limb's noise (metres), and the
        least share of a bone in a point.
    """
    matrix, right = np.zeros((3, 3)), np.zeros((3, 3))
    cost = 0.0
    for _round in range(N_ROUNDS):
        matrix[:] = 0.0
        right[:] = 0.0
        cost = _match(points, shares, start, sizes, matrix, right)
        for joint in range(3):
            matrix[joint, joint] += pulls[joint, 3] + LEAST
            for axis in range(3):
                right[joint, axis] += pulls[joint, 3] * pulls[joint, axis]
                right[joint, axis] += LEAST * start[joint, axis]
        for bone in range(2):
            _keep_length(start, bone, sizes[bone], sizes[2], matrix, right)
        start[:] = np.linalg.solve(matrix, right)
    for bone in range(2):
        length = math.sqrt(_squared(start[bone], start[bone + 1]))
        cost += sizes[2] * (length - sizes[bone]) ** 2
    for joint in range(3):
        if pulls[joint, 3] > 0.0:
            cost += pulls[joint, 3] * _squared(start[joint], pulls[joint, :3])
    return cost


@compiled
def _squared(a: FloatArray, b: FloatArray) -> float:
    squared: float = (a[0] - b[0]) ** 2 + (a[1] - b[1]) ** 2 + (a[2] - b[2]) ** 2
    return squared


@compiled
def _along(point: FloatArray, a: FloatArray, b: FloatArray) -> tuple[float, float]:
    """Return where on the bone from a to b a point is nearest (0 to 1), and how far squared."""
    length = max(_squared(a, b), LEAST)
    t = 0.0
    for axis in range(3):
        t += (point[axis] - a[axis]) * (b[axis] - a[axis])
    t = min(max(t / length, 0.0), 1.0)
    far = 0.0
    for axis in range(3):
        far += (point[axis] - a[axis] - t * (b[axis] - a[axis])) ** 2
    return t, far


@compiled
def _match(
    points: FloatArray,
    shares: FloatArray,
    joints: FloatArray,
    sizes: FloatArray,
    matrix: FloatArray,
    right: FloatArray,
) -> float:
    """Add what the points say of the joints; return the cost of the points."""
    half = 0.5 / (sizes[3] * sizes[3])
    cost = 0.0
    for i in range(points.shape[0]):
        t1, far1 = _along(points[i], joints[0], joints[1])
        t2, far2 = _along(points[i], joints[1], joints[2])
        # Beyond three widths all is as far: what is no part of the limb must not drag it away.
        like1 = (shares[i, 0] + sizes[4]) * math.exp(-half * far1)
        like2 = (shares[i, 1] + sizes[4]) * math.exp(-half * far2)
        total = like1 + like2 + math.exp(-4.5) * sizes[4]
        cost -= points[i, 3] * math.log(total) / half
        _add(points[i], t1, points[i, 3] * like1 / total, 0, matrix, right)
        _add(points[i], t2, points[i, 3] * like2 / total, 1, matrix, right)
    return cost


@compiled
def _add(
    point: FloatArray, t: float, weight: float, bone: int, matrix: FloatArray, right: FloatArray
) -> None:
    a, b = 1.0 - t, t
    matrix[bone, bone] += weight * a * a
    matrix[bone, bone + 1] += weight * a * b
    matrix[bone + 1, bone] += weight * a * b
    matrix[bone + 1, bone + 1] += weight * b * b
    for axis in range(3):
        right[bone, axis] += weight * a * point[axis]
        right[bone + 1, axis] += weight * b * point[axis]


@compiled
def _keep_length(
    joints: FloatArray,
    bone: int,
    length_m: float,
    weight: float,
    matrix: FloatArray,
    right: FloatArray,
) -> None:
    """Add that the bone keeps its direction and has its length."""
    now = max(math.sqrt(_squared(joints[bone], joints[bone + 1])), LEAST)
    matrix[bone, bone] += weight
    matrix[bone + 1, bone + 1] += weight
    matrix[bone, bone + 1] -= weight
    matrix[bone + 1, bone] -= weight
    for axis in range(3):
        step = length_m * (joints[bone + 1, axis] - joints[bone, axis]) / now
        right[bone, axis] -= weight * step
        right[bone + 1, axis] += weight * step
