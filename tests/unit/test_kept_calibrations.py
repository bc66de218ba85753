"""Calibrations are kept sensor by sensor, and sensors bring the newest of theirs."""

from dataclasses import replace
from datetime import UTC, datetime, timedelta

import numpy as np
import pytest

from adibas.calibration.kept import REMIND_AFTER, KeptCalibrations, sensor_key, sizes_of
from adibas.cli.command_line import main
from adibas.data.calibration import CameraCalibration, RgbdCalibration
from adibas.data.frames import SensorFrame, SourceInfo
from adibas.errors import CalibrationError
from adibas.geometry.pinhole import Intrinsics
from adibas.recordings import RecordingOptions, create_recording, open_recording
from adibas.sensors.calibrated import CalibratedOpener
from adibas.sensors.simulator import SimulatorCamera

MADE = datetime(2026, 3, 1, 12, 0, 0, tzinfo=UTC)


def calibration(sensor="A1", days=0, width=640, focal_px=525.0, **changes):
    camera = CameraCalibration(width, 480, Intrinsics(focal_px, focal_px, 319.5, 239.5))
    made = (MADE + timedelta(days=days)).isoformat()
    return RgbdCalibration(
        color=camera, depth=camera, sensor_serial=sensor, created_utc=made, **changes
    )


@pytest.fixture
def kept(tmp_path):
    return KeptCalibrations(tmp_path / "calibrations")


def test_the_newest_comes_first_whatever_order_they_were_kept_in(kept):
    for days in (3, 9, 1):
        kept.keep(calibration(days=days, focal_px=500.0 + days))
    focal_px = [one.calibration.color.intrinsics.fx for one in kept.of_sensor("A1")]
    assert focal_px == [509.0, 503.0, 501.0]
    assert kept.newest("A1").made_utc == MADE + timedelta(days=9)


def test_an_older_one_that_is_damaged_does_not_keep_the_newest_away(kept):
    older = kept.keep(calibration(days=1))
    kept.keep(calibration(days=2))
    older.write_text("[]", encoding="utf-8")
    assert kept.newest("A1").made_utc == MADE + timedelta(days=2)
    with pytest.raises(CalibrationError):
        kept.of_sensor("A1")


@pytest.mark.parametrize("other", ["A2", "a1", "A/1", "../A1", "A1 ", "", "Ä1", "A" * 300])
def test_no_sensor_gets_the_calibration_of_another(kept, other):
    kept.keep(calibration("A1"))
    kept.keep(calibration("A_1"))
    assert kept.newest(other) is None
    assert kept.newest("A1").calibration.sensor_serial == "A1"


def test_every_serial_number_finds_its_own_within_the_folder(kept):
    for sensor in ("../../outside", "con", "a" * 300, "número 7", ":/?*"):
        path = kept.keep(calibration(sensor))
        assert kept.folder in path.resolve().parents
        assert kept.newest(sensor).calibration.sensor_serial == sensor


def test_the_newest_for_the_size_of_the_images_is_taken(kept):
    kept.keep(calibration(days=1, width=640))
    kept.keep(calibration(days=2, width=1280))
    small = sizes_of(calibration(width=640))
    assert kept.newest("A1", small).calibration.color.width == 640
    assert kept.newest("A1").calibration.color.width == 1280
    assert kept.newest("A1", ((320, 240), (320, 240))) is None


def test_a_calibration_without_a_sensor_or_a_time_is_not_kept(kept):
    with pytest.raises(ValueError, match="without a sensor"):
        kept.keep(calibration(""))
    with pytest.raises(CalibrationError, match="when it was made"):
        kept.keep(RgbdCalibration(sensor_serial="A1"))


def test_a_damaged_one_is_told_and_not_passed_over(kept):
    kept.keep(calibration(days=1))
    kept.keep(calibration(days=2)).write_text("{", encoding="utf-8")
    with pytest.raises(CalibrationError, match="damaged"):
        kept.newest("A1")


def test_after_half_a_year_it_is_old(kept):
    kept.keep(calibration())
    one = kept.newest("A1")
    assert not one.is_old(MADE + REMIND_AFTER)
    assert one.is_old(MADE + REMIND_AFTER + timedelta(seconds=1))


def test_a_sensor_without_a_number_is_known_by_its_name():
    assert sensor_key(SourceInfo(sensor_name="PS1080", sensor_serial="17")) == "17"
    assert sensor_key(SourceInfo(sensor_name="PS1080")) == "PS1080"
    assert sensor_key(SourceInfo()) == ""


def kept_of_simulator(kept):
    with SimulatorCamera("anterior") as camera:
        factory = camera.info
    mine = RgbdCalibration(
        color=factory.calibration.color,
        depth=factory.calibration.depth,
        color_from_depth=factory.calibration.color_from_depth,
        depth_unit_m=factory.calibration.depth_unit_m,
        sensor_serial=sensor_key(factory),
        created_utc=MADE.isoformat(),
        rms_px=0.25,
    )
    kept.keep(mine)
    return factory


def test_a_sensor_brings_the_calibration_that_was_kept_of_it(kept):
    factory = kept_of_simulator(kept)
    with CalibratedOpener(kept)("simulator:anterior") as camera:
        assert camera.info.calibration.rms_px == 0.25
        assert camera.info.sensor_serial == factory.sensor_serial
        assert not camera.is_live
        assert camera.read() is not None


def test_a_sensor_that_tells_its_vertical_is_believed(kept):
    factory = kept_of_simulator(kept).calibration
    with CalibratedOpener(kept)("simulator:anterior") as camera:
        calibration = camera.info.calibration
    assert calibration.floor.offset_m == factory.floor.offset_m
    np.testing.assert_array_equal(calibration.gravity, factory.gravity)


def test_a_vertical_that_was_kept_is_not_that_of_today(kept, monkeypatch):
    factory = kept_of_simulator(kept)
    down = np.array([0.0, 1.0, 0.0])
    moved = replace(
        kept.newest(factory.sensor_serial).calibration,
        gravity=down,
        gravity_sd_rad=0.001,
        created_utc=(MADE + timedelta(hours=1)).isoformat(),
    )
    kept.keep(moved)
    assert kept.newest(factory.sensor_serial).calibration.gravity_sd_rad == 0.001
    silent = replace(factory, calibration=replace(factory.calibration, gravity=None, floor=None))
    monkeypatch.setattr(SimulatorCamera, "info", silent)
    with CalibratedOpener(kept)("simulator:anterior") as camera:
        assert camera.info.calibration.rms_px == 0.25
        assert camera.info.calibration.gravity is None
        assert camera.info.calibration.gravity_sd_rad is None


def test_a_sensor_without_one_is_as_it_was(kept):
    with CalibratedOpener(kept)("simulator:anterior") as camera:
        assert isinstance(camera, SimulatorCamera)


def test_a_recording_keeps_the_calibration_that_it_was_made_with(kept, tmp_path):
    factory = kept_of_simulator(kept)
    path = tmp_path / "old.mcap"
    with create_recording(path, factory, RecordingOptions(is_live=False)) as writer:
        writer.write(SensorFrame(0, 0, np.full((480, 640), 1000, np.uint16)))
    with CalibratedOpener(kept)(str(path)) as camera:
        assert camera.info.calibration.rms_px == factory.calibration.rms_px


def test_images_that_the_sensor_registered_itself_need_its_own_calibration(kept, monkeypatch):
    factory = kept_of_simulator(kept)
    registered = SourceInfo(
        sensor_serial=factory.sensor_serial,
        sensor_name=factory.sensor_name,
        is_depth_registered=True,
        calibration=factory.calibration,
    )
    monkeypatch.setattr(SimulatorCamera, "info", registered)
    with CalibratedOpener(kept)("simulator:anterior") as camera:
        assert camera.info.calibration.rms_px == factory.calibration.rms_px


def test_a_damaged_calibration_leaves_no_sensor_open(kept, monkeypatch):
    kept_of_simulator(kept)
    next(kept.folder.glob("*/*.json")).write_text("[]", encoding="utf-8")
    closed = []

    def close(camera):
        closed.append(camera)

    monkeypatch.setattr(SimulatorCamera, "close", close)
    with pytest.raises(CalibrationError):
        CalibratedOpener(kept)("simulator:anterior")
    assert len(closed) == 1


def test_what_is_recorded_bears_the_kept_calibration(tmp_path, capsys, monkeypatch):
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "home"))
    kept_of_simulator(KeptCalibrations())
    out = tmp_path / "new.mcap"
    assert main(["record", "simulator:anterior", "--out", str(out), "--seconds", "0.1"]) == 0
    with open_recording(out) as recording:
        assert recording.info.calibration.rms_px == 0.25
    capsys.readouterr()
