"""Rotations and translations: ``points_color = color_from_depth.apply(points_depth)``.

Source: thesis, equation 3.1 (read as ``R p + t``, OpenCV's sign of t); Umeyama, Least-squares
estimation of transformation parameters between two point patterns, PAMI 13 (1991), for the fit.
"""

from dataclasses import dataclass

import numpy as np

from adibas.arrays import FloatArray, check_shape, read_only

ORTHONORMAL_TOLERANCE = 1e-6
# Points whose spread in a second direction is below this share of the first lie on a line.
DEGENERATE_SHARE = 1e-9
SMALLEST_ANGLE_RAD = 1e-8


@dataclass(frozen=True, slots=True, eq=False)
class RigidTransform:
    """Moves points from one frame of reference into another, without scale.

    Attributes
    ----------
    rotation : (3, 3) array
        Orthonormal, determinant +1.
    translation_m : (3,) array
        Added after the rotation, metres.
    """

    rotation: FloatArray
    translation_m: FloatArray

    def __post_init__(self) -> None:
        object.__setattr__(self, "rotation", np.array(self.rotation, float))
        object.__setattr__(self, "translation_m", np.array(self.translation_m, float))
        check_shape("rotation", self.rotation, (3, 3))
        check_shape("translation_m", self.translation_m, (3,))
        error = np.abs(self.rotation @ self.rotation.T - np.eye(3)).max()
        if not (error < ORTHONORMAL_TOLERANCE and np.linalg.det(self.rotation) > 0):
            raise ValueError("rotation must be orthonormal with determinant +1")
        if not np.isfinite(self.translation_m).all():
            raise ValueError("translation_m must be finite")
        read_only(self.rotation)
        read_only(self.translation_m)

    def apply(self, points_m: FloatArray) -> FloatArray:
        """Map (..., 3) points in metres; NaN stays NaN."""
        return np.asarray(points_m, float) @ self.rotation.T + self.translation_m

    def inverse(self) -> "RigidTransform":
        """Return the transform that undoes this one."""
        return RigidTransform(self.rotation.T, -self.rotation.T @ self.translation_m)

    def __matmul__(self, first: "RigidTransform") -> "RigidTransform":
        """Chain: ``a_from_c = a_from_b @ b_from_c``."""
        return RigidTransform(
            self.rotation @ first.rotation, self.rotation @ first.translation_m + self.translation_m
        )


IDENTITY = RigidTransform(np.eye(3), np.zeros(3))


def fit_rigid(
    points_to_m: FloatArray, points_from_m: FloatArray, weights: FloatArray | None = None
) -> RigidTransform:
    """Find the transform ``to_from`` that brings one set of points closest to another.

    Parameters
    ----------
    points_to_m, points_from_m : (N, 3) arrays
        The same points in two frames of reference, metres; pairs with a NaN are left out.
    weights : (N,) array, optional
        Not negative, such as the inverse variances; equal if left out.

    Returns
    -------
    to_from : RigidTransform
        Minimises ``sum weights * |points_to - to_from.apply(points_from)|^2`` over proper
        rotations: never a reflection.

    Raises
    ------
    ValueError
        Shapes differ, a weight is negative or not finite, or the points left (fewer than three,
        or all on one line) do not fix the rotation.
    """
    points_to_m, points_from_m = np.asarray(points_to_m, float), np.asarray(points_from_m, float)
    check_shape("points_to_m", points_to_m, (None, 3))
    check_shape("points_from_m", points_from_m, points_to_m.shape)
    share = np.ones(len(points_to_m)) if weights is None else np.asarray(weights, float)
    check_shape("weights", share, (len(points_to_m),))
    if not (np.isfinite(share).all() and (share >= 0).all()):
        raise ValueError("weights must be finite and not negative")
    kept = (share > 0) & ~np.isnan(points_to_m + points_from_m).any(axis=1)
    if not kept.any():
        raise ValueError("no pair of points is left to fit")
    share = share[kept] / share[kept].sum()
    mean_to, mean_from = share @ points_to_m[kept], share @ points_from_m[kept]
    moved_to, moved_from = points_to_m[kept] - mean_to, points_from_m[kept] - mean_from
    for moved in (moved_to, moved_from):
        spread = np.linalg.svd(moved * np.sqrt(share)[:, None], compute_uv=False)
        if len(spread) < 2 or not spread[1] > DEGENERATE_SHARE * spread[0]:  # noqa: PLR2004
            raise ValueError("points on one line, or fewer than three, do not fix a rotation")
    left, _, right = np.linalg.svd((moved_to * share[:, None]).T @ moved_from)
    sign = np.sign(np.linalg.det(left) * np.linalg.det(right))
    rotation = left @ np.diag([1.0, 1.0, sign]) @ right
    return RigidTransform(rotation, mean_to - rotation @ mean_from)


def rotation_from_vector(vector_rad: FloatArray) -> FloatArray:
    """Return the (3, 3) rotation about `vector_rad` (3,) by its length, right-handed.

    Source: Rodrigues' formula, R = I + sin(a) K + (1 - cos(a)) K^2.
    """
    vector_rad = np.asarray(vector_rad, float)
    check_shape("vector_rad", vector_rad, (3,))
    angle_rad = float(np.linalg.norm(vector_rad))
    x, y, z = vector_rad
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    # sinc is sin(pi x) / (pi x), and smooth at 0; 1 - cos(a) = 2 sin(a/2)^2.
    first = np.sinc(angle_rad / np.pi)
    second = 0.5 * np.sinc(angle_rad / (2.0 * np.pi)) ** 2
    rotation: FloatArray = np.eye(3) + first * cross + second * (cross @ cross)
    return rotation


def rotation_vector(rotation: FloatArray) -> FloatArray:
    """Return the (3,) axis times angle, 0 ... pi radians, of a (3, 3) rotation."""
    check_shape("rotation", rotation, (3, 3))
    odd = 0.5 * np.array(
        [
            rotation[2, 1] - rotation[1, 2],
            rotation[0, 2] - rotation[2, 0],
            rotation[1, 0] - rotation[0, 1],
        ]
    )
    sine, cosine = float(np.linalg.norm(odd)), (float(np.trace(rotation)) - 1.0) / 2.0
    angle_rad = np.arctan2(sine, cosine)
    if cosine > 0.0:
        scale = angle_rad / sine if sine > SMALLEST_ANGLE_RAD else 1.0
        return np.asarray(scale * odd)
    # Beyond a right angle the even part, cos I + (1 - cos) axis axis', shows the axis better.
    outer = (rotation + rotation.T) / 2.0 - cosine * np.eye(3)
    axis = outer[:, np.argmax(np.diag(outer))]
    axis = axis / np.linalg.norm(axis)
    return np.asarray(angle_rad * (axis if axis @ odd >= 0.0 else -axis))
