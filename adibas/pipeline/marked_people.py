"""Simulated people with markers on their joints, as a depth camera sees them.

Each set is of one person in one picture: who stands, moves, or sits, in clothes, perhaps on a
chair, seen from one of the four sides. Where a joint is marked is drawn among the places that show
most markers; what the camera does not see is missing.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from adibas.arrays import BoolArray, Float32Array, FloatArray
from adibas.data.calibration import CameraCalibration
from adibas.data.frames import depth_in_metres
from adibas.data.joints import JOINT_NAMES
from adibas.geometry.pinhole import project
from adibas.pipeline.skeleton_marks import MarkedBody
from adibas.pipeline.skeleton_poses import draw_pose
from adibas.pipeline.skeleton_simulator import SKIN_PLACES
from adibas.simulation.body import PosedBody
from adibas.simulation.device import DEPTH_UNIT_M
from adibas.simulation.figures import Figure, TrunkAngles
from adibas.simulation.limb_frames import (
    CLUTTER,
    Dressed,
    FrameSettings,
    LimbFrame,
    LimbFrames,
    dressed_person,
)
from adibas.simulation.poses import ArmAngles, Pose
from adibas.simulation.random_poses import angle_drawer, random_figure
from adibas.simulation.surface import SurfaceAnchors
from adibas.skeleton.starts import HEADINGS_RAD

ON_THIGHS = "hands on thighs"
KINDS = ("standing", "moving", "seated", ON_THIGHS)
VIEW_OFF_RAD = 0.35
DISTANCE_M = (1.9, 2.8)
PICTURES_A_PERSON = 8
MARKER_SD_M = 0.005
SHOWN_M = 0.04
"""A marker is seen where what is measured lies so near to it."""
FROM_THIGH_M, ALONG_THIGH = (0.07, 0.13), 0.3
"""How far the middle of a hand lies from the middle of the thigh, and from where on."""
MOST_TRIALS = 3000
PAIRED = ("shoulder", "elbow", "hand", "hip", "knee", "foot")


@dataclass(frozen=True, slots=True, eq=False)
class MarkedPicture:
    """One person with markers, and what a depth camera sees of both.

    Attributes
    ----------
    kind : str
        One of `KINDS`.
    view : str
        Which side the camera sees, within `VIEW_OFF_RAD`.
    depth_m : (H, W) float32 array
        NaN where not measured.
    mask : (H, W) bool array
        The person, and furniture that was taken for a part.
    camera : CameraCalibration
    points_m : (M, 3) array
        The markers that are seen, in camera axes, in any order.
    names : tuple of str
        Of each, its joint.
    up : (3,) array
        In camera axes.
    """

    kind: str
    view: str
    depth_m: Float32Array
    mask: BoolArray
    camera: CameraCalibration
    points_m: FloatArray
    names: tuple[str, ...]
    up: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class JointPlaces:
    """Where one joint, or both of a pair, may be marked.

    Attributes
    ----------
    names : tuple of str
        One, or those of left and right.
    options_m : (P, 1 or 2, 3) array
        Places, in camera axes.
    is_seen : (P, 1 or 2) bool array
    """

    names: tuple[str, ...]
    options_m: FloatArray
    is_seen: BoolArray


def marked_pictures(seed: int, n_pictures: int, first: int = 0) -> Iterator[MarkedPicture]:
    """Give pictures `first` to `n_pictures`, of kinds and views in turn.

    Picture i depends on the seed and i alone. People who cannot lay their hands on their thighs are
    left out.
    """
    frames = {
        view: LimbFrames(seed, frame_settings(heading_rad))
        for view, heading_rad in HEADINGS_RAD.items()
    }
    views = list(HEADINGS_RAD)
    for number in range(first, n_pictures):
        kind = KINDS[number % len(KINDS)]
        view = views[number // len(KINDS) % len(views)]
        person = number // PICTURES_A_PERSON
        rng = np.random.default_rng([seed, 0x44, number])
        dressed = dressed_person(seed, person)
        pose = _pose(rng, kind, dressed)
        if pose is None:
            continue
        posture = "seated" if kind == ON_THIGHS else kind
        frame = frames[view].seen(dressed, pose, (person, posture), number)
        camera = frames[view].camera
        places = places_of(frame, dressed, camera)
        chosen = (most_seen(rng, [one]) for one in places)
        yield marked(rng, frame, camera, (kind, view), zip(places, chosen, strict=True))


def frame_settings(heading_rad: float) -> FrameSettings:
    """Return how people are seen whose heading is about that one."""
    return FrameSettings(
        has_damage=False,
        farthest_turn_rad=VIEW_OFF_RAD,
        distance_m=DISTANCE_M,
        step=1,
        turned_rad=heading_rad,
    )


def _pose(rng: np.random.Generator, kind: str, dressed: Dressed) -> Pose | None:
    if kind == ON_THIGHS:
        return hands_on_thighs(rng, MarkedBody(dressed.body))
    return draw_pose(rng, kind)


def hands_on_thighs(rng: np.random.Generator, body: MarkedBody) -> Pose | None:
    """Return somebody who sits upright with the hands on the thighs; None where none was found."""
    draw = angle_drawer(rng)
    for _ in range(MOST_TRIALS):
        legs = random_figure(rng, "seated")
        trunk = TrunkAngles(
            pelvis=draw(-10, 10),
            chest=draw(-10, 12),
            head=draw(-15, 25),
            side_bend=draw(-6, 6),
            twist=draw(-8, 8),
            look=draw(-20, 20),
            tilt=draw(-10, 10),
        )
        arms = [
            ArmAngles(
                elevation=draw(5, 50),
                plane=draw(20, 110),
                rotation=draw(-20, 70),
                elbow=draw(30, 100),
                pronation=draw(-20, 90),
                wrist=draw(-30, 30),
                curl=draw(0, 50),
            )
            for _ in range(2)
        ]
        pose = Figure(arms[0], arms[1], legs.left_leg, legs.right_leg, trunk).pose()
        centres_m = dict(zip(JOINT_NAMES, body.posed(pose).centres, strict=True))
        if all(_is_on_thigh(centres_m, side) for side in ("left", "right")):
            return pose
    return None


def _is_on_thigh(centres_m: dict[str, FloatArray], side: str) -> bool:
    """Say whether the middle of a hand lies above the thigh of its side, as near as skin lets."""
    hip_m, knee_m = centres_m[f"{side}_hip"], centres_m[f"{side}_knee"]
    off_m, thigh_m = centres_m[f"{side}_hand"] - hip_m, knee_m - hip_m
    along = float(np.clip(off_m @ thigh_m / (thigh_m @ thigh_m), 0.0, 1.0))
    beside_m = off_m - along * thigh_m
    nearest_m, farthest_m = FROM_THIGH_M
    is_near = nearest_m < float(np.linalg.norm(beside_m)) < farthest_m
    return bool(is_near and along > ALONG_THIGH and beside_m[1] < 0.0)


def places_of(frame: LimbFrame, dressed: Dressed, camera: CameraCalibration) -> list[JointPlaces]:
    """Return where each joint, or both of a pair, may be marked, and what of it is seen."""
    depth_m = depth_in_metres(frame.depth_mm, DEPTH_UNIT_M)
    is_body = (frame.labels > 0) & (frame.labels != CLUTTER)
    return [
        JointPlaces(
            tuple(f"{side}_{joint}" for side in ("left", "right")) if joint in PAIRED else (joint,),
            options_m,
            _are_seen(options_m, depth_m, is_body, camera),
        )
        for joint, options_m in _places_m(frame, dressed).items()
    ]


def most_seen(rng: np.random.Generator, moments: Sequence[JointPlaces]) -> int:
    """Return which place shows most markers over some frames; one of them by chance."""
    counts = np.sum([one.is_seen.sum(axis=1) for one in moments], axis=0)
    return int(rng.choice(np.flatnonzero(counts == counts.max())))


def marked(
    rng: np.random.Generator,
    frame: LimbFrame,
    camera: CameraCalibration,
    what: tuple[str, str],
    markings: Iterable[tuple[JointPlaces, int]],
) -> MarkedPicture:
    """Return the picture of a frame with the markers that are seen, in any order.

    `what` are kind and view, `markings` the places of each joint and which of them is marked.
    """
    names: list[str] = []
    points_m: list[FloatArray] = []
    for places, chosen in markings:
        for side, name in enumerate(places.names):
            if places.is_seen[chosen, side]:
                names.append(name)
                noise_m = rng.normal(scale=MARKER_SD_M, size=3)
                points_m.append(places.options_m[chosen, side] + noise_m)
    order = rng.permutation(len(names))
    points = np.array(points_m).reshape(-1, 3)[order]
    named = tuple(names[i] for i in order)
    depth_m = depth_in_metres(frame.depth_mm, DEPTH_UNIT_M)
    up = frame.camera_from_body.rotation @ np.array([0.0, -1.0, 0.0])
    return MarkedPicture(*what, depth_m, frame.labels > 0, camera, points, named, up)


def _places_m(frame: LimbFrame, dressed: Dressed) -> dict[str, FloatArray]:
    """Return for each joint (P, 1 or 2, 3) places on cloth or skin in which it may be marked."""
    body, posed = dressed.body, frame.posed
    fronts, backs, marks = (
        frame.camera_from_body.apply(_on_cloth(dressed, posed, anchors))
        for anchors in (body.front_joint_anchors, body.back_joint_anchors, body.landmark_anchors)
    )
    landmarks = dict(zip(body.landmark_anchors.names, marks, strict=True))
    torso = JOINT_NAMES.index("torso")
    landmarks["sternum"] = 0.5 * (landmarks["sternal_notch"] + fronts[torso])
    places: dict[str, FloatArray] = {}
    for joint, others in SKIN_PLACES.items():
        prefixes = ("left_", "right_") if joint in PAIRED else ("",)
        own = [JOINT_NAMES.index(f"{prefix}{joint}") for prefix in prefixes]
        beside = [[landmarks[f"{prefix}{place}"] for prefix in prefixes] for place in others]
        places[joint] = np.stack([fronts[own], backs[own], *(np.stack(one) for one in beside)])
    return places


def _on_cloth(dressed: Dressed, posed: PosedBody, anchors: SurfaceAnchors) -> FloatArray:
    skin_m, normals = posed.on_skin(anchors)
    thickness_m = anchors.on(dressed.thickness_m[:, None], dressed.body.model.triangles)
    return np.asarray(skin_m + thickness_m * normals)


def _are_seen(
    places_m: FloatArray, depth_m: Float32Array, is_body: BoolArray, camera: CameraCalibration
) -> BoolArray:
    """Say of (..., 3) places whether the picture shows the body there."""
    u, v = np.moveaxis(np.rint(project(places_m, camera.intrinsics)), -1, 0)
    is_inside = (u >= 0) & (u < camera.width) & (v >= 0) & (v < camera.height)
    columns, rows = (np.where(is_inside, at, 0).astype(np.intp) for at in (u, v))
    is_there = np.abs(depth_m[rows, columns] - places_m[..., 2]) < SHOWN_M
    return np.asarray(is_inside & is_there & is_body[rows, columns])
