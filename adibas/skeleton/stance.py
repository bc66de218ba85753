"""How all joints of somebody who stands still in a declared view lie together.

Core and limbs tell how a limb depends on the core, and nothing of how one limb depends on another.
Where all joints of people who stand still are is a mixture of normal distributions. Of some one
limb is elsewhere, or its outer bone (a hand on the hip): it is as long as usual, or nearly as the
same bone of the other side where that is seen, and points anywhere, arms mostly to where elbows
bend: about the mean direction of arms that do not hang (Fisher, Dispersion on a sphere, Proceedings
of the Royal Society A 217, 1953).
"""

import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from adibas.arrays import FloatArray, IntArray
from adibas.shapes.gaussian_mixture import Mixture

LEAST_PLACES = 3
"""Fewer points together tell nothing."""
BALL = 4.0 / 3.0 * math.pi
REACH = 1.1
"""How far an outer point may be whose inner one is hidden, in lengths of both bones."""
BEYOND = math.exp(-20.0)
"""Density, per cubic metre, of an outer point farther away."""
TINY_M = 1e-3
OF_NATS = 7.0
"""Components that are less likely than the likeliest by more are not those of a way."""
LIFTED = np.array([[0.50, 0.51, -0.70], [-0.19, -0.43, -0.88]])
"""Mean directions of a left upper arm (outwards, down, forwards) and forearm that does not hang.

Of 9,101 arms of simulated people who move, seed 11.
"""
CONCENTRATIONS = (2.3, 2.0)
"""Of both about these directions."""
MIRRORED = np.array([[1.0, 1.0, 1.0], [-1.0, 1.0, 1.0]])
"""Left arm, right arm: the first limbs."""


class Stance(NamedTuple):
    """N joints of people who stand, in the axes of a patient who faces the camera, metres, y down.

    Attributes
    ----------
    weights : (K,) array
        Of the components; they sum to 1.
    means, covariances : (K, 3 N) and (K, 3 N, 3 N) arrays
        Of the places about the middle of the points that are seen, wherever that is.
    limbs : (L, 3) int array
        Which labels are a limb's root, inner and outer point: a left limb, then its mirror image.
    bone_means, bone_sds : (L, 2) arrays
        Of the logarithms of the lengths of both bones.
    bone_correlations : (L, 2) array
        Of these with those of the other side.
    """

    weights: FloatArray
    means: FloatArray
    covariances: FloatArray
    limbs: IntArray
    bone_means: FloatArray
    bone_sds: FloatArray
    bone_correlations: FloatArray


def stance_log_densities(
    stance: Stance,
    places_m: FloatArray,
    partners: IntArray,
    room_m3: float,
    elsewhere: Sequence[float],
) -> FloatArray:
    """Return the (W,) log densities of W ways to name points, if somebody stands there.

    Parameters
    ----------
    places_m : (M, 3) array
        In the axes of the stance, centred.
    partners : (W, N) int array
        Of each name its point, -1 for none.
    room_m3 : float
        In which a point is that nothing is known of.
    elsewhere : sequence of L float
        How often each limb is elsewhere, and again how often its outer bone alone; of one person no
        two are.
    """
    rests, logs = [partners], [np.full(len(partners), math.log1p(-2.0 * sum(elsewhere)))]
    for limb, (labels, often) in enumerate(zip(stance.limbs, elsewhere, strict=True)):
        free = bone_log_densities(stance, limb, places_m, partners, room_m3)
        for n_fixed in (1, 2):
            rest = partners.copy()
            rest[:, labels[n_fixed:]] = -1
            rests.append(rest)
            logs.append(math.log(often) + free[:, n_fixed - 1 :].sum(axis=1))
    together = place_log_densities(_mixture(stance), places_m, np.concatenate(rests))
    return np.asarray(
        np.logaddexp.reduce(together.reshape(len(rests), -1) + np.stack(logs), axis=0)
    )


def components_of(stance: Stance, places_m: FloatArray, way: IntArray) -> Mixture:
    """Return the components that may be of one way to name points: (N,), of each name its point."""
    labels = np.flatnonzero(way >= 0)
    of_labels = _mixture(stance).marginal(_columns(labels))
    logs = of_labels.log_densities(places_m[way[labels]].reshape(1, -1))[0]
    kept = logs > logs.max() - OF_NATS
    return Mixture(stance.weights[kept], stance.means[kept], stance.covariances[kept])


def place_log_densities(mixture: Mixture, places_m: FloatArray, partners: IntArray) -> FloatArray:
    """Return the (W,) log densities of the places of the labels that have a point.

    Parameters
    ----------
    mixture : Mixture
        Of the 3 N coordinates of all labels.
    places_m : (M, 3) array
        In the axes of the mixture.
    partners : (W, N) int array
        Of each label its point, -1 for none. Ways with fewer than `LEAST_PLACES` have minus
        infinity.
    """
    different, inverse = np.unique(partners, axis=0, return_inverse=True)
    found = np.full(len(different), -np.inf)
    for labels, ways in _alike(different):
        if len(labels) >= LEAST_PLACES:
            rows = places_m[different[np.ix_(ways, labels)]].reshape(len(ways), -1)
            of_labels = mixture.marginal(_columns(labels))
            found[ways] = np.logaddexp.reduce(of_labels.log_densities(rows), axis=1)
    return found[inverse.ravel()]


def _mixture(stance: Stance) -> Mixture:
    return Mixture(stance.weights, stance.means, stance.covariances)


def _columns(labels: IntArray) -> IntArray:
    """Return which coordinates are those of labels."""
    return np.asarray((3 * labels[:, None] + np.arange(3)).ravel())


def _alike(partners: IntArray) -> Iterator[tuple[IntArray, IntArray]]:
    """Give the labels that have a point, and the ways in which it is just these."""
    has_point, inverse = np.unique(partners >= 0, axis=0, return_inverse=True)
    for number, one in enumerate(has_point):
        yield np.flatnonzero(one), np.flatnonzero(inverse.ravel() == number)


def bone_log_densities(
    stance: Stance, limb: int, places_m: FloatArray, partners: IntArray, room_m3: float
) -> FloatArray:
    """Return the (W, 2) log densities of a limb's points where it is elsewhere.

    A point at the end of a bone is in a shell about the other end, as thick as lengths vary; one
    whose bone has lost its other end is within the reach of both bones, or anywhere in the room.
    """
    root, inner, outer = (partners[:, label] for label in stance.limbs[limb])
    nowhere = -math.log(room_m3)
    upper, lower = (_lengths(stance, limb, bone, places_m, partners) for bone in (0, 1))
    to_inner = _shell(_apart(places_m, root, inner), *upper)
    to_outer = _shell(_apart(places_m, inner, outer), *lower)
    if limb < len(MIRRORED):
        to_inner += _lifted(places_m[inner] - places_m[root], limb, 0)
        to_outer += _lifted(places_m[outer] - places_m[inner], limb, 1)
    reach_m = float(np.exp(stance.bone_means[limb]).sum())
    is_near = _apart(places_m, root, outer) < REACH * reach_m
    within = np.where(is_near, -math.log(BALL * reach_m**3), math.log(BEYOND))
    of_inner = np.where(root >= 0, to_inner, nowhere)
    of_outer = np.where(inner >= 0, to_outer, np.where(root >= 0, within, nowhere))
    own = np.where(inner >= 0, of_inner, 0.0), np.where(outer >= 0, of_outer, 0.0)
    return np.stack(own, axis=1)


def _apart(places_m: FloatArray, first: IntArray, second: IntArray) -> FloatArray:
    """Return how far apart points are; where either is none, the number means nothing."""
    off_m = places_m[second] - places_m[first]
    return np.asarray(np.maximum(np.linalg.norm(off_m, axis=1), TINY_M))


def _lifted(bones_m: FloatArray, arm: int, bone: int) -> FloatArray:
    """Return by how much (W, 3) bones of a lifted arm are likelier to point there than anywhere."""
    mean = LIFTED[bone] / np.linalg.norm(LIFTED[bone]) * MIRRORED[arm]
    lengths_m = np.maximum(np.linalg.norm(bones_m, axis=1), TINY_M)
    concentration = CONCENTRATIONS[bone]
    even = math.log(concentration / math.sinh(concentration))
    return np.asarray(concentration * (bones_m @ mean) / lengths_m + even)


def _lengths(
    stance: Stance, limb: int, bone: int, places_m: FloatArray, partners: IntArray
) -> tuple[FloatArray, FloatArray]:
    """Return the (W,) means and deviations of the logarithm of a bone's length."""
    other = limb ^ 1
    first, second = (partners[:, stance.limbs[other, end]] for end in (bone, bone + 1))
    alike = stance.bone_correlations[limb, bone] * ((first >= 0) & (second >= 0))
    off = np.log(_apart(places_m, first, second)) - stance.bone_means[other, bone]
    slopes = alike * stance.bone_sds[limb, bone] / stance.bone_sds[other, bone]
    means = stance.bone_means[limb, bone] + slopes * off
    return np.asarray(means), stance.bone_sds[limb, bone] * np.sqrt(1.0 - alike**2)


def _shell(lengths_m: FloatArray, means: FloatArray, sds: FloatArray) -> FloatArray:
    """Return log densities, per cubic metre, at the end of a bone of log-normal length."""
    logs = np.log(lengths_m)
    of_length = -0.5 * ((logs - means) / sds) ** 2 - np.log(sds * math.sqrt(2 * math.pi)) - logs
    return np.asarray(of_length - math.log(4 * math.pi) - 2 * logs)
