"""Twelve frames of real depth with parts and joints drawn, to be looked at.

They are written below ``build/benchmarks/real_frames``, which is no part of the project. Parts in
colours, ours as dots with bones, the reference's joints as white circles.
"""

from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np

from adibas.arrays import AnyArray, Float32Array, FloatArray, UInt8Array
from adibas.geometry.pinhole import Intrinsics, project
from adibas.pipeline.limb_pictures import limb_picture
from adibas.pipeline.pose_following import PersonNow, PoseNow
from adibas.skeleton.proportions import PARENTS

FOLDER = Path(__file__).parents[1] / "build" / "benchmarks" / "real_frames"
PICTURED_TRIAL = 1
PICTURED_ACTIONS = (1, 27, 21)
"""An arm that is swept, a squat, the deep bend; of four people each."""
MIDDLE_ACTION = 1
"""Of the others the lowest frame is drawn."""
ENLARGED = 3
WHITE, DARK = (255, 255, 255), (20, 20, 20)
BONE_PX, DOT_PX, CIRCLE_PX = 2, 5, 9
Show = Callable[[int, Float32Array, PoseNow], None]
"""Told the number of a frame, its depth and who is in it."""


def pictured_frame(action: int, depths_m: Float32Array) -> int:
    """Return the frame of (T, H, W) depth to draw: in the middle, or where people are lowest."""
    if action == MIDDLE_ACTION:
        return len(depths_m) // 2
    return int(np.isfinite(depths_m).any(axis=2).sum(axis=1).argmin())


def drawing_of(name: str, frame: int, reference_m: FloatArray, camera: Intrinsics) -> Show:
    """Return what draws one frame of a recording.

    Parameters
    ----------
    name : str
        Of the picture; the number of the frame is added.
    frame : int
    reference_m : (T, 15, 3) array
        Joints of the reference, metres, camera axes; NaN where there is none.
    camera : Intrinsics
    """

    def show(number: int, depth_m: Float32Array, now: PoseNow) -> None:
        if number != frame:
            return
        person = now.people[0] if now.people else None
        picture = drawn(depth_m, person, reference_m[frame], camera)
        FOLDER.mkdir(parents=True, exist_ok=True)
        payload: AnyArray = cv2.imencode(".png", picture[..., ::-1])[1]
        (FOLDER / f"{name}_{number:03d}.png").write_bytes(payload.tobytes())

    return show


def drawn(
    depth_m: Float32Array, person: PersonNow | None, reference_m: FloatArray, camera: Intrinsics
) -> UInt8Array:
    """Return the enlarged (H, W, 3) picture of one frame; None: nobody was found in it."""
    labels = np.zeros(depth_m.shape, np.uint8)
    if person is not None:
        labels = (person.parts.chosen + 1).astype(np.uint8)
    size = depth_m.shape[1] * ENLARGED, depth_m.shape[0] * ENLARGED
    small = limb_picture(depth_m, labels)
    picture: UInt8Array = cv2.resize(small, size, interpolation=cv2.INTER_NEAREST).astype(np.uint8)
    for u, v in _places(reference_m, camera):
        cv2.circle(picture, (u, v), CIRCLE_PX, WHITE, 1, cv2.LINE_AA)
    if person is not None:
        _draw_joints(picture, person.joints.joints_m, camera)
    return picture


def _draw_joints(picture: UInt8Array, joints_m: FloatArray, camera: Intrinsics) -> None:
    for joint, parent in enumerate(PARENTS):
        ends = _places(joints_m[[joint, parent]], camera) if parent >= 0 else []
        if len(ends) == 2:  # both ends of a bone are seen
            cv2.line(picture, ends[0], ends[1], WHITE, BONE_PX, cv2.LINE_AA)
    for u, v in _places(joints_m, camera):
        cv2.circle(picture, (u, v), DOT_PX, DARK, -1, cv2.LINE_AA)
        cv2.circle(picture, (u, v), DOT_PX - 2, WHITE, -1, cv2.LINE_AA)


def _places(joints_m: FloatArray, camera: Intrinsics) -> list[tuple[int, int]]:
    """Return where the seen ones of some joints are in the enlarged picture."""
    pixels = ENLARGED * (project(joints_m, camera) + 0.5)
    return [(round(u), round(v)) for u, v in pixels.tolist() if np.isfinite([u, v]).all()]
