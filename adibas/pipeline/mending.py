"""Depth full of holes is mended before anybody is looked for in it, and that is said."""

import numpy as np

from adibas.arrays import Float32Array
from adibas.body.holes import fill_gaps, hole_share
from adibas.limbs.judging import Judgement, judge_holes

LEAST_SHARE = 0.1
"""Of the picture in holes; a good picture has 0.05 at most and stays as it is, to the last bit."""


def mended(depth_m: Float32Array) -> tuple[Float32Array, Judgement]:
    """Return the depth to look for people in, and what is to be said of its holes."""
    share = hole_share(np.asarray(np.isfinite(depth_m)))
    if share < LEAST_SHARE:
        return depth_m, Judgement(True, ())
    return fill_gaps(depth_m), judge_holes(share)
