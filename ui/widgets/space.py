"""What the 3-D view shows; without Qt."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from adibas.arrays import FloatArray
from adibas.data.discs import Discs


def _no_path() -> FloatArray:
    return np.zeros((0, 3))


@dataclass(frozen=True, slots=True, eq=False)
class Space:
    """A surface and places on it, in axes as a camera's: right, down, away.

    Attributes
    ----------
    discs : Discs
        Of the surface.
    landmarks_m : mapping
        (3,) place of each landmark, by its name.
    path_m : (P, 3) array
        Where the camera went.
    rotation_deg : int
        How far the picture is turned clockwise to be upright.
    """

    discs: Discs
    landmarks_m: Mapping[str, FloatArray] = field(default_factory=dict)
    path_m: FloatArray = field(default_factory=_no_path)
    rotation_deg: int = 0
