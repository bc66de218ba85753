"""Turning, moving and scaling a set of points onto another.

Source: thesis, equation 6.14, whose matrix (cos, sin; -sin, cos) turns anticlockwise for who looks
at the image with v downwards; here a rotation is any proper one and ``scale * R p + t`` the map.
Umeyama, Least-squares estimation of transformation parameters between two point patterns, PAMI 13
(1991), for the fit.
"""

from dataclasses import dataclass

import numpy as np

from adibas.arrays import FloatArray, check_shape, read_only
from adibas.shapes.similarity_kernels import best_similarity


@dataclass(frozen=True, slots=True, eq=False)
class Similarity:
    """The map ``scale * rotation @ p + translation`` in two or three dimensions.

    Attributes
    ----------
    scale : float
        Positive.
    rotation : (D, D) array
        Orthonormal, determinant +1.
    translation : (D,) array
        In the unit of the target.
    """

    scale: float
    rotation: FloatArray
    translation: FloatArray

    def __post_init__(self) -> None:
        check_shape("rotation", self.rotation, (len(self.translation),) * 2)
        if not self.scale > 0:
            raise ValueError(f"scale must be positive, got {self.scale}")
        read_only(self.rotation)
        read_only(self.translation)

    def apply(self, points: FloatArray) -> FloatArray:
        """Map (..., D) points; NaN stays NaN."""
        return np.asarray(self.scale * (points @ self.rotation.T) + self.translation)

    def inverse(self) -> "Similarity":
        """Return the map back."""
        back = self.rotation.T / self.scale
        return Similarity(1.0 / self.scale, self.rotation.T.copy(), -back @ self.translation)


def fit_similarity(
    target: FloatArray,
    source: FloatArray,
    weights: FloatArray | None = None,
    *,
    has_scale: bool = True,
) -> Similarity | None:
    """Find the map that brings `source` closest to `target`.

    Parameters
    ----------
    target, source : (N, D) arrays
        The same points, D of 2 or 3; pairs with a NaN are left out.
    weights : (N,) array or None
        Not negative; equal if left out.
    has_scale : bool
        False: the scale stays 1.

    Returns
    -------
    target_from_source : Similarity or None
        Minimises ``sum weights |target - map(source)|^2`` over proper rotations; None where the
        points left do not fix it (fewer than D, or spread along less than D - 1 directions).
    """
    check_shape("source", source, target.shape)
    share = np.ones(len(target)) if weights is None else np.asarray(weights, float)
    is_kept = (share > 0) & ~np.isnan(target + source).any(axis=1)
    if np.count_nonzero(is_kept) < target.shape[1]:
        return None
    scale, rotation, translation = best_similarity(
        np.asarray(target, float),
        np.asarray(source, float),
        np.where(is_kept, share, 0.0),
        has_scale,
    )
    return Similarity(scale, rotation, translation) if scale > 0 else None
