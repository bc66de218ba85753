"""Joints on real depth images of people that no part of the program has seen: UTD-MHAD.

The reference are the joints of the Kinect SDK. They are early by 1.7 frames, and some are defined
elsewhere in the body, so one constant offset for each joint is removed, taken from the other
people of the set. In deep bends (action 21) the reference itself is wrong.
"""

import os
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.io import loadmat

from adibas.arrays import BoolArray, Float32Array, FloatArray
from adibas.data.calibration import CameraCalibration
from adibas.data.joints import JOINT_NAMES
from adibas.data.skeleton_track import SkeletonTrack
from adibas.geometry.pinhole import Intrinsics
from adibas.limbs.model import LimbModel, load_model
from adibas.pipeline.person_judge import person_judge
from adibas.pipeline.pose import smooth_track
from adibas.pipeline.pose_following import PoseEstimator, forest_segmenter
from adibas.pipeline.pose_model import joint_model_for
from adibas.pipeline.shipped_limbs import shipped_model
from adibas.skeleton.following import ChosenJoints
from adibas.skeleton.proportions import MIRRORED
from adibas.skeleton.smoothing import SmoothingParams
from benchmarks.pose_pictures import (
    PICTURED_ACTIONS,
    PICTURED_TRIAL,
    Show,
    drawing_of,
    pictured_frame,
)
from benchmarks.table import Row

REAL_DATA = "ADIBAS_REAL_DATA"
MODEL = "ADIBAS_LIMB_MODEL"
"""Of the environment: another model than the shipped one, to compare them."""
CAMERA = CameraCalibration(320, 240, Intrinsics(285.63, 285.63, 160.0, 120.0))
LAG_FRAMES = 1.7
RATE_HZ = 30.0
ACTIONS = (1, 3, 4, 7, 10, 24, 27)
DEEP_BEND = 21
PEOPLE = (1, 3, 5, 7)
TRIALS = (1, 2)
NEAR_M, WIDER_M = 0.10, 0.15
KINECT_JOINTS = {
    "head": 0,
    "neck": 1,
    "torso": 2,
    "left_shoulder": 4,
    "left_elbow": 5,
    "left_hand": 7,
    "right_shoulder": 8,
    "right_elbow": 9,
    "right_hand": 11,
    "left_hip": 12,
    "left_knee": 13,
    "left_foot": 14,
    "right_hip": 16,
    "right_knee": 17,
    "right_foot": 18,
}
"""Places in the SDK's list; its feet are ours by the ankles."""
TO_CAMERA = np.array([-1.0, -1.0, 1.0])
"""The SDK mirrors its pictures, and its y points up."""
SHOULDERS = [JOINT_NAMES.index(name) for name in ("left_shoulder", "right_shoulder")]


@dataclass(frozen=True, slots=True, eq=False)
class Compared:
    """One recording: (T, 15, 3) joints of ours and of the reference."""

    person: int
    action: int
    ours_m: FloatArray
    reference_m: FloatArray


def rows(*, quick: bool) -> Iterable[Row]:
    """Measure; with `quick` one trial of the first and the last action."""
    folder = os.environ.get(REAL_DATA)
    if folder is None:
        return
    chosen = os.environ.get(MODEL)
    model = shipped_model() if chosen is None else load_model(Path(chosen))
    found = list(compare(Path(folder) / "utd_mhad", model, quick=quick))
    calm = [one for one in found if one.action != DEEP_BEND]
    told = f"real depth, {len(PEOPLE)} people, {sum(len(one.ours_m) for one in calm)} frames"
    yield from _rows_of(calm, told)
    bends = [one for one in found if one.action == DEEP_BEND]
    errors_m = _all_errors_m(bends, calm)
    yield _share(f"deep bend (a{DEEP_BEND}, reference wrong): joints within 10 cm", errors_m)


def _rows_of(calm: list[Compared], told: str) -> Iterator[Row]:
    by_person = {
        person: _errors_m([one for one in calm if one.person == person], _offsets_m(calm, person))
        for person in PEOPLE
    }
    means = [_near_share(errors_m, NEAR_M) for errors_m in by_person.values()]
    yield Row(
        f"{told}: joints within 10 cm, mean over people", float(np.mean(means)), "%", 80, "goal >="
    )
    wider = [_near_share(errors_m, WIDER_M) for errors_m in by_person.values()]
    yield Row("same: within 15 cm", float(np.mean(wider)), "%", 92, "goal >=")
    every_m = np.concatenate(list(by_person.values()))
    seen = np.isfinite(every_m)
    yield Row(
        "same: mean error of seen joints", 1e3 * float(every_m[seen].mean()), "mm", 60, "goal <="
    )
    yield Row("same: joints not seen", 100.0 * float((~seen).mean()), "%")
    yield Row("same: frames with shoulders exchanged", _flips(calm), "%", 1, "goal <")
    raw_m = np.concatenate([_errors_m([one], np.zeros((15, 3))) for one in calm])
    yield _share("same, without offsets: joints within 10 cm", raw_m)
    for person, errors_m in by_person.items():
        yield _share(f"person {person}: joints within 10 cm", errors_m)
    for joint, name in enumerate(JOINT_NAMES):
        yield _share(f"{name}: within 10 cm", every_m[:, joint])


def compare(folder: Path, model: LimbModel, *, quick: bool) -> Iterator[Compared]:
    """Yield our joints and the reference of every recording; twelve frames are drawn."""
    actions = (ACTIONS[0], DEEP_BEND) if quick else (*ACTIONS, DEEP_BEND)
    for action in actions:
        for person in PEOPLE:
            for trial in TRIALS[:1] if quick else TRIALS:
                name = f"a{action}_s{person}_t{trial}"
                depths_m = read_depths(folder / "Depth" / f"{name}_depth.mat")
                reference_m = read_reference(folder / "Skeleton" / f"{name}_skeleton.mat")
                places: FloatArray = np.arange(float(len(depths_m))) - LAG_FRAMES
                reference_m = at_frames(reference_m, places)
                show = None
                if action in PICTURED_ACTIONS and trial == PICTURED_TRIAL:
                    frame = pictured_frame(action, depths_m)
                    show = drawing_of(name, frame, reference_m, CAMERA.intrinsics)
                track = follow(depths_m, model, show)
                yield Compared(person, action, track.joints_m, reference_m)


def read_depths(path: Path) -> Float32Array:
    """Return (T, 240, 320) metres, NaN outside the person, as a camera sees it."""
    depth_mm = np.moveaxis(loadmat(path)["d_depth"], 2, 0)[:, :, ::-1]
    depth_m = depth_mm.astype(np.float32) / np.float32(1000)
    depth_m[depth_mm == 0] = np.nan
    return np.ascontiguousarray(depth_m)


def read_reference(path: Path) -> FloatArray:
    """Return (T, 15, 3) joints of the SDK, metres, camera axes."""
    joints = np.moveaxis(loadmat(path)["d_skel"].astype(float), 2, 0)
    order = [KINECT_JOINTS[name] for name in JOINT_NAMES]
    return np.asarray(joints[:, order] * TO_CAMERA)


def follow(depths_m: Float32Array, model: LimbModel, show: Show | None = None) -> SkeletonTrack:
    """Return the smoothed joints; the background is already taken away from these images."""
    estimator = PoseEstimator(
        CAMERA,
        forest_segmenter(model, CAMERA),
        joints=joint_model_for(model),
        judge=person_judge(model, CAMERA),
    )
    estimator.floor = None
    frames: list[tuple[int, ChosenJoints]] = []
    for number, depth_m in enumerate(depths_m):
        time_s = number / RATE_HZ
        now = estimator.look_at(depth_m, [_whole_mask(depth_m)], time_s)
        if show is not None:
            show(number, depth_m, now)
        joints = now.people[0].joints if now.people else _nothing()
        frames.append((round(1e9 * time_s), joints))
    return smooth_track(frames, 1, SmoothingParams())


def _whole_mask(depth_m: Float32Array) -> BoolArray:
    return np.asarray(np.isfinite(depth_m))


def _nothing() -> ChosenJoints:
    n_joints = len(JOINT_NAMES)
    return ChosenJoints(np.full((n_joints, 3), np.nan), np.full(n_joints, np.nan), 0.5)


def at_frames(joints_m: FloatArray, frames: FloatArray) -> FloatArray:
    """Return joints between frames, on straight lines; NaN before the first and after the last."""
    before = np.clip(np.floor(frames).astype(np.int64), 0, len(joints_m) - 2)
    share = (frames - before)[:, None, None]
    between = (1 - share) * joints_m[before] + share * joints_m[before + 1]
    between[(frames < 0) | (frames > len(joints_m) - 1)] = np.nan
    return np.asarray(between)


def _offsets_m(found: list[Compared], but_for: int) -> FloatArray:
    """Return (15, 3): where ours lie beside the reference's, median over the other people."""
    gaps_m = [one.ours_m - one.reference_m for one in found if one.person != but_for]
    return np.asarray(np.nanmedian(np.concatenate(gaps_m), axis=0))


def _errors_m(found: list[Compared], offsets_m: FloatArray) -> FloatArray:
    """Return (T, 15); infinite where ours is not seen, without the frames that lack a reference."""
    errors = []
    for one in found:
        there = np.isfinite(one.reference_m).all(axis=(1, 2))
        far_m = np.linalg.norm(one.ours_m - offsets_m - one.reference_m, axis=2)[there]
        errors.append(np.where(np.isfinite(far_m), far_m, np.inf))
    return np.concatenate(errors)


def _all_errors_m(found: list[Compared], calm: list[Compared]) -> FloatArray:
    return np.concatenate([_errors_m([one], _offsets_m(calm, one.person)) for one in found])


def _near_share(errors_m: FloatArray, limit_m: float) -> float:
    return 100.0 * float((errors_m < limit_m).mean())


def _share(name: str, errors_m: FloatArray) -> Row:
    return Row(name, _near_share(errors_m, NEAR_M), "%")


def _flips(found: list[Compared]) -> float:
    """Return the share of frames in which both shoulders are nearer to the other one's place."""
    flipped = []
    for one in found:
        ours, theirs = one.ours_m[:, SHOULDERS], one.reference_m[:, SHOULDERS]
        crossed = one.reference_m[:, [MIRRORED[joint] for joint in SHOULDERS]]
        straight_m = np.linalg.norm(ours - theirs, axis=2)
        crossed_m = np.linalg.norm(ours - crossed, axis=2)
        there = np.isfinite(straight_m).all(axis=1)
        flipped.append((crossed_m < straight_m).all(axis=1)[there])
    return 100.0 * float(np.concatenate(flipped).mean())
