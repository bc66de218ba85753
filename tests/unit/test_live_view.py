"""The live view: reading never waits, bursts lose nothing, and sensors come and go."""

import itertools
import threading
import time
from concurrent.futures import CancelledError
from types import SimpleNamespace

import numpy as np
import pytest

from adibas.errors import RecordingError, SensorError
from adibas.pipeline import acquisition
from adibas.pipeline.burst_recording import QUEUE_FRAMES
from adibas.pipeline.live import LiveView
from adibas.recordings import create_recording, open_recording
from adibas.sensors import SensorOptions
from tests.unit.live_rig import PATIENCE_S, UNPLUGGED, DrivenCamera, Sources, Told, frame


@pytest.fixture(autouse=True)
def impatient(monkeypatch):
    monkeypatch.setattr(acquisition, "RETRY_S", 0.01)
    monkeypatch.setattr(acquisition, "SLICE_S", 0.01)


@pytest.fixture
def told():
    return Told()


@pytest.fixture
def shown(told):
    """Opens a view on the things that its source gives one after the other, and closes it."""
    cameras, views = [], []

    def show(*things, **options):
        cameras.extend(thing for thing in things if isinstance(thing, DrivenCamera))
        view = LiveView(told, opener=Sources(*things))
        views.append(view)
        view.open("any", SensorOptions(), **options)
        return view

    before = set(threading.enumerate())
    yield show
    told.gate.set()
    for camera in cameras:
        camera.push(*[SensorError("over")] * 3)
    for view in views:
        view.close()
    assert set(threading.enumerate()) == before, "a closed view leaves no thread"
    assert all(camera.is_closed for camera in cameras)


def wait_until(condition):
    """Wait for what no listener is told."""
    deadline_s = time.monotonic() + PATIENCE_S
    while not condition():
        assert time.monotonic() < deadline_s
        threading.Event().wait(0.002)


@pytest.fixture
def writer(tmp_path):
    writer = create_recording(tmp_path / "burst.mcap", DrivenCamera().info)
    yield writer
    writer.abandon()


class GatedWriter:
    """A writer on a disk that stands still until the gate opens."""

    def __init__(self):
        self.gate, self.is_busy = threading.Event(), threading.Event()
        self.frames = []

    def write(self, sensor_frame):
        self.is_busy.set()
        assert self.gate.wait(PATIENCE_S)
        self.frames.append(sensor_frame)


def test_frames_are_shown_and_the_state_is_told(told, shown):
    camera = DrivenCamera([frame(0)])
    view = shown(camera)
    told.wait_for_frame(0)
    np.testing.assert_array_equal(told.frames[0].color_rgb, frame(0).color)
    assert told.frames[0].depth_m.shape == (24, 32)
    assert np.isnan(told.frames[0].depth_m[frame(0).depth_raw == 0]).all()
    assert told.kinds == ["opening", "live"]
    assert view.state is told.states[-1]
    assert view.state.info is camera.info


def test_a_slow_listener_never_delays_the_sensor_and_gets_the_newest(told, shown):
    told.gate.clear()
    camera = DrivenCamera([frame(0)])
    shown(camera)
    told.wait_for_frame(0)
    camera.push(*map(frame, range(1, 51)))
    wait_until(lambda: camera.n_asked == 52)  # all are read while the listener still holds 0
    assert told.sequences == [0]
    told.gate.set()
    told.wait_for(lambda: len(told.frames) == 2)
    assert told.sequences == [0, 50]


def test_no_frame_of_a_burst_is_lost_while_the_screen_stands_still(told, shown, writer):
    told.gate.clear()
    camera = DrivenCamera([frame(0)])
    view = shown(camera)
    told.wait_for_frame(0)
    progress = []
    future = view.capture(20, writer, lambda *numbers: progress.append(numbers))
    camera.push(*map(frame, range(1, 30)))
    burst = future.result(PATIENCE_S)
    assert [one.sequence for one in burst.frames] == list(range(1, 21))
    assert (burst.n_dropped, burst.n_restarts, burst.timestamp_ns) == (
        0,
        0,
        frame(1).timestamp_ns,
    )
    assert progress == [(i, 20) for i in range(1, 21)]
    assert [one.sequence for one in burst] == list(range(1, 21))
    writer.close()
    with open_recording(writer.path) as recording:
        for got, want in zip(recording, burst.frames, strict=True):
            np.testing.assert_array_equal(got.depth_raw, want.depth_raw)


def test_frames_that_the_sensor_lost_are_counted_over_unplugging(told, shown, writer):
    first = DrivenCamera([frame(3), frame(5), UNPLUGGED])
    second = DrivenCamera([frame(0)])
    view = shown(first, second)
    told.wait_for_frame(0)
    future = view.capture(3, writer)
    second.push(*map(frame, (1, 4, 5)))
    assert future.result(PATIENCE_S).n_dropped == 2
    told.wait_for_frame(5)
    told.wait_for(lambda: told.frames[-1].n_dropped == 3)


def test_an_unplugged_sensor_comes_back(told, shown):
    first, second = DrivenCamera([frame(0), UNPLUGGED]), DrivenCamera([frame(7)])
    shown(first, SensorError("not yet"), SensorError("not yet"), second)
    told.wait_for_frame(7)
    assert told.kinds == ["opening", "live", "lost", "lost", "live"]
    assert [str(state.error) for state in told.states[2:4]] == [str(UNPLUGGED), "not yet"]
    assert first.is_closed


def test_a_sensor_that_is_not_there_yet_is_waited_for(told, shown):
    shown(SensorError("none"), SensorError("none"), DrivenCamera([frame(1)]))
    told.wait_for_frame(1)
    assert told.kinds == ["opening", "lost", "live"], "the same error is told once"


def test_a_sensor_may_take_its_time_for_the_first_frame(told, shown):
    slow = [SensorError("not yet")] * 3
    shown(DrivenCamera([*slow, frame(0), UNPLUGGED]))
    told.wait_for(lambda: "lost" in told.kinds)
    assert told.kinds[:3] == ["opening", "live", "lost"]


def test_unplugging_fails_the_burst_and_not_the_view(told, shown, writer):
    first, second = DrivenCamera([frame(0)]), DrivenCamera([frame(50)])
    view = shown(first, second)
    told.wait_for_frame(0)
    future = view.capture(5, writer)
    first.push(frame(1), frame(2), UNPLUGGED)
    with pytest.raises(SensorError, match="unplugged"):
        future.result(PATIENCE_S)
    told.wait_for_frame(50)
    again = view.capture(1, writer)
    second.push(frame(51))
    assert again.result(PATIENCE_S).frames[0].sequence == 51


def test_a_disk_that_is_too_slow_is_told_and_does_not_stop_the_picture(told, shown):
    camera = DrivenCamera([frame(0, (4, 4))])
    view = shown(camera)
    told.wait_for_frame(0)
    gated = GatedWriter()
    future = view.capture(QUEUE_FRAMES + 20, gated)
    camera.push(frame(1, (4, 4)))
    assert gated.is_busy.wait(PATIENCE_S)
    camera.push(*(frame(i, (4, 4)) for i in range(2, QUEUE_FRAMES + 10)))
    told.wait_for_frame(QUEUE_FRAMES + 9)
    assert not future.done(), "the writer is busy, so it is not ours yet"
    gated.gate.set()
    with pytest.raises(RecordingError, match="too slow"):
        future.result(PATIENCE_S)


def test_a_full_disk_ends_the_burst_with_its_error(told, shown):
    class FullDisk(GatedWriter):
        def write(self, sensor_frame):  # noqa: ARG002
            raise RecordingError("The disk is full.")

    camera = DrivenCamera([frame(0)])
    view = shown(camera)
    told.wait_for_frame(0)
    future = view.capture(5, FullDisk())
    camera.push(frame(1))
    with pytest.raises(RecordingError, match="full"):
        future.result(PATIENCE_S)
    camera.push(frame(2))
    told.wait_for_frame(2)


def test_a_burst_can_be_cancelled_and_another_one_taken(told, shown, writer):
    camera = DrivenCamera([frame(0)])
    view = shown(camera)
    told.wait_for_frame(0)
    view.cancel_capture()  # of nothing: no harm
    future = view.capture(5, writer)
    with pytest.raises(ValueError, match="already"):
        view.capture(5, writer)
    view.cancel_capture()
    with pytest.raises(CancelledError):
        future.result(PATIENCE_S)
    again = view.capture(1, writer)
    camera.push(frame(1))
    assert len(again.result(PATIENCE_S)) == 1


def test_nothing_can_be_captured_without_a_live_sensor(told, shown, writer):
    with pytest.raises(SensorError, match="No sensor is live"):
        LiveView(told).capture(5, writer)
    view = shown(SensorError("none"))
    told.wait_for(lambda: "lost" in told.kinds)
    with pytest.raises(SensorError, match="No sensor is live"):
        view.capture(5, writer)


def test_a_burst_needs_a_frame(told, shown, writer):
    view = shown(DrivenCamera([frame(0)]))
    told.wait_for_frame(0)
    with pytest.raises(ValueError, match="one frame at least"):
        view.capture(0, writer)


def test_a_recording_begins_anew_and_its_clock_goes_on(told, shown, writer):
    passes = [
        DrivenCamera([*map(frame, (10, 11, 12)), None], is_live=False),
        DrivenCamera([frame(10)], is_live=False),
    ]
    view = shown(*passes)
    told.wait_for(lambda: 13 in told.sequences)
    assert told.kinds == ["opening", "live"], "beginning anew is no change of state"
    future = view.capture(4, writer)
    passes[1].push(frame(11), frame(12), None)
    last = DrivenCamera([frame(10), frame(11)], is_live=False)
    view._running._acquisition._opener.things.append(last)
    burst = future.result(PATIENCE_S)
    last.push(None)
    assert [one.sequence for one in burst.frames] == [14, 15, 16, 17]
    assert burst.n_restarts == 1
    assert (np.diff([one.timestamp_ns for one in burst.frames]) > 0).all()
    np.testing.assert_array_equal(burst.frames[2].depth_raw, frame(10).depth_raw)
    assert burst.frames[2].color_timestamp_ns - burst.frames[2].timestamp_ns == 1_000_000


def test_a_recording_that_does_not_loop_ends_and_says_so_to_a_burst(told, shown, writer):
    camera = DrivenCamera([frame(0)], is_live=False)
    view = shown(camera, is_looping=False)
    told.wait_for_frame(0)
    future = view.capture(5, writer)
    camera.push(frame(1), None)
    with pytest.raises(SensorError, match="ended before the burst was whole"):
        future.result(PATIENCE_S)
    told.wait_for_states("opening", "live", "ended")
    assert told.states[-1].error is None


@pytest.mark.parametrize(
    "things",
    [
        [RecordingError("damaged")],
        [DrivenCamera([frame(0), RecordingError("damaged")], is_live=False)],
        [DrivenCamera([None], is_live=False)],
    ],
    ids=["at opening", "inside", "empty"],
)
def test_a_damaged_or_empty_recording_ends_with_the_reason(told, shown, things):
    shown(*things)
    told.wait_for(lambda: "ended" in told.kinds)
    assert isinstance(told.states[-1].error, RecordingError)


def test_whatever_is_no_sensor_is_paced_by_the_view(told, shown):
    view = shown(DrivenCamera([frame(0)], is_live=False))
    told.wait_for_frame(0)
    opener = view._running._acquisition._opener
    assert opener.opened == ["any"]
    assert not opener.options[0].is_paced, "else it could not be closed while it sleeps"


def test_another_source_takes_the_place_of_the_first(told):
    first, second = DrivenCamera([frame(0)], is_punctual=True), DrivenCamera([frame(9)])
    view = LiveView(told, opener=Sources(first, second))
    view.open("first")
    told.wait_for_frame(0)
    view.open("second")
    told.wait_for_frame(9)
    assert first.is_closed
    second.push(UNPLUGGED)
    view.close()
    assert "closed" in told.kinds[:4]
    assert told.kinds[-1] == "closed"
    assert view.state.kind == "closed"


def punctual(*things):
    return DrivenCamera(things, is_punctual=True)


@pytest.mark.parametrize(
    ("things", "kind"),
    [
        ([punctual()], "opening"),
        ([punctual(frame(0))], "live"),
        ([UNPLUGGED], "lost"),
        ([DrivenCamera([frame(0), None], is_live=False)], "ended"),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_it_closes_from_any_state_and_leaves_no_thread(told, things, kind):
    before = set(threading.enumerate())
    view = LiveView(told, opener=Sources(*things))
    view.close()
    view.open("any", is_looping=False)
    told.wait_for(lambda: kind in told.kinds)
    view.close()
    view.close()
    assert set(threading.enumerate()) == before
    assert told.kinds[-1] == "closed"
    assert told.kinds.count("closed") == 1


def test_closing_fails_the_burst_that_is_being_taken(told, writer):
    view = LiveView(told, opener=Sources(punctual(frame(0))))
    view.open("any")
    told.wait_for_frame(0)
    future = view.capture(5, writer)
    view.close()
    with pytest.raises(SensorError, match="closed"):
        future.result(0)


@pytest.mark.parametrize("call", ["frame_arrived", "state_changed"])
def test_an_exception_of_the_listener_is_no_secret(told, monkeypatch, writer, call):
    crashes = []
    monkeypatch.setattr(threading, "excepthook", crashes.append)
    before = set(threading.enumerate())
    camera = punctual(frame(0))
    view = LiveView(told, opener=Sources(camera))
    view.open("any")
    told.wait_for_frame(0)
    future = view.capture(5, writer)

    def crash(_):
        raise ZeroDivisionError

    monkeypatch.setattr(told, call, crash)
    camera.push(frame(1), UNPLUGGED)
    with pytest.raises(SensorError):
        future.result(PATIENCE_S)
    wait_until(lambda: crashes and camera.is_closed)
    assert crashes[0].exc_type is ZeroDivisionError
    view.close()
    assert set(threading.enumerate()) == before


def test_a_bug_in_a_camera_ends_the_view_and_reaches_the_crash_report(told, monkeypatch):
    crashes = []
    monkeypatch.setattr(threading, "excepthook", crashes.append)
    camera = punctual(frame(0), ZeroDivisionError())
    view = LiveView(told, opener=Sources(camera))
    view.open("any")
    told.wait_for(lambda: told.kinds[-1:] == ["closed"])
    wait_until(lambda: crashes)
    assert crashes[0].exc_type is ZeroDivisionError
    assert camera.is_closed
    view.close()


def test_the_rate_is_that_of_the_arrivals(told, shown, monkeypatch):
    clock = itertools.count()
    monkeypatch.setattr(acquisition, "time", SimpleNamespace(monotonic=lambda: next(clock) * 0.05))
    camera = DrivenCamera(map(frame, range(20)), is_live=False)
    shown(camera)
    told.wait_for_frame(19)
    assert told.frames[-1].frame_rate_hz == pytest.approx(20.0)
