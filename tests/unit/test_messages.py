"""Foxglove messages byte by byte as Foxglove's own protobuf package writes them."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from adibas.data.calibration import CameraCalibration
from adibas.data.frames import EncodedImage
from adibas.errors import RecordingError
from adibas.geometry.pinhole import Intrinsics
from adibas.recordings.messages import (
    RVL_IMAGE,
    Stamp,
    camera_calibration,
    compressed_image,
    raw_image,
    read_color,
    read_depth,
    rvl_image,
)
from adibas.recordings.protobuf import decode_message

TIME_NS = 1_700_000_000_123_456_789

# Written by foxglove-schemas-protobuf 0.4.0 for the values in the tests.
COMPRESSED_IMAGE_BYTES = bytes.fromhex(
    "0a0b0880e2cfaa0610959aef3a1202ffd81a046a7065672205636f6c6f72"
)
RAW_IMAGE_BYTES = bytes.fromhex(
    "0a0b0880e2cfaa0610959aef3a15020000001d01000000220531365543312d040000003204010203043a0564"
    "65707468"
)
CAMERA_CALIBRATION_BYTES = bytes.fromhex(
    "0a0b0880e2cfaa0610959aef3a15800200001de00100002209706c756d625f626f622a289a9999999999b93f"
    "9a9999999999c9bf333333333333d33f9a9999999999d93f000000000000e03f32480000000000407f400000"
    "000000000000000000000000744000000000000000000000000000507f400000000000006e40000000000000"
    "00000000000000000000000000000000f03f3a48000000000000f03f00000000000000000000000000000000"
    "0000000000000000000000000000f03f00000000000000000000000000000000000000000000000000000000"
    "0000f03f42600000000000407f40000000000000000000000000000074400000000000000000000000000000"
    "00000000000000507f400000000000006e400000000000000000000000000000000000000000000000000000"
    "00000000f03f00000000000000004a056465707468"
)


def test_a_compressed_image_is_the_same_to_the_byte():
    stamp = Stamp(TIME_NS, "color", 5)
    assert compressed_image(EncodedImage("jpeg", b"\xff\xd8"), stamp) == COMPRESSED_IMAGE_BYTES
    assert read_color(COMPRESSED_IMAGE_BYTES) == EncodedImage("jpeg", b"\xff\xd8")


def test_a_raw_image_is_the_same_to_the_byte():
    image = np.array([[0x0201, 0x0403]], np.uint16)
    assert raw_image(image, Stamp(TIME_NS, "depth", 5)) == RAW_IMAGE_BYTES
    np.testing.assert_array_equal(read_depth("foxglove.RawImage", RAW_IMAGE_BYTES), image)


def test_a_camera_calibration_is_the_same_to_the_byte():
    camera = CameraCalibration(640, 480, Intrinsics(500, 501, 320, 240), (0.1, -0.2, 0.3, 0.4, 0.5))
    written = camera_calibration(camera, Stamp(TIME_NS, "depth", 5))
    assert written == CAMERA_CALIBRATION_BYTES


def test_eight_and_more_terms_of_distortion_are_the_rational_model():
    terms = tuple(float(i) for i in range(1, 13))
    written = []
    for n_terms in (8, 12):
        camera = CameraCalibration(640, 480, Intrinsics(500, 501, 320, 240), terms[:n_terms])
        written.append(camera_calibration(camera, Stamp(TIME_NS, "depth", 5)))
    assert b"rational_polynomial" in written[0]
    assert np.array(terms[:8]).tobytes() in written[0]
    assert written[0] == written[1]


@given(st.integers(0, 2**63 - 1), st.integers(0, 2**64 - 1), st.floats(0, 1))
def test_our_own_message_keeps_every_field(time_ns, sequence, unit_m):
    image = np.array([[1, 0, 65535]], np.uint16)
    written = rvl_image(image, unit_m, Stamp(time_ns, "depth", sequence))
    values = decode_message(RVL_IMAGE, written)
    assert (values["timestamp"], values["sequence"]) == (time_ns, sequence)
    assert (values["width"], values["height"], values["unit_m"]) == (3, 1, unit_m)
    assert values["frame_id"] == "depth"
    np.testing.assert_array_equal(read_depth("adibas.RvlImage", written), image)


@given(st.binary(max_size=60))
def test_any_bytes_are_an_image_or_refused(data):
    try:
        image = read_depth("adibas.RvlImage", data)
    except (RecordingError, ValueError):
        return
    assert image.dtype == np.uint16


def test_a_raw_image_whose_sizes_differ_is_refused():
    with pytest.raises(RecordingError):
        read_depth("foxglove.RawImage", RAW_IMAGE_BYTES.replace(b"\x15\x02", b"\x15\x03"))
