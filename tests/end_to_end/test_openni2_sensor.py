"""The real OpenNI2 library with a virtual sensor: all but the hardware."""

import json
import os
import subprocess
import sys

import numpy as np
import pytest

from adibas.recordings import open_recording
from adibas.recordings.decoding import decode_color
from tests.virtual_openni2.virtual_sensor import (
    COLOR,
    DEPTH,
    DEPTH_1_MM,
    DEPTH_100_UM,
    GRAY16,
    INFRARED,
    MODES,
    N_IMAGES,
    PROJECT,
    RGB888,
    VirtualSensor,
    build_openni2,
    write_dump,
)

DEPTH_MM = (DEPTH, DEPTH_1_MM, 640, 480, 30)
DEPTH_TENTHS = (DEPTH, DEPTH_100_UM, 640, 480, 30)
COLOR_SMALL = (COLOR, RGB888, 640, 480, 30)
COLOR_LARGE = (COLOR, RGB888, 1280, 1024, 10)
INFRARED_MODE = (INFRARED, GRAY16, 640, 480, 30)
REGISTRATION_SHIFT = 8

RECORD = """
with open_source("openni2", SensorOptions(**OPTIONS)) as camera:
    frames = [camera.read() for _ in range(4)]
    info = camera.info
    give(unit=info.depth_unit_m, rate=info.frame_rate_hz, name=info.sensor_name,
         serial=info.sensor_serial, is_registered=info.is_depth_registered, live=camera.is_live,
         offset=list(info.calibration.color_from_depth.translation_m))
give(sequence=[f.sequence for f in frames], time=[f.timestamp_ns for f in frames],
     color_time=[f.color_timestamp_ns for f in frames])
np.savez(FOLDER / "frames.npz", depth=[f.depth_raw for f in frames],
         color=[f.color for f in frames if f.color is not None],
         infrared=[f.infrared_raw for f in frames if f.infrared_raw is not None])
"""

REFUSED = """
try:
    with open_source("openni2", SensorOptions(**OPTIONS)) as camera:
        while camera.read(2.0) is not None:
            pass
except AdibasError as error:
    give(error=str(error), kind=type(error).__name__)
"""


@pytest.fixture(scope="session")
def library(tmp_path_factory):
    return build_openni2(tmp_path_factory.mktemp("openni2"))


@pytest.fixture(scope="session")
def dumped(tmp_path_factory):
    path = tmp_path_factory.mktemp("dump") / "sensor.bin"
    return path, write_dump(path, np.random.default_rng(5))


@pytest.fixture
def images(dumped):
    return dumped[1]


@pytest.fixture
def sensor(library, dumped, tmp_path):
    dump = tmp_path / "sensor.bin"
    dump.symlink_to(dumped[0])
    return VirtualSensor(library, dump)


def record(sensor, **options):
    """Return what was said and the images of four frames."""
    given = sensor.run(RECORD.replace("OPTIONS", repr(options)))
    with np.load(sensor.dump.parent / "frames.npz") as saved:
        return given, dict(saved)


def sent(images, mode, sequence, pace_mode):
    """Return the image of `mode` that the sensor sends with image `sequence` of `pace_mode`."""
    tick = (sequence - 1) * (30 // pace_mode[-1])
    return images[mode][tick // (30 // mode[-1]) % N_IMAGES]


def test_the_sensor_is_listed_with_its_serial_number_and_every_mode(sensor):
    given = sensor.run("""
from adibas.sensors.openni2_modes import list_sensors
found, = list_sensors()
give(name=found.name, vendor=found.vendor, serial=found.serial, uri=found.uri,
     modes=[[m.stream, m.pixel_format, m.width, m.height, m.frame_rate_hz] for m in found.modes])
""")
    names = {INFRARED: "infrared", COLOR: "color", DEPTH: "depth"}
    formats = {100: "DEPTH_1_MM", 101: "DEPTH_100_UM", 200: "RGB888", 203: "GRAY16"}
    expected = [[names[m[0]], formats[m[1]], *m[2:]] for m in MODES]
    assert sorted(given["modes"]) == sorted(expected)
    assert (given["name"], given["vendor"]) == ("Virtual sensor", "PrimeSense")
    assert (given["serial"], given["uri"]) == ("VIRTUAL-0001", "virtual/0")


def test_large_colour_and_depth_arrive_bit_by_bit_and_belong_together(sensor, images):
    given, frames = record(sensor)
    assert frames["color"].shape == (4, 1024, 1280, 3)
    assert given["time"] == given["color_time"]
    assert (given["unit"], given["rate"], given["live"]) == (0.001, 10.0, True)
    assert (given["name"], given["serial"]) == ("Virtual sensor", "VIRTUAL-0001")
    for i, sequence in enumerate(given["sequence"]):
        np.testing.assert_array_equal(
            frames["color"][i], sent(images, COLOR_LARGE, sequence, COLOR_LARGE)
        )
        np.testing.assert_array_equal(
            frames["depth"][i], sent(images, DEPTH_MM, sequence, COLOR_LARGE)
        )


def test_small_colour_comes_with_depth_in_tenths_of_a_millimetre(sensor, images):
    given, frames = record(sensor, color_size=(640, 480), depth_unit_m=0.0001)
    assert (given["unit"], given["rate"]) == (0.0001, 30.0)
    for i, sequence in enumerate(given["sequence"]):
        np.testing.assert_array_equal(
            frames["color"][i], sent(images, COLOR_SMALL, sequence, COLOR_SMALL)
        )
        np.testing.assert_array_equal(
            frames["depth"][i], sent(images, DEPTH_TENTHS, sequence, COLOR_SMALL)
        )


def test_the_sensor_registers_the_depth_itself_when_asked_and_only_then(sensor, images):
    given, frames = record(sensor, color_size=(640, 480), is_depth_registered=True)
    plain, _ = record(sensor, color_size=(640, 480))
    assert (given["is_registered"], plain["is_registered"]) == (True, False)
    assert (given["offset"], plain["offset"]) == ([0.0, 0.0, 0.0], [-0.025, 0.0, 0.0])
    expected = sent(images, DEPTH_MM, given["sequence"][0], COLOR_SMALL)
    np.testing.assert_array_equal(frames["depth"][0], np.roll(expected, -REGISTRATION_SHIFT, 1))


def test_infrared_comes_in_place_of_colour(sensor, images):
    given, frames = record(sensor, is_infrared=True)
    assert frames["color"].size == 0
    assert given["color_time"] == [None] * 4
    for i, sequence in enumerate(given["sequence"]):
        for name, mode in (("infrared", INFRARED_MODE), ("depth", DEPTH_MM)):
            expected = sent(images, mode, sequence, INFRARED_MODE)
            np.testing.assert_array_equal(frames[name][i], expected)


def test_a_sensor_that_insists_on_mirroring_is_mirrored_back(sensor, images):
    sensor.tell("mirrored")
    given, frames = record(sensor, color_size=(640, 480))
    for name, mode in (("color", COLOR_SMALL), ("depth", DEPTH_MM)):
        expected = sent(images, mode, given["sequence"][0], COLOR_SMALL)
        np.testing.assert_array_equal(frames[name][0], expected)


def test_unplugging_ends_in_one_sentence_at_once(sensor):
    given = sensor.run("""
with open_source("openni2") as camera:
    camera.read()
    Path(DUMP + ".unplug").touch()
    try:
        while True:
            camera.read(600.0)  # longer than this test may take: the message must be noticed
    except AdibasError as error:
        give(error=str(error), kind=type(error).__name__)
""")
    assert given["kind"] == "SensorError"
    assert given["error"] == (
        "The sensor Virtual sensor was unplugged. Plug it in again and try again."
    )


def test_a_silent_sensor_is_given_up_after_the_time_allowed(sensor):
    sensor.tell("silence")
    given = sensor.run("""
with open_source("openni2") as camera:
    try:
        camera.read(0.5)
    except AdibasError as error:
        give(error=str(error), kind=type(error).__name__)
""")
    assert given["kind"] == "SensorError"
    assert "sends no pictures" in given["error"]


def test_ctrl_c_ends_the_waiting_for_a_silent_sensor(sensor):
    given = sensor.run("""
import os, signal, threading
with open_source("openni2") as camera:
    camera.read()
    Path(DUMP + ".silence").touch()
    threading.Timer(0.5, os.kill, (os.getpid(), signal.SIGINT)).start()
    try:
        while True:
            camera.read(600.0)
    except KeyboardInterrupt:
        give(interrupted=True)
with open_source("openni2", SensorOptions(color_size=(640, 480))) as camera:
    give(opened=camera.info.sensor_name)
""")
    assert given == {"interrupted": True, "opened": "Virtual sensor"}


def test_closing_ends_a_read_of_another_thread(sensor):
    given = sensor.run("""
import threading
camera = open_source("openni2")
camera.read()
Path(DUMP + ".silence").touch()
given = []
def read():
    while (frame := camera.read(600.0)) is not None:
        pass
    given.append(frame)
reader = threading.Thread(target=read)
reader.start()
time.sleep(0.5)
camera.close()
reader.join()
give(given=given)
""")
    assert given == {"given": [None]}


@pytest.mark.parametrize("is_reading", [True, False])
def test_the_program_ends_with_an_open_sensor(sensor, is_reading):
    given = sensor.run(
        """
import threading
camera = open_source("openni2")
camera.read()
if IS_READING:
    Path(DUMP + ".silence").touch()
    threading.Thread(target=camera.read, args=(600.0,), daemon=True).start()
    time.sleep(0.5)
give(ends=True)
""".replace("IS_READING", str(is_reading))
    )
    assert given == {"ends": True}


def test_a_sensor_opens_again_and_again_in_one_process(sensor):
    given = sensor.run("""
import threading
sizes = []
for size in [(640, 480), (1280, 1024)] * 3:
    with open_source("openni2", SensorOptions(color_size=size)) as camera:
        sizes.append(camera.read().color.shape[1])
    camera.close()
give(sizes=sizes, threads=[one.name for one in threading.enumerate()])
""")
    assert given["sizes"] == [640, 1280] * 3
    assert given["threads"] == ["MainThread", "camera library"]


def test_a_live_sensor_is_recorded_until_it_is_unplugged(sensor, images):
    given = sensor.run("""
from adibas.pipeline.recording import record
def unplug(n_written, _n_expected):
    if n_written > 5:
        Path(DUMP + ".unplug").touch()
with open_source("openni2", SensorOptions(color_size=(640, 480))) as camera:
    try:
        record(camera, FOLDER / "live.mcap", progress=unplug)
    except AdibasError as error:
        give(error=str(error), kind=type(error).__name__)
""")
    path = sensor.dump.parent / "live.mcap"
    assert given["kind"] == "SensorError"
    assert "Virtual sensor was unplugged" in given["error"]
    assert given["error"].endswith(f"are kept in {path}.")
    with open_recording(path) as recording:
        assert recording.notice is None
        assert recording.info.sensor_serial == "VIRTUAL-0001"
        assert len(recording) > 5
        for frame in recording:
            depth = sent(images, DEPTH_MM, frame.sequence, COLOR_SMALL)
            np.testing.assert_array_equal(frame.depth_raw, depth)


def test_the_command_records_a_live_sensor_for_the_seconds_asked(sensor, images):
    # On a busy machine frames may be lost, and then it says so.
    given = sensor.run(
        """
import sys
from ui.main import main
from contextlib import redirect_stdout
sys.argv = ["adibas", "record", "openni2", "--seconds", "1", "--out", str(FOLDER / "live.mcap")]
with (FOLDER / "said.txt").open("w") as said, redirect_stdout(said):
    code = main()
give(code=code)
""",
        allowed="too slow",
    )
    assert given["code"] == 0
    with open_recording(sensor.dump.parent / "live.mcap") as recording:
        frame, last = recording.read(0), recording.read(len(recording) - 1)
        assert 0 <= last.timestamp_ns - frame.timestamp_ns < 1_000_000_000
        n_counted = last.sequence - frame.sequence + 1
        # Ten periods of 99,999 microseconds are a little less than the second.
        assert n_counted <= len(recording) + recording.info.n_dropped <= 11
    color = decode_color(frame.color, frame.sequence)
    np.testing.assert_array_equal(color, sent(images, COLOR_LARGE, frame.sequence, COLOR_LARGE))


def test_the_doctor_names_the_sensor(sensor):
    given = sensor.run("""
from adibas.sensors.doctor import findings
give(**{finding.name: finding.detail for finding in findings()})
""")
    assert given["OpenNI2"] == (
        "Virtual sensor, serial number VIRTUAL-0001, colour 1280 x 1024, 640 x 480"
    )


def test_without_a_sensor_the_user_is_told_to_plug_one_in(sensor):
    sensor.tell("gone")
    given = sensor.run(REFUSED.replace("OPTIONS", "{}"))
    assert given["kind"] == "SensorError"
    assert given["error"].startswith("OpenNI2 finds no sensor. Plug it in")


def test_a_sensor_that_cannot_register_says_so(sensor):
    sensor.tell("plain")
    given = sensor.run(REFUSED.replace("OPTIONS", repr({"is_depth_registered": True})))
    assert given["kind"] == "SensorError"
    assert "cannot register depth to colour itself" in given["error"]


def test_a_depth_unit_that_no_sensor_has_is_refused(sensor):
    given = sensor.run(REFUSED.replace("OPTIONS", repr({"depth_unit_m": 0.01})))
    assert given["error"] == (
        "OpenNI2 sensors measure depth in units of 1 mm or 0.1 mm, not 10 mm."
    )


def test_of_two_sensors_each_is_opened_by_its_serial_number_or_its_address(sensor):
    sensor.tell("second")
    given = sensor.run("""
from adibas.sensors.openni2_modes import list_sensors
from adibas.sensors.sources import source_of
found = list_sensors()
opened = {}
for source in (*(source_of("openni2", one, found) for one in found), "openni2:virtual/1"):
    with open_source(source, SensorOptions(color_size=(640, 480))) as camera:
        opened[source] = camera.info.sensor_serial
        camera.read()
with open_source("openni2:VIRTUAL-0001") as one, open_source("openni2:VIRTUAL-0002") as other:
    both = [camera.info.sensor_serial for camera in (one, other) if camera.read()]
try:
    open_source("openni2:VIRTUAL-0003")
except AdibasError as error:
    give(error=str(error))
give(opened=opened, both=both)
""")
    assert given["opened"] == {
        "openni2:VIRTUAL-0001": "VIRTUAL-0001",
        "openni2:VIRTUAL-0002": "VIRTUAL-0002",
        "openni2:virtual/1": "VIRTUAL-0002",
    }
    assert given["both"] == ["VIRTUAL-0001", "VIRTUAL-0002"]
    assert given["error"].startswith("The sensor VIRTUAL-0003 is not plugged in.")


def test_two_sensors_with_one_serial_number_are_told_apart_by_their_addresses(sensor):
    sensor.tell("second")
    sensor.tell("twins")
    given = sensor.run("""
from adibas.sensors.openni2_modes import list_sensors
from adibas.sensors.sources import source_of
found = list_sensors()
give(serials=[one.serial for one in found],
     sources=[source_of("openni2", one, found) for one in found])
""")
    assert given["serials"] == ["VIRTUAL-0001"] * 2
    assert given["sources"] == ["openni2:virtual/0", "openni2:virtual/1"]


def test_a_sensor_that_is_pulled_out_while_recording_comes_back_each_time(sensor):
    """`adibas benchmark reliability sensor` pulls it a hundred times."""
    run = subprocess.run(
        [sys.executable, "-m", "benchmarks.sensor_trial", "3"],
        cwd=PROJECT,
        env=os.environ
        | {"OPENNI2_REDIST": str(sensor.library), "ADIBAS_VIRTUAL_SENSOR": str(sensor.dump)},
        capture_output=True,
        text=True,
        timeout=180,
        check=False,
    )
    assert run.returncode == 0, run.stderr
    *pulls, end = map(json.loads, run.stdout.splitlines())
    assert end == {"left": []}
    for pull in pulls:
        assert "was unplugged" in pull["sentence"]
        assert pull["burst"]
    assert len(pulls) == 3
    assert pulls[-1]["n_threads"] == pulls[1]["n_threads"]
    assert pulls[-1]["n_files"] == pulls[1]["n_files"]
