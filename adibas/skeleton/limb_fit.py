"""Arms and legs of known size laid into the surface of their parts."""

from dataclasses import dataclass

import numpy as np

from adibas.arrays import FloatArray
from adibas.data.joints import BODY_PART_NAMES, JOINT_NAMES
from adibas.data.part_cloud import PartCloud
from adibas.skeleton.limb_fit_kernels import fit_limbs_from

LIMBS: tuple[tuple[tuple[str, ...], tuple[str, ...]], ...] = tuple(
    (tuple(f"{side}_{joint}" for joint in joints), tuple(f"{side}_{part}" for part in parts))
    for side in ("left", "right")
    for joints, parts in (
        (("shoulder", "elbow", "hand"), ("upper_arm", "lower_arm", "hand")),
        (("hip", "knee", "foot"), ("upper_leg", "lower_leg", "foot")),
    )
)
"""Joints of each limb from its root on, and its parts."""

N_MIDDLES, MIDDLE_BAND, END_BAND = 4, 0.15, 0.3
"""Elbows or knees that are tried as starts, and how well lengths must fit for that."""


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
    fitted_m = joints_m.copy()
    for names, parts in LIMBS:
        at = [JOINT_NAMES.index(name) for name in names]
        columns = [BODY_PART_NAMES.index(part) for part in parts]
        fitted_m[at] = _fitted(cloud, columns, joints_m[at], latest_m[at], lengths_m[at], params)
    return fitted_m


def _fitted(
    cloud: PartCloud,
    columns: list[int],
    joints_m: FloatArray,
    latest_m: FloatArray,
    lengths_m: FloatArray,
    params: LimbFitParams,
) -> FloatArray:
    weights = cloud.weights_m2[:, columns]
    total = weights.sum(axis=1)
    used = total > params.least_limb * cloud.weights_m2.sum(axis=1)
    if used.sum() < params.least_points or not np.isfinite(joints_m[0, 0]):
        return joints_m
    is_leg = columns[0] in _LEGS
    radius_m = params.leg_radius_m if is_leg else params.arm_radius_m
    places_m = cloud.points_m[used]
    places_m = places_m * (1.0 + radius_m / np.linalg.norm(places_m, axis=1, keepdims=True))
    weight = total[used] / total[used].mean()
    points = np.ascontiguousarray(np.column_stack([places_m, weight]))
    shares = weights[used] / total[used, None]
    both = np.ascontiguousarray(np.column_stack([shares[:, 0], shares[:, 1] + shares[:, 2]]))
    pulls = np.zeros((3, 4))
    root_pull = params.hip_pull if is_leg else params.shoulder_pull
    for joint, pull in enumerate((root_pull, params.middle_pull, params.end_pull)):
        if np.isfinite(joints_m[joint, 0]):
            pulls[joint] = (*joints_m[joint], pull)
    sizes = np.array(
        [lengths_m[1], lengths_m[2], params.length_weight, params.width_m, params.least_part]
    )
    starts_m = _starts(points, joints_m, latest_m, lengths_m)
    costs = fit_limbs_from(points, both, starts_m, pulls, sizes)
    known = np.where(np.isfinite(costs), costs, np.inf)
    best_m = starts_m[int(known.argmin())] if np.isfinite(known).any() else joints_m
    seen_m = _seen_only(points, both, best_m, params)
    is_bare = ~np.isfinite(joints_m[:, 0])
    own_m = cloud.points_m[total > params.bare_share * cloud.weights_m2.sum(axis=1)]
    gaps_m = np.linalg.norm(own_m[:, None] - seen_m[is_bare], axis=2)
    seen_m[is_bare] = np.where(
        (gaps_m < params.bare_reach_m).any(axis=0)[:, None], seen_m[is_bare], np.nan
    )
    return seen_m


_LEGS = [k for k, name in enumerate(BODY_PART_NAMES) if name.endswith("upper_leg")]


def _starts(
    points: FloatArray, joints_m: FloatArray, latest_m: FloatArray, lengths_m: FloatArray
) -> FloatArray:
    """Return (S, 3, 3) starts: as chosen, a moment ago, stretched to the farthest point, bent."""
    root_m = joints_m[0]
    away_m = points[:, :3] - root_m
    far_m = np.linalg.norm(away_m, axis=1)
    end_m = points[far_m >= np.quantile(far_m, 0.95), :3].mean(axis=0)
    way = (end_m - root_m) / max(float(np.linalg.norm(end_m - root_m)), 1e-6)
    straight_m = np.stack(
        [root_m, root_m + lengths_m[1] * way, root_m + (lengths_m[1] + lengths_m[2]) * way]
    )
    known = [one_m for one_m in (joints_m, latest_m) if np.isfinite(one_m[1:]).any()]
    starts = [straight_m, *(np.where(np.isfinite(one_m), one_m, straight_m) for one_m in known)]
    near_length = np.abs(far_m - lengths_m[1]) < MIDDLE_BAND * lengths_m[1]
    for middle_m in _spread_out(points[near_length, :3]):
        gap = np.linalg.norm(points[:, :3] - middle_m, axis=1) - lengths_m[2]
        ends_m = points[np.abs(gap) < END_BAND * lengths_m[2], :3]
        if len(ends_m):
            beside_m = np.linalg.norm(ends_m - 0.5 * (root_m + middle_m), axis=1)
            starts.append(np.stack([root_m, middle_m, ends_m[beside_m.argmax()]]))
    return np.stack(starts)


def _spread_out(points_m: FloatArray) -> FloatArray:
    """Return up to `N_MIDDLES` of the points, each as far as can be from those before."""
    if not len(points_m):
        return points_m
    chosen = [0]
    gap_m = np.linalg.norm(points_m - points_m[0], axis=1)
    while len(chosen) < min(N_MIDDLES, len(points_m)):
        chosen.append(int(gap_m.argmax()))
        gap_m = np.minimum(gap_m, np.linalg.norm(points_m - points_m[chosen[-1]], axis=1))
    return np.asarray(points_m[chosen])


def _seen_only(
    points: FloatArray, shares: FloatArray, joints_m: FloatArray, params: LimbFitParams
) -> FloatArray:
    """Return the joints with NaN where no surface of the limb is near; the root has its own.

    The end must have surface that the upper bone does not explain, by place or by its part.
    """
    seen_m = joints_m.copy()
    for joint in (1, 2):
        near = np.linalg.norm(points[:, :3] - joints_m[joint], axis=1) < params.reach_m
        if points[near, 3].sum() < params.least_near * points[:, 3].sum():
            seen_m[joint] = np.nan
    upper_m, lower_m = (_distances_m(points, joints_m[k], joints_m[k + 1]) for k in (0, 1))
    on_lower = lower_m < params.reach_m
    own = on_lower & ((upper_m > 1.5 * params.width_m) | (shares[:, 1] > shares[:, 0]))
    if points[own, 3].sum() < params.least_own * points[:, 3].sum():
        seen_m[2] = np.nan
    return seen_m


def _distances_m(points: FloatArray, a_m: FloatArray, b_m: FloatArray) -> FloatArray:
    """Return (N,) distances of points from the bone from a to b."""
    bone_m = b_m - a_m
    along = (points[:, :3] - a_m) @ bone_m / max(float(bone_m @ bone_m), 1e-9)
    nearest_m = a_m + np.clip(along, 0.0, 1.0)[:, None] * bone_m
    return np.asarray(np.linalg.norm(points[:, :3] - nearest_m, axis=1))
