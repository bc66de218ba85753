"""A limb of two bones laid into the surface of its parts, where the parts are told apart badly.

A forest knows a leg as a leg better than it knows where the knee is. So the pixels of all parts of
a limb are explained by two bones of known length: points and bones are matched by distance and by
the parts' probabilities, then the joints are moved by least squares, in turns (expectation and
maximisation on points, as in Corazza et al., IJCV 87 (2010), section 3, for whole surfaces).
"""

import math

import numpy as np

from adibas.arrays import FloatArray
from adibas.kernels import compiled, compiled_parallel, parallel_range

N_ROUNDS = 8
LEAST = 1e-9


@compiled_parallel
def fit_limbs_from(
    points: FloatArray, shares: FloatArray, starts: FloatArray, pulls: FloatArray, sizes: FloatArray
) -> FloatArray:
    """Do as `fit_limb` with each of (S, 3, 3) starts, on all cores; return the (S,) costs."""
    costs = np.empty(starts.shape[0])
    for number in parallel_range(starts.shape[0]):
        costs[number] = fit_limb(points, shares, starts[number], pulls, sizes)
    return costs


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
    for number in range(N_ROUNDS):
        cost = _match(points, shares, start, sizes, matrix, right, number == N_ROUNDS - 1)
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
def _along(
    px: float, py: float, pz: float, joints: FloatArray, bone: int, length: float
) -> tuple[float, float]:
    """Return where on a bone a point is nearest (0 to 1), and how far squared.

    `length` is squared.
    """
    ax, ay, az = joints[bone, 0], joints[bone, 1], joints[bone, 2]
    bx, by, bz = joints[bone + 1, 0] - ax, joints[bone + 1, 1] - ay, joints[bone + 1, 2] - az
    dx, dy, dz = px - ax, py - ay, pz - az
    t = min(max((dx * bx + dy * by + dz * bz) / length, 0.0), 1.0)
    ex, ey, ez = dx - t * bx, dy - t * by, dz - t * bz
    return t, ex * ex + ey * ey + ez * ez


@compiled
def _match(  # noqa: PLR0913, PLR0915, PLR0917  (a kernel: sums in numbers of their own)
    points: FloatArray,
    shares: FloatArray,
    joints: FloatArray,
    sizes: FloatArray,
    matrix: FloatArray,
    right: FloatArray,
    is_last: bool,
) -> float:
    """Put down what the points say of the joints; return the cost of the points, if `is_last`.

    The sums are kept in numbers of their own: sums in an array wait for what was just written, and
    take twice as long.
    """
    half = 0.5 / (sizes[3] * sizes[3])
    # Beyond three widths all is as far: what is no part of the limb must not drag it away.
    far_away = math.exp(-4.5) * sizes[4]
    length1 = max(_squared(joints[0], joints[1]), LEAST)
    length2 = max(_squared(joints[1], joints[2]), LEAST)
    m00 = m01 = m11 = m12 = m22 = 0.0
    x0 = y0 = z0 = x1 = y1 = z1 = x2 = y2 = z2 = 0.0
    cost = 0.0
    for i in range(points.shape[0]):
        px, py, pz, weight = points[i, 0], points[i, 1], points[i, 2], points[i, 3]
        t1, far1 = _along(px, py, pz, joints, 0, length1)
        t2, far2 = _along(px, py, pz, joints, 1, length2)
        like1 = (shares[i, 0] + sizes[4]) * math.exp(-half * far1)
        like2 = (shares[i, 1] + sizes[4]) * math.exp(-half * far2)
        total = like1 + like2 + far_away
        if is_last:
            cost -= weight * math.log(total) / half
        w1, w2 = weight * like1 / total, weight * like2 / total
        a1, a2 = 1.0 - t1, 1.0 - t2
        m00 += w1 * a1 * a1
        m01 += w1 * a1 * t1
        m11 += w1 * t1 * t1
        m11 += w2 * a2 * a2
        m12 += w2 * a2 * t2
        m22 += w2 * t2 * t2
        x0, y0, z0 = x0 + w1 * a1 * px, y0 + w1 * a1 * py, z0 + w1 * a1 * pz
        x1, y1, z1 = x1 + w1 * t1 * px, y1 + w1 * t1 * py, z1 + w1 * t1 * pz
        x1, y1, z1 = x1 + w2 * a2 * px, y1 + w2 * a2 * py, z1 + w2 * a2 * pz
        x2, y2, z2 = x2 + w2 * t2 * px, y2 + w2 * t2 * py, z2 + w2 * t2 * pz
    matrix[0, 0], matrix[0, 1], matrix[0, 2] = m00, m01, 0.0
    matrix[1, 0], matrix[1, 1], matrix[1, 2] = m01, m11, m12
    matrix[2, 0], matrix[2, 1], matrix[2, 2] = 0.0, m12, m22
    right[0, 0], right[0, 1], right[0, 2] = x0, y0, z0
    right[1, 0], right[1, 1], right[1, 2] = x1, y1, z1
    right[2, 0], right[2, 1], right[2, 2] = x2, y2, z2
    return cost


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
