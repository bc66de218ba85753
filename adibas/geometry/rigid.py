"""Rotations and translations: ``points_color = color_from_depth.apply(points_depth)``.

Source: thesis, equation 3.1 (read as ``R p + t``, OpenCV's sign of t).
"""

from dataclasses import dataclass

import numpy as np

from adibas.arrays import FloatArray, check_shape, read_only

ORTHONORMAL_TOLERANCE = 1e-6


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
