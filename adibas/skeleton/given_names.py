"""Names that points have already: what the others could be must agree with them."""

from collections.abc import Sequence

import numpy as np

from adibas.arrays import BoolArray, IntArray

OPEN = -1
"""Of a point whose name is to be found."""


def given_index(labels: Sequence[str], names: Sequence[str]) -> IntArray:
    """Return the (M,) indices in `names` of labels that stay, `OPEN` where there is none.

    Of a label that stands twice the second one tells nothing.
    """
    given = np.full(len(labels), OPEN)
    for point, label in enumerate(labels):
        if label in names:
            index = names.index(label)
            given[point] = OPEN if index in given else index
    return given


def nothing_given(n_points: int) -> IntArray:
    """Return the indices of points of which no name is known."""
    return np.full(n_points, OPEN)


def has_names(given: IntArray) -> bool:
    """Say whether the name of any point is given."""
    return bool((given != OPEN).any())


def agrees(partners: IntArray, given: IntArray) -> BoolArray:
    """Return (P,): which ways to name (P, N), each name's point, give the points what they have."""
    points = np.flatnonzero(given != OPEN)
    return np.asarray((partners[:, given[points]] == points).all(axis=1))
