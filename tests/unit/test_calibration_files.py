"""A calibration comes back from the disk exactly, and a broken one is told in words."""

import copy
import json

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from adibas.calibration.files import (
    calibration_from_json,
    calibration_to_json,
    check_fits,
    read_calibration,
    write_calibration,
)
from adibas.data.calibration import CameraCalibration, DepthBias, RgbdCalibration
from adibas.errors import CalibrationError
from adibas.geometry.pinhole import Intrinsics
from adibas.geometry.planes import Plane
from adibas.geometry.rigid import RigidTransform

TURN = cv2.Rodrigues(np.array([0.01, -0.02, 0.03]))[0]


def whole_calibration(fx=1050.1):
    return RgbdCalibration(
        color=CameraCalibration(1280, 1024, Intrinsics(fx, 1051.2, 640.3, 511.4), (0.1,) * 5),
        depth=CameraCalibration(640, 480, Intrinsics(580.0, 581.0, 320.0, 240.0)),
        color_from_depth=RigidTransform(TURN, np.array([0.025, 0.001, -0.002])),
        depth_unit_m=0.0001,
        depth_bias=DepthBias(0.01, 1.02, -0.003, (1e-3, -2e-3, 3e-3, -4e-3, 5e-3)),
        rms_px=0.13,
        parameter_names=("color.fx", "color.fy"),
        covariance=np.array([[0.3, 0.1], [0.1, 0.2]]),
        gravity=np.array([0.0, 1.0, 0.0]),
        floor=Plane(np.array([0.0, -1.0, 0.0]), 1.1),
        gravity_sd_rad=0.002,
        floor_flatness_m=0.003,
        sensor_serial="A1",
        created_utc="2026-11-21T10:00:00+00:00",
        valid_region={"color": [[10, 10], [1270, 1010]]},
        corner_method="gradient",
    )


@given(st.floats(1e-3, 1e6))
def test_what_was_written_comes_back_bit_by_bit(fx):
    document = calibration_to_json(whole_calibration(fx))
    back = calibration_from_json(json.loads(json.dumps(document)), "c.json")
    assert calibration_to_json(back) == document
    assert back.color.intrinsics.fx == fx
    np.testing.assert_array_equal(back.color_from_depth.rotation, TURN)
    np.testing.assert_array_equal(back.covariance, [[0.3, 0.1], [0.1, 0.2]])
    assert back.floor.offset_m == 1.1
    assert (back.gravity_sd_rad, back.floor_flatness_m) == (0.002, 0.003)


def test_a_file_holds_the_contract_s_keys(tmp_path):
    write_calibration(tmp_path / "c.json", whole_calibration())
    document = json.loads((tmp_path / "c.json").read_text())
    assert document["format"] == "adibas-calibration"
    assert document["color"]["width"] == 1280
    assert document["rms_convention"] == "points"
    assert read_calibration(tmp_path / "c.json").sensor_serial == "A1"


def test_everything_after_the_unit_may_be_missing_and_a_camera_may_stand_alone():
    document = calibration_to_json(whole_calibration())
    small = {key: document[key] for key in ("format", "version", "color", "depth_unit_m")}
    calibration = calibration_from_json(small, "c.json")
    assert calibration.depth is None
    assert calibration.covariance is None
    assert calibration.depth_bias == DepthBias()
    assert calibration_to_json(calibration)["color"] == document["color"]


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"format": "other"}, "no calibration of ADiBAS"),
        ({"version": 2}, "later version"),
        ({"color": None, "depth": None}, "neither"),
        ({"color": {"width": 1}}, "fx is missing"),
        ({"depth_unit_m": "1"}, "no number"),
        ({"depth_unit_m": True}, "no number"),
        ({"depth_unit_m": 0}, "positive"),
        ({"rms_px": float("nan")}, "not finite"),
        ({"gravity": [0, float("inf"), 0]}, "not finite"),
        ({"gravity": [0, 1]}, "shape"),
        ({"covariance": [[1.0]]}, "shape"),
        ({"covariance": [[1.0], [1.0, 2.0]]}, "rows of different lengths"),
        ({"covariance": [[1.0, "2"], [1.0, 2.0]]}, "no number"),
        ({"parameter_names": []}, "shape"),
        ({"parameter_names": "color.fx"}, "no list"),
        ({"rms_convention": "coordinates"}, "rms_convention"),
        ({"gravity": [0, 9.81, 0]}, "gravity must have length 1"),
        ({"gravity": "down"}, "gravity is no list"),
        ({"gravity": [[0, 1, 0]]}, "shape"),
        ({"gravity": [0, 10**400, 0]}, "not finite"),
        ({"color": "x"}, "color is no group"),
        ({"color": {"width": [1] * 1000, "fx": 1, "fy": 1, "cx": 0, "cy": 0}}, "a value is no"),
        ({"depth_bias": {"a": None}}, "no number"),
        ({"gravity_sd_rad": "small"}, "no number"),
        ({"floor": {"normal": [0, -1, 0]}}, r"floor\.offset_m is missing"),
        ({"color_from_depth": {"rotation": [[1, 0], [0, 1]], "translation_m": [0, 0, 0]}}, "shape"),
        ({"color_from_depth": []}, "damaged"),
        ({"depth_bias": {"image_term": [1.0]}}, "image_term must have one of"),
        ({"depth_bias": {"image_term": [1.0, "x"]}}, "no number"),
        ({"depth_bias": {"image_term": 1.0}}, "image_term is no list"),
        ({"depth_bias": {"image_term": [[1.0], [2.0]]}}, "image_term is no list of numbers"),
        ({"floor": {"normal": [0, -2, 0], "offset_m": 1}}, "length 1"),
    ],
)
def test_what_makes_no_sense_is_refused_with_its_reason(change, words):
    document = copy.deepcopy(calibration_to_json(whole_calibration())) | change
    with pytest.raises(CalibrationError, match=rf"^c\.json .*{words}"):
        calibration_from_json(document, "c.json")


def test_calibration_of_the_depth_camera_alone_comes_back():
    depth_alone = RgbdCalibration(depth=whole_calibration().depth)
    document = calibration_to_json(depth_alone)
    assert "color" not in document
    assert calibration_to_json(calibration_from_json(document, "c.json")) == document


def test_null_is_the_same_as_missing():
    document = calibration_to_json(whole_calibration())
    needed = {"format", "version", "color", "depth_unit_m"}
    nulls = dict.fromkeys(key for key in document if key not in needed)
    calibration = calibration_from_json(document | nulls, "c.json")
    assert calibration.depth is None
    assert calibration.covariance is None
    assert calibration.depth_bias == DepthBias()
    assert calibration.rms_px is None
    assert calibration.sensor_serial == ""


def test_an_image_size_is_whole_numbers():
    document = calibration_to_json(whole_calibration())
    document["color"]["width"] = 1280.5
    with pytest.raises(CalibrationError, match="no whole number"):
        calibration_from_json(document, "c.json")


BROKEN = [
    b"{",
    b"[" * 30_000,
    b"x" * 70_000,
    b"%YAML:1.0\n---\nA: " + b"[" * 200_000,
    b"\xff\xfe\x00",
    b"",
    b"just words",
    b"%YAML:1.0\n---\n{{{",
    b"<?xml",
]


@pytest.mark.parametrize("content", BROKEN, ids=range(len(BROKEN)))
def test_a_broken_file_is_one_sentence(tmp_path, content):
    (tmp_path / "c.json").write_bytes(content)
    with pytest.raises(CalibrationError, match=r"^c\.json"):
        read_calibration(tmp_path / "c.json")


def test_a_missing_or_huge_file_is_one_sentence(tmp_path):
    with pytest.raises(CalibrationError, match="cannot be read"):
        read_calibration(tmp_path / "none.json")
    with (tmp_path / "huge.json").open("wb") as file:
        file.truncate(17 * 1024 * 1024)
    with pytest.raises(CalibrationError, match="too large"):
        read_calibration(tmp_path / "huge.json")


@pytest.mark.parametrize("ending", ["yaml", "xml"])
@pytest.mark.parametrize("names", [("camera_matrix", "distortion_coefficients"), ("K", "D")])
def test_a_file_that_opencv_wrote_is_read(tmp_path, ending, names):
    path = tmp_path / f"c.{ending}"
    matrix = np.array([[500.5, 0, 320.25], [0, 501.5, 240.75], [0, 0, 1]])
    storage = cv2.FileStorage(str(path), cv2.FileStorage_WRITE)
    storage.write("image_width", 640)
    storage.write("image_height", 480)
    storage.write(names[0], matrix)
    storage.write(names[1], np.array([[0.1, -0.2, 0.001, 0.002, 0.3]]))
    storage.release()
    camera = read_calibration(path).color
    np.testing.assert_array_equal(camera.intrinsics.matrix(), matrix)
    assert camera.distortion == (0.1, -0.2, 0.001, 0.002, 0.3)
    assert (camera.width, camera.height) == (640, 480)


ROS = """image_width: 640
image_height: 480
camera_name: c
camera_matrix: {rows: 3, cols: 3, data: [500.0, 0, 320, 0, 501, 240, 0, 0, 1]}
distortion_model: MODEL
distortion_coefficients: {rows: 1, cols: 5, data: [0.1, -0.2, 0, 0, 0]}
"""


def test_a_ros_camera_info_is_read(tmp_path):
    (tmp_path / "c.yaml").write_text(ROS.replace("MODEL", "plumb_bob"))
    camera = read_calibration(tmp_path / "c.yaml").color
    assert camera.intrinsics == Intrinsics(500.0, 501.0, 320.0, 240.0)
    assert camera.distortion == (0.1, -0.2, 0.0, 0.0, 0.0)


def test_a_ros_message_with_short_names_is_read(tmp_path):
    (tmp_path / "c.yaml").write_text(
        "height: 480\nwidth: 640\ndistortion_model: rational_polynomial\n"
        "D: [0.1, -0.2, 0.0, 0.0, 0.3, 0.01, 0.02, 0.03]\n"
        "K: [500.0, 0.0, 320.0, 0.0, 501.0, 240.0, 0.0, 0.0, 1.0]\n"
    )
    camera = read_calibration(tmp_path / "c.yaml").color
    assert camera.intrinsics == Intrinsics(500.0, 501.0, 320.0, 240.0)
    assert camera.distortion == (0.1, -0.2, 0.0, 0.0, 0.3, 0.01, 0.02, 0.03)


OPENCV = """%YAML:1.0
---
image_size: [ 640, 480 ]
M1: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 500., 0., 320., 0., 501., 240., 0., 0., 1. ]
D1: !!opencv-matrix
   rows: 1
   cols: 14
   dt: d
   data: [ 0.1, 0., 0., 0., 0., 0., 0., 0., 0., 0., 0., 0.2, 0., 0. ]
"""


def test_stereo_names_and_zero_tilt_are_read(tmp_path):
    (tmp_path / "c.yml").write_text(OPENCV)
    camera = read_calibration(tmp_path / "c.yml").color
    assert (camera.width, camera.height) == (640, 480)
    assert camera.distortion == (0.1, *(0.0,) * 10, 0.2)


def mutated(content, rng):
    """A few bytes changed, cut, doubled, or replaced by what parsers stumble over."""
    content = bytearray(content)
    for _ in range(rng.integers(1, 6)):
        place = int(rng.integers(len(content)))
        kind = rng.integers(4)
        if kind == 0:
            content[place] = rng.integers(256)
        elif kind == 1 and len(content) > 60:
            del content[place : place + 40]
        elif kind == 2:
            content[place:place] = content[place : place + 60]
        else:
            content[place:place] = rng.choice(
                [b"-", b"1e999", b"null", b"[", b"{", b".Nan", b"<a>"]
            )
    return bytes(content)


def test_mutated_files_are_read_or_refused_in_words(tmp_path):
    rng = np.random.default_rng(1)
    whole = json.dumps(calibration_to_json(whole_calibration()))
    seeds = [text.encode() for text in (whole, OPENCV, ROS.replace("MODEL", "plumb_bob"))]
    path = tmp_path / "c.json"
    refusals = []
    for i in range(150):
        path.write_bytes(mutated(seeds[i % 3], rng))
        try:
            camera = read_calibration(path).color
        except CalibrationError as error:
            refusals.append(str(error))
        else:
            assert camera is None or np.isfinite(camera.intrinsics.matrix()).all()
    assert len(refusals) > 50
    assert all(refusal.startswith("c.json") for refusal in refusals)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (OPENCV.replace("240.", ".Nan"), "finite"),
        (OPENCV.replace("0.2, 0., 0.", "0.2, 0.1, 0."), "distortion must have"),
        (OPENCV.replace("0., 0., 1. ]", "0., 1., 1. ]"), "matrix is none"),
        (OPENCV.replace("640", "999999"), "image size"),
        (OPENCV.replace("M1: !!opencv-matrix", "M1: 5\nX:"), "no 3x3 camera matrix"),
        (OPENCV.replace("rows: 3", "rows: 100000"), "not what OpenCV writes"),
        (OPENCV.replace("image_size: [ 640, 480 ]", "image_size: 640"), "no image size"),
        ("a: &a [1, 2]\nimage_width: *a\n", "no YAML"),
        ("image_width: 2001-99-99\n", "no YAML"),
        ("- 1\n", "no camera_info"),
        (ROS.replace("MODEL", "equidistant"), "lens model"),
        (ROS.replace("MODEL", "plumb_bob").replace("image_width: 640\n", ""), "damaged"),
        (ROS.replace("MODEL", "plumb_bob").replace("[500.0, 0,", "[500.0, 3,"), "skew"),
        (ROS.replace("MODEL", "plumb_bob").replace("[500.0,", "[-1,"), "focal"),
        ("%YAML:1.0\n---\nimage_width: 640\nimage_height: 480\n", "no 3x3 camera matrix"),
    ],
)
def test_a_foreign_file_that_cannot_be_used_says_why(tmp_path, text, words):
    (tmp_path / "c.yaml").write_text(text)
    with pytest.raises(CalibrationError, match=words):
        read_calibration(tmp_path / "c.yaml")


def test_an_xml_file_cannot_pull_in_another_file(tmp_path):
    (tmp_path / "secret").write_text("640")
    path = tmp_path / "c.xml"
    path.write_text(
        f'<?xml version="1.0"?><!DOCTYPE x [<!ENTITY e SYSTEM "{tmp_path}/secret">]>'
        "<opencv_storage><image_width>&e;</image_width></opencv_storage>"
    )
    with pytest.raises(CalibrationError, match="cannot be used"):
        read_calibration(path)


def test_a_published_opencv_calibration_is_read(real_data):
    camera = read_calibration(real_data / "calibration/opencv_left/left_intrinsics.yml").color
    assert camera.intrinsics.fx == pytest.approx(535.916, abs=1e-3)
    assert camera.intrinsics.cx == pytest.approx(342.283, abs=1e-3)


def test_a_calibration_must_fit_the_images():
    calibration = whole_calibration()
    check_fits(calibration, (1024, 1280), (480, 640))
    with pytest.raises(CalibrationError, match=r"colour images of 1280x1024.*640x480"):
        check_fits(calibration, (480, 640), (480, 640))
    with pytest.raises(CalibrationError, match="depth images"):
        check_fits(calibration, (1024, 1280), (240, 320))
    check_fits(RgbdCalibration(color=calibration.color), (1024, 1280), None)
    check_fits(RgbdCalibration(depth=calibration.depth), None, (480, 640))
    with pytest.raises(CalibrationError, match="no depth camera"):
        check_fits(RgbdCalibration(color=calibration.color), (1024, 1280), (480, 640))
