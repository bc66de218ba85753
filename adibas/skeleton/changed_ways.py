"""Ways to name points that are one change away from a way.

A way is an (N,) array: of each name its point, -1 for none.
"""

import numpy as np

from adibas.arrays import IntArray

NO_POINT = -1


def one_change_away(way: IntArray, n_points: int) -> IntArray:
    """Return the (V, N) ways at one change from a way to name `n_points` points.

    A name loses its point, takes one that is free, or gives its own to a name that has none.
    """
    free = np.setdiff1d(np.arange(n_points), way).tolist()
    named = np.flatnonzero(way >= 0).tolist()
    hidden = np.flatnonzero(way < 0).tolist()
    changes = [{name: NO_POINT} for name in named]
    changes += [{name: point} for name in range(len(way)) for point in free]
    changes += [{name: NO_POINT, to: int(way[name])} for name in named for to in hidden]
    ways = np.tile(way, (len(changes), 1))
    for changed, change in zip(ways, changes, strict=True):
        changed[list(change)] = list(change.values())
    return ways


def not_listed(ways: IntArray, listed: IntArray) -> IntArray:
    """Return those of the (V, N) ways that are none of the (W, N) listed ones."""
    before = {way.tobytes() for way in np.ascontiguousarray(listed)}
    is_new = [way.tobytes() not in before for way in np.ascontiguousarray(ways)]
    return ways[np.array(is_new, np.bool_)]
