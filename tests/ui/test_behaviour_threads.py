"""Frames and drafts go through threads of their own, and nothing of them is lost or mixed up."""

from itertools import pairwise

import numpy as np
import pytest

from adibas.behaviour.editing import Draft, History
from adibas.data.coding import Occurrence
from adibas.data.frames import SensorFrame
from adibas.errors import FileError, RecordingError
from adibas.pipeline.coding_drafts import BesideRecording, read_draft
from adibas.recordings import open_recording
from tests.ui.behaviour_scene import INFO, make_recording
from tests.unit.coding_samples import coding
from ui.behaviour.content import Bar, Timeline
from ui.behaviour.frame_feed import QtFrameFeed, picture_of
from ui.behaviour.keeping import DraftKeeper
from ui.behaviour.timeline_painter import bars_to_paint
from ui.behaviour.timeline_scale import TimeScale


@pytest.fixture
def feed():
    made = QtFrameFeed()
    made.told = []
    made.arrived.subscribe(lambda index, picture: made.told.append((index, picture)))
    made.failed.subscribe(lambda index, error: made.told.append((index, error)))
    yield made
    made.close()


def test_the_frame_that_was_asked_for_last_arrives(feed, qtbot, tmp_path):
    feed.show(open_recording(make_recording(tmp_path / "a.mcap")))
    for index in range(50):
        feed.ask(index)
    qtbot.waitUntil(lambda: [index for index, _picture in feed.told][-1:] == [49])
    assert all(int(picture[0, 0, 0]) == index for index, picture in feed.told)


def test_nothing_arrives_of_a_recording_that_was_left(feed, qtbot, tmp_path):
    feed.show(open_recording(make_recording(tmp_path / "a.mcap", 5)))
    feed.ask(4)
    feed.show(open_recording(make_recording(tmp_path / "b.mcap", 3)))
    feed.ask(2)
    qtbot.waitUntil(lambda: bool(feed.told))
    assert [index for index, _picture in feed.told] == [2]


def test_a_frame_that_cannot_be_read_is_told(feed, qtbot):
    class Broken:
        info, notice = INFO, None

        def __enter__(self):
            return self

        def __exit__(self, *_error):
            pass

        def read(self, index):
            raise RecordingError("Frame {index} is damaged.", index=index)

    feed.show(Broken())
    feed.ask(3)
    qtbot.waitUntil(lambda: bool(feed.told))
    index, error = feed.told[0]
    assert (index, str(error)) == (3, "Frame 3 is damaged.")


def test_without_a_recording_nobody_is_asked(feed):
    feed.ask(1)
    assert feed.told == []


def test_a_frame_without_colour_and_depth_has_no_picture():
    infrared = np.zeros((4, 4), np.uint16)
    frame = SensorFrame(sequence=7, timestamp_ns=1, infrared_raw=infrared)
    with pytest.raises(RecordingError, match="Frame 7 holds no picture"):
        picture_of(frame, INFO)


def test_the_newest_draft_is_written(tmp_path):
    place, failures = BesideRecording(tmp_path / "a.mcap"), []
    keeper = DraftKeeper(failures.append)
    for second in range(2, 30):
        keeper.keep(place, History(Draft(coding(("seated", 1, second)))), 0)
    keeper.flush()
    assert read_draft(place).coding.occurrences[0].end_ms == 29_000
    keeper.keep(place, History(Draft(coding(("seated", 1, 40)))), 0)
    keeper.close()
    assert read_draft(place).coding.occurrences[0].end_ms == 40_000
    assert failures == []


def test_a_draft_that_cannot_be_written_is_told(tmp_path):
    (tmp_path / "file").write_text("")
    failures = []
    keeper = DraftKeeper(failures.append)
    keeper.keep(BesideRecording(tmp_path / "file" / "a.mcap"), History(Draft(coding())), 0)
    keeper.close()
    assert isinstance(failures[0], FileError)


WHOLE = TimeScale(left_px=100, width_px=600).of_session(5000, 65_000)


def test_a_time_and_its_place_are_each_other():
    for time_ms in (5000, 17_000, 65_000):
        assert WHOLE.ms_at(WHOLE.x_of(time_ms)) == time_ms
    assert WHOLE.ms_at(-50) == 5000
    assert WHOLE.ms_at(9000) == 65_000


def test_zooming_keeps_the_time_under_the_mouse_and_stays_in_the_session():
    near = WHOLE.zoomed(4.0, 35_000)
    assert near.x_of(35_000) == WHOLE.x_of(35_000)
    assert near.to_ms - near.from_ms == 15_000
    assert near.zoomed(0.01, 35_000).fitted() == WHOLE
    assert near.zoomed(1e9, 35_000).to_ms - near.zoomed(1e9, 35_000).from_ms == 200
    assert near.moved(-1e9).from_ms == 5000
    assert near.moved(1e9).to_ms == 65_000


def test_a_time_out_of_sight_is_turned_to():
    near = WHOLE.zoomed(4.0, 12_000)
    assert near.showing(12_000) is near
    assert near.showing(60_000).from_ms <= 60_000 <= near.showing(60_000).to_ms


def test_of_what_lies_in_one_pixel_one_is_painted_and_the_chosen_one():
    short = [Occurrence("nods", begin, begin + 1) for begin in (9000, 9002, 9004, 9200)]
    long = Occurrence("nods", 9006, 9400)
    bars = [Bar(0, one.begin_ms, one.end_ms, "coded", one) for one in (*short[:3], long, short[3])]
    bars.append(Bar(1, 9001, 9002, "coded"))
    content = Timeline(5000, 65_000, bars=tuple(bars), chosen=short[1])
    assert WHOLE.px_per_ms == 0.01
    painted = list(bars_to_paint(content, WHOLE))
    assert painted == [bars[0], bars[1], bars[3], bars[4], bars[5]]
    assert list(bars_to_paint(content, WHOLE.zoomed(100.0, 9000))) == bars
    assert list(bars_to_paint(content, WHOLE.zoomed(4.0, 60_000))) == []


def test_the_same_session_keeps_its_zoom():
    near = WHOLE.zoomed(4.0, 12_000)
    assert near.of_session(5000, 65_000) is near
    assert near.of_session(0, 10).from_ms == 0
    assert TimeScale().of_session(7, 7).end_ms == 8


@pytest.mark.parametrize(("least_px", "step_ms"), [(60, 10_000), (11, 2000), (590, 60_000)])
def test_ticks_are_round_and_far_enough_apart(least_px, step_ms):
    ticks = WHOLE.ticks_ms(least_px)
    assert ticks[0] == 5000
    assert {after - before for before, after in pairwise(ticks)} == {step_ms}


def test_a_day_has_ticks_of_whole_hours():
    day = TimeScale(width_px=10).of_session(0, 86_400_000)
    assert day.ticks_ms(5.0) == [0, 46_800_000]
