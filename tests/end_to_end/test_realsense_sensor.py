"""The RealSense library with its own software device: all but the hardware."""

import os
import threading

import numpy as np
import pyrealsense2 as rs
import pytest

from adibas.errors import SensorError
from adibas.geometry.pinhole import project
from adibas.sensors import SensorOptions, open_source, realsense
from adibas.sensors.realsense import RealSenseCamera
from adibas.sensors.realsense_calibration import distortion_of, rigid
from adibas.sensors.realsense_library import list_sensors, load_realsense
from adibas.sensors.sources import source_of

DEPTH_SIZE, COLOR_SIZE = (848, 480), (1280, 720)
PERIOD_MS = 1000 / 30
SCALE_M = 0.00025
LENS = [0.1, -0.2, 0.001, 0.002, 0.05]
ANGLE_RAD = 0.02
BYTES = {rs.format.z16: 2, rs.format.rgb8: 3, rs.format.y8: 1}


def intrinsics(size, focal_px, model=rs.distortion.brown_conrady, coefficients=LENS):
    lens = rs.intrinsics()
    lens.width, lens.height = size
    lens.fx = lens.fy = focal_px
    lens.ppx, lens.ppy = size[0] / 2 + 3, size[1] / 2 - 5
    lens.model, lens.coeffs = model, coefficients
    return lens


def extrinsics():
    """Return a small turn about the vertical and 15 mm to the side, as the library keeps it."""
    cosine, sine = np.cos(ANGLE_RAD), np.sin(ANGLE_RAD)
    moved = rs.extrinsics()
    moved.rotation = [cosine, 0, -sine, 0, 1, 0, sine, 0, cosine]
    moved.translation = [0.015, 0.0, 0.001]
    return moved


class SoftwareSensor:
    """A device without hardware that sends what it is told to."""

    def __init__(self, serial="0123456789"):
        self.device = rs.software_device()
        self.device.register_info(rs.camera_info.name, "Software D435")
        self.device.register_info(rs.camera_info.serial_number, serial)
        stereo = self.device.add_sensor("Stereo Module")
        rgb = self.device.add_sensor("RGB Camera")
        stereo.add_read_only_option(rs.option.depth_units, SCALE_M)
        self.profiles, self.sensors = {}, {}
        for uid, (name, sensor, size, pixel_format, focal_px) in enumerate(
            (
                ("depth", stereo, DEPTH_SIZE, rs.format.z16, 425.0),
                ("infrared", stereo, DEPTH_SIZE, rs.format.y8, 425.0),
                ("color", rgb, (640, 480), rs.format.rgb8, 600.0),
                ("color", rgb, COLOR_SIZE, rs.format.rgb8, 910.0),
            )
        ):
            video = rs.video_stream()
            video.type, video.fmt = getattr(rs.stream, name), pixel_format
            video.index = 1 if name == "infrared" else 0
            video.uid, video.fps, video.bpp = uid, 30, BYTES[pixel_format]
            video.width, video.height = size
            video.intrinsics = intrinsics(size, focal_px)
            profile = sensor.add_video_stream(video).as_video_stream_profile()
            self.profiles[name], self.sensors[name] = profile, sensor
            if name == "color":
                self.profiles["depth"].register_extrinsics_to(profile, extrinsics())

    def send(self, name, number, pixels):
        frame = rs.software_video_frame()
        frame.profile = self.profiles[name]
        frame.pixels = np.ascontiguousarray(pixels)
        frame.bpp = BYTES[frame.profile.format()]
        frame.stride = frame.profile.width() * frame.bpp
        frame.timestamp = 1000.0 + number * PERIOD_MS
        frame.domain = rs.timestamp_domain.hardware_clock
        frame.frame_number = number
        self.sensors[name].on_video_frame(frame)


@pytest.fixture
def moments():
    rng = np.random.default_rng(3)
    width, height = DEPTH_SIZE
    return [
        {
            "depth": rng.integers(0, 12_000, (height, width), np.uint16),
            "color": rng.integers(0, 256, (*COLOR_SIZE[::-1], 3), np.uint8),
            "infrared": rng.integers(0, 256, (height, width), np.uint8),
        }
        for _ in range(5)
    ]


@pytest.fixture
def sensor():
    return SoftwareSensor()


def send_all(sensor, moments, names):
    for number, moment in enumerate(moments, start=1):
        for name in names:
            sensor.send(name, number, moment[name])


def test_depth_and_colour_arrive_bit_by_bit_and_belong_together(sensor, moments):
    with RealSenseCamera(sensor.device) as camera:
        send_all(sensor, moments, ("depth", "color"))
        frames = [camera.read(5.0) for _ in moments]
        assert camera.is_live
    for number, (frame, moment) in enumerate(zip(frames, moments, strict=True), start=1):
        np.testing.assert_array_equal(frame.depth_raw, moment["depth"])
        np.testing.assert_array_equal(frame.color, moment["color"])
        assert frame.sequence == number
        assert frame.timestamp_ns == round((1000.0 + number * PERIOD_MS) * 1e6)
        assert frame.color_timestamp_ns == frame.timestamp_ns


def test_the_left_infrared_image_comes_in_place_of_colour(sensor, moments):
    with RealSenseCamera(sensor.device, SensorOptions(is_infrared=True)) as camera:
        send_all(sensor, moments, ("depth", "infrared"))
        frame = camera.read(5.0)
    np.testing.assert_array_equal(frame.infrared_raw, moments[0]["infrared"])
    np.testing.assert_array_equal(frame.depth_raw, moments[0]["depth"])
    assert frame.color is None


def test_the_wished_size_is_chosen_where_the_sensor_has_it(sensor):
    with RealSenseCamera(sensor.device, SensorOptions(color_size=(640, 480))) as camera:
        assert camera.info.calibration.color.width == 640


def test_the_header_tells_sensor_unit_and_factory_calibration(sensor):
    with RealSenseCamera(sensor.device) as camera:
        info = camera.info
    assert (info.sensor_name, info.sensor_serial) == ("Software D435", "0123456789")
    assert (info.depth_unit_m, info.frame_rate_hz) == (SCALE_M, 30.0)
    color = info.calibration.color
    assert (color.width, color.height) == COLOR_SIZE
    assert (color.intrinsics.fx, color.intrinsics.cx, color.intrinsics.cy) == (910.0, 643.0, 355.0)
    np.testing.assert_allclose(color.distortion, LENS, atol=1e-7)
    assert info.calibration.rms_px is None


def test_extrinsics_move_points_as_the_library_does(sensor):
    with RealSenseCamera(sensor.device) as camera:
        color_from_depth = camera.info.calibration.color_from_depth
    point_m = [0.3, -0.2, 1.7]
    expected_m = rs.rs2_transform_point_to_point(extrinsics(), point_m)
    np.testing.assert_allclose(color_from_depth.apply(np.array(point_m)), expected_m, atol=1e-6)
    assert np.abs(rigid(extrinsics()).rotation - np.eye(3)).max() > 0.01


@pytest.mark.parametrize(
    "model", [rs.distortion.modified_brown_conrady, rs.distortion.inverse_brown_conrady]
)
def test_variants_of_the_lens_model_are_fitted_to_what_the_library_projects(model):
    lens = intrinsics(COLOR_SIZE, 910.0, model, [-0.055, 0.065, 0.0004, 0.0003, -0.02])
    k1, k2, p1, p2, k3 = distortion_of(rs, lens)
    rng = np.random.default_rng(1)
    x, y = rng.uniform(-0.65, 0.65, 100), rng.uniform(-0.35, 0.35, 100)
    r2 = x * x + y * y
    radial = 1 + k1 * r2 + k2 * r2**2 + k3 * r2**3
    distorted = np.stack(
        [
            x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x),
            y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y,
        ],
        axis=1,
    )
    got = distorted * 910.0 + [lens.ppx, lens.ppy]
    points = np.stack([x, y, np.ones(100)], axis=1)
    expected = [rs.rs2_project_point_to_pixel(lens, list(point)) for point in points]
    np.testing.assert_allclose(got, expected, atol=0.1)
    pinhole = project(points, _pinhole(lens))
    assert np.abs(pinhole - expected).max() > 5.0, "the lens distorts, or this proves nothing"


def _pinhole(lens):
    from adibas.geometry.pinhole import Intrinsics

    return Intrinsics(lens.fx, lens.fy, lens.ppx, lens.ppy)


def test_a_fish_eye_is_refused():
    lens = intrinsics(COLOR_SIZE, 300.0, rs.distortion.kannala_brandt4, [0.1, 0.1, 0.1, 0.1, 0])
    with pytest.raises(SensorError, match="kannala_brandt4, which is not supported"):
        distortion_of(rs, lens)


def test_a_lens_without_distortion_has_no_coefficients():
    lens = intrinsics(COLOR_SIZE, 910.0, rs.distortion.inverse_brown_conrady, [0.0] * 5)
    assert distortion_of(rs, lens) == ()


def test_a_silent_sensor_is_given_up_after_the_time_allowed(sensor):
    with (
        RealSenseCamera(sensor.device) as camera,
        pytest.raises(SensorError, match="Software D435 sends no pictures"),
    ):
        camera.read(0.3)


def test_a_slow_reader_of_a_live_sensor_loses_frames_and_sees_the_gap(sensor, moments):
    with RealSenseCamera(sensor.device) as camera:
        for number in range(1, 41):
            sensor.send("depth", number, moments[0]["depth"])
            sensor.send("color", number, moments[0]["color"])
        first = [camera.read(5.0).sequence for _ in range(8)]
        sensor.send("depth", 41, moments[0]["depth"])
        sensor.send("color", 41, moments[0]["color"])
        assert camera.read(5.0).sequence == 41
    assert first == list(range(1, 9))


def record_file(sensor, moments, path):
    recorder = rs.recorder(str(path), sensor.device)
    received = threading.Semaphore(0)
    sensors = recorder.query_sensors()
    for one, name in zip(sensors, ("depth", "color"), strict=True):
        one.open(sensor.profiles[name])
        one.start(lambda _frame: received.release())
    for number, moment in enumerate(moments, start=1):
        for name in ("depth", "color"):
            sensor.send(name, number, moment[name])
            assert received.acquire(timeout=5)
    for one in sensors:
        one.stop()
        one.close()


@pytest.fixture
def file(sensor, moments, tmp_path):
    path = tmp_path / "recorded.db3"
    record_file(sensor, moments, path)
    return path


def test_a_file_of_the_library_plays_bit_by_bit_to_its_end(file, moments):
    with open_source(f"realsense:{file}") as camera:
        info = camera.info
        frames = []
        while (frame := camera.read(5.0)) is not None:
            frames.append(frame)
        assert camera.read(5.0) is None
        assert not camera.is_live
    assert [frame.sequence for frame in frames] == [1, 2, 3, 4, 5]
    for frame, moment in zip(frames, moments, strict=True):
        np.testing.assert_array_equal(frame.depth_raw, moment["depth"])
        np.testing.assert_array_equal(frame.color, moment["color"])
    assert (info.sensor_serial, info.depth_unit_m) == ("0123456789", SCALE_M)
    np.testing.assert_allclose(info.calibration.color.distortion, LENS, atol=1e-7)
    np.testing.assert_allclose(
        info.calibration.color_from_depth.translation_m, [0.015, 0.0, 0.001], atol=1e-6
    )


@pytest.fixture
def long_file(sensor, moments, tmp_path):
    """Hold more moments than the camera's queue has room for."""
    path = tmp_path / "long.db3"
    record_file(sensor, moments * 6, path)
    return path


def test_a_slow_reader_of_a_file_loses_nothing(long_file, moments):
    with open_source(f"realsense:{long_file}") as camera:
        sequences = []
        while (frame := camera.read(5.0)) is not None:
            sequences.append(frame.sequence)
            if frame.sequence == 2:
                threading.Event().wait(1.2)
    assert sequences == list(range(1, 6 * len(moments) + 1))


class LateSensor:
    """A sensor after whose start the computer is busy with something else."""

    def __init__(self, sensor):
        self.sensor, self.name = sensor, sensor.name
        self.open, self.stop, self.close = sensor.open, sensor.stop, sensor.close

    def start(self, on_frame):
        self.sensor.start(on_frame)
        threading.Event().wait(0.2)


def test_a_file_begins_with_its_first_frame_however_late_its_second_sensor_starts(
    long_file, moments, monkeypatch
):
    by_sensor = realsense._by_sensor
    monkeypatch.setattr(
        realsense,
        "_by_sensor",
        lambda profiles: [(LateSensor(one), modes) for one, modes in by_sensor(profiles)],
    )
    with open_source(f"realsense:{long_file}") as camera:
        first = camera.read(5.0)
    assert first.sequence == 1
    np.testing.assert_array_equal(first.color, moments[0]["color"])


def test_a_file_that_is_closed_in_the_middle_does_not_hang(file):
    with open_source(f"realsense:{file}") as camera:
        assert camera.read(5.0).sequence == 1


@pytest.mark.parametrize("name", ["broken.db3", "broken.bag"])
def test_a_broken_file_is_told_in_one_sentence(tmp_path, name):
    (tmp_path / name).write_bytes(b"no recording" * 100)
    with pytest.raises(SensorError, match="is no recording of the RealSense library"):
        open_source(f"realsense:{tmp_path / name}")


def test_a_missing_file_is_told_in_one_sentence(tmp_path):
    with pytest.raises(SensorError, match=r"none\.bag is not there"):
        open_source(f"realsense:{tmp_path / 'none.bag'}")


def test_without_a_sensor_the_user_is_told_to_plug_one_in():
    with pytest.raises(SensorError, match=r"^No RealSense is found\. Plug it into a USB 3 port"):
        open_source("realsense")


class PluggedIn:
    """What the library sees when these sensors are plugged in."""

    def __init__(self, devices):
        self.devices = devices

    def query_devices(self):
        return self.devices


def test_of_several_sensors_one_is_opened_by_its_serial_number(monkeypatch):
    sensors = [SoftwareSensor("0001"), SoftwareSensor("0002")]
    context = PluggedIn([one.device for one in sensors])
    monkeypatch.setattr(rs, "context", lambda: context)
    found = list_sensors()
    assert [one.serial for one in found] == ["0001", "0002"]
    sources = [source_of("realsense", one, found) for one in found]
    assert sources == ["realsense:0001", "realsense:0002"]
    for source, serial in (*zip(sources, ("0001", "0002"), strict=True), ("realsense", "0001")):
        with open_source(source) as camera:
            assert camera.info.sensor_serial == serial
    with pytest.raises(SensorError, match="The sensor 0003 is not plugged in"):
        open_source("realsense:0003")


def test_registration_by_the_sensor_is_refused():
    with pytest.raises(SensorError, match="does not register depth to colour itself"):
        open_source("realsense", SensorOptions(is_depth_registered=True))


class Unpluggable:
    """A device that is gone as soon as it is told so."""

    def __init__(self, device):
        self._device = device
        self.is_gone = False

    def is_connected(self):
        return not self.is_gone

    def __getattr__(self, name):
        return getattr(self._device, name)


def test_unplugging_ends_in_one_sentence_at_once(sensor, moments):
    device = Unpluggable(sensor.device)
    with RealSenseCamera(device) as camera:
        send_all(sensor, moments, ("depth", "color"))
        device.is_gone = True
        assert [camera.read(60.0).sequence for _ in moments] == [1, 2, 3, 4, 5]
        with pytest.raises(SensorError, match="Software D435 was unplugged"):
            camera.read(60.0)


def test_the_library_may_not_hand_on_statistics_of_use(monkeypatch):
    monkeypatch.setenv("RS2_RUM_CLOUD_ENABLED", "1")
    load_realsense()
    assert os.environ["RS2_RUM_CLOUD_ENABLED"] == "0"
