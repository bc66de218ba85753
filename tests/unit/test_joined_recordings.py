"""Recordings that follow one another are read as one, frame by frame."""

from dataclasses import replace

import numpy as np
import pytest

from adibas.data.calibration import CameraCalibration, DepthBias, RgbdCalibration
from adibas.errors import RecordingError
from adibas.geometry.pinhole import Intrinsics
from adibas.pipeline.joined_access import access_to, joined_access, joined_key
from adibas.pipeline.recording_access import FILES
from adibas.recordings.joined import SEAM_NS, JoinedRecording, begins_ns_of
from tests.unit.recorded_frames import INFO, make_frames

CAMERA = CameraCalibration(4, 4, Intrinsics(4.0, 4.0, 1.5, 1.5))


class Part:
    """A recording in memory."""

    def __init__(self, n_frames, info=INFO, notice=None):
        self.frames = make_frames(n_frames)
        self.info, self.notice = info, notice
        self.timestamps_ns = np.array([one.timestamp_ns for one in self.frames], np.int64)
        self.is_closed = False

    def __len__(self):
        return len(self.frames)

    def read(self, index):
        return self.frames[index]

    def close(self):
        self.is_closed = True


@pytest.fixture
def parts():
    return [Part(3), Part(5, replace(INFO, n_dropped=2), "cut"), Part(2, notice="short")]


@pytest.fixture
def joined(parts):
    return JoinedRecording(parts, ["a", "b", "c"])


def test_every_frame_of_every_part_is_there_in_order(joined, parts):
    frames = [frame for part in parts for frame in part.frames]
    assert len(joined) == len(frames) == 10
    for index, frame in enumerate(frames):
        found = joined.read(index)
        assert found.sequence == index
        assert found.depth_raw is frame.depth_raw
        assert found.timestamp_ns == joined.timestamps_ns[index]
        assert found.color_timestamp_ns - found.timestamp_ns == (
            frame.color_timestamp_ns - frame.timestamp_ns
        )
    for wrong in (-1, 10):
        with pytest.raises(IndexError):
            joined.read(wrong)


def test_times_go_on_with_a_second_between_two_parts(joined, parts):
    steps_ns = np.diff(joined.timestamps_ns)
    assert (steps_ns > 0).all()
    assert [int(step) for step in steps_ns[[2, 7]]] == [SEAM_NS, SEAM_NS]
    within_ns = np.diff(parts[1].timestamps_ns)
    np.testing.assert_array_equal(steps_ns[3:7], within_ns)
    assert begins_ns_of(joined) == tuple(int(joined.timestamps_ns[at]) for at in (0, 3, 8))
    assert begins_ns_of(parts[0]) == ()


def test_what_was_lost_of_each_part_is_told(joined, parts):
    assert joined.notice == "cut short"
    assert joined.info.n_dropped == sum(part.info.n_dropped for part in parts)
    joined.close()
    assert all(part.is_closed for part in parts)
    assert JoinedRecording([Part(1)], ["a"]).notice is None


@pytest.mark.parametrize(
    ("info", "n_frames", "words"),
    [
        (replace(INFO, sensor_serial="other"), 2, "another camera"),
        (replace(INFO, calibration=RgbdCalibration(depth=CAMERA)), 2, "another camera"),
        (replace(INFO, is_depth_registered=not INFO.is_depth_registered), 2, "another camera"),
        (INFO, 0, "no frames"),
    ],
)
def test_parts_that_do_not_belong_together_are_told(info, n_frames, words):
    with pytest.raises(RecordingError, match=f"b .*{words}"):
        JoinedRecording([Part(2), Part(n_frames, info)], ["a", "b"])


def test_another_correction_of_depth_is_another_camera():
    biased = RgbdCalibration(depth=CAMERA, depth_bias=DepthBias(a=0.01))
    parts = [
        Part(2, replace(INFO, calibration=one)) for one in (RgbdCalibration(depth=CAMERA), biased)
    ]
    with pytest.raises(RecordingError, match="calibrated anew"):
        JoinedRecording(parts, ["a", "b"])
    assert len(JoinedRecording([parts[1], parts[1]], ["a", "b"])) == 4


def test_every_part_is_closed_also_where_one_fails(parts, monkeypatch):
    def fail():
        raise RecordingError("{file} is gone.", file="b")

    joined = JoinedRecording(parts, ["a", "b", "c"])
    monkeypatch.setattr(parts[1], "close", fail)
    with pytest.raises(RecordingError, match="b is gone"):
        joined.close()
    assert [part.is_closed for part in parts] == [True, False, True]


def test_files_are_reached_as_one_and_closed_where_one_is_missing(tmp_path):
    opened = []

    def open_part(path):
        if path.name == "missing":
            raise RecordingError("{file} is missing.", file=path.name)
        opened.append(Part(2))
        return opened[-1]

    access = replace(FILES, open=open_part, sha256=lambda path: path.name)
    whole = joined_access([tmp_path / "a", tmp_path / "b"], access)
    with whole.open(tmp_path / "a") as reader:
        assert len(reader) == 4
    assert len(whole.sha256(tmp_path / "a")) == 64
    assert whole.sha256(tmp_path) != joined_access([tmp_path / "a"], access).sha256(tmp_path)
    with pytest.raises(RecordingError, match="missing"):
        joined_access([tmp_path / "a", tmp_path / "missing"], access).open(tmp_path)
    assert all(part.is_closed for part in opened)
    assert joined_key(["a", "b"]) != joined_key(["b", "a"])


def test_one_file_is_reached_as_ever_and_tables_are_not_joined(tmp_path):
    assert access_to([tmp_path / "a.csv"]) is FILES
    assert access_to([tmp_path / "a.mcap", tmp_path / "b.mcap"]) is not FILES
    with pytest.raises(RecordingError, match=r"b.csv is a table of joints"):
        access_to([tmp_path / "a.mcap", tmp_path / "b.csv"])
