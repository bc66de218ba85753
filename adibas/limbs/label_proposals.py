"""Labels of a person's pixels out of the joints: what an editor of labelled images starts from.

Limbs are cylinders with round ends between joints, head, hands and feet spheres, as in the editor
of the thesis; a pixel gets the limb whose surface is nearest, if any is near.

Source: thesis, section 6.3 and figure 6.9 (the ground-truth editor). Widths are ours.
"""

from dataclasses import dataclass

import numpy as np

from adibas.arrays import BoolArray, Float32Array, FloatArray, UInt8Array, check_shape
from adibas.data.joints import JOINT_NAMES, SIDES
from adibas.data.limbs import FULL_BODY

BONES_M = (
    ("neck", "torso", 0.385),
    *((f"{side}shoulder", f"{side}elbow", 0.257) for side in SIDES),
    *((f"{side}elbow", f"{side}hand", 0.267) for side in SIDES),
    *((f"{side}hip", f"{side}knee", 0.383) for side in SIDES),
    *((f"{side}knee", f"{side}foot", 0.416) for side in SIDES),
)
"""Lengths of the usual adult of the body model: a child's limbs are as much thinner as its bones
are shorter."""


@dataclass(frozen=True, slots=True)
class ProposalWidths:
    """Radii of that adult; tuned on simulated people (``docs/limbs.md``).

    Attributes
    ----------
    head_m, hand_m, foot_m : float
        Of spheres.
    neck_m, trunk_m, upper_arm_m, lower_arm_m, upper_leg_m, lower_leg_m : float
        Of cylinders.
    wrist_share, ankle_share : float
        Where on the bone from the elbow to the hand the lower arm ends, and on that from the knee
        to the foot the lower leg.
    reach_m : float
        A pixel that is farther than this from every surface gets no label.
    """

    head_m: float = 0.09
    hand_m: float = 0.05
    foot_m: float = 0.097
    neck_m: float = 0.058
    trunk_m: float = 0.105
    upper_arm_m: float = 0.04
    lower_arm_m: float = 0.044
    upper_leg_m: float = 0.08
    lower_leg_m: float = 0.076
    wrist_share: float = 0.7
    ankle_share: float = 0.95
    reach_m: float = 0.15


@dataclass(frozen=True, slots=True, eq=False)
class Capsule:
    """A cylinder with round ends, or a sphere where both ends are one; camera axes, metres."""

    label: str
    begin_m: FloatArray
    end_m: FloatArray
    radius_m: float


def propose_labels(
    points_m: FloatArray | Float32Array,
    mask: BoolArray,
    joints_m: FloatArray,
    widths: ProposalWidths | None = None,
) -> UInt8Array:
    """Return (H, W) labels: index in `BODY_PART_NAMES` + 1, 0 where no limb is near.

    Parameters
    ----------
    points_m : (H, W, 3) array
        What each pixel sees, camera axes; NaN where not measured.
    mask : (H, W) bool array
        Of the person; all others stay 0.
    joints_m : (15, 3) array
        In the order of `JOINT_NAMES`, camera axes; NaN where not seen: limbs that need such a joint
        are not proposed.
    widths : ProposalWidths or None
    """
    widths = widths or ProposalWidths()
    check_shape("points_m", points_m, (*mask.shape, 3))
    labels = np.zeros(mask.shape, np.uint8)
    known = mask & np.isfinite(points_m).all(axis=2)
    wanted_m = np.asarray(points_m[known], np.float64)
    nearest_m = np.full(len(wanted_m), widths.reach_m)
    chosen = np.zeros(len(wanted_m), np.uint8)
    for capsule in capsules_of(joints_m, widths):
        distance_m = outside_m(wanted_m, capsule)
        is_nearer = distance_m < nearest_m
        nearest_m[is_nearer] = distance_m[is_nearer]
        chosen[is_nearer] = FULL_BODY.names.index(capsule.label) + 1
    labels[known] = chosen
    return labels


def outside_m(points_m: FloatArray, capsule: Capsule) -> FloatArray:
    """Return how far each of (N, 3) points is outside of a capsule; negative inside."""
    along = capsule.end_m - capsule.begin_m
    length_sq = float(along @ along)
    since = points_m - capsule.begin_m
    share = np.clip(since @ along / length_sq, 0.0, 1.0) if length_sq else np.zeros(len(points_m))
    return np.asarray(np.linalg.norm(since - share[:, None] * along, axis=1) - capsule.radius_m)


def capsules_of(joints_m: FloatArray, widths: ProposalWidths | None = None) -> tuple[Capsule, ...]:
    """Return the limbs of (15, 3) joints, those alone whose joints are all seen."""
    widths = widths or ProposalWidths()
    check_shape("joints_m", joints_m, (len(JOINT_NAMES), 3))
    at = dict(zip(JOINT_NAMES, np.asarray(joints_m, np.float64), strict=True))
    limbs = [*_trunk(at, widths), *(limb for side in SIDES for limb in _limbs(at, side, widths))]
    size = _size(at)
    return tuple(
        Capsule(label, begin_m, end_m, size * radius_m)
        for label, begin_m, end_m, radius_m in limbs
        if np.isfinite(begin_m).all() and np.isfinite(end_m).all()
    )


Limb = tuple[str, FloatArray, FloatArray, float]
Joints = dict[str, FloatArray]


def _trunk(at: Joints, widths: ProposalWidths) -> list[Limb]:
    neck, head, radius_m = at["neck"], at["head"], widths.trunk_m
    hips = [at[f"{side}hip"] for side in SIDES]
    pelvis = (hips[0] + hips[1]) / 2
    inner = [at[f"{side}shoulder"] + 0.35 * (neck - at[f"{side}shoulder"]) for side in SIDES]
    below = [neck + 0.3 * (at["torso"] - neck), at["torso"]]
    return [
        ("head", head, head, widths.head_m),
        ("neck", neck, neck + 0.4 * (head - neck), widths.neck_m),
        ("torso", below[0], below[1], radius_m),
        ("torso", at["torso"], pelvis, radius_m),
        *(
            ("torso", shoulder + 0.2 * (hip - shoulder), hip + 0.2 * (pelvis - hip), radius_m * 0.8)
            for shoulder, hip in zip(inner, hips, strict=True)
        ),
    ]


def _limbs(at: Joints, side: str, widths: ProposalWidths) -> list[Limb]:
    shoulder, elbow, hand = (at[f"{side}{joint}"] for joint in ("shoulder", "elbow", "hand"))
    hip, knee, foot = (at[f"{side}{joint}"] for joint in ("hip", "knee", "foot"))
    wrist = elbow + widths.wrist_share * (hand - elbow)
    ankle = knee + widths.ankle_share * (foot - knee)
    return [
        (f"{side}upper_arm", shoulder, elbow, widths.upper_arm_m),
        (f"{side}lower_arm", elbow, wrist, widths.lower_arm_m),
        (f"{side}hand", hand, hand, widths.hand_m),
        (f"{side}upper_leg", hip + 0.15 * (knee - hip), knee, widths.upper_leg_m),
        (f"{side}lower_leg", knee, ankle, widths.lower_leg_m),
        (f"{side}foot", foot, foot, widths.foot_m),
    ]


def _size(at: Joints) -> float:
    """Return how large somebody is beside the usual adult, by the bones that are seen."""
    shares = [np.linalg.norm(at[one] - at[other]) / usual_m for one, other, usual_m in BONES_M]
    seen = [share for share in shares if np.isfinite(share)]
    return float(np.median(seen)) if seen else 1.0
