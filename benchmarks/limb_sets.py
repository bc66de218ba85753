"""A hand as the thesis' 63 frames, and people and poses that no training has seen."""

import math
import os
from functools import cache
from pathlib import Path

import numpy as np

from adibas.arrays import AnyArray, Float32Array, FloatArray, UInt8Array
from adibas.data.joints import BODY_PART_NAMES
from adibas.data.limbs import HAND
from adibas.geometry.pinhole import Intrinsics
from adibas.limbs.model import CLUTTER
from adibas.simulation.body import ShapedBody, load_body_model
from adibas.simulation.body_shape import BodyShape
from adibas.simulation.driven_poses import driven_pose, turned_to_camera
from adibas.simulation.limb_frames import FrameSettings, LimbFrames, dressed_person
from adibas.simulation.limb_people import random_kind, wide_pose
from adibas.simulation.poses import ArmAngles, Pose, standing
from adibas.simulation.raster import rasterise
from adibas.simulation.rotations import about
from benchmarks.mocap_files import read_mocap_joints

CLEAN = FrameSettings(has_clutter=False, has_damage=False)
LIVE = FrameSettings(
    has_clutter=False,
    has_damage=False,
    farthest_turn_rad=math.radians(40),
    distance_m=(1.9, 3.2),
)
MOCAP_STEP = 40
Read = tuple[Float32Array, UInt8Array, float]


def metres(depth_mm: AnyArray) -> Float32Array:
    """Return metres with NaN."""
    depth_m: Float32Array = depth_mm.astype(np.float32) * np.float32(1e-3)
    depth_m[depth_mm == 0] = np.nan
    return depth_m


class UnseenFrames:
    """People whom no training has seen, each in one pose.

    Parameters
    ----------
    n_frames, seed : int
    settings : FrameSettings
    poses : list of Pose or None
        Theirs in turn; None: drawn as in training.
    """

    labels = (*BODY_PART_NAMES, CLUTTER)

    def __init__(
        self, n_frames: int, seed: int, settings: FrameSettings, poses: list[Pose] | None = None
    ) -> None:
        self._n_frames, self._seed, self._poses = n_frames, seed, poses
        self._frames = LimbFrames(seed, settings)
        self._kept: dict[int, Read] = {}

    def __len__(self) -> int:
        return self._n_frames

    def read(self, index: int) -> Read:
        """Return metres, labels and focal_px of frame `index`."""
        if index not in self._kept:
            self._kept[index] = self._draw(index)
        return self._kept[index]

    def _draw(self, index: int) -> Read:
        rng = np.random.default_rng([self._seed, index, 7])
        kind = random_kind(rng) if self._poses is None else "driven"
        pose = self._poses[index % len(self._poses)] if self._poses else wide_pose(rng, kind)
        person = index // 2
        dressed = dressed_person(self._seed, person)
        frame = self._frames.seen(dressed, pose, (person, kind), index)
        return metres(frame.depth_mm), frame.labels, self._frames.camera.intrinsics.fx


@cache
def mocap_poses() -> tuple[Pose, ...]:
    """Return poses of all motion capture, a third of a second apart, shuffled; () without it."""
    folder = os.environ.get("ADIBAS_REAL_DATA")
    if not folder:
        return ()
    poses = []
    for path in sorted((Path(folder) / "mocap").glob("*/*.amc")):
        joints_m = read_mocap_joints(path.parent / f"{path.parent.name}.asf", path)
        poses += [driven_pose(turned_to_camera(one)) for one in joints_m[::MOCAP_STEP]]
    order = np.random.default_rng(0).permutation(len(poses))
    return tuple(poses[number] for number in order)


class HandFrames:
    """A left hand before the camera, fingers bent and spread by turns: the thesis' 63 frames."""

    labels = HAND.names

    def __init__(self, n_frames: int) -> None:
        self._n_frames = n_frames
        self._part = _finger_of_vertex()

    def __len__(self) -> int:
        return self._n_frames

    def read(self, index: int) -> Read:
        """Return metres, labels and focal_px of frame `index`."""
        rng = np.random.default_rng([63, index])
        body = _hand_owner()
        arm = ArmAngles(
            elevation=math.radians(85 + rng.uniform(-10, 10)),
            plane=math.radians(60 + rng.uniform(-15, 15)),
            elbow=math.radians(70 + rng.uniform(-15, 15)),
            rotation=math.radians(-90 + rng.uniform(-20, 20)),
            pronation=math.radians(60 + rng.uniform(-40, 40)),
            wrist=math.radians(rng.uniform(-30, 30)),
            curl=math.radians(rng.uniform(0, 55)),
        )
        posed = body.posed(standing(left_arm=arm))
        vertices = posed.vertices_m - posed.joints_m[6]
        vertices = vertices @ about(np.array([0.0, 1.0, 0.0]), rng.uniform(-0.4, 0.4)).T
        vertices[:, 2] += rng.uniform(0.6, 0.8)
        seen = rasterise(
            vertices,
            body.model.triangles,
            Intrinsics(570.0, 570.0, 159.5, 119.5),
            (240, 320),
            hides_back_faces=True,
        )
        labels = np.zeros((240, 320), np.uint8)
        is_seen = seen.triangle >= 0
        corners = body.model.triangles[seen.triangle[is_seen]]
        labels[is_seen] = self._part[corners].max(axis=1)
        depth_m = seen.depth_m + rng.normal(0, 0.002, labels.shape).astype(np.float32)
        depth_m[labels == 0] = np.nan
        return depth_m, labels, 570.0


@cache
def _hand_owner() -> ShapedBody:
    return load_body_model().shaped(BodyShape("male", 34, 1.79, 78))


def _finger_of_vertex() -> UInt8Array:
    """Return (V,) values of `HAND` of the left hand's vertices, 0 elsewhere."""
    model = load_body_model()
    weights: FloatArray = np.zeros((model.n_vertices, len(HAND) + 1))
    fingers = ("1", "2", "3", "4", "5")
    for bone, name in enumerate(model.bone_names):
        value = 0
        if name.endswith(".L") and name.startswith(("wrist", "metacarpal")):
            value = 1
        elif name.endswith(".L") and name.startswith("finger"):
            value = 2 + fingers.index(name[len("finger")])
        share = np.where(model.bone_indices == bone, model.bone_weights, 0).sum(axis=1)
        weights[:, value] += share
    return np.asarray(weights.argmax(axis=1), np.uint8)
