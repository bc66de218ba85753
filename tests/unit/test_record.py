"""Recording: every frame that came is in the file, and what did not come is told."""

import errno
import signal
import subprocess
import sys
import threading
from pathlib import Path

import numpy as np
import pytest

from adibas.data.frames import SensorFrame, SourceInfo
from adibas.errors import RecordingError, SensorError
from adibas.pipeline.recording import QUEUE_FRAMES, record
from adibas.recordings import open_recording
from adibas.sensors import DepthCamera

PERIOD_NS = 33_333_333
PROJECT = Path(__file__).parents[2]


def frame(sequence, size=(24, 32)):
    rng = np.random.default_rng(sequence)
    return SensorFrame(
        sequence=sequence,
        timestamp_ns=1_000_000 + sequence * PERIOD_NS,
        depth_raw=rng.integers(0, 5000, size, np.uint16),
        color=rng.integers(0, 256, (*size, 3), np.uint8),
        color_timestamp_ns=1_000_000 + sequence * PERIOD_NS,
    )


class ListedCamera(DepthCamera):
    """Gives what it is told to: frames, errors, or None for the end; calls what can be called."""

    def __init__(self, given, *, is_live=True):
        self._given = iter(given)
        self._is_live = is_live

    @property
    def info(self):
        return SourceInfo(sensor_name="listed", frame_rate_hz=30.0)

    @property
    def is_live(self):
        return self._is_live

    def read(self, timeout_s=5.0):  # noqa: ARG002
        thing = next(self._given, None)
        if isinstance(thing, Exception):
            raise thing
        return thing() if callable(thing) else thing

    def close(self):
        pass


def test_every_frame_is_in_the_file_bit_by_bit(tmp_path):
    frames = [frame(i) for i in range(20)]
    summary = record(ListedCamera(frames), tmp_path / "a.mcap")
    with open_recording(summary.path) as recording:
        assert len(recording) == 20
        for expected, got in zip(frames, recording, strict=True):
            assert (got.sequence, got.timestamp_ns) == (expected.sequence, expected.timestamp_ns)
            np.testing.assert_array_equal(got.depth_raw, expected.depth_raw)
    assert (summary.n_frames, summary.n_dropped) == (20, 0)
    assert summary.seconds == pytest.approx(20 / 30, abs=1e-6)


def test_the_time_is_the_sensors_own(tmp_path):
    frames = [frame(i) for i in range(200)]
    summary = record(ListedCamera(frames, is_live=False), tmp_path / "a.mcap", seconds=2.0)
    assert summary.n_frames == 61, "frames 0 ... 60 lie within 2 s of the first one"


def test_a_clock_that_stands_still_does_not_record_for_ever(tmp_path):
    def still(index):
        threading.Event().wait(0.02)
        return SensorFrame(index, 5, np.ones((4, 4), np.uint16))

    camera = ListedCamera((lambda i=i: still(i)) for i in range(1000))
    assert 1 <= record(camera, tmp_path / "a.mcap", seconds=0.1).n_frames < 200


def test_frames_that_the_sensor_lost_are_counted(tmp_path):
    frames = [frame(i) for i in (3, 4, 7, 8, 12)]
    assert record(ListedCamera(frames), tmp_path / "a.mcap").n_dropped == 5


def test_a_live_sensor_that_is_too_fast_loses_frames_and_each_is_counted(tmp_path):
    n_given = 3 * QUEUE_FRAMES
    frames = [frame(i, (480, 640)) for i in range(n_given)]
    summary = record(ListedCamera(frames), tmp_path / "a.mcap")
    assert QUEUE_FRAMES <= summary.n_frames < n_given
    assert summary.n_frames + summary.n_dropped == n_given
    with open_recording(summary.path) as recording:
        assert recording.info.n_dropped == summary.n_dropped


def test_a_source_that_can_wait_loses_nothing(tmp_path):
    frames = [frame(i, (240, 320)) for i in range(2 * QUEUE_FRAMES)]
    summary = record(ListedCamera(frames, is_live=False), tmp_path / "a.mcap")
    assert (summary.n_frames, summary.n_dropped) == (2 * QUEUE_FRAMES, 0)


def test_an_unplugged_sensor_leaves_a_whole_recording_and_says_where(tmp_path):
    unplugged = SensorError("The sensor {sensor} was unplugged.", sensor="S")
    path = tmp_path / "a.mcap"
    with pytest.raises(SensorError) as told:
        record(ListedCamera([*map(frame, range(7)), unplugged]), path)
    assert str(told.value) == (
        f"The sensor S was unplugged. The 7 frames that came before are kept in {path}."
    )
    with open_recording(path) as recording:
        assert len(recording) == 7
        assert recording.notice is None


def test_without_a_single_frame_no_file_is_left(tmp_path):
    with pytest.raises(SensorError, match=r"^unplugged$"):
        record(ListedCamera([SensorError("unplugged")]), tmp_path / "a.mcap")
    with pytest.raises(SensorError, match="Nothing was recorded"):
        record(ListedCamera([]), tmp_path / "a.mcap")
    assert list(tmp_path.iterdir()) == []


def test_stopping_from_outside_finishes_the_file(tmp_path):
    stop = threading.Event()
    given = [frame(0), frame(1), lambda: (stop.set(), frame(2))[1], *map(frame, range(3, 50))]
    summary = record(ListedCamera(given, is_live=False), tmp_path / "a.mcap", stop=stop)
    assert summary.n_frames == 3


def test_a_bug_in_the_camera_is_not_taken_for_a_fault_of_the_world(tmp_path):
    with pytest.raises(ZeroDivisionError):
        record(ListedCamera([frame(0), ZeroDivisionError()]), tmp_path / "a.mcap")


def test_progress_is_told_with_what_is_expected(tmp_path):
    told = []
    record(
        ListedCamera([frame(i) for i in range(30)], is_live=False),
        tmp_path / "a.mcap",
        seconds=0.5,
        progress=lambda *numbers: told.append(numbers),
    )
    assert told[-1] == (16, 15)


FULL_DISK = """
import resource, sys
from pathlib import Path
from adibas.errors import RecordingError
from adibas.pipeline.recording import record
from tests.unit.test_record import ListedCamera, frame

resource.setrlimit(resource.RLIMIT_FSIZE, (400_000, 400_000))
try:
    record(ListedCamera([frame(i, (96, 128)) for i in range(60)], is_live=False), Path(sys.argv[1]))
except RecordingError as error:
    print(error)
"""

INTERRUPTED = """
import sys, threading
from pathlib import Path
from adibas.pipeline.recording import record
from tests.unit.test_record import ListedCamera, frame

def slow(index):
    threading.Event().wait(0.02)
    if index == 5:
        print("five", flush=True)
    return frame(index)

camera = ListedCamera((lambda i=i: slow(i)) for i in range(3000))
print(record(camera, Path(sys.argv[1])).n_frames)
"""


def python(script, path):
    return subprocess.Popen(
        [sys.executable, "-W", "error", "-c", script, str(path)],
        cwd=PROJECT,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def test_a_full_disk_keeps_what_was_written_and_says_where(tmp_path):
    with python(FULL_DISK, tmp_path / "a.mcap") as process:
        said, complaints = process.communicate(timeout=60)
    assert complaints == ""
    assert "the disk is full" in said
    (kept,) = tmp_path.iterdir()
    assert f"are in {kept.name}" in said
    with open_recording(kept) as recording:
        assert [f.sequence for f in recording] == list(range(len(recording)))
        assert len(recording) > 3


def test_a_disk_that_is_full_at_the_very_end_is_told_with_the_files_real_name(
    tmp_path, monkeypatch
):
    def full(_file):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr("adibas.recordings.part_file.PartFile.sync", full)
    with pytest.raises(RecordingError, match="the disk is full") as told:
        record(ListedCamera(map(frame, range(5))), tmp_path / "a.mcap")
    (kept,) = tmp_path.iterdir()
    assert kept.name == "a.part.mcap"
    assert f"are in {kept.name}." in str(told.value)
    with open_recording(kept) as recording:
        assert len(recording) == 5


def test_ctrl_c_finishes_the_file(tmp_path):
    with python(INTERRUPTED, tmp_path / "a.mcap") as process:
        assert process.stdout.readline() == "five\n"
        process.send_signal(signal.SIGINT)
        said, complaints = process.communicate(timeout=60)
    assert (process.returncode, complaints) == (0, "")
    with open_recording(tmp_path / "a.mcap") as recording:
        assert len(recording) == int(said) >= 5
        assert recording.notice is None
