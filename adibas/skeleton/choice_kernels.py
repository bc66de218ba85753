"""The best choice of one place for each joint, by dynamic programming on the tree of bones.

Source: Felzenszwalb & Huttenlocher, Pictorial structures for object recognition, IJCV 61 (2005),
section 3.
"""

import math

import numpy as np

from adibas.arrays import FloatArray, IntArray
from adibas.kernels import compiled

FAR = 1e9


@compiled
def bone_cost(
    child_m: FloatArray, parent_m: FloatArray, length_m: float, spread_m: float, most: float
) -> float:
    """Return half the squared deviation of a bone's length, at most `most`."""
    dx, dy, dz = child_m[0] - parent_m[0], child_m[1] - parent_m[1], child_m[2] - parent_m[2]
    off = (math.sqrt(dx * dx + dy * dy + dz * dz) - length_m) / spread_m
    return min(0.5 * off * off, most)


@compiled
def choose(
    places_m: FloatArray,
    costs: FloatArray,
    tree: tuple[IntArray, IntArray],
    bones: tuple[FloatArray, FloatArray],
    most: float,
) -> tuple[IntArray, FloatArray]:
    """Return the cheapest choice.

    Parameters
    ----------
    places_m : (J, K, 3) array
        Metres.
    costs : (J, K + 1) array
        Of each place, and of "not seen" last; `FAR` where there is no place.
    tree : two (J,) arrays
        Parents (-1: none), and the joints, each after its parent.
    bones : two (J,) arrays
        Length and spread of the bone from each joint to its parent, metres.
    most : float
        Cost of a bone that cannot be.

    Returns
    -------
    chosen : (J,) array
        Number of the place, K: not seen.
    margins : (J,) array
        By how much the whole would cost more without the joint's place (0 or less: not seen).
    """
    parents, order = tree
    pairs = _pairs(places_m, parents, bones, most)
    n_joints, n_states = costs.shape
    up = costs.copy()
    to_parent = np.zeros((n_joints, n_states))
    best_of = np.zeros((n_joints, n_states), np.int64)
    for step in range(n_joints - 1, -1, -1):
        joint = order[step]
        parent = parents[joint]
        if parent < 0:
            continue
        for above in range(n_states):
            best = int(np.argmin(up[joint] + pairs[joint, :, above]))
            best_of[joint, above] = best
            to_parent[joint, above] = up[joint, best] + pairs[joint, best, above]
        up[parent] += to_parent[joint]
    return _walked_down(up, to_parent, best_of, pairs, tree)


@compiled
def _pairs(
    places_m: FloatArray, parents: IntArray, bones: tuple[FloatArray, FloatArray], most: float
) -> FloatArray:
    """Return (J, K + 1, K + 1): cost of the bone from each place to each place of the parent."""
    n_joints, n_places = places_m.shape[:2]
    pairs = np.zeros((n_joints, n_places + 1, n_places + 1))
    for joint in range(n_joints):
        parent = parents[joint]
        if parent < 0:
            continue
        for place in range(n_places):
            for above in range(n_places):
                child_m, parent_m = places_m[joint, place], places_m[parent, above]
                if child_m[0] == child_m[0] and parent_m[0] == parent_m[0]:
                    length_m, spread_m = bones[0][joint], bones[1][joint]
                    pairs[joint, place, above] = bone_cost(
                        child_m, parent_m, length_m, spread_m, most
                    )
    return pairs


@compiled
def _walked_down(
    up: FloatArray,
    to_parent: FloatArray,
    best_of: IntArray,
    pairs: FloatArray,
    tree: tuple[IntArray, IntArray],
) -> tuple[IntArray, FloatArray]:
    """Choose from the root on; the costs of everything outside a joint give its margin."""
    parents, order = tree
    n_joints, n_states = up.shape
    chosen = np.zeros(n_joints, np.int64)
    margins = np.zeros(n_joints)
    whole = up.copy()
    for step in range(n_joints):
        joint = order[step]
        parent = parents[joint]
        if parent < 0:
            chosen[joint] = np.argmin(whole[joint])
        else:
            chosen[joint] = best_of[joint, chosen[parent]]
            outside = whole[parent] - to_parent[joint]
            for state in range(n_states):
                whole[joint, state] = up[joint, state] + np.min(outside + pairs[joint, state])
        margins[joint] = whole[joint, n_states - 1] - np.min(whole[joint, : n_states - 1])
    return chosen, margins
