"""Two namers are asked where one is in doubt: their probabilities are multiplied.

Source: Hinton, Training products of experts by minimizing contrastive divergence, Neural
Computation 14 (2002), for the product; the weights were chosen on simulated people of their own.
"""

from functools import cache

import numpy as np

from adibas.arrays import FloatArray, IntArray, read_only
from adibas.data.joints import mirror_order
from adibas.shapes.assignment_kernels import assign
from adibas.skeleton.labelling import Labelling

DOUBT = 0.97
"""A point of which no name has this share is in doubt."""
FIRST_WEIGHT, SECOND_WEIGHT = 0.8, 0.2
LEAST_MASS = 1e-3
"""Neither is ever surer than this."""


def is_in_doubt(labelling: Labelling) -> bool:
    """Say whether of any point it is not sure what it is."""
    return bool(len(labelling.masses)) and bool(labelling.masses.max(axis=1).min() < DOUBT)


def combined(
    first: Labelling, second: Labelling, names: tuple[str, ...], sure: float, side_sure: float
) -> Labelling:
    """Return what both say together; the heading is the first one's.

    Parameters
    ----------
    sure, side_sure : float
        See `PartsOdds`.
    """
    both = np.maximum(first.masses, LEAST_MASS) ** FIRST_WEIGHT
    both = both * np.maximum(second.masses, LEAST_MASS) ** SECOND_WEIGHT
    masses = both / both.sum(axis=1, keepdims=True)
    return named_by(masses, names, first.heading_rad, sure, side_sure)


def named_by(
    masses: FloatArray, names: tuple[str, ...], heading_rad: float, sure: float, side_sure: float
) -> Labelling:
    """Return the most probable names of M points, none given twice.

    Parameters
    ----------
    masses : (M, N + 1) array
        See `Labelling`.
    sure, side_sure : float
        See `PartsOdds`.
    """
    logs = np.log(np.maximum(masses, np.finfo(float).tiny))
    chosen = assign(np.ascontiguousarray(logs[:, -1:] - logs[:, :-1]))
    index = np.where(chosen < 0, len(names), chosen)
    given, guesses, confidences = names_of(index, masses, names, sure, side_sure)
    return Labelling(given, guesses, confidences, heading_rad, masses)


def names_of(
    index: IntArray, masses: FloatArray, names: tuple[str, ...], sure: float, side_sure: float
) -> tuple[tuple[str | None, ...], tuple[str | None, ...], FloatArray]:
    """Return the names that are sure enough, the guesses, and how sure each is.

    Parameters
    ----------
    index : (M,) int array
        Of each point's name, N for none.
    masses : (M, N + 1) array
    """
    n_names = len(names)
    rows = np.arange(len(index))
    confidences = masses[rows, index]
    other = _mirrored(names)[index]
    of_other = np.where(other == index, 0.0, masses[rows, other])
    guesses = tuple(None if i == n_names else names[i] for i in index)
    is_sure = (confidences >= sure) & (of_other <= side_sure)
    given = tuple(guess if yes else None for guess, yes in zip(guesses, is_sure, strict=True))
    return given, guesses, confidences


@cache
def _mirrored(names: tuple[str, ...]) -> IntArray:
    """Return of each name, and of no name, which one is its mirror image."""
    mirrored = np.array([*mirror_order(names), len(names)])
    read_only(mirrored)
    return mirrored
