"""Types that cross a stage border refuse what makes no sense and cannot be changed."""

import numpy as np
import pytest

from adibas.data.calibration import CameraCalibration, DepthBias, RgbdCalibration
from adibas.data.frames import EncodedImage, RgbdFrame, SensorFrame, SourceInfo, depth_in_metres
from adibas.data.joints import BODY_PART_NAMES, JOINT_NAMES
from adibas.data.markers import Marker
from adibas.data.masks import BodyMask
from adibas.data.posture import PostureAnalysis, Provenance
from adibas.geometry.pinhole import Intrinsics

INTRINSICS = Intrinsics(fx=500.0, fy=500.0, cx=320.0, cy=240.0)


def test_no_reading_becomes_missing_and_counts_become_metres():
    raw = np.array([[0, 1], [2000, 65535]], np.uint16)
    depth_m = depth_in_metres(raw, 0.001)
    assert np.isnan(depth_m[0, 0])
    np.testing.assert_allclose(depth_m.ravel()[1:], [0.001, 2.0, 65.535], rtol=1e-6)
    assert depth_m.dtype == np.float32


def test_frames_cannot_be_changed_after_they_were_made():
    raw = np.ones((2, 3), np.uint16)
    frame = SensorFrame(
        0, 0, depth_raw=raw, color=np.zeros((4, 6, 3), np.uint8), color_timestamp_ns=1
    )
    for image in (frame.depth_raw, frame.color):
        with pytest.raises(ValueError, match="read-only"):
            image[0, 0] = 1


@pytest.mark.parametrize(
    "parts",
    [
        {"depth_raw": np.ones((2, 3))},
        {"depth_raw": np.ones(3, np.uint16)},
        {"infrared_raw": np.ones((2, 3), np.uint8)},
        {"color": np.zeros((2, 3), np.uint8), "color_timestamp_ns": 0},
        {"color": EncodedImage("jpeg", b""), "color_timestamp_ns": None},
    ],
)
def test_a_frame_of_the_wrong_kind_is_refused(parts):
    with pytest.raises(ValueError, match=r"must|together"):
        SensorFrame(0, 0, **parts)


def test_a_frame_in_metres_is_float32():
    color_rgb = np.zeros((2, 2, 3), np.uint8)
    assert RgbdFrame(0, 0, np.ones((2, 2), np.float32), color_rgb).depth_m[0, 0] == 1
    with pytest.raises(ValueError, match="float32"):
        RgbdFrame(0, 0, np.ones((2, 2)), color_rgb)


@pytest.mark.parametrize("parts", [{"depth_unit_m": 0.0}, {"frame_rate_hz": -1.0}])
def test_a_source_has_a_positive_unit_and_rate(parts):
    with pytest.raises(ValueError, match="positive"):
        SourceInfo(**parts)


@pytest.mark.parametrize("size", [(0, 480), (640, -1)])
def test_a_camera_has_a_size(size):
    with pytest.raises(ValueError, match="size"):
        CameraCalibration(*size, INTRINSICS)


def test_distortion_has_a_length_of_the_model():
    assert CameraCalibration(640, 480, INTRINSICS, (0.1, 0.0, 0.0, 0.0)).distortion[0] == 0.1
    with pytest.raises(ValueError, match="distortion"):
        CameraCalibration(640, 480, INTRINSICS, (0.1, 0.0, 0.0))


def test_depth_bias_is_the_polynomial_of_its_docstring():
    depth_m = np.array([[1.0, 2.0, np.nan]], np.float32)
    corrected = DepthBias(a=0.01, b=1.02, c=-0.003).correct(depth_m)
    np.testing.assert_allclose(corrected, [[1.027, 2.038, np.nan]], rtol=1e-6)
    assert DepthBias().correct(depth_m) is depth_m
    assert DepthBias(image_term=(0.0, 0.0)).correct(depth_m) is depth_m


def test_image_term_of_the_depth_bias_is_the_polynomial_of_its_docstring():
    camera = CameraCalibration(3, 2, Intrinsics(10.0, 20.0, 1.5, 0.25))
    factors = tuple((0.01 * np.arange(1.0, 10.0)).tolist())
    depth_m = np.array([[1.0, 2.0, np.nan], [0.5, 1.5, 3.0]], np.float32)
    for n_terms in (2, 5, 9):
        bias = DepthBias(0.1, 1.1, -0.2, factors[:n_terms])
        found = RgbdCalibration(depth=camera, depth_bias=bias).corrected_depth(depth_m)
        assert found.dtype == np.float32
        for row, column in np.ndindex(2, 3):
            z, x, y = float(depth_m[row, column]), (column - 1.5) / 10.0, (row - 0.25) / 20.0
            powers = [(1, 0), (0, 1), (2, 0), (1, 1), (0, 2), (3, 0), (2, 1), (1, 2), (0, 3)]
            image = sum(f * x**i * y**j for f, (i, j) in zip(bias.image_term, powers, strict=False))
            wanted = 0.1 + 1.1 * z + (-0.2 + image) * z**2
            np.testing.assert_allclose(found[row, column], wanted, rtol=2e-6)


def test_an_image_term_is_kept_for_a_camera_and_cannot_be_changed():
    camera = CameraCalibration(3, 2, Intrinsics(10.0, 20.0, 1.5, 0.25))
    bias = DepthBias(image_term=(0.1, 0.2))
    square_term_per_m = bias.square_term_per_m(camera)
    assert DepthBias(image_term=(0.1, 0.2)).square_term_per_m(camera) is square_term_per_m
    assert not square_term_per_m.flags.writeable


def test_an_image_term_needs_its_camera():
    bias, depth_m = DepthBias(image_term=(0.1, 0.2)), np.ones((2, 3), np.float32)
    with pytest.raises(ValueError, match="needs the depth camera"):
        bias.correct(depth_m)
    with pytest.raises(ValueError, match="depth_m must have shape"):
        bias.correct(depth_m, CameraCalibration(4, 2, INTRINSICS))


@pytest.mark.parametrize(
    "wrong", [{"a": np.nan}, {"image_term": (1.0,)}, {"image_term": (0.0, np.inf)}]
)
def test_a_depth_bias_is_finite_and_of_a_known_order(wrong):
    with pytest.raises(ValueError, match=r"image_term|finite"):
        DepthBias(**wrong)


def test_a_calibration_checks_its_parts():
    names = ("color.fx", "color.fy")
    calibration = RgbdCalibration(
        parameter_names=names, covariance=np.eye(2), gravity=np.array([0.0, 1.0, 0.0])
    )
    with pytest.raises(ValueError, match="read-only"):
        calibration.covariance[0, 0] = 2.0
    with pytest.raises(ValueError, match="covariance"):
        RgbdCalibration(parameter_names=names, covariance=np.eye(3))
    with pytest.raises(ValueError, match="gravity"):
        RgbdCalibration(gravity=np.zeros(2))
    with pytest.raises(ValueError, match="depth_unit_m"):
        RgbdCalibration(depth_unit_m=-0.001)


def test_a_marker_has_position_and_covariance_or_neither():
    assert Marker("m01", 1.0, 2.0, 3.0, np.eye(2)).position_m is None
    measured = Marker("m01", 1.0, 2.0, 3.0, np.eye(2), np.zeros(3), np.eye(3))
    with pytest.raises(ValueError, match="read-only"):
        measured.position_m[0] = 1.0
    with pytest.raises(ValueError, match="together"):
        Marker("m01", 1.0, 2.0, 3.0, np.eye(2), position_m=np.zeros(3))


def test_a_mask_is_boolean():
    assert BodyMask(np.ones((2, 2), bool)).pixels.all()
    with pytest.raises(ValueError, match="bool"):
        BodyMask(np.ones((2, 2), np.uint8))


def test_an_analysis_knows_its_view_and_picture():
    parts = {
        "patient": "p1",
        "n_frames": 1,
        "first_frame": 0,
        "markers": (),
        "rejected": (),
        "distances": (),
        "angles": (),
        "calibration": RgbdCalibration(),
        "provenance": Provenance("", "", "", "", {}),
    }
    picture_rgb = np.zeros((2, 2, 3), np.uint8)
    assert PostureAnalysis(view="anterior", picture_rgb=picture_rgb, **parts).notices == ()
    with pytest.raises(ValueError, match="view"):
        PostureAnalysis(view="above", picture_rgb=picture_rgb, **parts)
    with pytest.raises(ValueError, match="uint8"):
        PostureAnalysis(view="", picture_rgb=np.zeros((2, 2, 3)), **parts)


def test_joints_and_parts_are_the_contract_s():
    assert JOINT_NAMES[:4] == ("head", "neck", "left_shoulder", "right_shoulder")
    assert JOINT_NAMES[-1] == "right_foot"
    assert len(JOINT_NAMES) == len(BODY_PART_NAMES) == 15
    assert BODY_PART_NAMES[3] == "left_upper_arm"
    assert BODY_PART_NAMES[9] == "right_upper_arm"
