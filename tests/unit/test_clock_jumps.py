"""Clocks that jump ahead are refused, for the gap would fill up; times that come again pass."""

from dataclasses import replace

import numpy as np
import pytest

from adibas.errors import LimbError, MarkerError, RecordingError
from adibas.pipeline import movement_frames
from adibas.pipeline.movement import MovementRequest, measure_moving
from adibas.pipeline.movement_markers import FrameMarkers
from adibas.pipeline.pose import PoseRequest, pose_recording
from adibas.recordings import create_recording
from tests.unit.recorded_frames import INFO, START_NS, make_frames, write_frames


@pytest.fixture
def jumping(tmp_path):
    """Two frames since the sensor began, then the time of day."""
    first, second, *rest = make_frames()
    early = [
        replace(
            frame,
            timestamp_ns=frame.timestamp_ns - START_NS,
            color_timestamp_ns=frame.color_timestamp_ns - START_NS,
        )
        for frame in (first, second)
    ]
    path = tmp_path / "jump.mcap"
    write_frames(create_recording(path, INFO), [*early, *rest])
    return path


def no_progress(_done, _total):
    pass


@pytest.mark.parametrize(
    "measure",
    [
        lambda path: pose_recording(PoseRequest(path), no_progress),
        lambda path: measure_moving(MovementRequest(path, "led"), no_progress),
    ],
    ids=["without markers", "of markers"],
)
def test_a_recording_whose_clock_jumps_a_day_ahead_is_refused_before_any_frame_is_looked_at(
    jumping, measure
):
    with pytest.raises(RecordingError, match=r"jump\.mcap: the frame after the one at 0.033 s"):
        measure(jumping)


def test_the_frames_before_a_jump_can_be_looked_at(jumping):
    with pytest.raises(LimbError, match="Nobody was found"):
        pose_recording(PoseRequest(jumping, frames=(0, 2)), no_progress)


def test_markers_are_not_looked_for_twice_in_frames_that_have_one_time(tmp_path, monkeypatch):
    first, second, third, *_rest = make_frames()
    path = tmp_path / "repeated.mcap"
    write_frames(create_recording(path, INFO), [first, second, second, first, third])
    looked_at = []
    monkeypatch.setattr(
        movement_frames,
        "markers_of_frame",
        lambda frame, *_: (
            looked_at.append(frame.timestamp_ns) or FrameMarkers(np.empty((0, 3))),
            None,
        ),
    )
    with pytest.raises(MarkerError, match="No marker was found"):
        measure_moving(MovementRequest(path, "led", view="anterior"), no_progress)
    assert sorted(looked_at) == [one.timestamp_ns for one in (first, second, third)]
