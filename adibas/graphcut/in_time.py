"""Frames that follow each other: the labels of the last one as costs in the next.

Whole stretches can be labelled at once by a mask of three dimensions (`connect_pixels`); live, the
past is decided, and a pair of which one label is known is a cost of the other.
"""

import numpy as np

from adibas.arrays import AnyArray, FloatArray, Int32Array, check_shape
from adibas.graphcut.energy import LabelEnergy

NO_LABEL = -1


def ties_in_time(depth_m: AnyArray, before_m: AnyArray) -> FloatArray:
    """Return how much each pixel shows what it showed one frame before, 0 to 1.

    Equation 6.23 for the two depths of a pixel, whose neighbour in time is at distance 1.

    Parameters
    ----------
    depth_m, before_m : (N,) arrays
        Of the same pixels now and one frame before; NaN where not measured, which ties nothing.
    """
    check_shape("before_m", before_m, depth_m.shape)
    squares = (np.asarray(depth_m, np.float64) - before_m) ** 2
    is_known = np.isfinite(squares)
    mean = squares[is_known].mean() if is_known.any() else 0.0
    falling = np.exp(-squares / (2.0 * mean)) if mean > 0.0 else np.ones_like(squares)
    return np.where(is_known, falling, 0.0)


def follow(energy: LabelEnergy, previous: AnyArray, weights: FloatArray) -> LabelEnergy:
    """Return the energy with the ties of each pixel to the frame before.

    Parameters
    ----------
    energy : LabelEnergy
        Of N pixels.
    previous : (N,) integer array
        Labels at the same pixels one frame before; -1 where there was none.
    weights : (N,) array
        Of each tie in units of the energy: a lambda times `ties_in_time`.
    """
    check_shape("previous", previous, (energy.graph.n_pixels,))
    check_shape("weights", weights, (energy.graph.n_pixels,))
    is_known = previous > NO_LABEL
    ties: Int32Array = np.where(is_known, np.rint(weights), 0).astype(np.int32)
    prices = energy.penalties[:, np.where(is_known, previous, 0)]
    costs = np.ascontiguousarray(energy.costs + prices * ties, dtype=np.int32)
    return LabelEnergy(energy.graph, costs, energy.weights, energy.penalties)
