"""A recording is a camera: the same frames, at the pace that is asked for."""

import numpy as np
import pytest

from adibas.data.frames import SensorFrame, SourceInfo
from adibas.errors import RecordingError
from adibas.recordings import create_recording
from adibas.sensors import SensorOptions, open_source
from adibas.sensors.pace import Pacer

PERIOD_NS = 20_000_000


@pytest.fixture
def recorded(tmp_path):
    rng = np.random.default_rng(2)
    frames = [
        SensorFrame(10 + i, 5 * PERIOD_NS + i * PERIOD_NS, rng.integers(0, 900, (6, 8), np.uint16))
        for i in range(8)
    ]
    path = tmp_path / "a.mcap"
    with create_recording(path, SourceInfo(sensor_serial="S1", frame_rate_hz=50.0)) as recording:
        for frame in frames:
            recording.write(frame)
    return path, frames


def test_a_recording_plays_bit_by_bit_and_ends(recorded):
    path, frames = recorded
    with open_source(str(path)) as camera:
        assert camera.info.sensor_serial == "S1"
        assert not camera.is_live
        for expected in frames:
            frame = camera.read()
            assert (frame.sequence, frame.timestamp_ns) == (
                expected.sequence,
                expected.timestamp_ns,
            )
            np.testing.assert_array_equal(frame.depth_raw, expected.depth_raw)
        assert camera.read() is None
        assert camera.read() is None


def test_what_is_no_recording_is_told(tmp_path):
    (tmp_path / "a.mcap").write_text("nothing of the kind")
    with pytest.raises(RecordingError, match="is no recording"):
        open_source(str(tmp_path / "a.mcap"))


class Clock:
    def __init__(self):
        self.now_s = 100.0
        self.slept_s = []

    def sleep(self, seconds):
        self.slept_s.append(seconds)
        self.now_s += seconds


def test_frames_come_when_they_are_due():
    clock = Clock()
    pacer = Pacer(lambda: clock.now_s, clock.sleep)
    for index in range(5):
        pacer.wait_for(7_000_000_000 + index * PERIOD_NS)
        assert clock.now_s == pytest.approx(100.0 + index * 0.02)


def test_a_slow_reader_catches_up_without_waiting():
    clock = Clock()
    pacer = Pacer(lambda: clock.now_s, clock.sleep)
    pacer.wait_for(0)
    clock.now_s += 0.05
    for index in (1, 2):
        pacer.wait_for(index * PERIOD_NS)
    assert clock.slept_s == []
    pacer.wait_for(3 * PERIOD_NS)
    assert clock.slept_s == [pytest.approx(0.01)]


@pytest.mark.parametrize("jump_ns", [10**12, -(10**12)])
def test_a_clock_that_jumps_does_not_stop_the_replay(jump_ns):
    clock = Clock()
    pacer = Pacer(lambda: clock.now_s, clock.sleep)
    pacer.wait_for(10**13)
    pacer.wait_for(10**13 + jump_ns)
    pacer.wait_for(10**13 + jump_ns + PERIOD_NS)
    assert clock.slept_s == [pytest.approx(0.02)]


def test_a_paced_recording_takes_the_time_that_it_took(recorded, monkeypatch):
    path, _ = recorded
    slept_s = []
    monkeypatch.setattr("adibas.sensors.replay.Pacer", lambda: Pacer(lambda: 0.0, slept_s.append))
    with open_source(str(path), SensorOptions(is_paced=True)) as camera:
        while camera.read() is not None:
            pass
    assert slept_s == pytest.approx([0.02 * i for i in range(1, 8)])
