"""How long pieces of work take, in turn, so that what else a machine does meets all alike."""

import time
from collections.abc import Callable

import numpy as np

Work = Callable[[], object]


def spent_s(work: Work, clock: Callable[[], float] = time.process_time) -> float:
    """Do it once; return the seconds by the clock given."""
    begin = clock()
    work()
    return clock() - begin


def median_ms(work: Work, n_rounds: int, clock: Callable[[], float] = time.process_time) -> float:
    """Return the median time of one work after a first time."""
    return medians_ms([work], n_rounds, clock)[0]


def medians_ms(
    works: list[Work], n_rounds: int, clock: Callable[[], float] = time.process_time
) -> list[float]:
    """Run works in turn after a first time; return the median time of each."""
    spent: list[list[float]] = [[] for _ in works]
    for _ in range(n_rounds + 1):
        for work, times_s in zip(works, spent, strict=True):
            times_s.append(spent_s(work, clock))
    return [1e3 * float(np.median(times_s[1:])) for times_s in spent]
