"""Our own .oni reader and writer; tests/end_to_end plays the files with the real OpenNI2."""

import struct
from dataclasses import replace

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from adibas.calibration.files import write_calibration
from adibas.data.frames import SensorFrame, SourceInfo
from adibas.errors import RecordingError
from adibas.recordings import create_recording, open_recording
from adibas.recordings import oni_records as oni
from adibas.recordings.oni_codec import decode_16z, decode_16zt, encode_16zt
from adibas.recordings.reading import DamagedError
from tests.unit.recorded_frames import (
    INFO,
    assert_same_frame,
    assert_same_info,
    make_frames,
    write_frames,
)

values = st.sampled_from([0, 1, 500, 501, 900, 65535]) | st.integers(0, 65535)
images = arrays(np.uint16, st.tuples(st.integers(1, 8), st.integers(1, 40)), elements=values)
smooth = arrays(
    np.uint16, st.tuples(st.integers(1, 8), st.integers(1, 40)), elements=st.integers(800, 815)
)


@given(images | smooth)
def test_depth_survives_the_codec_bit_by_bit(depth):
    np.testing.assert_array_equal(decode_16zt(encode_16zt(depth), depth.shape), depth)


@given(st.binary(max_size=80), st.integers(0, 12), st.integers(0, 12))
def test_any_bytes_give_an_image_or_are_called_damaged(data, height, width):
    for decode in (decode_16zt, decode_16z):
        try:
            image = decode(data, (height, width))
        except DamagedError:
            continue
        assert image.shape == (height, width)


@given(smooth, st.data())
def test_a_cut_image_is_called_damaged(depth, data):
    encoded = encode_16zt(depth)
    with pytest.raises(DamagedError):
        decode_16zt(encoded[: data.draw(st.integers(0, len(encoded) - 1))], depth.shape)


def test_long_runs_end_where_they_should():
    for length in range(1, 70):
        depth = np.full((1, length + 3), 7, np.uint16)
        depth[0, -2:] = (8, 300)
        np.testing.assert_array_equal(decode_16zt(encode_16zt(depth), depth.shape), depth)


def test_the_bytes_of_the_codec_are_those_of_the_format():
    # 100 100 100 | 101 | 400: table 100 101 400; one pair without a step, one step alone, ...
    depth = np.array([[100, 100, 100, 101, 400]], np.uint16)
    table = struct.pack("<HHHH", 3, 100, 101, 400)
    assert encode_16zt(depth) == table + struct.pack("<H", 0) + bytes((0xE1, 0x55))


def test_an_older_codec_without_a_table_is_read():
    data = struct.pack("<H", 1000) + bytes((0xE2, 0xFF, 0x07, 0xD0, 0x5D))
    expected = [[1000, 1000, 1000, 1000, 1000, 2000, 2001]]
    np.testing.assert_array_equal(decode_16z(data, (1, 7)), np.array(expected, np.uint16))


@pytest.fixture
def recorded(tmp_path):
    frames = make_frames(6)
    write_frames(create_recording(tmp_path / "a.oni", INFO), frames)
    return tmp_path / "a.oni", frames


@pytest.mark.parametrize("share", [0.45, 0.7, 0.9, 0.999])
def test_a_cut_file_gives_every_whole_frame_and_says_what_was_lost(recorded, share):
    path, frames = recorded
    data = path.read_bytes()
    end_of_images = data.index(struct.pack("<II", oni.RECORD_MAGIC, oni.NODE_REMOVED))
    shortened = path.with_name("cut.oni")
    shortened.write_bytes(data[: int(end_of_images * share)])
    with open_recording(shortened) as reader:
        assert "cut.oni is cut" in reader.notice
        assert 0 < len(reader) < 6
        assert reader.info.depth_unit_m == INFO.depth_unit_m
        for got, want in zip(reader, frames, strict=False):
            np.testing.assert_array_equal(got.depth_raw, want.depth_raw)
            assert got.color == want.color
            assert got.timestamp_ns == want.timestamp_ns // 1000 * 1000


def test_a_file_without_our_table_is_paired_by_time(recorded):
    path, frames = recorded
    data = path.read_bytes()
    end = data.index(struct.pack("<IIII", oni.RECORD_MAGIC, oni.END, 0, 28)) + 28
    (path.with_name("b.oni")).write_bytes(data[:end])
    with open_recording(path.with_name("b.oni")) as reader:
        assert reader.notice is None
        assert [frame.sequence for frame in reader] == [1, 2, 3, 4, 5, 6]
        for got, want in zip(reader, frames, strict=True):
            np.testing.assert_array_equal(got.depth_raw, want.depth_raw)
            assert got.color == want.color


def test_mirrored_images_of_others_are_flipped_back(recorded):
    path, frames = recorded
    data = path.read_bytes()
    unmirrored, mirrored = (oni.text("xnMirror") + struct.pack("<IQ", 8, value) for value in (0, 1))
    assert data.count(unmirrored) == 2
    path.write_bytes(data.replace(unmirrored, mirrored))
    with open_recording(path) as reader:
        np.testing.assert_array_equal(reader.read(1).depth_raw, frames[1].depth_raw[:, ::-1])
        assert reader.read(1).color.shape == (48, 64, 3)


def test_images_that_change_their_size_are_refused(tmp_path):
    writer = create_recording(tmp_path / "a.oni", SourceInfo())
    writer.write(SensorFrame(0, 0, depth_raw=np.ones((4, 6), np.uint16)))
    with pytest.raises(RecordingError, match="the size of its images changes"):
        writer.write(SensorFrame(1, 1, depth_raw=np.ones((6, 4), np.uint16)))
    writer.close()
    with open_recording(tmp_path / "a.oni") as reader:
        assert len(reader) == 1


def test_colour_that_changes_from_jpeg_to_pixels_is_refused_rather_than_made_worse(tmp_path):
    writer = create_recording(tmp_path / "a.oni", INFO)
    writer.write(make_frames(1, "jpeg")[0])
    with pytest.raises(RecordingError, match="in part JPEG"):
        writer.write(make_frames(1, "array")[0])
    writer.abandon()


def test_too_many_values_after_the_first_image_are_refused(tmp_path):
    writer = create_recording(tmp_path / "a.oni", SourceInfo())
    writer.write(SensorFrame(0, 0, depth_raw=np.ones((256, 256), np.uint16)))
    every_value = np.arange(65536, dtype=np.uint16).reshape(256, 256)
    with pytest.raises(RecordingError, match="more than 32,768 different values"):
        writer.write(SensorFrame(1, 1, depth_raw=every_value))
    writer.abandon()


def test_a_damaged_image_is_named_and_the_others_are_read(recorded):
    path, frames = recorded
    data = bytearray(path.read_bytes())
    at = data.index(b"\xff\xd8\xff")  # the first JPEG; before it the first depth image
    data[at - 400 : at - 60] = bytes(340)
    path.write_bytes(data)
    with open_recording(path) as reader:
        with pytest.raises(RecordingError, match=r"Frame 0 of a.oni is damaged"):
            reader.read(0)
        assert_same_frame(reader.read(1), frames[1])


def test_gaps_are_counted_and_numbers_kept(recorded):
    path, frames = recorded
    with open_recording(path) as reader:
        assert reader.info.n_dropped == 3
        assert [frame.sequence for frame in reader] == [frame.sequence for frame in frames]


def test_the_calibration_survives_without_the_file_beside_it_and_that_file_comes_first(recorded):
    path, _ = recorded
    beside = path.with_name("a.calibration.json")
    other = replace(INFO.calibration, sensor_serial="other")
    write_calibration(beside, other)
    with open_recording(path) as reader:
        assert reader.info.calibration.sensor_serial == "other"
    beside.unlink()
    with open_recording(path) as reader:
        assert_same_info(reader.info, INFO)


def test_a_calibration_of_something_else_is_not_taken_for_ours(recorded):
    path, _ = recorded
    with pytest.raises(RecordingError, match=r"a.calibration.json would be taken for it"):
        create_recording(path, SourceInfo())


@pytest.mark.parametrize(
    ("pixel_format", "width", "to_rgb"),
    [
        (oni.GRAY8, 192, lambda raw: np.repeat(raw.reshape(48, 192, 1), 3, axis=2)),
        (
            oni.YUV422,
            96,
            lambda raw: cv2.cvtColor(raw.reshape(48, 96, 2), cv2.COLOR_YUV2RGB_UYVY),
        ),
        (oni.YUYV, 96, lambda raw: cv2.cvtColor(raw.reshape(48, 96, 2), cv2.COLOR_YUV2RGB_YUYV)),
    ],
)
def test_colour_of_other_recorders_becomes_rgb(tmp_path, pixel_format, width, to_rgb):
    path = tmp_path / "a.oni"
    frames = make_frames(2, "array")
    write_frames(create_recording(path, INFO), frames)
    ours = oni.int_property(2, "oniPixelFormat", oni.RGB888)
    size, new_size = (struct.pack("<III", w, 48, 30) for w in (64, width))
    data = path.read_bytes().replace(ours, oni.int_property(2, "oniPixelFormat", pixel_format))
    path.write_bytes(data.replace(size, new_size))
    with open_recording(path) as reader:
        for got, want in zip(reader, frames, strict=True):
            np.testing.assert_array_equal(got.color, to_rgb(want.color.ravel()))


def test_a_stream_of_an_unknown_codec_is_refused_frame_by_frame(recorded):
    path, _ = recorded
    path.write_bytes(path.read_bytes().replace(b"16zT", b"17zT").replace(b"JPEG", b"JPG2"))
    with open_recording(path) as reader, pytest.raises(RecordingError, match="Frame 0"):
        reader.read(0)


def test_a_file_of_an_older_layout_is_refused_in_words(recorded):
    path, _ = recorded
    data = bytearray(path.read_bytes())
    data[6] = 0
    path.write_bytes(data)
    with pytest.raises(RecordingError, match="cannot be read"):
        open_recording(path)
