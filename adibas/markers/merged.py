"""Two markers that overlap in the picture look like one, and its centre is nobody's.

However a disc is turned to the camera, its longer half axis is its radius: two discs that touch
make a spot more than twice as long as the others.
"""

from dataclasses import dataclass

import numpy as np

from adibas.arrays import BoolArray, FloatArray
from adibas.texts import message

MERGED = message("as long as two markers side by side")


@dataclass(frozen=True, slots=True)
class MergedParams:
    """When a spot is two markers.

    Attributes
    ----------
    least_length : float
        In lengths of the median marker: 1.35. Of 225 simulated stickers and LEDs the longest has
        1.21; two stickers of 4 pixels whose centres are 3 pixels apart have 1.38 to 1.55.
    greatest_axis_ratio : float
        Short over long axis; a larger marker beside small ones is as round as they are: 0.8.
    least_radius : float
        And its disc has this many times the median radius: 0, however small, since what stands
        still is long for no other reason.
    least_markers : int
        Fewer have no median worth the name: 4.
    """

    least_length: float = 1.35
    greatest_axis_ratio: float = 0.8
    least_radius: float = 0.0
    least_markers: int = 4


def are_merged(
    radii_m: FloatArray, axis_ratios: FloatArray, params: MergedParams | None = None
) -> BoolArray:
    """Say of each marker whether it is as long as two.

    Parameters
    ----------
    radii_m : (N,) array
        Of the disc with its area; NaN where its distance is not known.
    axis_ratios : (N,) array
        Short over long axis.
    """
    params = params or MergedParams()
    lengths_m = radii_m / np.sqrt(axis_ratios)
    known = lengths_m[np.isfinite(lengths_m)]
    if len(known) < params.least_markers:
        return np.zeros(len(radii_m), np.bool_)
    is_long = lengths_m > params.least_length * float(np.median(known))
    is_large = radii_m > params.least_radius * float(np.nanmedian(radii_m))
    found: BoolArray = is_long & is_large & (axis_ratios < params.greatest_axis_ratio)
    return found
