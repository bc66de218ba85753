"""The corners between which the body model interpolates, and their weights."""

from functools import reduce

import numpy as np

from adibas.arrays import FloatArray

PHENOTYPE_GRID = {
    "gender": (0.0, 1.0),
    "age": (0.0, 1 / 3, 2 / 3, 1.0),
    "muscle": (0.0, 0.5, 1.0),
    "weight": (0.0, 0.5, 1.0),
    "height": (0.0, 1.0),
    "proportions": (0.0, 1.0),
}
"""anny's anchors: gender 0 is male; age 0 a baby, 1/3 a child, 2/3 young, 1 old."""

_AGES_YEARS = (1.0, 10.0, 25.0, 90.0)
"""What MakeHuman means by baby, child, young and old."""


def anny_age(age_years: float) -> float:
    """Return anny's age (0 to 1) of a person of `age_years`, 1 to 90."""
    return float(np.interp(age_years, _AGES_YEARS, PHENOTYPE_GRID["age"]))


def corner_weights(phenotype: FloatArray) -> FloatArray:
    """Return the weight of each grid corner for one person: linear in each parameter.

    Parameters
    ----------
    phenotype : (6,) array
        In the order of `PHENOTYPE_GRID`, clipped to 0 ... 1.
    """
    anchors = PHENOTYPE_GRID.values()
    hats = [_hats(value, np.array(at)) for value, at in zip(phenotype, anchors, strict=True)]
    return reduce(lambda left, right: np.outer(left, right).ravel(), hats)


def _hats(value: float, anchors: FloatArray) -> FloatArray:
    value = min(max(value, anchors[0]), anchors[-1])
    above = min(int(np.searchsorted(anchors, value, side="right")), len(anchors) - 1)
    share = (value - anchors[above - 1]) / (anchors[above] - anchors[above - 1])
    weights = np.zeros(len(anchors))
    weights[above - 1], weights[above] = 1 - share, share
    return weights
