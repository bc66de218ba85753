"""Distances of points and angles at a vertex, with their derivatives by every coordinate."""

from typing import NamedTuple

import numpy as np

from adibas.arrays import FloatArray


def distance(a_m: FloatArray, b_m: FloatArray) -> FloatArray:
    """Return the (...) distances of (..., 3) points, metres; NaN stays NaN."""
    return np.asarray(np.linalg.norm(np.asarray(a_m, float) - np.asarray(b_m, float), axis=-1))


def distance_derivatives(a_m: FloatArray, b_m: FloatArray) -> FloatArray:
    """Return the derivatives of the distance by both points, (..., 2, 3); no unit.

    NaN where the points coincide: a distance of 0 has no derivative.
    """
    towards_a = unit(np.asarray(a_m, float) - np.asarray(b_m, float))
    return np.stack([towards_a, -towards_a], axis=-2)


def angle(a_m: FloatArray, vertex_m: FloatArray, c_m: FloatArray) -> FloatArray:
    """Return the angles at `vertex_m` between the directions to `a_m` and to `c_m`.

    Parameters
    ----------
    a_m, vertex_m, c_m : (..., 3) arrays
        Metres.

    Returns
    -------
    angle_rad : (...) array
        In [0, pi], exact to rounding also near both ends; NaN where a point coincides with the
        vertex or is NaN.

    Source: Kahan, How futile are mindless assessments of roundoff (2006), section 12: of the two
    unit vectors a and c it is 2 atan2(|a - c|, |a + c|).
    """
    to_a, to_c = unit(np.asarray(a_m, float) - vertex_m), unit(np.asarray(c_m, float) - vertex_m)
    apart = np.linalg.norm(to_a - to_c, axis=-1)
    together = np.linalg.norm(to_a + to_c, axis=-1)
    return np.asarray(2.0 * np.arctan2(apart, together))


def angle_derivatives(a_m: FloatArray, vertex_m: FloatArray, c_m: FloatArray) -> FloatArray:
    """Return the derivatives of the angle by the three points.

    Returns
    -------
    derivatives : (..., 3, 3) array
        Radians per metre, in the order a, vertex, c. At 0 and pi, where the angle has no
        derivative, the one-sided slope in a direction of no meaning. NaN where a point coincides
        with the vertex.
    """
    moves = arm_derivatives(a_m, vertex_m, c_m)
    return moves.turn_a + moves.turn_c


class ArmDerivatives(NamedTuple):
    """How the two arms of an angle move when its points do: (..., 3, 3) arrays, a vertex c.

    Attributes
    ----------
    turn_a, turn_c : radians per metre
        Each arm turns in the plane of the angle, and widens it.
    lift_a, lift_c : radians per metre
        Each arm rises above the plane, to the side of its normal.
    stretch_a, stretch_c : 1 per metre
        Each arm grows, as a share of its length.
    """

    turn_a: FloatArray
    turn_c: FloatArray
    lift_a: FloatArray
    lift_c: FloatArray
    stretch_a: FloatArray
    stretch_c: FloatArray


def arm_derivatives(a_m: FloatArray, vertex_m: FloatArray, c_m: FloatArray) -> ArmDerivatives:
    """Return the derivatives of both arms by (..., 3) points in metres.

    Of the plane of a straight angle, or one of 0, nothing is known but that it holds the line: an
    arbitrary one is taken. NaN where a point coincides with the vertex.
    """
    side_a = np.asarray(a_m, float) - vertex_m
    side_c = np.asarray(c_m, float) - vertex_m
    to_a, to_c = unit(side_a), unit(side_c)
    normal = _normal(to_a, to_c)
    per_a = 1.0 / np.linalg.norm(np.where(np.isnan(to_a), np.nan, side_a), axis=-1, keepdims=True)
    per_c = 1.0 / np.linalg.norm(np.where(np.isnan(to_c), np.nan, side_c), axis=-1, keepdims=True)
    zero = np.zeros_like(normal)

    def of_a(direction: FloatArray) -> FloatArray:
        return np.stack([direction * per_a, -direction * per_a, zero], axis=-2)

    def of_c(direction: FloatArray) -> FloatArray:
        return np.stack([zero, -direction * per_c, direction * per_c], axis=-2)

    return ArmDerivatives(
        turn_a=of_a(np.cross(to_a, normal)),
        turn_c=of_c(np.cross(normal, to_c)),
        lift_a=of_a(normal),
        lift_c=of_c(normal),
        stretch_a=of_a(to_a),
        stretch_c=of_c(to_c),
    )


def unit(vectors: FloatArray) -> FloatArray:
    """Return (..., 3) vectors at length 1; NaN for those of length 0."""
    lengths = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.asarray(vectors / np.where(lengths > 0, lengths, np.nan))


def _normal(to_a: FloatArray, to_c: FloatArray) -> FloatArray:
    """Return a unit vector across both directions; any such where they are parallel."""
    normal = np.cross(to_a, to_c)
    is_parallel = (normal == 0.0).all(axis=-1)
    if is_parallel.any():
        least = np.eye(3)[np.argmin(np.abs(np.nan_to_num(to_a)), axis=-1)]
        normal = np.where(is_parallel[..., None], np.cross(to_a, least), normal)
    # Nearly parallel directions leave a cross product that rounding has tilted.
    normal = unit(normal)
    return unit(normal - (normal * to_a).sum(axis=-1, keepdims=True) * to_a)
