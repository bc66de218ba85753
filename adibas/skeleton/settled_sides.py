"""Left and right of a recording's first frames, once it is known which side is shown.

Live nobody can say better. In a recording the frames before can be told again: sides were kept
from frame to frame, so that where the whole person is exchanged in the frame in which the view
becomes sure, all frames before it are exchanged as well.
"""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from adibas.skeleton.following import ChosenJoints
from adibas.skeleton.proportions import MIRRORED
from adibas.skeleton.sides import SideParams, sideways

EVEN, LEAN = 0.5, 0.15
"""A frame whose probability lies so far on the other side saw another view: somebody turned."""


def settled(frames: Sequence[ChosenJoints], params: SideParams) -> list[ChosenJoints]:
    """Return the frames of one person with the sides of the first ones as they were known later.

    Parameters
    ----------
    frames : sequence of ChosenJoints
        In their order; axes of a camera that stands upright.
    params : SideParams
        From which odds on the view is sure.
    """
    fronts = np.array([one.front_probability for one in frames])
    first = next((k for k, front in enumerate(fronts) if params.is_sure(front)), 0)
    if first == 0:
        return list(frames)
    view = math.copysign(1.0, fronts[first] - EVEN)
    told = list(frames)
    is_exchanged = False
    for k in range(first - 1, -1, -1):
        if (fronts[k] - EVEN) * view < -LEAN:
            break
        shown = sideways(frames[k].joints_m, params.wide_share)
        if shown:
            is_exchanged = shown != view
        if is_exchanged:
            told[k] = _exchanged(frames[k])
    return told


def _exchanged(one: ChosenJoints) -> ChosenJoints:
    mirror = list(MIRRORED)
    return replace(one, joints_m=one.joints_m[mirror], confidence=one.confidence[mirror])
