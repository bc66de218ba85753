"""Whether the names of one frame, to which no view was told, show which way somebody faces.

Whose front and back look alike may still be known to be seen from one of both, and not aside.
"""

import math

import numpy as np

from adibas.data.joints import JOINT_NAMES, mirror_order, other_side
from adibas.skeleton.labelling import Labelling

LEAST_NAMES, LEAST_SIDED, SURE = 4, 2, 0.8
"""A frame with fewer names, fewer that are of a side, or one less sure tells no heading."""
LEAST_PAIRED, MOST_UNSURE = 8, 1
"""Of a frame that tells the axis so many points are what they are, or that of the other side."""

_SIDED = np.array([other_side(name) != name for name in JOINT_NAMES])
_MIRROR = mirror_order(JOINT_NAMES)


def tells_heading(labelling: Labelling) -> bool:
    """Say whether the heading of named joints is sure.

    Of 798 simulated pictures of markers that a camera sees 289 are, two of them wrongly
    (docs/skeleton.md).
    """
    named = [
        (name, confidence)
        for name, confidence in zip(labelling.names, labelling.confidences.tolist(), strict=True)
        if name is not None
    ]
    n_sided = sum(other_side(name) != name for name, _confidence in named)
    is_enough = len(named) >= LEAST_NAMES and n_sided >= LEAST_SIDED
    is_sure = all(confidence >= SURE for _name, confidence in named)
    return is_enough and is_sure and not math.isnan(labelling.heading_rad)


def tells_axis(labelling: Labelling) -> bool:
    """Say whether the heading of the 15 joints is sure but for half a turn.

    Left and right of a joint count as one name. Of the same pictures 425 are, two wrongly.
    """
    of_names = labelling.masses[:, :-1]
    of_pairs = np.where(_SIDED, of_names + of_names[:, _MIRROR], of_names)
    is_sure = of_pairs.max(axis=1, initial=0.0) >= SURE
    n_sided = np.count_nonzero(is_sure & _SIDED[of_pairs.argmax(axis=1)])
    n_unsure = np.count_nonzero(~is_sure & (labelling.masses[:, -1] < SURE))
    is_enough = np.count_nonzero(is_sure) >= LEAST_PAIRED and n_sided >= LEAST_SIDED
    is_known = not math.isnan(labelling.heading_rad)
    return bool(is_enough and n_unsure <= MOST_UNSURE and is_known)
