"""Up to which cost a proposal is a report.

Source: thesis, equation 7.5; the false alarms that it does not see count, too.
"""

import numpy as np

from adibas.arrays import BoolArray, FloatArray, IntArray
from adibas.gestures.segments import Examples, Segment

RIGHT_OVERLAP = 0.5
BARELY = 1e-9


def best_threshold(costs: FloatArray, is_right: BoolArray, n_wanted: int) -> float:
    """Return the cost up to which most is found with fewest false alarms (F1 of all thresholds).

    In the middle to the next dearer one; the largest right cost and a tenth where all is right.
    """
    if not is_right.any():
        return float(costs.min()) * (1 - BARELY) if len(costs) else BARELY
    order = np.argsort(costs)
    best = int(np.argmax(f1_by_threshold(costs, is_right, n_wanted)))
    here = costs[order[best]]
    after = costs[order[best + 1]] if best + 1 < len(costs) else 1.1 * here
    return max(float(0.5 * (here + min(after, 1.1 * here))), BARELY)


def f1_by_threshold(costs: FloatArray, is_right: BoolArray, n_wanted: int) -> FloatArray:
    """Return the F1 of all that costs no more than each, the cheapest first."""
    hits = np.minimum(np.cumsum(is_right[np.argsort(costs)]), n_wanted)
    taken = np.arange(1, len(costs) + 1)
    return np.asarray(2.0 * hits / (taken + n_wanted))


def target(segment: Segment, examples: Examples) -> FloatArray:
    """Return (labels,): 1 for each gesture that is done in half of the segment's time."""
    found = np.zeros(len(examples.labels))
    for gesture in examples.in_stream(segment.stream):
        if segment.overlap(gesture) >= RIGHT_OVERLAP:
            found[gesture.label] = 1.0
    return found


def standard_error(share: FloatArray | float, n: IntArray | int) -> FloatArray:
    """Return the standard error of a share, or several, of `n`."""
    share = np.asarray(share, np.float64)
    return np.asarray(np.sqrt(share * (1.0 - share) / n))
