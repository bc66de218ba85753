"""`adibas record`: what its options ask of the sensor, and what it says at the end."""

import json

import numpy as np
import pytest

from adibas.cli import main
from adibas.data.frames import EncodedImage, SensorFrame, SourceInfo
from adibas.errors import SensorError
from adibas.recordings import RecordingOptions, create_recording, open_recording
from adibas.sensors import DepthCamera

PERIOD_NS = 33_333_333


def frame(sequence):
    rng = np.random.default_rng(sequence)
    return SensorFrame(
        sequence=sequence,
        timestamp_ns=sequence * PERIOD_NS,
        depth_raw=rng.integers(500, 5000, (24, 32), np.uint16),
        color=rng.integers(0, 256, (24, 32, 3), np.uint8),
        color_timestamp_ns=sequence * PERIOD_NS,
    )


class FakeSensor(DepthCamera):
    """A live sensor that gives a list of frames and errors."""

    info = SourceInfo(sensor_name="fake")
    is_live = True

    def __init__(self, given):
        self._given = iter(given)
        self.options = None
        self.is_closed = False

    def read(self, timeout_s=5.0):  # noqa: ARG002
        thing = next(self._given, None)
        if isinstance(thing, Exception):
            raise thing
        return thing

    def close(self):
        self.is_closed = True


@pytest.fixture
def plugged_in(monkeypatch):
    """Plug in a sensor that gives what it is told to."""

    def plug(given):
        sensor = FakeSensor(given)

        def open_source(_text, options):
            sensor.options = options
            return sensor

        monkeypatch.setattr("adibas.sensors.calibrated.open_source", open_source)
        return sensor

    return plug


def test_the_options_reach_the_sensor(plugged_in, tmp_path):
    sensor = plugged_in(map(frame, range(3)))
    argv = ["record", "openni2", "--out", str(tmp_path / "a.mcap"), "--color-size", "640x480"]
    assert main([*argv, "--registered", "--infrared"]) == 0
    assert sensor.options.color_size == (640, 480)
    assert sensor.options.is_depth_registered
    assert sensor.options.is_infrared
    assert sensor.is_closed


def test_without_options_the_colour_is_large_and_lossless(plugged_in, tmp_path):
    sensor = plugged_in(map(frame, range(3)))
    assert main(["record", "openni2", "--out", str(tmp_path / "a.mcap")]) == 0
    assert sensor.options.color_size == (1280, 1024)
    assert not sensor.options.is_depth_registered
    assert not sensor.options.is_infrared
    with open_recording(tmp_path / "a.mcap") as recording:
        assert recording.read(0).color.encoding == "png"


def test_jpeg_is_a_choice(plugged_in, tmp_path):
    plugged_in(map(frame, range(3)))
    assert main(["record", "openni2", "--jpeg", "--out", str(tmp_path / "a.mcap")]) == 0
    with open_recording(tmp_path / "a.mcap") as recording:
        color = recording.read(0).color
        assert isinstance(color, EncodedImage)
        assert color.encoding == "jpeg"


@pytest.mark.parametrize("option", [["--color-size", "640x480"], ["--registered"], ["--infrared"]])
def test_what_concerns_live_sensors_is_refused_for_others(option, tmp_path, capsys):
    out = tmp_path / "a.mcap"
    assert main(["record", "simulator", "--out", str(out), *option]) == 1
    assert "no live sensor" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("size", ["640", "640x", "0x480", "axb", "-1x3", "99999x99999", "640*480"])
def test_a_size_that_is_none_is_wrong_usage(size, tmp_path, capsys):
    with pytest.raises(SystemExit) as stopped:
        main(["record", "openni2", "--out", str(tmp_path / "a.mcap"), f"--color-size={size}"])
    assert stopped.value.code == 2
    assert "1280x1024" in capsys.readouterr().err


def test_dropped_frames_are_told_with_a_remedy(plugged_in, tmp_path, capsys):
    plugged_in(map(frame, (0, 1, 5, 6)))
    out = tmp_path / "a.mcap"
    assert main(["record", "openni2", "--out", str(out), "--json"]) == 0
    captured = capsys.readouterr()
    assert captured.err.startswith("3 frames were lost")
    assert "--jpeg" in captured.err
    assert json.loads(captured.out)["n_dropped"] == 3


def test_what_a_replayed_recording_lacks_is_not_blamed_on_the_cable(tmp_path, capsys):
    source, out = tmp_path / "a.mcap", tmp_path / "b.mcap"
    with create_recording(source, SourceInfo(), RecordingOptions()) as writer:
        for sequence in (0, 1, 5):
            writer.write(frame(sequence))
    assert main(["record", str(source), "--out", str(out)]) == 0
    assert capsys.readouterr().err == ""
    with open_recording(out) as recording:
        assert recording.info.n_dropped == 3


def test_an_unplugged_sensor_leaves_a_whole_recording(plugged_in, tmp_path, capsys):
    unplugged = SensorError("The sensor was unplugged. Plug it in again.")
    sensor = plugged_in([*map(frame, range(4)), unplugged])
    out = tmp_path / "a.mcap"
    assert main(["record", "openni2", "--out", str(out)]) == 1
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err == (
        "The sensor was unplugged. Plug it in again. The 4 frames that came before are kept in "
        f"{out}.\n"
    )
    assert sensor.is_closed
    with open_recording(out) as recording:
        assert len(recording) == 4
        assert recording.notice is None


def test_a_sensor_that_gives_nothing_leaves_no_file(plugged_in, tmp_path, capsys):
    plugged_in([SensorError("The sensor gave no frame. Plug it in anew.")])
    assert main(["record", "openni2", "--out", str(tmp_path / "a.mcap")]) == 1
    assert capsys.readouterr().err == "The sensor gave no frame. Plug it in anew.\n"
    assert list(tmp_path.iterdir()) == []


def test_a_recording_is_replaced_only_when_that_is_asked_for(plugged_in, tmp_path, capsys):
    out = tmp_path / "a.mcap"
    out.write_bytes(b"a session")
    argv = ["record", "openni2", "--out", str(out)]
    plugged_in(map(frame, range(3)))
    assert main(argv) == 1
    assert "--overwrite" in capsys.readouterr().err
    assert out.read_bytes() == b"a session"
    assert main([*argv, "--overwrite"]) == 0
    with open_recording(out) as recording:
        assert len(recording) == 3


def test_what_is_to_be_replaced_stays_when_nothing_comes(plugged_in, tmp_path):
    out = tmp_path / "a.mcap"
    out.write_bytes(b"a session")
    plugged_in([SensorError("The sensor gave no frame. Plug it in anew.")])
    assert main(["record", "openni2", "--out", str(out), "--overwrite"]) == 1
    assert [path.read_bytes() for path in tmp_path.iterdir()] == [b"a session"]


def test_a_recording_is_not_recorded_into_itself(tmp_path, capsys):
    path = tmp_path / "a.mcap"
    with create_recording(path, SourceInfo(), RecordingOptions()) as writer:
        writer.write(frame(0))
    before = path.read_bytes()
    assert main(["record", str(path), "--out", str(path), "--overwrite"]) == 1
    assert "into itself" in capsys.readouterr().err
    assert path.read_bytes() == before
