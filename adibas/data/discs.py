"""A surface as coloured discs, to be looked at from any side."""

import math
from dataclasses import dataclass

import numpy as np

from adibas.arrays import Float32Array, UInt8Array, check_shape, read_only

HALF_DIAGONAL = 0.71
"""Of a square of side 1: discs of that radius leave no gap."""
LEAST_FACING = 0.3
"""A disc is not made larger than that of a surface seen so (cosine of the slant)."""


@dataclass(frozen=True, slots=True, eq=False)
class Discs:
    """Discs that lie in a surface and cover it; all arrays have N rows.

    Attributes
    ----------
    points_m : (N, 3) float32 array
        Their middles.
    normals : (N, 3) float32 array
        Unit length, towards where the surface was seen from; NaN where that is unknown.
    radii_m : (N,) float32 array
    colors_rgb : (N, 3) uint8 array
    """

    points_m: Float32Array
    normals: Float32Array
    radii_m: Float32Array
    colors_rgb: UInt8Array

    def __post_init__(self) -> None:
        for name in ("points_m", "normals", "colors_rgb"):
            check_shape(name, getattr(self, name), (len(self.points_m), 3))
        check_shape("radii_m", self.radii_m, (len(self.points_m),))
        for array in (self.points_m, self.normals, self.radii_m, self.colors_rgb):
            read_only(array)

    def __len__(self) -> int:
        """Return the number of discs."""
        return len(self.points_m)

    def at_most(self, most: int) -> "Discs":
        """Return evenly chosen discs, `most` at most, so much larger that they cover as much."""
        step = max(1, math.ceil(len(self) / most))
        if step == 1:
            return self
        return Discs(
            self.points_m[::step].copy(),
            self.normals[::step].copy(),
            self.radii_m[::step] * np.float32(math.sqrt(step)),
            self.colors_rgb[::step].copy(),
        )
