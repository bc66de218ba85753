"""What the 3-D view shows; without Qt."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from adibas.arrays import FloatArray, UInt8Array


@dataclass(frozen=True, slots=True, eq=False)
class Space:
    """A surface and places on it, in axes as a camera's: right, down, away.

    Attributes
    ----------
    points_m : (N, 3) array
        Of the surface.
    colors_rgb : (N, 3) uint8 array
        Of the points.
    landmarks_m : mapping
        (3,) place of each landmark, by its name.
    rotation_deg : int
        How far the picture is turned clockwise to be upright.
    """

    points_m: FloatArray
    colors_rgb: UInt8Array
    landmarks_m: Mapping[str, FloatArray] = field(default_factory=dict)
    rotation_deg: int = 0
