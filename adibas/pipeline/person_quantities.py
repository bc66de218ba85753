"""All by which a person is told from a thing, out of the limbs and joints of one frame."""

from collections.abc import Callable

import numpy as np

from adibas.arrays import BoolArray, Float32Array, FloatArray
from adibas.body.rays import viewing_rays
from adibas.data.calibration import CameraCalibration
from adibas.data.limbs import LimbParts
from adibas.limbs.facing import front_evidence
from adibas.limbs.figure import FIGURES, describe_figure
from adibas.limbs.likeness import PART_QUANTITIES, describe_parts
from adibas.limbs.proposals import part_points, propose_joints
from adibas.pipeline.pose_model import shipped_joint_model
from adibas.skeleton.following import PersonFollower
from adibas.skeleton.plausibility import PLAUSIBILITIES, describe_joints

QUANTITIES = (*PART_QUANTITIES, *FIGURES, *PLAUSIBILITIES)
Describe = Callable[[Float32Array, BoolArray, LimbParts], FloatArray]
"""Takes depth, the mask of somebody, and the limbs that were found in it."""


def describer(camera: CameraCalibration) -> Describe:
    """Return what gives the (23,) `QUANTITIES` of limbs in images of this camera."""
    rays, focal_px = viewing_rays(camera), camera.intrinsics.fx
    model = shipped_joint_model()

    def described(depth_m: Float32Array, mask: BoolArray, parts: LimbParts) -> FloatArray:
        points = part_points(depth_m, parts, rays)
        proposals = propose_joints(points, model.offsets)
        at_first_sight = PersonFollower(model.proportions)
        joints = at_first_sight.follow(proposals, 0.0, front_evidence(points), points.cloud())
        return np.concatenate(
            [
                describe_parts(depth_m, mask, focal_px, parts),
                describe_figure(depth_m, mask, rays, parts),
                describe_joints(joints, model.proportions),
            ]
        )

    return described
