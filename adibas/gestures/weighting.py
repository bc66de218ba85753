"""Which joints tell gestures apart.

Source: thesis, table 7.2, with its two names put right: the mean off the diagonal is the
variability between gestures, the mean of the diagonal that within one.
"""

from collections.abc import Sequence

import numpy as np

from adibas.arrays import FloatArray, IntArray
from adibas.gestures.descriptor import DESCRIBED_JOINTS
from adibas.gestures.segments import Examples, Segment, at_one_length
from adibas.timeseries.dtw import cross_costs, pairwise_costs

N_JOINTS = len(DESCRIBED_JOINTS)
MOST_COMPARED = 40
"""Pieces on each side when one gesture is held against everything else: costs grow with the
product."""
NEAREST_SHARE = 1 / 3
SHARE = 0.25
"""Of the weights of table 7.2, and of those of the gesture; the rest is equal for all joints. Told
by few people, weights of joints are too sure. Chosen on simulated actors of seeds 5201 and 5202."""


def cautious_weights(examples: Examples, chosen: IntArray) -> FloatArray:
    """Return (labels, 14) weights for the alignment, the sum of each row 1.

    Those that tell all gestures apart, those that tell each from everything else, and equal ones.

    Parameters
    ----------
    examples : Examples
    chosen : (k,) integer array
        Which of them are held against each other.
    """
    some = [examples.gestures[int(index)] for index in chosen]
    labels = np.array([one.label for one in some], np.int64)
    common = joint_weights([at_one_length(examples.frames_of(one)) for one in some], labels)
    return (1.0 - 2.0 * SHARE) / N_JOINTS + SHARE * (common + weights_of_gestures(examples))


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


def weights_of_gestures(examples: Examples) -> FloatArray:
    """Return (labels, 14) weights of the joints that tell each gesture from everything else.

    As `joint_weights`, with all that is not the gesture in place of the other gestures: the other
    gestures, and pieces of its length of the streams in which none is marked. Of those the third
    that is most like the gesture: in a bend every joint is elsewhere, and that alone would make
    every joint tell a wave. Each row has the sum 1; all alike where no joint tells anything, where
    there is nothing else, or where there is no example: who alone shows a gesture may be left out.
    """
    raw = np.array([_own_weights(examples, label) for label in range(len(examples.labels))])
    total = raw.sum(axis=1, keepdims=True)
    alike = np.full(N_JOINTS, 1.0 / N_JOINTS)
    return np.where(total > 0, raw / np.where(total > 0, total, 1.0), alike)


def _own_weights(examples: Examples, label: int) -> FloatArray:
    """Return (14,) weights of one gesture before they are made to sum to 1; 0 where none tells."""
    own = [one for one in examples.gestures if one.label == label]
    if not own:
        return np.zeros(N_JOINTS)
    others = [one for one in examples.gestures if one.label != label]
    others += _unmarked(examples, int(np.median([one.end - one.begin + 1 for one in own])))
    pieces = [_some(examples, part) for part in (own, others)]
    return _told_apart(*pieces) if others else np.zeros(N_JOINTS)


def _unmarked(examples: Examples, n_frames: int) -> list[Segment]:
    """Return pieces of `n_frames`, one after the other, in which no gesture is marked.

    Of streams with examples: in others they may be done without being marked.
    """
    found = []
    for stream in sorted({gesture.stream for gesture in examples.gestures}):
        marked = examples.marked(stream)
        found += [
            Segment(stream, -1, begin, begin + n_frames - 1)
            for begin in range(0, len(marked) - n_frames + 1, n_frames)
            if not marked[begin : begin + n_frames].any()
        ]
    return found


def _some(examples: Examples, segments: Sequence[Segment]) -> list[FloatArray]:
    """Return as many as are compared, evenly chosen, at one length."""
    n_chosen = min(len(segments), MOST_COMPARED)
    places = np.linspace(0, len(segments) - 1, n_chosen).astype(np.int64)
    return [at_one_length(examples.frames_of(segments[place])) for place in places]


def _told_apart(own: Sequence[FloatArray], others: Sequence[FloatArray]) -> FloatArray:
    """Return (14,): max(0, (inter - intra) / inter) of each joint."""
    weights = np.zeros(N_JOINTS)
    likeness = np.ma.masked_invalid(cross_costs(own, others)).mean(axis=0).filled(np.inf)
    near = np.argsort(likeness)[: max(round(NEAREST_SHARE * len(others)), 1)]
    for joint in range(N_JOINTS):
        mine, theirs = _joint(own, joint), _joint([others[place] for place in near], joint)
        within = pairwise_costs(mine)
        np.fill_diagonal(within, np.nan)
        intra, inter = _mean(within), _mean(cross_costs(mine, theirs))
        if inter > 0 and np.isfinite(intra):
            weights[joint] = max(0.0, (inter - intra) / inter)
    return weights


def spread(weights: FloatArray, n_numbers: int) -> FloatArray:
    """Return the factors (labels, n_numbers) of each number of a descriptor.

    x, y, z of positions, then of velocities.
    """
    return np.tile(np.repeat(weights, 3, axis=1), (1, n_numbers // (3 * N_JOINTS)))


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
