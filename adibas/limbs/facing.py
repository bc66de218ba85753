"""Front or back, by what sticks out: toes before the ankles, and the face before the trunk.

A forest that was trained on people from the front takes a back for a front and exchanges the
sides; its labels cannot tell. The shape can: toes point to where the person looks, and a head
leans forward, seen against the chest or against the back.
"""

from dataclasses import dataclass

import numpy as np

from adibas.arrays import FloatArray
from adibas.limbs.proposals import PartPoints

LOWEST_SHARE = 0.3
"""Of the lower leg, that is taken for the ankle."""


@dataclass(frozen=True, slots=True)
class FacingParams:
    """How much shapes tell; lengths from simulated people with true parts.

    Attributes
    ----------
    toes_middle_m, toes_spread_m : float
        Ankle behind the middle of the foot: 0.06 from the front and -0.02 from behind when
        standing; 0.01 is undecided, 0.04 from there tells all.
    head_middle_m, head_spread_m : float
        Head behind the trunk: -0.02 from the front, 0.08 from behind; 0.03 and 0.06.
    toes_weight, head_weight : float
        In one frame: 0.3 and 0.2, log odds.
    foot_area_m2 : float
        A foot of which less is seen tells less in proportion: 0.006. Of feet that real sensors
        lose in the floor, a few wrong pixels are left.
    """

    toes_middle_m: float = 0.01
    toes_spread_m: float = 0.04
    head_middle_m: float = 0.03
    head_spread_m: float = 0.06
    toes_weight: float = 0.3
    head_weight: float = 0.2
    foot_area_m2: float = 0.006


def front_evidence(points: PartPoints, params: FacingParams | None = None) -> float:
    """Return log odds of front against back in one frame; 0 where nothing tells."""
    params = params or FacingParams()
    middles_m = points.middles_m()
    total = 0.0
    for side in ("left", "right"):
        foot, leg = f"{side}_foot", f"{side}_lower_leg"
        if foot in middles_m and leg in middles_m:
            ahead_m = float(_lower_end_m(points.of(leg))[2] - middles_m[foot][2])
            told = float(np.clip((ahead_m - params.toes_middle_m) / params.toes_spread_m, -1, 1))
            whole = min(1.0, float(points.of(foot)[:, 3].sum()) / params.foot_area_m2)
            total += 0.5 * params.toes_weight * whole * told
    if "head" in middles_m and "torso" in middles_m:
        behind_m = float(middles_m["head"][2] - middles_m["torso"][2])
        told = (params.head_middle_m - behind_m) / params.head_spread_m
        total += params.head_weight * float(np.clip(told, -1.0, 1.0))
    return total


def _lower_end_m(points: FloatArray) -> FloatArray:
    """Return the middle of the lowest part of a leg's (m, 4) points; y points down."""
    lowest = points[:, 1] >= np.quantile(points[:, 1], 1.0 - LOWEST_SHARE)
    return np.asarray(points[lowest, :3].mean(axis=0))
