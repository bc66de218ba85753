"""Simulated people: one body model, shaped to a person, set into a pose.

Body axes: x to the patient's left, y down with the floor at y = 0, z to the patient's back;
metres. A body with heading 0 faces a camera that looks along z, so a scene needs only a
`RigidTransform` to put it before one. See ``docs/simulation-body.md``.
"""

import functools
import json
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from adibas.arrays import Float32Array, FloatArray, Int32Array, IntArray, UInt8Array, read_only
from adibas.data.joints import BODY_PART_NAMES, JOINT_NAMES
from adibas.resources import resource_path
from adibas.simulation.arm_room import find_arm_room_rad, with_arm_room
from adibas.simulation.body_shape import BodyShape
from adibas.simulation.landmarks import RestBody, joint_anchors, landmark_anchors
from adibas.simulation.phenotype import corner_weights
from adibas.simulation.poses import DOWN, FORWARD, Pose, standing
from adibas.simulation.rotations import about
from adibas.simulation.shape_fitting import (
    DENSITY_KG_PER_M3,
    fit_phenotype,
    standing_stature_m,
    volume_m3,
)
from adibas.simulation.skeleton import Skeleton, bone_turns
from adibas.simulation.skinning import add_normals, skin
from adibas.simulation.surface import SurfaceAnchors

_SINGLE_BONE_JOINTS = {
    "neck": "neck01",
    "torso": "spine03",
    **{
        f"{side}_{joint}": f"{bone}.{suffix}"
        for side, suffix in (("left", "L"), ("right", "R"))
        for joint, bone in (
            ("shoulder", "upperarm01"),
            ("elbow", "lowerarm01"),
            ("hip", "upperleg01"),
            ("knee", "lowerleg01"),
            ("foot", "foot"),
        )
    },
}


@dataclass(frozen=True, eq=False)
class BodyModel:
    """What all simulated people share; V vertices, T triangles, B bones, K bones a vertex.

    Attributes
    ----------
    triangles : (T, 3) array
        Vertex indices, counter-clockwise seen from outside.
    bone_names : tuple of str
    bone_parents : (B,) array
        -1 for the root.
    bone_indices, bone_weights : (V, K) arrays
        Which bones move a vertex, strongest first; the weights sum to 1.
    mean_vertices_m : (3 V,) array
    shape_basis_m : (R, 3 V) array
    corner_coefficients : (C, R) array
        Shape coefficients at the corners of `PHENOTYPE_GRID`.
    corner_bone_heads_m : (C, 3 B) array
    provenance : dict
        Source, version, licence, errors of the export.
    """

    triangles: Int32Array
    bone_names: tuple[str, ...]
    bone_parents: IntArray
    bone_indices: UInt8Array
    bone_weights: Float32Array
    mean_vertices_m: Float32Array
    shape_basis_m: Float32Array
    corner_coefficients: FloatArray
    corner_bone_heads_m: FloatArray
    provenance: dict[str, Any]

    @property
    def n_vertices(self) -> int:
        """Return V."""
        return len(self.bone_indices)

    @cached_property
    def part_weights(self) -> Float32Array:
        """Return (V, 15) shares of the parts in `BODY_PART_NAMES`; each row sums to 1.

        Interpolate over the triangle and take the largest: the border is then smooth.
        """
        part_of_bone = np.array([_part_of_bone(name) for name in self.bone_names])
        weights = np.zeros((self.n_vertices, len(BODY_PART_NAMES)), np.float32)
        rows = np.arange(self.n_vertices)
        for k in range(self.bone_indices.shape[1]):
            np.add.at(
                weights, (rows, part_of_bone[self.bone_indices[:, k]]), self.bone_weights[:, k]
            )
        read_only(weights)
        return weights

    @cached_property
    def triangle_parts(self) -> IntArray:
        """Return (T,) indices in `BODY_PART_NAMES`: the part with most of each triangle."""
        parts: IntArray = self.part_weights[self.triangles].sum(1).argmax(1)
        return parts

    @cached_property
    def head_vertices(self) -> IntArray:
        """Return the indices of the vertices that move with the skull alone."""
        head = self.part_weights[:, BODY_PART_NAMES.index("head")]
        return np.flatnonzero(head > 0.99)  # noqa: PLR2004

    def evaluated(self, phenotype: FloatArray) -> tuple[FloatArray, Skeleton]:
        """Return (V, 3) rest vertices and the skeleton of a `PHENOTYPE_GRID` parameter vector."""
        corners = corner_weights(phenotype)
        coefficients = (corners @ self.corner_coefficients).astype(np.float32)
        vertices_m = (self.mean_vertices_m + coefficients @ self.shape_basis_m).reshape(-1, 3)
        heads_m = (corners @ self.corner_bone_heads_m).reshape(-1, 3)
        skeleton = Skeleton(self.bone_names, self.bone_parents, heads_m)
        return vertices_m.astype(float), skeleton

    def shaped(self, shape: BodyShape) -> "ShapedBody":
        """Return the person wanted: exact in stature, as near in weight as the model can.

        Raises
        ------
        ValueError
            The model has no such stature at that age and sex.
        """
        phenotype = fit_phenotype(self, shape)
        vertices_m, skeleton = self.evaluated(phenotype)
        return ShapedBody(self, shape, phenotype, vertices_m, skeleton)


@dataclass(frozen=True, eq=False)
class ShapedBody:
    """One person at rest (arms and legs spread).

    Attributes
    ----------
    model : BodyModel
    shape : BodyShape
        What was asked for.
    phenotype : (6,) array
        What was found, in the order of `PHENOTYPE_GRID`.
    rest_vertices_m : (V, 3) array
    skeleton : Skeleton
    """

    model: BodyModel
    shape: BodyShape
    phenotype: FloatArray
    rest_vertices_m: FloatArray
    skeleton: Skeleton

    @cached_property
    def stature_m(self) -> float:
        """Return the stature reached: sole to vertex in the standing pose."""
        return standing_stature_m(self.model, self.rest_vertices_m, self.skeleton)

    @cached_property
    def weight_kg(self) -> float:
        """Return the weight reached: the volume of the mesh times `DENSITY_KG_PER_M3`."""
        return DENSITY_KG_PER_M3 * volume_m3(self.rest_vertices_m, self.model.triangles)

    @cached_property
    def _rest_joints_m(self) -> FloatArray:
        skull = self.rest_vertices_m[self.model.head_vertices]
        joints = {name: self.skeleton.head(bone) for name, bone in _SINGLE_BONE_JOINTS.items()}
        joints["head"] = 0.5 * (skull.min(0) + skull.max(0))
        for side, suffix in (("left", ".L"), ("right", ".R")):
            wrist, knuckle = (self.skeleton.head(b + suffix) for b in ("wrist", "finger3-1"))
            joints[f"{side}_hand"] = 0.5 * (wrist + knuckle)
        return np.stack([joints[name] for name in JOINT_NAMES])

    @cached_property
    def _rest(self) -> RestBody:
        return RestBody(
            self.rest_vertices_m, self.model.triangles, self.model.triangle_parts, self.skeleton
        )

    @cached_property
    def landmark_anchors(self) -> SurfaceAnchors:
        """Return the landmarks by name; see `adibas.simulation.landmarks`."""
        return landmark_anchors(self._rest)

    @cached_property
    def front_joint_anchors(self) -> SurfaceAnchors:
        """Return the skin point in front of each joint of `JOINT_NAMES` when standing."""
        stood = self.posed(standing())
        return joint_anchors(self._rest, stood.joints_m, stood.vertices_m, FORWARD)

    @cached_property
    def back_joint_anchors(self) -> SurfaceAnchors:
        """Return the skin point behind each joint of `JOINT_NAMES` when standing."""
        stood = self.posed(standing())
        return joint_anchors(self._rest, stood.joints_m, stood.vertices_m, -FORWARD)

    @cached_property
    def arm_room_rad(self) -> float:
        """Return by how much this body's hanging arms are spread so as to clear its hips."""
        part = self.model.part_weights.argmax(1)
        return find_arm_room_rad(lambda pose: self._exactly_posed(pose).vertices_m, part)

    def posed(self, pose: Pose) -> "PosedBody":
        """Return the body in `pose`: lowest point on the floor, ankles about `pose.offset_m`.

        Hanging arms are spread by `arm_room_rad`, 0 for slender people and 15 degrees for
        the heaviest; `PosedBody.pose` is the pose that results.
        """
        return self._exactly_posed(with_arm_room(pose, self.arm_room_rad))

    def _exactly_posed(self, pose: Pose) -> "PosedBody":
        turns = bone_turns(self.skeleton, pose)
        vertices_m = np.empty_like(self.rest_vertices_m)
        skin(
            self.rest_vertices_m,
            self.model.bone_indices,
            self.model.bone_weights,
            turns,
            vertices_m,
        )
        names = self.model.bone_names
        ankles = [names.index(name) for name in ("foot.L", "foot.R")]
        middle = np.mean([_moved(turns[b], self.skeleton.heads_m[b]) for b in ankles], axis=0)
        shift = np.array([pose.offset_m[0], -pose.lift_m, pose.offset_m[1]]) - np.array(
            [middle[0], vertices_m[:, 1].max(), middle[2]]
        )
        heading = about(DOWN, pose.heading_rad)
        vertices_m = (vertices_m + shift) @ heading.T
        turns[:, :, 3] += shift
        turns = heading @ turns
        return PosedBody(self, pose, vertices_m, turns)


@dataclass(frozen=True, eq=False)
class PosedBody:
    """One person in one pose.

    Attributes
    ----------
    body : ShapedBody
    pose : Pose
        The one asked for, with room for the arms.
    vertices_m : (V, 3) array
        Body axes, floor at y = 0.
    bone_turns : (B, 3, 4) array
        Maps from rest points to posed ones.
    """

    body: ShapedBody
    pose: Pose
    vertices_m: FloatArray
    bone_turns: FloatArray

    @cached_property
    def joints_m(self) -> FloatArray:
        """Return the (15, 3) joints in the order of `JOINT_NAMES`, metres."""
        names = self.body.model.bone_names
        bones = [names.index(bone) for bone in _bone_of_joint()]
        turns = self.bone_turns[bones]
        rest = self.body._rest_joints_m  # noqa: SLF001  (the rest of the same body)
        return np.asarray(np.einsum("jab,jb->ja", turns[:, :, :3], rest) + turns[:, :, 3])

    @cached_property
    def vertex_normals(self) -> FloatArray:
        """Return (V, 3) unit vectors that point out of the skin."""
        normals = np.zeros_like(self.vertices_m)
        add_normals(self.vertices_m, self.body.model.triangles, normals)
        return normals

    def on_skin(self, anchors: SurfaceAnchors) -> tuple[FloatArray, FloatArray]:
        """Return (N, 3) positions in metres and (N, 3) outward unit normals of skin points."""
        triangles = self.body.model.triangles
        normals = anchors.on(self.vertex_normals, triangles)
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        return anchors.on(self.vertices_m, triangles), normals

    @cached_property
    def landmarks(self) -> dict[str, FloatArray]:
        """Return the (3,) position of each landmark, metres."""
        anchors = self.body.landmark_anchors
        return dict(zip(anchors.names, self.on_skin(anchors)[0], strict=True))


def _moved(turn: FloatArray, point_m: FloatArray) -> FloatArray:
    moved: FloatArray = turn[:, :3] @ point_m + turn[:, 3]
    return moved


@functools.cache
def _bone_of_joint() -> tuple[str, ...]:
    """Return for each joint the bone that carries it."""
    hands = {"left_hand": "wrist.L", "right_hand": "wrist.R"}
    carried = _SINGLE_BONE_JOINTS | hands | {"head": "head"}
    return tuple(carried[name] for name in JOINT_NAMES)


def _part_of_bone(bone: str) -> int:
    """Return the index in `BODY_PART_NAMES` of the part that a bone moves."""
    stem, _, suffix = bone.partition(".")
    side = {"L": "left_", "R": "right_", "": ""}[suffix]
    limbs = {
        "upperarm": "upper_arm",
        "lowerarm": "lower_arm",
        "wrist": "hand",
        "finger": "hand",
        "metacarpal": "hand",
        "upperleg": "upper_leg",
        "lowerleg": "lower_leg",
        "foot": "foot",
        "toe": "foot",
    }
    for start, part in limbs.items():
        if stem.startswith(start):
            return BODY_PART_NAMES.index(side + part)
    if stem in ("head", "eye"):
        return BODY_PART_NAMES.index("head")
    return BODY_PART_NAMES.index("neck" if stem.startswith("neck") else "torso")


@functools.cache
def load_body_model() -> BodyModel:
    """Return the body model of ``resources/models/body.npz``; it is read once."""
    with np.load(resource_path("models", "body.npz"), allow_pickle=False) as file:
        steps = file["shape_basis_step"][:, None]
        basis = file["shape_basis"].reshape(len(steps), -1)
        heads = file["corner_bone_heads_m"]
        model = BodyModel(
            triangles=file["triangles"].astype(np.int32),
            bone_names=tuple(str(name) for name in file["bone_names"]),
            bone_parents=file["bone_parents"].astype(np.int64),
            bone_indices=file["bone_indices"],
            bone_weights=(file["bone_weights"] / np.iinfo(np.uint16).max).astype(np.float32),
            mean_vertices_m=file["mean_vertices_m"].ravel(),
            shape_basis_m=basis * steps,
            corner_coefficients=file["corner_coefficients"].astype(float),
            corner_bone_heads_m=heads.reshape(len(heads), -1).astype(float),
            provenance=json.loads(str(file["provenance"])),
        )
    for array in (model.triangles, model.bone_indices, model.bone_weights):
        read_only(array)
    return model
