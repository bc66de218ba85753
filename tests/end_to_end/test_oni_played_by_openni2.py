"""The real OpenNI2 plays the .oni files that we write, bit by bit."""

import subprocess
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest

from adibas.data.frames import EncodedImage, SensorFrame, SourceInfo
from adibas.recordings import RecordingOptions, create_recording, open_recording
from adibas.recordings.decoding import decode_color

N_FRAMES = 4
ATTEMPTS = 3
"""The player of OpenNI2 crashes now and then on a busy computer: the program ends by a signal."""
PROGRAM = Path(__file__).with_name("play_oni.py")


def play(path, stream, folder):
    out = folder / f"{stream}.npz"
    command = [sys.executable, str(PROGRAM), str(path), stream, str(out)]
    for _attempt in range(ATTEMPTS):
        done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)
        if done.returncode >= 0:
            break
    assert done.returncode == 0, done.stderr
    return np.load(out)


def record(path, info, *, encoding, top_depth, has_infrared=False):
    rng = np.random.default_rng(7)
    with create_recording(path, info, RecordingOptions(is_live=False)) as writer:
        for i in range(N_FRAMES):
            depth = rng.integers(0, top_depth, (480, 640), dtype=np.uint16)
            depth[:, :200] = 0
            depth[:, 200:300] = 1000 + i
            color = cv2.GaussianBlur(rng.integers(0, 256, (1024, 1280, 3), np.uint8), (0, 0), 4)
            if encoding == "jpeg":
                color = EncodedImage("jpeg", cv2.imencode(".jpg", color)[1].tobytes())
            infrared = depth[::2, ::2] // 64 if has_infrared else None
            time_ns = 5_000_000_000 + i * 33_333_333
            writer.write(SensorFrame(3 * i, time_ns, depth, color, time_ns + 8_000_000, infrared))
    return open_recording(path)


def assert_played(path, folder, reader, *, with_infrared=False):
    played = {name: play(path, name, folder) for name in ("depth", "color")}
    for stream in played.values():
        assert list(stream["numbers"]) == list(range(1, N_FRAMES + 1))
    for i, frame in enumerate(reader):
        np.testing.assert_array_equal(played["depth"]["images"][i], frame.depth_raw)
        ours = decode_color(frame.color, frame.sequence)
        np.testing.assert_array_equal(played["color"]["images"][i], ours)
        assert int(played["depth"]["times_us"][i]) == frame.timestamp_ns // 1000
        assert int(played["color"]["times_us"][i]) == frame.color_timestamp_ns // 1000
    if with_infrared:
        images = play(path, "ir", folder)["images"]
        for image, frame in zip(images, reader, strict=True):
            np.testing.assert_array_equal(image, frame.infrared_raw)
    return played


def test_compressed_depth_and_jpeg_in_two_sizes_come_out_as_they_went_in(tmp_path):
    path = tmp_path / "clinic.oni"
    info = SourceInfo(depth_unit_m=0.001)
    with record(path, info, encoding="jpeg", top_depth=9000, has_infrared=True) as reader:
        played = assert_played(path, tmp_path, reader, with_infrared=True)
    assert int(played["depth"]["format"]) == 100


def test_any_depth_value_in_tenths_of_a_millimetre_and_plain_colour_come_out(tmp_path):
    path = tmp_path / "clinic.oni"
    info = SourceInfo(depth_unit_m=0.0001)
    with record(path, info, encoding="rgb", top_depth=65536) as reader:
        played = assert_played(path, tmp_path, reader)
    assert int(played["depth"]["format"]) == 101


@pytest.mark.parametrize("stream", ["depth", "color"])
def test_one_stream_alone_is_played(tmp_path, stream):
    path = tmp_path / "alone.oni"
    image = np.arange(48 * 64, dtype=np.uint16).reshape(48, 64)
    color = np.repeat((image % 256).astype(np.uint8)[..., None], 3, axis=2)
    with create_recording(path, SourceInfo()) as writer:
        for i in range(N_FRAMES):
            time_ns = (i + 1) * 33_000_000
            if stream == "depth":
                writer.write(SensorFrame(i, time_ns, depth_raw=image + np.uint16(i)))
            else:
                shown = np.roll(color, i, axis=1)
                writer.write(SensorFrame(i, time_ns, color=shown, color_timestamp_ns=time_ns))
    images = play(path, stream, tmp_path)["images"]
    with open_recording(path) as reader:
        for played, frame in zip(images, reader, strict=True):
            ours = frame.depth_raw if stream == "depth" else frame.color
            np.testing.assert_array_equal(played, ours)
