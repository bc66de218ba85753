"""Joints of a recording whose clock jumps a day ahead are not asked for: the gap would fill up."""

from dataclasses import replace

import pytest

from adibas.errors import LimbError, RecordingError
from adibas.pipeline.movement import MovementRequest, measure_moving
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
