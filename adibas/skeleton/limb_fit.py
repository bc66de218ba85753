"""Arms and legs of known size laid into the surface of their parts."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from adibas.arrays import FloatArray
from adibas.data.joints import BODY_PART_NAMES, JOINT_NAMES
from adibas.data.part_cloud import PartCloud
from adibas.skeleton.limb_fit_kernels import fit_limbs_from
from adibas.skeleton.limb_start_kernels import limb_points, limb_starts, limb_support

LIMBS: tuple[tuple[tuple[str, ...], tuple[str, ...]], ...] = tuple(
    (tuple(f"{side}_{joint}" for joint in joints), tuple(f"{side}_{part}" for part in parts))
    for side in ("left", "right")
    for joints, parts in (
        (("shoulder", "elbow", "hand"), ("upper_arm", "lower_arm", "hand")),
        (("hip", "knee", "foot"), ("upper_leg", "lower_leg", "foot")),
    )
)
"""Joints of each limb from its root on, and its parts."""


@dataclass(frozen=True, slots=True)
class LimbFitParams:
    """How limbs are laid into their surface.

    Attributes
    ----------
    arm_radius_m, leg_radius_m : float
        How far bones lie behind the surface: 0.03 and 0.055.
    width_m : float
        Of a limb's surface about its bone, standard deviation: 0.04.
    least_part : float
        Share of a point that either bone has, whatever the forest says: 0.3.
    shoulder_pull, hip_pull, middle_pull, end_pull : float
        Weight of a proposed place against a point of the surface of the limb's mean weight, in
        points: 100, 60, 3 and 5.
    length_weight : float
        Of a bone's length, in points: 400.
    least_limb : float
        Squares count in which the limb has more than this share of all parts: 0.02.
    least_points : int
        Squares of surface from which on a limb is laid: 12.
    reach_m : float
        A joint is seen where surface lies so near to it: 0.14.
    least_near : float
        Of the limb's points that must lie there: 0.02.
    least_own : float
        Of the limb's points that must lie at the lower bone and be its own: 0.05.
    bare_reach_m, bare_share : float
        A joint that nothing was proposed for is seen only where surface so near (0.1) has more
        than this share (0.3) of the limb: knees behind a table were laid where no leg was seen.
    """

    arm_radius_m: float = 0.03
    leg_radius_m: float = 0.055
    width_m: float = 0.04
    least_part: float = 0.3
    shoulder_pull: float = 100.0
    hip_pull: float = 60.0
    middle_pull: float = 3.0
    end_pull: float = 5.0
    length_weight: float = 400.0
    least_limb: float = 0.02
    least_points: int = 12
    reach_m: float = 0.14
    least_near: float = 0.02
    least_own: float = 0.05
    bare_reach_m: float = 0.1
    bare_share: float = 0.3


def fit_limbs(
    cloud: PartCloud,
    joints_m: FloatArray,
    latest_m: FloatArray,
    lengths_m: FloatArray,
    params: LimbFitParams | None = None,
) -> FloatArray:
    """Return (15, 3) joints; those of arms and legs laid into their surface.

    Parameters
    ----------
    joints_m : (15, 3) array
        As they were chosen; NaN where not seen.
    latest_m : (15, 3) array
        A moment ago; NaN where not known: another start.
    lengths_m : (15,) array
        Of the bone that ends at each joint.
    """
    params = params or LimbFitParams()
    fitted_m, of_all = joints_m.copy(), cloud.weights_m2.sum(axis=1)
    for names, parts in LIMBS:
        at = [JOINT_NAMES.index(name) for name in names]
        columns = [BODY_PART_NAMES.index(part) for part in parts]
        surface = _LimbSurface(cloud.points_m, cloud.weights_m2[:, columns], of_all)
        is_leg = columns[0] in _LEGS
        fitted_m[at] = _fitted(surface, is_leg, joints_m[at], latest_m[at], lengths_m[at], params)
    return fitted_m


class _LimbSurface(NamedTuple):
    """(N, 3) points of a person, (N, 3) weights of a limb's parts, and (N,) of all parts."""

    points_m: FloatArray
    weights_m2: FloatArray
    of_all_m2: FloatArray


def _fitted(
    surface: _LimbSurface,
    is_leg: bool,
    joints_m: FloatArray,
    latest_m: FloatArray,
    lengths_m: FloatArray,
    params: LimbFitParams,
) -> FloatArray:
    weights = surface.weights_m2
    total = weights.sum(axis=1)
    used = total > params.least_limb * surface.of_all_m2
    if used.sum() < params.least_points or not np.isfinite(joints_m[0, 0]):
        return joints_m
    radius_m = params.leg_radius_m if is_leg else params.arm_radius_m
    own = total[used]
    points, both = limb_points(surface.points_m[used], weights[used], own, own.mean(), radius_m)
    pulls = np.zeros((3, 4))
    root_pull = params.hip_pull if is_leg else params.shoulder_pull
    for joint, pull in enumerate((root_pull, params.middle_pull, params.end_pull)):
        if np.isfinite(joints_m[joint, 0]):
            pulls[joint] = (*joints_m[joint], pull)
    sizes = np.array(
        [lengths_m[1], lengths_m[2], params.length_weight, params.width_m, params.least_part]
    )
    starts_m = limb_starts(points, joints_m, latest_m, lengths_m[1:])
    costs = fit_limbs_from(points, both, starts_m, pulls, sizes)
    known = np.where(np.isfinite(costs), costs, np.inf)
    best_m = starts_m[int(known.argmin())] if np.isfinite(known).any() else joints_m
    seen_m = _seen_only(points, both, best_m, params)
    is_bare = ~np.isfinite(joints_m[:, 0])
    if is_bare.any():
        own_m = surface.points_m[total > params.bare_share * surface.of_all_m2]
        gaps_m = np.linalg.norm(own_m[:, None] - seen_m[is_bare], axis=2)
        is_near = (gaps_m < params.bare_reach_m).any(axis=0)
        seen_m[is_bare] = np.where(is_near[:, None], seen_m[is_bare], np.nan)
    return seen_m


_LEGS = [k for k, name in enumerate(BODY_PART_NAMES) if name.endswith("upper_leg")]


def _seen_only(
    points: FloatArray, shares: FloatArray, joints_m: FloatArray, params: LimbFitParams
) -> FloatArray:
    """Return the joints with NaN where no surface of the limb is near; the root has its own.

    The end must have surface that the upper bone does not explain, by place or by its part.
    """
    seen_m, all_points = joints_m.copy(), points[:, 3].sum()
    at_middle, at_end, of_end = limb_support(
        points, shares, joints_m, params.reach_m, 1.5 * params.width_m
    )
    if at_middle < params.least_near * all_points:
        seen_m[1] = np.nan
    if at_end < params.least_near * all_points or of_end < params.least_own * all_points:
        seen_m[2] = np.nan
    return seen_m
