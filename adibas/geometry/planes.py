"""Planes, and the floor among them."""

from dataclasses import dataclass

import numpy as np

from adibas.arrays import FloatArray, check_shape, read_only


@dataclass(frozen=True, slots=True, eq=False)
class Plane:
    """Points p with ``normal . p + offset_m = 0``; the sum is the signed distance from it.

    Attributes
    ----------
    normal : (3,) array
        Unit length; of a floor it points up, so that the signed distance is the height.
    offset_m : float
        Signed distance of the origin, metres; of a floor the camera's height above it.
    """

    normal: FloatArray
    offset_m: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "normal", np.array(self.normal, float))
        check_shape("normal", self.normal, (3,))
        if not abs(np.linalg.norm(self.normal) - 1.0) < 1e-6:  # noqa: PLR2004  (rounding)
            raise ValueError(f"normal must have length 1, got {np.linalg.norm(self.normal)}")
        read_only(self.normal)

    def signed_distance_m(self, points_m: FloatArray) -> FloatArray:
        """Return the (...) signed distances of (..., 3) points, metres; NaN stays NaN."""
        distances: FloatArray = np.asarray(points_m, float) @ self.normal + self.offset_m
        return distances
