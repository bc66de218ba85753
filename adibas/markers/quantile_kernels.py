"""Quantiles of a few values, in compiled loops."""

import math

from adibas.arrays import FloatArray
from adibas.kernels import compiled


@compiled
def quantile(values: FloatArray, share: float) -> float:
    """Return the quantile, linear between two values; reorders `values`. NaN of nothing.

    Source: Hoare, Algorithm 65: Find, CACM 1961.
    """
    if len(values) == 0:
        return math.nan
    place = share * (len(values) - 1)
    k = int(place)
    low, high = 0, len(values) - 1
    while low < high:
        pivot, i, j = values[k], low, high
        while i <= j:
            while values[i] < pivot:
                i += 1
            while pivot < values[j]:
                j -= 1
            if i <= j:
                values[i], values[j] = values[j], values[i]
                i, j = i + 1, j - 1
        low = i if j < k else low
        high = j if k < i else high
    above = values[k + 1 :].min() if place > k else values[k]
    return float(values[k] + (place - k) * (above - values[k]))
