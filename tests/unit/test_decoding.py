"""Frames in metres and RGB, and colour images that are not what they say."""

import resource
import struct
import zlib

import cv2
import numpy as np
import pytest

from adibas.data.frames import EncodedImage, SensorFrame, SourceInfo
from adibas.errors import RecordingError
from adibas.recordings.decoding import decode_color, encoded_size, to_rgbd

COLOR = cv2.GaussianBlur(
    np.random.default_rng(3).integers(0, 256, (12, 20, 3), dtype=np.uint8), (0, 0), 1
)
BGR = cv2.cvtColor(COLOR, cv2.COLOR_RGB2BGR)
PNG = cv2.imencode(".png", BGR)[1].tobytes()
JPEG = cv2.imencode(".jpg", BGR, [cv2.IMWRITE_JPEG_QUALITY, 100])[1].tobytes()


def frame(color, depth=None):
    depth = np.array([[0, 1000]], np.uint16) if depth is None else depth
    return SensorFrame(17, 5, depth_raw=depth, color=color, color_timestamp_ns=6)


def test_depth_becomes_metres_and_no_reading_becomes_nan():
    rgbd = to_rgbd(frame(COLOR), SourceInfo(depth_unit_m=0.0001))
    np.testing.assert_allclose(rgbd.depth_m, np.array([[np.nan, 0.1]]), rtol=1e-6)
    assert (rgbd.sequence, rgbd.timestamp_ns) == (17, 5)
    assert rgbd.color_rgb is COLOR


def test_png_is_exact_and_jpeg_close_and_both_are_rgb():
    np.testing.assert_array_equal(decode_color(EncodedImage("png", PNG), 0), COLOR)
    orange = np.full((16, 16, 3), (250, 130, 10), np.uint8)
    payload = cv2.imencode(".jpg", cv2.cvtColor(orange, cv2.COLOR_RGB2BGR))[1].tobytes()
    difference = decode_color(EncodedImage("jpeg", payload), 0).astype(int) - orange
    assert np.abs(difference).max() <= 3


@pytest.mark.parametrize("kind", ["grey", "alpha", "deep"])
def test_other_kinds_of_png_become_eight_bit_rgb(kind):
    images = {"grey": BGR[..., 0], "alpha": np.dstack([BGR, BGR[..., :1]])}
    image = images.get(kind, BGR.astype(np.uint16) * 257)
    payload = cv2.imencode(".png", image)[1].tobytes()
    color = decode_color(EncodedImage("png", payload), 0)
    assert color.shape == COLOR.shape
    assert color.dtype == np.uint8
    expected = np.repeat(BGR[..., :1], 3, axis=2) if kind == "grey" else COLOR
    np.testing.assert_array_equal(color, expected)


@pytest.mark.parametrize("missing", ["depth", "colour"])
def test_a_frame_without_depth_or_colour_is_refused_in_one_sentence(missing):
    half = SensorFrame(17, 5, depth_raw=np.ones((1, 2), np.uint16))
    if missing == "depth":
        half = SensorFrame(17, 5, color=COLOR, color_timestamp_ns=5)
    with pytest.raises(RecordingError, match=f"Frame 17 has no {missing}"):
        to_rgbd(half, SourceInfo())


@pytest.mark.parametrize("payload", [b"", b"nothing", PNG[:60], PNG[:-5], JPEG[:-30], JPEG[:300]])
def test_a_damaged_colour_image_is_refused_with_its_frame(payload, capfd):
    with pytest.raises(RecordingError, match="colour image of frame 17 is damaged"):
        to_rgbd(frame(EncodedImage("jpeg", payload)), SourceInfo())
    capfd.readouterr()  # the decoder grumbles


def test_a_huge_image_is_refused_by_its_head():
    png = bytearray(PNG)
    png[16:24] = struct.pack(">II", 60_000, 60_000)
    with pytest.raises(RecordingError, match="damaged or too large"):
        decode_color(EncodedImage("png", bytes(png)), 3)
    start = JPEG.index(b"\xff\xc0")
    jpeg = bytearray(JPEG)
    jpeg[start + 5 : start + 9] = struct.pack(">HH", 65_000, 65_000)
    with pytest.raises(RecordingError, match="damaged or too large"):
        decode_color(EncodedImage("jpeg", bytes(jpeg)), 3)


def test_a_part_that_claims_gigabytes_is_refused_before_memory_is_taken():
    at = PNG.index(b"IDAT") - 4
    bomb = PNG[:at] + (2**31 - 1).to_bytes(4, "big") + PNG[at + 4 :]
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    with pytest.raises(RecordingError, match="damaged or too large"):
        decode_color(EncodedImage("png", bomb), 3)
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 100_000


def test_an_animation_is_refused():
    part = b"acTL" + struct.pack(">II", 2, 0)
    part = struct.pack(">I", 8) + part + zlib.crc32(part).to_bytes(4, "big")
    with pytest.raises(RecordingError, match="damaged or too large"):
        decode_color(EncodedImage("png", PNG[:33] + part + PNG[33:]), 3)


def test_a_few_bytes_cannot_ask_for_millions_of_pixels():
    head = struct.pack(">IIBBBBB", 7000, 7000, 8, 2, 0, 0, 0)
    crc = zlib.crc32(b"IHDR" + head).to_bytes(4, "big")
    with pytest.raises(RecordingError, match="damaged or too large"):
        decode_color(EncodedImage("png", PNG[:16] + head + crc + PNG[33:]), 3)


@pytest.mark.parametrize("payload", [PNG, JPEG])
def test_the_size_is_known_without_decoding(payload):
    assert encoded_size(payload) == (12, 20)
