"""Where somebody would mark the joints of a simulated body, without posing all of its skin."""

from dataclasses import dataclass

import numpy as np

from adibas.arrays import FloatArray, IntArray
from adibas.simulation.arm_room import with_arm_room
from adibas.simulation.body import PosedBody, ShapedBody
from adibas.simulation.poses import Pose
from adibas.simulation.skeleton import bone_turns
from adibas.simulation.skinning import skin
from adibas.simulation.surface import SurfaceAnchors


@dataclass(frozen=True, slots=True, eq=False)
class JointMarks:
    """The places of one pose, metres, from an origin of their own.

    Attributes
    ----------
    centres, fronts, backs : (15, 3) arrays
        In the order of `JOINT_NAMES`.
    landmarks : dict
        The (3,) place of each landmark by name.
    """

    centres: FloatArray
    fronts: FloatArray
    backs: FloatArray
    landmarks: dict[str, FloatArray]


class MarkedBody:
    """One person, of whom only the skin at joints and landmarks is posed."""

    def __init__(self, body: ShapedBody) -> None:
        self._body = body
        self._anchors = (body.front_joint_anchors, body.back_joint_anchors, body.landmark_anchors)
        corners = [body.model.triangles[one.triangles] for one in self._anchors]
        chosen = np.unique(np.concatenate([one.ravel() for one in corners]))
        self._corners = [np.searchsorted(chosen, one) for one in corners]
        self._rest_m = np.ascontiguousarray(body.rest_vertices_m[chosen])
        self._bones = np.ascontiguousarray(body.model.bone_indices[chosen])
        self._weights = np.ascontiguousarray(body.model.bone_weights[chosen])

    def posed(self, pose: Pose) -> JointMarks:
        """Return the places in a pose; the turn and place of the whole body are left out."""
        with_room = with_arm_room(pose, self._body.arm_room_rad)
        turns = bone_turns(self._body.skeleton, with_room)
        skin_m = np.empty_like(self._rest_m)
        skin(self._rest_m, self._bones, self._weights, turns, skin_m)
        centres = PosedBody(self._body, with_room, skin_m, turns).joints_m
        fronts, backs, landmarks = (
            _on(skin_m, corners, anchors)
            for corners, anchors in zip(self._corners, self._anchors, strict=True)
        )
        names = self._anchors[-1].names
        return JointMarks(centres, fronts, backs, dict(zip(names, landmarks, strict=True)))


def _on(skin_m: FloatArray, corners: IntArray, anchors: SurfaceAnchors) -> FloatArray:
    return np.asarray(np.einsum("nk,nkd->nd", anchors.barycentric, skin_m[corners]))
