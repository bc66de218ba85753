"""What limbs of one person in one frame tell of the joints: for the judge and for the choice."""

from dataclasses import dataclass

from adibas.arrays import Float32Array
from adibas.data.joint_proposals import JointProposals
from adibas.data.limbs import LimbParts
from adibas.data.part_cloud import PartCloud
from adibas.limbs.facing import FacingParams, front_evidence
from adibas.limbs.proposals import ProposalParams, part_points, propose_joints
from adibas.pipeline.pose_model import JointModel


@dataclass(frozen=True, slots=True, eq=False)
class PersonEvidence:
    """One person in one frame.

    Attributes
    ----------
    proposals : JointProposals
        Where each joint may be.
    front : float
        Log odds that the front is shown.
    cloud : PartCloud
        Surface that arms and legs are laid into.
    """

    proposals: JointProposals
    front: float
    cloud: PartCloud


def evidence_of(
    depth_m: Float32Array,
    parts: LimbParts,
    rays: Float32Array,
    model: JointModel,
    proposing: ProposalParams | None = None,
    facing: FacingParams | None = None,
) -> PersonEvidence:
    """Return what limbs tell of joints; (H, W) depth in metres, `rays` as in `part_points`.

    Raises
    ------
    LimbError
        The labels are not those of the whole body.
    """
    points = part_points(depth_m, parts, rays, proposing)
    proposals = propose_joints(points, model.offsets, proposing)
    front = 0.0 if model.facing is None else front_evidence(points, model.facing, facing)
    return PersonEvidence(proposals, front, points.cloud())
