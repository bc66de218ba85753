"""Joints without markers in live frames, and where the pictures show them."""

from types import SimpleNamespace

import cv2
import numpy as np
import pytest

from adibas.data.calibration import CameraCalibration, RgbdCalibration
from adibas.data.joints import JOINT_NAMES
from adibas.geometry.distortion import project_distorted
from adibas.geometry.pinhole import Intrinsics
from adibas.geometry.rigid import RigidTransform
from adibas.pipeline.live_people import LivePeople, joints_in_pictures
from adibas.recordings.decoding import to_rgbd
from adibas.simulation.scenes import SceneSettings, SimulatedScene
from adibas.skeleton.following import ChosenJoints

TURNED = cv2.Rodrigues(np.array([0.01, -0.02, 0.03]))[0]
COLOR = CameraCalibration(
    640, 480, Intrinsics(525.0, 530.0, 320.0, 245.0), (0.1, -0.2, 0.001, 0.002, 0.05)
)
DEPTH = CameraCalibration(320, 240, Intrinsics(285.0, 285.0, 160.0, 120.0))
CALIBRATION = RgbdCalibration(
    color=COLOR, depth=DEPTH, color_from_depth=RigidTransform(TURNED, np.array([0.025, 0.0, 0.001]))
)


def somebody(joints_m, is_view_sure=True):
    joints = ChosenJoints(joints_m, joints_m[:, 0] * 0.0 + 0.5, 0.9, is_view_sure)
    return SimpleNamespace(person=3, joints=joints)


@pytest.fixture
def joints_m():
    rng = np.random.default_rng(4)
    return rng.uniform((-0.5, -0.4, 1.8), (0.5, 0.4, 2.4), (15, 3))


def test_joints_lie_in_both_pictures_where_opencv_projects_them(joints_m):
    found = joints_in_pictures(somebody(joints_m), CALIBRATION)
    assert (found.person, found.n_seen) == (3, 15)
    for places, camera, turn, shift in (
        (found.in_color, COLOR, TURNED, np.array([0.025, 0.0, 0.001])),
        (found.in_depth, DEPTH, np.eye(3), np.zeros(3)),
    ):
        matrix = np.array(
            [
                [camera.intrinsics.fx, 0, camera.intrinsics.cx],
                [0, camera.intrinsics.fy, camera.intrinsics.cy],
                [0, 0, 1],
            ]
        )
        lens = np.array(camera.distortion or (0.0,) * 4)
        expected, _ = cv2.projectPoints(joints_m, turn, shift, matrix, lens)
        assert tuple(places) == JOINT_NAMES
        np.testing.assert_allclose(list(places.values()), expected[:, 0], atol=1e-6)


def test_joints_that_are_not_seen_or_beside_the_picture_have_no_place(joints_m):
    joints_m[0] = np.nan
    joints_m[1] = (3.0, 0.0, 2.0)
    joints_m[2, 2] = -1.0
    found = joints_in_pictures(somebody(joints_m), CALIBRATION)
    assert set(found.in_color) == set(found.in_depth) == set(JOINT_NAMES[3:])


@pytest.mark.parametrize("is_sure", [True, False])
def test_whether_the_side_that_is_seen_is_known_goes_with_the_joints(joints_m, is_sure):
    found = joints_in_pictures(somebody(joints_m, is_sure), CALIBRATION)
    assert found.is_view_sure is is_sure


def test_without_a_calibrated_camera_its_picture_shows_no_joints(joints_m):
    found = joints_in_pictures(somebody(joints_m), RgbdCalibration(depth=DEPTH))
    assert found.in_color == {}
    assert len(found.in_depth) == 15


def test_joints_of_a_simulated_patient_are_drawn_on_the_patient():
    scene = SimulatedScene(SceneSettings(seed=31))
    simulated = scene.frame(0)
    frame = to_rgbd(simulated.sensor_frame, scene.info)
    calibration = scene.info.calibration
    moment = LivePeople().look(frame.depth_m, 1, calibration)
    (person,) = moment.people
    drawn = joints_in_pictures(person, calibration)
    assert moment.unseen is None
    assert drawn.n_seen >= 12
    color = calibration.color
    truth_uv = project_distorted(simulated.truth.joints_color_m, color.intrinsics, color.distortion)
    off_px = [
        np.hypot(*(np.array(drawn.in_color[name]) - place))
        for name, place in zip(JOINT_NAMES, truth_uv, strict=True)
        if name in drawn.in_color
    ]
    ten_cm_px = 0.1 * color.intrinsics.fx / 2.0
    assert np.median(off_px) < ten_cm_px / 2
    assert np.mean(np.array(off_px) < ten_cm_px) > 0.85
