"""Which joints tell gestures apart.

Source: thesis, table 7.2, with its two names put right: the mean off the diagonal is the
variability between gestures, the mean of the diagonal that within one.
"""

from collections.abc import Sequence

import numpy as np

from adibas.arrays import FloatArray, IntArray
from adibas.gestures.descriptor import DESCRIBED_JOINTS
from adibas.timeseries.dtw import pairwise_costs

N_JOINTS = len(DESCRIBED_JOINTS)


def joint_weights(segments: Sequence[FloatArray], labels: IntArray) -> FloatArray:
    """Return (14,) weights with the sum 1; all alike where no joint tells anything.

    Parameters
    ----------
    segments : sequence of (n, d) arrays
        Descriptors, two of a gesture at least.
    labels : (k,) integer array
    """
    raw = np.array(
        [_weight(pairwise_costs(_joint(segments, joint)), labels) for joint in range(N_JOINTS)]
    )
    total = raw.sum()
    return raw / total if total > 0 else np.full(N_JOINTS, 1.0 / N_JOINTS)


def spread(weights: FloatArray, n_numbers: int) -> FloatArray:
    """Return the factor of each number of a descriptor: x, y, z of positions, then velocities."""
    return np.tile(np.repeat(weights, 3), n_numbers // (3 * N_JOINTS))


def _joint(segments: Sequence[FloatArray], joint: int) -> list[FloatArray]:
    columns = np.arange(3 * joint, 3 * joint + 3)
    if segments[0].shape[1] > 3 * N_JOINTS:
        columns = np.concatenate([columns, 3 * N_JOINTS + columns])
    return [np.ascontiguousarray(segment[:, columns]) for segment in segments]


def _weight(costs: FloatArray, labels: IntArray) -> float:
    """Return max(0, (inter - intra) / inter) of one joint; 0 where nothing can be said."""
    np.fill_diagonal(costs, np.nan)  # nobody is an example beside himself
    costs[np.isinf(costs)] = np.nan
    names = np.unique(labels)
    mean = np.array(
        [[_mean(costs[np.ix_(labels == a, labels == b)]) for b in names] for a in names]
    )
    intra = _mean(np.diag(mean))
    inter = _mean(mean[~np.eye(len(names), dtype=bool)])
    return max(0.0, (inter - intra) / inter) if inter > 0 and np.isfinite(intra) else 0.0


def _mean(values: FloatArray) -> float:
    known = values[np.isfinite(values)]
    return float(known.mean()) if known.size else float("nan")
