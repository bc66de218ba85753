"""Frames that follow each other: the labels of the last one as costs in the next.

Whole stretches can be labelled at once by a mask of three dimensions (`connect_pixels`); live, the
past is decided, and a pair of which one label is known is a cost of the other.
"""

import numpy as np

from adibas.arrays import AnyArray, FloatArray, Int32Array, check_shape
from adibas.graphcut.energy import LabelEnergy

NO_LABEL = -1


def follow(energy: LabelEnergy, previous: AnyArray, weights: FloatArray) -> LabelEnergy:
    """Return the energy with the ties of each pixel to the frame before.

    Parameters
    ----------
    energy : LabelEnergy
        Of N pixels.
    previous : (N,) integer array
        Labels at the same pixels one frame before; -1 where there was none.
    weights : (N,) array
        Of each tie in units of the energy: lambda times equation 6.23 of the two depths, say.
    """
    check_shape("previous", previous, (energy.graph.n_pixels,))
    check_shape("weights", weights, (energy.graph.n_pixels,))
    is_known = previous > NO_LABEL
    ties: Int32Array = np.where(is_known, np.rint(weights), 0).astype(np.int32)
    prices = energy.penalties[:, np.where(is_known, previous, 0)]
    costs = np.ascontiguousarray(energy.costs + prices * ties, dtype=np.int32)
    return LabelEnergy(energy.graph, costs, energy.weights, energy.penalties)
