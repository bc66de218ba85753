"""What is known of points beside their places, when they are named by core and limbs."""

from dataclasses import dataclass

import numpy as np

from adibas.arrays import FloatArray, IntArray
from adibas.skeleton.seen_space import EVERYWHERE, SeenSpace


@dataclass(frozen=True, slots=True, eq=False)
class Known:
    """What is known of M points beside their places.

    Attributes
    ----------
    size_odds : (M,) array
        See `adibas.skeleton.sizes.size_log_odds`.
    given : (M,) int array
        See `adibas.skeleton.given_names.given_index`.
    seen : SeenSpace
        By the cameras, in the axes of the points.
    """

    size_odds: FloatArray
    given: IntArray
    seen: SeenSpace = EVERYWHERE

    def size_odds_of(self, partners: IntArray) -> FloatArray:
        """Return the (P,) log odds by size of (P, N) ways to name: each name's point, or -1."""
        return np.asarray(np.append(self.size_odds, 0.0)[partners].sum(axis=1))
