"""Recordings travel through every format without a change to what was measured."""

import json
from dataclasses import replace
from itertools import product

import numpy as np
import pytest

from adibas.data.frames import EncodedImage, SensorFrame, SourceInfo
from adibas.errors import AdibasError, RecordingError
from adibas.recordings import create_recording, open_recording
from adibas.recordings.convert import convert
from tests.unit.recorded_frames import (
    INFO,
    assert_same_frame,
    assert_same_info,
    make_frames,
    write_frames,
)

NAMES = {"mcap": "a.mcap", "oni": "a.oni", "tum": "a"}


def record(path, frames, info=INFO):
    write_frames(create_recording(path, info), frames)
    return path


def assert_holds(path, frames, info=INFO, n_dropped=3):
    with open_recording(path) as reader:
        assert len(reader) == len(frames)
        assert reader.notice is None
        assert reader.info.n_dropped == n_dropped
        assert_same_info(reader.info, info)
        assert list(reader.timestamps_ns) == [frame.timestamp_ns for frame in frames]
        for got, want in zip(reader, frames, strict=True):
            assert_same_frame(got, want)


@pytest.mark.parametrize(("source", "target"), [*product(NAMES, NAMES)])
def test_a_whole_recording_arrives_in_the_other_format(tmp_path, source, target):
    frames = make_frames(infrared=True)
    path = record(tmp_path / "source" / NAMES[source], frames)
    summary = convert(path, tmp_path / "target" / NAMES[target])
    assert (summary.n_frames, summary.n_dropped, summary.notice) == (5, 3, None)
    assert_holds(tmp_path / "target" / NAMES[target], frames)


@pytest.mark.parametrize("target", NAMES)
def test_jpeg_colour_keeps_its_bytes(tmp_path, target):
    frames = make_frames()
    convert(record(tmp_path / "s.mcap", frames), tmp_path / "t" / NAMES[target])
    with open_recording(tmp_path / "t" / NAMES[target]) as reader:
        assert [frame.color.payload for frame in reader] == [f.color.payload for f in frames]


@pytest.mark.parametrize(("target", "encoding"), [*product(NAMES, ["array", "png"])])
def test_lossless_colour_stays_lossless(tmp_path, target, encoding):
    frames = make_frames(encoding=encoding)
    convert(record(tmp_path / "s.mcap", frames), tmp_path / "t" / NAMES[target])
    assert_holds(tmp_path / "t" / NAMES[target], frames)


@pytest.mark.parametrize(("target", "has_depth"), [*product(NAMES, [True, False])])
def test_depth_alone_and_colour_alone_arrive(tmp_path, target, has_depth):
    frames = make_frames(depth=has_depth, color=not has_depth)
    convert(record(tmp_path / "s.mcap", frames), tmp_path / "t" / NAMES[target])
    assert_holds(tmp_path / "t" / NAMES[target], frames)


@pytest.mark.parametrize("target", NAMES)
def test_a_stream_that_begins_late_and_stops_early_arrives(tmp_path, target):
    frames = make_frames(6)
    frames[0] = replace(frames[0], color=None, color_timestamp_ns=None)
    frames[5] = replace(frames[5], depth_raw=None)
    convert(record(tmp_path / "s.mcap", frames), tmp_path / "t" / NAMES[target])
    assert_holds(tmp_path / "t" / NAMES[target], frames)


def test_a_plain_mcap_holds_the_same_depth(tmp_path):
    frames = make_frames()
    convert(record(tmp_path / "s.mcap", frames), tmp_path / "plain.mcap", plain=True)
    assert_holds(tmp_path / "plain.mcap", frames)


def test_a_unit_that_oni_cannot_hold_is_refused_in_words(tmp_path):
    info = SourceInfo(depth_unit_m=1 / 5000)
    path = record(tmp_path / "s.mcap", make_frames(), info)
    with pytest.raises(RecordingError, match=r"its unit of depth is 0.2 mm.*Choose .mcap"):
        convert(path, tmp_path / "t.oni")
    assert [item.name for item in tmp_path.iterdir()] == ["s.mcap"]


def test_any_unit_travels_to_mcap_and_tum(tmp_path):
    info = SourceInfo(depth_unit_m=1 / 5000)
    frames = make_frames()
    convert(record(tmp_path / "s.mcap", frames, info), tmp_path / "tum")
    convert(tmp_path / "tum", tmp_path / "t.mcap")
    assert_holds(tmp_path / "t.mcap", frames, info)


@pytest.mark.parametrize("top", [32768, 65536])
def test_oni_holds_depth_with_as_many_values_as_there_are(tmp_path, top):
    values = np.random.default_rng(2).permutation(top).astype(np.uint16).reshape(256, -1)
    frames = [SensorFrame(i, i, depth_raw=values.copy()) for i in range(2)]
    path = record(tmp_path / "s.mcap", frames, SourceInfo())
    convert(path, tmp_path / "t.oni")
    assert_holds(tmp_path / "t.oni", frames, SourceInfo(), n_dropped=0)


def test_plain_is_refused_where_it_means_nothing(tmp_path):
    path = record(tmp_path / "s.mcap", make_frames())
    with pytest.raises(RecordingError, match="cannot be plain"):
        convert(path, tmp_path / "t.oni", plain=True)


@pytest.mark.parametrize("name", NAMES.values())
def test_a_recording_is_not_converted_into_itself(tmp_path, name):
    path = record(tmp_path / name, make_frames())
    with pytest.raises(RecordingError, match="into itself"):
        convert(path, path)
    assert_holds(path, make_frames())


def test_an_unknown_ending_is_refused(tmp_path):
    path = record(tmp_path / "s.mcap", make_frames())
    with pytest.raises(RecordingError, match=r"t.avi cannot be written"):
        convert(path, tmp_path / "t.avi")


@pytest.mark.parametrize("name", ["nothing.mcap", "text.oni", "empty"])
def test_what_is_no_recording_is_refused_in_one_sentence(tmp_path, name):
    (tmp_path / "text.oni").write_text("hello")
    (tmp_path / "empty").mkdir()
    with pytest.raises(RecordingError, match=f"{name} (cannot be read|is no recording)"):
        open_recording(tmp_path / name)


def test_progress_is_told_after_every_frame(tmp_path):
    told = []
    path = record(tmp_path / "s.mcap", make_frames(3))
    convert(path, tmp_path / "tum", progress=lambda done, total: told.append((done, total)))
    assert told == [(1, 3), (2, 3), (3, 3)]


@pytest.mark.parametrize("target", NAMES.values())
def test_a_damaged_source_leaves_no_target(tmp_path, target):
    source = record(tmp_path / "s" / "a", make_frames())
    (source / "depth" / "000003.png").write_bytes(b"no picture")
    with pytest.raises(AdibasError, match="Frame 3 of a is damaged"):
        convert(source, tmp_path / "t" / target)
    assert list((tmp_path / "t").iterdir()) == []


def test_a_calibration_beside_an_oni_file_is_the_documented_json(tmp_path):
    record(tmp_path / "clinic.oni", make_frames())
    written = json.loads((tmp_path / "clinic.calibration.json").read_text())
    assert written["format"] == "adibas-calibration"
    assert written["color"]["fx"] == INFO.calibration.color.intrinsics.fx


def test_dropped_frames_are_counted_from_gaps_and_from_what_the_sensor_said(tmp_path):
    for name in NAMES.values():
        with create_recording(tmp_path / name, SourceInfo()) as writer:
            for frame in make_frames():
                writer.write(frame)
            writer.count_dropped(4)
            assert writer.n_dropped == 7
        with open_recording(tmp_path / name) as reader:
            assert reader.info.n_dropped == 7


def test_an_encoded_image_is_written_as_it_came(tmp_path):
    image = EncodedImage("png", make_frames(1, "png")[0].color.payload)
    frame = SensorFrame(0, 5, color=image, color_timestamp_ns=6)
    for name in ("a.mcap", "a"):
        with create_recording(tmp_path / name, SourceInfo()) as writer:
            writer.write(frame)
        with open_recording(tmp_path / name) as reader:
            assert reader.read(0).color == image
