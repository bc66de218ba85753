"""A turn from a live view into the store: all of it, or nothing."""

from dataclasses import replace

import numpy as np
import pytest

from adibas.data.calibration import CameraCalibration, RgbdCalibration
from adibas.data.frames import SourceInfo
from adibas.errors import CalibrationError, SensorError
from adibas.geometry.pinhole import Intrinsics
from adibas.pipeline.capturing import BEGAN_ANEW, LOST_FRAMES
from adibas.pipeline.live import LiveView
from adibas.pipeline.turn_taking import take_turn
from tests.unit.live_rig import UNPLUGGED, DrivenCamera, Sources, Told, frame
from tests.unit.store_samples import add_session, open_sample

N_FRAMES, RATE_HZ = 6, 30.0
CAMERA = CameraCalibration(32, 24, Intrinsics(30.0, 30.0, 15.5, 11.5))
CALIBRATION = RgbdCalibration(CAMERA, CAMERA)


class GivenUpError(Exception):
    """What a progress raises whose work is given up."""


@pytest.fixture
def store(tmp_path):
    with open_sample(tmp_path / "store") as opened:
        yield opened


@pytest.fixture
def session_id(store):
    return add_session(store).session_id


@pytest.fixture
def showing():
    """Give a live view and its camera, which has sent one frame."""
    views = []

    def show(calibration=CALIBRATION, own=None):
        info = SourceInfo(sensor_name="S", frame_rate_hz=RATE_HZ, calibration=calibration)
        camera, told = DrivenCamera([frame(0)], info=info), Told()
        view = LiveView(told, opener=Sources(camera))
        views.append((view, camera))
        view.open("any", calibration=own)
        told.wait_for(lambda: told.frames)
        return view, camera

    yield show
    for view, camera in views:
        camera.push(None)
        view.close()


def pushing(camera, things):
    """Return a progress that lets the sensor go on once somebody waits for it."""
    told = []

    def progress(done, total):
        if not told:
            camera.push(*things)
        told.append((done, total))

    return progress, told


def assert_nothing_kept(store, session_id):
    assert store.recordings.of_session(session_id) == ()
    assert list((store.folder / "recordings").rglob("*.sealed*")) == []


def test_every_frame_is_in_the_recording_with_the_calibration_in_use(store, session_id, showing):
    own = replace(CALIBRATION, rms_px=0.125)
    view, camera = showing(own=own)
    lost_one = [frame(number) for number in (1, 2, 3, 5, 6, 7)]
    progress, told = pushing(camera, lost_one)
    turn = take_turn(store, view, session_id, progress, N_FRAMES / RATE_HZ)
    assert (turn.session_id, turn.n_frames) == (session_id, N_FRAMES)
    assert turn.notices == (LOST_FRAMES,)
    assert told[0] == (0, N_FRAMES)
    with store.recordings.open(turn.recording_id) as recording:
        assert recording.info.calibration.rms_px == own.rms_px
        for index, wanted in enumerate(lost_one):
            np.testing.assert_array_equal(recording.read(index).depth_raw, wanted.depth_raw)


def test_a_recording_that_begins_anew_inside_the_turn_is_told(store, session_id):
    info = SourceInfo(sensor_name="S", frame_rate_hz=RATE_HZ, calibration=CALIBRATION)
    first, again = (DrivenCamera(is_live=False, info=info) for _ in range(2))
    told = Told()
    view = LiveView(told, opener=Sources(first, again))
    view.open("any.mcap")
    first.push(frame(0))
    told.wait_for(lambda: told.frames)
    progress, _ = pushing(first, [frame(1), frame(2), None])
    again.push(*(frame(number) for number in range(4)))
    turn = take_turn(store, view, session_id, progress, N_FRAMES / RATE_HZ)
    assert BEGAN_ANEW in turn.notices
    again.push(None)
    view.close()


@pytest.mark.parametrize("things", [[frame(1), UNPLUGGED], [frame(1), None]])
def test_half_a_turn_leaves_nothing(store, session_id, showing, things):
    view, camera = showing()
    with pytest.raises(SensorError):
        take_turn(store, view, session_id, pushing(camera, things)[0], N_FRAMES / RATE_HZ)
    assert_nothing_kept(store, session_id)


def test_a_turn_that_is_given_up_leaves_nothing(store, session_id, showing):
    view, _camera = showing()

    def give_up(_done, _total):
        raise GivenUpError

    with pytest.raises(GivenUpError):
        take_turn(store, view, session_id, give_up, N_FRAMES / RATE_HZ)
    assert_nothing_kept(store, session_id)


def test_without_a_calibrated_depth_camera_no_turn_begins(store, session_id, showing):
    view, _camera = showing(calibration=replace(CALIBRATION, depth=None))
    with pytest.raises(CalibrationError, match="lacks the depth camera"):
        take_turn(store, view, session_id, lambda *_: None)
    assert_nothing_kept(store, session_id)


def test_without_a_live_sensor_no_turn_begins(store, session_id):
    with pytest.raises(SensorError, match="No sensor is live"):
        take_turn(store, LiveView(Told(), opener=Sources()), session_id, lambda *_: None)
