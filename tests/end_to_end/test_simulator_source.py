"""The simulated clinic is a source like any sensor."""

import numpy as np
import pytest

from adibas.errors import SensorError
from adibas.pipeline.recording import record
from adibas.recordings import open_recording
from adibas.recordings.decoding import to_rgbd
from adibas.sensors import SensorOptions, open_source
from adibas.simulation.crowds import crowd_names, open_crowd
from adibas.simulation.scenes import open_scene, scene_names


def test_it_gives_the_frames_of_the_scene():
    name = scene_names()[0]
    scene = open_scene(name, seed=3)
    with open_source(f"simulator:{name}", SensorOptions(seed=3)) as camera:
        assert not camera.is_live
        assert camera.info.depth_unit_m == scene.info.depth_unit_m
        for index in range(2):
            frame = camera.read()
            expected = scene.frame(index).sensor_frame
            np.testing.assert_array_equal(frame.depth_raw, expected.depth_raw)
            assert frame.timestamp_ns == expected.timestamp_ns


def test_its_colour_has_the_wished_size():
    options = SensorOptions(color_size=(640, 480))
    with open_source("simulator", options) as camera:
        assert camera.read().color.shape == (480, 640, 3)
        assert camera.info.calibration.color.width == 640


def test_frames_rendered_side_by_side_are_those_of_one_after_the_other():
    options = SensorOptions(color_size=(640, 480), seed=4)
    scene = open_scene(scene_names()[0], seed=4, color_size=(480, 640))
    expected = [scene.frame(index).sensor_frame for index in range(6)]
    with open_source("simulator", options) as camera:
        for one in expected:
            frame = camera.read()
            assert (frame.sequence, frame.timestamp_ns) == (one.sequence, one.timestamp_ns)
            np.testing.assert_array_equal(frame.depth_raw, one.depth_raw)
            np.testing.assert_array_equal(frame.color, one.color)


def test_it_is_recorded_for_the_seconds_asked(tmp_path):
    with open_source("simulator") as camera:
        summary = record(camera, tmp_path / "a.mcap", seconds=0.1)
    assert summary.n_dropped == 0
    with open_recording(summary.path) as recording:
        assert len(recording) == summary.n_frames >= 3
        first = to_rgbd(recording.read(0), recording.info)
        assert recording.info.calibration is not None
    assert 0.5 < np.nanmedian(first.depth_m) < 8.0


def test_an_unknown_scene_lists_those_that_exist():
    with pytest.raises(SensorError) as told:
        open_source("simulator:moon")
    for name in (*scene_names(), *crowd_names()):
        assert name in str(told.value)


@pytest.mark.parametrize("name", crowd_names())
def test_several_people_and_furniture_are_recorded_in_depth_alone(tmp_path, name):
    with open_source(f"simulator:{name}", SensorOptions(seed=2)) as camera:
        summary = record(camera, tmp_path / f"{name}.mcap", seconds=0.1)
    scene = open_crowd(name, 2)
    with open_recording(summary.path) as recording:
        assert recording.info.calibration.floor is not None
        assert len(recording) >= 3
        for index in range(3):
            frame = recording.read(index)
            assert frame.color is None
            expected = scene.frame(index).sensor_frame
            np.testing.assert_array_equal(frame.depth_raw, expected.depth_raw)


def test_what_is_closed_while_it_is_read_says_so():
    camera = open_source("simulator", SensorOptions(color_size=(640, 480)))
    camera.read()
    camera.close()
    for _ in range(3):  # a frame may be whole already
        with pytest.raises(SensorError, match="is closed"):
            while camera.read() is not None:
                pass
