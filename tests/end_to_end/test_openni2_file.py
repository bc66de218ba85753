"""The real OpenNI2 plays the .oni files that we write, and our reader agrees with it."""

import numpy as np
import pytest

from adibas.data.frames import SensorFrame, SourceInfo
from adibas.errors import SensorError
from adibas.recordings import create_recording, open_recording
from adibas.sensors import open_source
from adibas.sensors.openni2 import OpenNI2Camera
from adibas.sensors.openni2_modes import list_sensors

N_FRAMES = 12
PERIOD_US = 33_333


def make_frames(depth_size, color_size):
    """Return frames with smooth and rough depth, holes, and random colour."""
    rng = np.random.default_rng(11)
    height, width = depth_size
    ramp = (1000 + np.arange(width) * 3)[None, :] + np.arange(height)[:, None]
    frames = []
    for i in range(N_FRAMES):
        depth = (ramp + rng.integers(0, 1 + 700 * (i % 3), depth_size)).astype(np.uint16)
        depth[rng.random(depth_size) < 0.1] = 0
        time_ns = (1_000_000 + i * PERIOD_US) * 1000
        color = None if color_size is None else rng.integers(0, 256, (*color_size, 3), np.uint8)
        frames.append(
            SensorFrame(
                sequence=i + 1,
                timestamp_ns=time_ns,
                depth_raw=depth,
                color=color,
                color_timestamp_ns=None if color is None else time_ns + 2_000_000,
            )
        )
    return frames


def write(path, frames, info=SourceInfo()):  # noqa: B008  # frozen
    with create_recording(path, info) as recording:
        for frame in frames:
            recording.write(frame)


def play(path):
    with open_source(f"openni2:{path}") as camera:
        frames = []
        while (frame := camera.read(10.0)) is not None:
            frames.append(frame)
        return frames, camera.info


def assert_same(got, expected):
    assert len(got) == len(expected)
    for one, other in zip(got, expected, strict=True):
        np.testing.assert_array_equal(one.depth_raw, other.depth_raw)
        assert (one.color is None) == (other.color is None)
        if one.color is not None:
            np.testing.assert_array_equal(one.color, other.color)
        assert one.sequence == other.sequence
        assert one.timestamp_ns == other.timestamp_ns
        assert one.color_timestamp_ns == other.color_timestamp_ns


@pytest.mark.parametrize(
    ("depth_size", "color_size"),
    [((480, 640), (480, 640)), ((480, 640), (1024, 1280)), ((240, 320), None)],
)
def test_openni2_plays_what_we_wrote_bit_by_bit_and_our_reader_agrees(
    tmp_path, depth_size, color_size
):
    written = make_frames(depth_size, color_size)
    path = tmp_path / "ours.oni"
    write(path, written)
    played, info = play(path)
    assert_same(played, written)
    with open_recording(path) as recording:
        assert_same(list(recording), played)
    assert (info.depth_unit_m, info.frame_rate_hz) == (0.001, 30.0)


def test_tenths_of_a_millimetre_stay_tenths(tmp_path):
    written = make_frames((240, 320), (240, 320))
    write(tmp_path / "a.oni", written, SourceInfo(depth_unit_m=0.0001))
    played, info = play(tmp_path / "a.oni")
    assert info.depth_unit_m == 0.0001
    assert_same(played, written)


def test_the_end_is_the_end_and_a_file_opens_again(tmp_path):
    write(tmp_path / "a.oni", make_frames((240, 320), (240, 320)))
    camera = open_source(f"openni2:{tmp_path / 'a.oni'}")
    assert not camera.is_live
    while camera.read(10.0) is not None:
        pass
    assert camera.read(10.0) is None
    camera.close()
    camera.close()
    assert len(play(tmp_path / "a.oni")[0]) == N_FRAMES


def test_two_files_play_side_by_side(tmp_path):
    frames = make_frames((240, 320), (240, 320))
    write(tmp_path / "a.oni", frames)
    write(tmp_path / "b.oni", frames[::-1])
    with (
        OpenNI2Camera(tmp_path / "a.oni") as first,
        OpenNI2Camera(tmp_path / "b.oni") as second,
    ):
        np.testing.assert_array_equal(first.read(10.0).depth_raw, frames[0].depth_raw)
        np.testing.assert_array_equal(second.read(10.0).depth_raw, frames[-1].depth_raw)
        np.testing.assert_array_equal(first.read(10.0).depth_raw, frames[1].depth_raw)


def test_a_file_that_is_none_is_told_in_one_sentence(tmp_path):
    (tmp_path / "text.oni").write_text("no recording")
    with pytest.raises(SensorError, match=r"^text\.oni is no OpenNI2 recording"):
        open_source(f"openni2:{tmp_path / 'text.oni'}")
    with pytest.raises(SensorError, match=r"^none\.oni cannot be read"):
        open_source(f"openni2:{tmp_path / 'none.oni'}")


def test_a_file_cut_by_a_crash_plays_to_its_last_whole_image(tmp_path):
    frames = make_frames((240, 320), (240, 320))
    recording = create_recording(tmp_path / "a.oni", SourceInfo())
    for frame in frames:
        recording.write(frame)
    (part,) = tmp_path.iterdir()
    cut = tmp_path / "cut.oni"
    cut.write_bytes(part.read_bytes()[:-1000])
    recording.abandon()
    with OpenNI2Camera(cut) as camera:
        played = []
        while (frame := camera.read(1.0)) is not None:
            played.append(frame)
    assert_same(played, frames[: len(played)])
    assert len(played) >= N_FRAMES - 1


def test_a_file_with_less_than_it_promises_is_told(tmp_path):
    write(tmp_path / "a.oni", make_frames((240, 320), (240, 320)))
    whole = (tmp_path / "a.oni").read_bytes()
    (tmp_path / "half.oni").write_bytes(whole[: len(whole) // 2])
    with (
        OpenNI2Camera(tmp_path / "half.oni") as camera,
        pytest.raises(SensorError, match=r"^half\.oni is damaged: 1\d of its images are not found"),
    ):
        while camera.read(0.5) is not None:
            pass


def test_a_file_that_was_played_is_no_sensor(tmp_path):
    write(tmp_path / "a.oni", make_frames((240, 320), None))
    with OpenNI2Camera(tmp_path / "a.oni") as camera:
        assert camera.read() is not None
        assert list_sensors() == ()
    assert list_sensors() == ()
    with pytest.raises(SensorError, match="finds no sensor"):
        OpenNI2Camera()
