"""The frames of real depth that the benchmark draws, to be looked at."""

from types import SimpleNamespace

import cv2
import numpy as np

from adibas.data.joints import JOINT_NAMES
from adibas.data.limbs import NO_LABEL
from adibas.geometry.pinhole import Intrinsics
from benchmarks import pose_pictures
from benchmarks.pose_pictures import ENLARGED, drawing_of, drawn, pictured_frame

CAMERA = Intrinsics(100.0, 100.0, 39.5, 29.5)
TORSO, NECK = JOINT_NAMES.index("torso"), JOINT_NAMES.index("neck")


def somebody():
    depth_m = np.full((60, 80), np.nan, np.float32)
    depth_m[10:50, 30:50] = 2.0
    chosen = np.full(depth_m.shape, NO_LABEL, np.int16)
    chosen[10:50, 30:50] = 2
    joints_m = np.full((len(JOINT_NAMES), 3), np.nan)
    joints_m[TORSO] = 0.0, 0.2, 2.0
    joints_m[NECK] = 0.0, -0.2, 2.0
    person = SimpleNamespace(
        parts=SimpleNamespace(chosen=chosen), joints=SimpleNamespace(joints_m=joints_m)
    )
    return depth_m, person


def test_parts_joints_bones_and_the_reference_are_drawn_where_they_are():
    depth_m, person = somebody()
    reference_m = np.full((len(JOINT_NAMES), 3), np.nan)
    reference_m[0] = 0.5, 0.0, 2.0
    picture = drawn(depth_m, person, reference_m, CAMERA)
    assert picture.shape == (60 * ENLARGED, 80 * ENLARGED, 3)
    middle = 40 * ENLARGED
    for row_px in (20, 30, 40):  # the neck, half of the bone, the torso
        assert (picture[row_px * ENLARGED, middle] > 200).all()
    limb = picture[15 * ENLARGED, 32 * ENLARGED]
    assert limb.max() > limb.min(), "a limb has a colour"
    circle = picture[30 * ENLARGED, (65 * ENLARGED - 12) : (65 * ENLARGED + 13)]
    assert (circle.max(axis=1) > 100).sum() in range(2, 7), "a circle is not filled"
    assert not drawn(depth_m * np.nan, None, reference_m * np.nan, CAMERA).any()


def test_one_frame_of_a_recording_is_written(tmp_path, monkeypatch):
    monkeypatch.setattr(pose_pictures, "FOLDER", tmp_path / "frames")
    depth_m, person = somebody()
    depths_m = np.stack([depth_m] * 5)
    depths_m[3, :30] = np.nan
    assert pictured_frame(1, depths_m) == 2
    frame = pictured_frame(27, depths_m)
    assert frame == 3
    reference_m = np.full((5, len(JOINT_NAMES), 3), np.nan)
    show = drawing_of("a27_s1_t1", frame, reference_m, CAMERA)
    for number, one_m in enumerate(depths_m):
        show(number, one_m, SimpleNamespace(people=(person,)))
    (path,) = (tmp_path / "frames").iterdir()
    assert path.name == "a27_s1_t1_003.png"
    assert cv2.imread(str(path)).shape == (60 * ENLARGED, 80 * ENLARGED, 3)
