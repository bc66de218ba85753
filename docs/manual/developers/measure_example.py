"""A new kind of measure: one length as a share of another, such as leg to trunk."""

import numpy as np

from adibas.arrays import FloatArray
from adibas.data.protocols import KindRule
from adibas.measures.kind_values import Directions

RULE = KindRule("share", 4, has_axis=False)
"""Four points, in per cent, without a sign: for `KINDS` in adibas/data/protocols.py."""


def distance_share(points_m: FloatArray, _directions: Directions) -> FloatArray:
    """Return |b - a| as a share of |d - c|, of (..., 4, 3) points; NaN where c and d coincide."""
    first = np.linalg.norm(points_m[..., 1, :] - points_m[..., 0, :], axis=-1)
    whole = np.linalg.norm(points_m[..., 3, :] - points_m[..., 2, :], axis=-1)
    return np.asarray(first / np.where(whole > 0, whole, np.nan))
