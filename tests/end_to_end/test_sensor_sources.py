"""The text that names a source, what the machine has, and libraries that are not there."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from adibas.errors import FileError, SensorError
from adibas.sensors import open_source
from adibas.sensors.doctor import findings
from adibas.sensors.openni2_library import find_library_folder, load_openni2
from adibas.sensors.ports import SensorDescription
from adibas.sensors.sources import is_sensor, source_of

PROJECT = Path(__file__).parents[2]


@pytest.mark.parametrize("text", ["", "openni3", "openni3:x.bag", "no/such/file"])
def test_an_unknown_source_lists_what_is_possible(text):
    with pytest.raises(SensorError) as told:
        open_source(text)
    for possible in ("openni2:FILE.oni", "realsense", "simulator:SCENE", "recording"):
        assert possible in str(told.value)


@pytest.mark.parametrize("name", ["visit.mcap", "VISIT.ONI"])
def test_a_recording_that_is_gone_is_named_without_its_folder(name):
    with pytest.raises(FileError) as told:
        open_source(f"no/such/{name}")
    assert str(told.value) == f"{name} is not there. Check the name and the folder."


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("openni2", True),
        ("openni2:1d27/0609@1/4", True),
        ("realsense:0123456789", True),
        ("openni2:walk.oni", False),
        ("openni2:WALK.ONI", False),
        ("realsense:walk.db3", False),
        ("simulator", False),
        ("walk.mcap", False),
    ],
)
def test_a_sensor_is_told_from_a_file(text, expected):
    assert is_sensor(text) is expected


def test_a_file_without_the_usual_ending_is_no_sensor(tmp_path):
    (tmp_path / "walk").touch()
    assert not is_sensor(f"openni2:{tmp_path / 'walk'}")


def test_a_single_sensor_needs_no_name_and_others_the_serial_number_or_the_address():
    one, twin, nameless = (
        SensorDescription("Xtion", "Asus", serial, f"address/{number}")
        for number, serial in enumerate(("A1", "A1", ""))
    )
    other = SensorDescription("Xtion", "Asus", "B2", "address/3")
    every = (one, twin, nameless, other)
    assert source_of("openni2", one, (one,)) == "openni2"
    assert [source_of("openni2", sensor, every) for sensor in every] == [
        "openni2:address/0",
        "openni2:address/1",
        "openni2:address/2",
        "openni2:B2",
    ]


def test_the_first_kinect_is_not_available_and_says_so():
    with pytest.raises(SensorError, match=r"kinect1.* is not available in this version"):
        open_source("kinect1")


@pytest.mark.parametrize(
    ("module", "source", "remedy"),
    [
        ("openni", "openni2", "pip install openni"),
        ("pyrealsense2", "realsense", "pip install pyrealsense2"),
    ],
)
def test_a_missing_binding_says_how_to_install_it(monkeypatch, module, source, remedy):
    monkeypatch.setitem(sys.modules, module, None)
    with pytest.raises(SensorError, match=remedy):
        open_source(source)


def test_a_missing_openni2_library_says_how_to_install_it(monkeypatch, tmp_path):
    for name in ("OPENNI2_REDIST", "OPENNI2_REDIST64"):
        monkeypatch.delenv(name, raising=False)
    with pytest.raises(SensorError, match="sudo apt-get install libopenni2-0"):
        find_library_folder((tmp_path,))


def test_the_variable_of_openni2_goes_before_the_system(monkeypatch, tmp_path):
    (tmp_path / "libOpenNI2.so").touch()
    monkeypatch.delenv("OPENNI2_REDIST64", raising=False)
    monkeypatch.setenv("OPENNI2_REDIST", str(tmp_path))
    assert find_library_folder() == tmp_path


def test_a_library_without_the_development_link_is_found_and_loads(tmp_path):
    """Debian's libopenni2-0 alone has libOpenNI2.so.0 only."""
    installed = next(Path("/usr/lib").glob("*/libOpenNI2.so.0")).parent
    bare = tmp_path / "lib"
    bare.mkdir()
    (bare / "libOpenNI2.so.0").symlink_to(installed / "libOpenNI2.so.0")
    (bare / "OpenNI2").symlink_to(installed / "OpenNI2")
    script = (
        "from pathlib import Path; import sys, os\n"
        "from adibas.sensors import openni2_library as library\n"
        "folder = library.find_library_folder((Path(sys.argv[1]),))\n"
        "assert folder == library.find_library_folder((Path(sys.argv[1]),))\n"
        "os.environ['OPENNI2_REDIST'] = str(folder)\n"
        "from openni import openni2\n"
        "assert library.load_openni2() is openni2\n"
        "print(openni2.loaded_dll_directory)\n"
    )
    environment = os.environ | {"XDG_CACHE_HOME": str(tmp_path / "cache")}
    for name in ("OPENNI2_REDIST", "OPENNI2_REDIST64"):
        environment.pop(name, None)
    run = subprocess.run(
        [sys.executable, "-W", "error", "-c", script, str(bare)],
        cwd=PROJECT,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert (run.returncode, run.stderr) == (0, "")
    assert run.stdout.strip() == str(tmp_path / "cache" / "adibas" / "openni2")


def test_the_library_is_loaded_once():
    assert load_openni2() is load_openni2()


def test_the_doctor_finds_what_the_tests_need():
    found = {finding.name: finding for finding in findings()}
    for name in ("Qt", "OpenCV", "numba", "OpenNI2", "RealSense"):
        assert found[name].ok, found[name]
        assert found[name].detail


def test_the_doctor_survives_a_bare_machine(monkeypatch, tmp_path):
    for module in ("openni", "pyrealsense2"):
        monkeypatch.setitem(sys.modules, module, None)
    monkeypatch.setattr("importlib.util.find_spec", lambda _name: None)
    found = findings(tmp_path / "no such folder")
    lacking = {finding.name: finding for finding in found if not finding.ok}
    assert {"Qt", "OpenCV", "numba", "OpenNI2", "RealSense", "Disk"} <= set(lacking)
    assert all(finding.remedy and finding.detail for finding in lacking.values())


def test_the_doctor_imports_no_qt_and_no_opencv():
    script = (
        "import sys\nfrom adibas.sensors.doctor import findings\nfindings()\n"
        "print(sorted({'PySide6', 'cv2', 'numba'} & set(sys.modules)))"
    )
    run = subprocess.run(
        [sys.executable, "-c", script], cwd=PROJECT, capture_output=True, text=True, check=True
    )
    assert run.stdout.strip() == "[]"
