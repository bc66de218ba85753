"""Two or more codings cut into units of time, and into tables of who saw what."""

from collections.abc import Sequence

import numpy as np

from adibas.arrays import BoolArray, FloatArray, IntArray
from adibas.behaviour.budget import Span, merged
from adibas.data.coding import Coding


def unit_middles(within: Span, unit_ms: int) -> IntArray:
    """Return the middle of each whole unit, milliseconds.

    Raises
    ------
    ValueError
        A unit does not last.
    """
    if unit_ms <= 0:
        raise ValueError(f"a unit must last, got {unit_ms} ms")
    n_units = (within[1] - within[0]) // unit_ms
    return np.asarray(within[0] + unit_ms // 2 + unit_ms * np.arange(n_units), np.int64)


def lasting_at(coding: Coding, behaviour: str, subject: str, times_ms: IntArray) -> BoolArray:
    """Return (n,): whether a state lasts at each time; it begins at its first millisecond."""
    spans = merged((one.begin_ms, one.end_ms) for one in coding.of(behaviour, subject))
    begins = np.array([begin for begin, _ in spans], np.int64)
    ends = np.array([end for _, end in spans], np.int64)
    before = np.searchsorted(begins, times_ms, side="right") - 1
    lasts = np.zeros(len(times_ms), bool)
    if spans:
        lasts = (before >= 0) & (times_ms < ends[np.maximum(before, 0)])
    return np.asarray(lasts)


def presence_table(first: BoolArray, second: BoolArray) -> FloatArray:
    """Return (2, 2) counts: present, absent; rows the first observer, columns the second."""
    return np.array(
        [
            [(first & second).sum(), (first & ~second).sum()],
            [(~first & second).sum(), (~first & ~second).sum()],
        ],
        float,
    )


def combinations(columns: Sequence[BoolArray]) -> IntArray:
    """Return (n,): one number for each combination of what lasts; 0: nothing does.

    Parameters
    ----------
    columns : sequence of (n,) bool arrays
        One a behaviour, 60 at most.
    """
    numbers = np.zeros(len(columns[0]) if columns else 0, np.int64)
    for place, column in enumerate(columns):
        numbers |= column.astype(np.int64) << place
    return numbers


def combination_counts(observers: Sequence[IntArray]) -> tuple[FloatArray, IntArray]:
    """Return (n, k): how many observers saw each combination in each unit, and which those are."""
    kinds, places = np.unique(np.stack(observers), return_inverse=True)
    places = places.reshape(len(observers), -1)
    counts = np.zeros((places.shape[1], len(kinds)))
    for row in places:
        counts[np.arange(places.shape[1]), row] += 1
    return counts, np.asarray(kinds, np.int64)


def combination_table(first: IntArray, second: IntArray) -> tuple[FloatArray, IntArray]:
    """Return counts (k, k) of combinations and which those are; rows the first observer."""
    kinds, places = np.unique(np.concatenate([first, second]), return_inverse=True)
    rows, columns = places[: len(first)], places[len(first) :]
    table = np.zeros((len(kinds), len(kinds)))
    np.add.at(table, (rows, columns), 1)
    return table, np.asarray(kinds, np.int64)
