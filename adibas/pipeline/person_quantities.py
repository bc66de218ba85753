"""All by which a person is told from a thing, out of the limbs and joints of one frame."""

from collections.abc import Callable

import numpy as np

from adibas.arrays import BoolArray, Float32Array, FloatArray
from adibas.body.rays import viewing_rays
from adibas.data.calibration import CameraCalibration
from adibas.data.limbs import LimbParts
from adibas.limbs.figure import FIGURES, describe_figure
from adibas.limbs.likeness import PART_QUANTITIES, describe_parts
from adibas.pipeline.person_evidence import PersonEvidence, evidence_of
from adibas.pipeline.pose_model import shipped_joint_model
from adibas.skeleton.following import PersonFollower
from adibas.skeleton.plausibility import PLAUSIBILITIES, describe_joints

QUANTITIES = (*PART_QUANTITIES, *FIGURES, *PLAUSIBILITIES)
Describe = Callable[[Float32Array, BoolArray, LimbParts, PersonEvidence | None], FloatArray]
"""Takes depth, the mask of somebody, the limbs in it, and what they tell, if that is known yet."""


def describer(camera: CameraCalibration) -> Describe:
    """Return what gives the (23,) `QUANTITIES` of limbs in images of this camera."""
    rays, focal_px = viewing_rays(camera), camera.intrinsics.fx
    model = shipped_joint_model()

    def described(
        depth_m: Float32Array, mask: BoolArray, parts: LimbParts, seen: PersonEvidence | None = None
    ) -> FloatArray:
        seen = seen or evidence_of(depth_m, parts, rays, model)
        at_first_sight = PersonFollower(model.proportions)
        joints = at_first_sight.follow(seen.proposals, 0.0, seen.front, seen.cloud)
        return np.concatenate(
            [
                describe_parts(depth_m, mask, focal_px, parts),
                describe_figure(depth_m, mask, rays, parts),
                describe_joints(joints, model.proportions),
            ]
        )

    return described
