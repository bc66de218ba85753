"""What the built program is made of, and what it tells the desktop; nothing is built here."""

import os
import re
import shutil
import subprocess
import sys
import sysconfig
import xml.etree.ElementTree as ET
from importlib.util import find_spec
from pathlib import Path

import pytest
import yaml
from PIL import Image

from adibas import __version__
from adibas.cli import command_line
from adibas.recordings import RECORDING_ENDINGS
from adibas.sessions.migrating import REVISIONS
from installers import bundle, debian, freezing
from installers.icon_files import FOLDER, drawn, write_icon
from installers.manual import build
from ui import main

LINUX = bundle.ROOT / "installers" / "linux"
WORKFLOW = bundle.ROOT / ".github" / "workflows" / "installers.yml"
LIBRARIES = Path(sysconfig.get_path("purelib"))
MIME = {"mime": "http://www.freedesktop.org/standards/shared-mime-info"}
RULE = re.compile(r'(ATTR\{id\w+\}=="[0-9a-f]{4}", ){1,2}MODE="0660", GROUP="plugdev", ')


def test_the_program_takes_all_resources_and_steps_of_the_store_along():
    places = {Path(source): folder for source, folder in bundle.data_files()}
    assert places[bundle.ROOT / "resources"] == "resources"
    assert places[REVISIONS] == "adibas/sessions/migrations"
    assert all(source.exists() for source in places)


def test_nothing_is_left_out_that_is_asked_for():
    assert not set(bundle.UNSEEN) & set(bundle.EXCLUDED)
    assert all(find_spec(name) for name in bundle.UNSEEN)


IMPORTED = """
import importlib, pkgutil, sys
import adibas, ui
from installers.start import leave_out_open_gl

def tell_file(event, details):
    if event == "open" and isinstance(details[0], str):
        print("opened", details[0])

class LeftOut:
    def find_spec(self, name, path=None, target=None):
        if any(f"{name}.".startswith(f"{one}.") for one in sys.argv[1:]):
            raise ModuleNotFoundError(f"{name} is left out", name=name)

sys.addaudithook(tell_file)
sys.meta_path.insert(0, LeftOut())
for package in (adibas, ui):
    for module in pkgutil.walk_packages(package.__path__, f"{package.__name__}."):
        if ".migrations." not in module.name:  # these run inside Alembic alone
            importlib.import_module(module.name)

sys.frozen = True
leave_out_open_gl()
import numpy, pyqtgraph  # what is imported when it is needed
from hmmlearn.hmm import GaussianHMM
from PySide6.QtWidgets import QApplication
from adibas.reports.fonts import picture_font

application = QApplication(["adibas"])
widget = pyqtgraph.PlotWidget()
widget.plot([1.0, 2.0])
values = numpy.r_[numpy.linspace(0, 1, 20), numpy.linspace(9, 10, 20)][:, None]
states = GaussianHMM(2, random_state=1).fit(values).predict(values)
assert numpy.unique(states[:20]).size == numpy.unique(states[20:]).size == 1
assert picture_font(12).getlength("knee") > 0
"""


@pytest.fixture(scope="module")
def without_left_out():
    """What Python says that has the whole program and not what is left out."""
    command = [sys.executable, "-c", IMPORTED, *bundle.EXCLUDED]
    how = {"env": {**os.environ, "QT_QPA_PLATFORM": "offscreen"}, "cwd": bundle.ROOT}
    return subprocess.run(command, capture_output=True, text=True, check=False, **how)


def test_every_module_of_the_program_is_imported_without_what_is_left_out(without_left_out):
    assert without_left_out.returncode == 0, without_left_out.stderr[-2000:]


def test_no_file_that_is_left_out_is_opened(without_left_out):
    lines = without_left_out.stdout.splitlines()
    paths = [Path(line.removeprefix("opened ")) for line in lines if line.startswith("opened ")]
    names = [str(path.relative_to(LIBRARIES)) for path in paths if LIBRARIES in path.parents]
    files = [(name, str(LIBRARIES / name), "DATA") for name in names]
    assert "matplotlib/mpl-data/matplotlibrc" in names
    assert bundle.without_unneeded(files) == files


@pytest.mark.parametrize(
    ("file", "is_needed"),
    [
        (("PySide6/Qt/plugins/platforms/libqxcb.so", "x", "BINARY"), True),
        (("PySide6/Qt/plugins/platforms/libqoffscreen.so", "x", "BINARY"), True),
        (("PySide6/Qt/plugins/platforms/libqvnc.so", "x", "BINARY"), False),
        (("PySide6/Qt/plugins/printsupport/libcupsprintersupport.so", "x", "BINARY"), True),
        (("PySide6/Qt/plugins/imageformats/libqsvg.so", "x", "BINARY"), True),
        (("PySide6/Qt/plugins/imageformats/libqwebp.so", "x", "BINARY"), False),
        (("PySide6/Qt/translations/qtbase_ca.qm", "x", "DATA"), True),
        (("PySide6/Qt/translations/qtbase_pt_BR.qm", "x", "DATA"), True),
        (("PySide6/Qt/translations/qtbase_fr.qm", "x", "DATA"), False),
        (("sklearn/svm/_libsvm.cpython-311-x86_64-linux-gnu.so", "x", "EXTENSION"), True),
        (("sklearn/svm/_libsvm.pyx", "x", "DATA"), False),
        (("sklearn/svm/src/liblinear/linear.cpp", "x", "DATA"), False),
        (("sklearn/svm/src/liblinear/COPYRIGHT", "x", "DATA"), True),
        (("sklearn/datasets/images/china.jpg", "x", "DATA"), False),
        (("sklearn/utils/_repr_html/estimator.css", "x", "DATA"), True),
        (("pyqtgraph/icons/peegee/peegee_512px.png", "x", "DATA"), False),
        (("pyqtgraph/icons/lock.svg", "x", "DATA"), True),
        (("resources/translations/es/qt.ts", "x", "DATA"), False),
        (("resources/translations/es/qt.qm", "x", "DATA"), True),
        (("numba-0.68.1.dist-info/RECORD", "x", "DATA"), False),
        (("numba-0.68.1.dist-info/METADATA", "x", "DATA"), True),
        (("libavif-1.so", "pillow.libs/libavif-1.so", "SYMLINK"), False),
        (("libtiff-1.so", "pillow.libs/libtiff-1.so", "SYMLINK"), True),
    ],
)
def test_what_nobody_needs_stays_out(file, is_needed):
    assert bundle.without_unneeded([file]) == [file] * is_needed


@pytest.mark.skipif(sys.platform != "linux", reason="Debian's libraries")
def test_debians_own_libraries_stay_out_but_not_python():
    folder = "/usr/lib/x86_64-linux-gnu/"
    files = [(name, folder + name, "BINARY") for name in ("libxcb.so.1", "libpython3.11.so.1.0")]
    assert bundle.without_unneeded(files) == files[1:]


def test_the_package_asks_for_what_is_loaded_by_name_and_not_for_what_tests_need():
    names = debian.listed_packages()
    assert {"libgomp1", "libxcb-cursor0", "libegl1", "libopenni2-0", "libcups2"} <= set(names)
    assert not {"xvfb", "g++", "python3-venv"} & set(names)


def test_a_package_that_is_not_finished_does_not_take_the_place_of_the_one_before(
    tmp_path, monkeypatch
):
    before = tmp_path / f"adibas_{__version__}_amd64.deb"
    before.write_bytes(b"whole")

    def packed_halfway(program, *arguments):
        if program == "dpkg-deb":
            Path(arguments[-1]).write_bytes(b"half")
            raise SystemExit("dpkg-deb failed")
        return "amd64\n"

    monkeypatch.setattr(debian, "OUT", tmp_path)
    monkeypatch.setattr(debian.freezing, "WORK", tmp_path)
    monkeypatch.setattr(debian, "_run", packed_halfway)
    for name in ("lay_out", "write_control"):
        monkeypatch.setattr(debian, name, lambda _tree: None)
    with pytest.raises(SystemExit, match="dpkg-deb failed"):
        debian.build_package()
    assert [path.read_bytes() for path in tmp_path.iterdir()] == [b"whole"]


def test_nothing_is_built_without_the_manual(tmp_path, monkeypatch):
    monkeypatch.setattr(freezing, "MANUAL", tmp_path / "index.html")
    monkeypatch.setattr(freezing, "collect", lambda: pytest.fail("it is built"))
    with pytest.raises(SystemExit, match="Build it: python -m installers"):
        freezing.freeze()


@pytest.mark.parametrize("script", ["windows/build.ps1", "macos/build.sh"])
def test_other_systems_build_the_manual_before_the_program(script):
    """On Debian it is a target of the Makefile that `make installer` asks for."""
    text = (LINUX.parent / script).read_text(encoding="utf-8")
    modules = re.findall(r"python -m (installers[.\w]+)", text)
    assert modules == ["installers.manual.build", "installers.freezing"]
    assert freezing.MANUAL.parent == build.BUILT


def test_every_system_has_a_job_that_builds_on_a_machine_which_can():
    jobs = yaml.safe_load(WORKFLOW.read_text(encoding="utf-8"))["jobs"]
    commands = {
        name: [step["run"] for step in job["steps"] if "run" in step] for name, job in jobs.items()
    }
    assert commands["linux"][-2:] == ["make installer", "make installer-check"]
    assert jobs["linux"]["container"]["options"] == "--privileged", "debootstrap mounts"
    for name, script in (("windows", "windows/build.ps1"), ("macos", "macos/build.sh")):
        assert commands[name][-1] == f"installers/{script}"
        assert (LINUX.parent / script).is_file()


def test_what_is_not_made_for_a_system_is_not_asked_for_there():
    """Intel's library for its sensors has no wheel for macOS: pip would end there."""
    locked = (LINUX.parent / "requirements.lock").read_text(encoding="utf-8")
    (line,) = re.findall(r"^pyrealsense2==.*", locked, re.MULTILINE)
    assert "; sys_platform != 'darwin'" in line


def test_every_file_of_the_desktop_has_its_place():
    scripts = {"postinst", "postrm", "check.sh", "adibas.1"}
    assert {path.name for path in LINUX.iterdir()} == set(debian.PLACES) | scripts


@pytest.mark.skipif(shutil.which("desktop-file-validate") is None, reason="no desktop-file-utils")
def test_the_desktop_entry_is_valid():
    command = ["desktop-file-validate", str(LINUX / "adibas.desktop")]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout + done.stderr) == (0, "")


def test_the_desktop_knows_every_kind_of_recording_and_opens_it_with_us():
    types = ET.parse(LINUX / "adibas-mime.xml").getroot().findall("mime:mime-type", MIME)
    globs = {kind.find("mime:glob", MIME).get("pattern"): kind.get("type") for kind in types}
    assert {f"*{ending}" for ending in RECORDING_ENDINGS} <= set(globs)
    entry = (LINUX / "adibas.desktop").read_text(encoding="utf-8")
    (line,) = re.findall("^MimeType=(.*);$", entry, re.MULTILINE)
    assert set(line.split(";")) == {globs[f"*{ending}"] for ending in RECORDING_ENDINGS}


def test_the_program_takes_what_the_desktop_gives_it_for_a_recording():
    assert main.names_recording("Visit 2.MCAP")
    assert not any(map(main.names_recording, command_line.COMMANDS))


def test_without_a_display_a_recording_is_not_taken_for_a_command(monkeypatch, capsys):
    monkeypatch.setattr(sys, "argv", ["adibas", "visits/Visit 2.MCAP"])
    monkeypatch.setattr(main, "has_display", lambda: False)
    assert main.main() == 1
    told = capsys.readouterr().err
    assert told.startswith("There is no display to show Visit 2.MCAP on.")


def test_the_rules_of_the_sensors_are_lines_that_udev_reads():
    path = LINUX / "60-adibas-sensors.rules"
    assert path.name < "73"  # the tag is acted on there
    lines = [line for line in path.read_text().splitlines() if line and line[0] != "#"]
    assert lines[0] == 'ACTION=="remove", GOTO="adibas_end"'
    assert lines[-1] == 'LABEL="adibas_end"'
    assert all(RULE.match(line) and line.endswith('TAG+="uaccess"') for line in lines[3:-1])


@pytest.mark.parametrize("name", sorted(debian.ICONS))
def test_icons_are_drawn_in_their_size(name):
    icon = drawn(FOLDER / f"{name}.svg", 48)
    assert icon.size == (48, 48)
    assert icon.getextrema()[3] == (0, 255)  # transparent corners


@pytest.mark.parametrize("ending", [".ico", ".icns"])
def test_icons_of_other_systems_can_be_read(tmp_path, ending):
    write_icon(tmp_path / f"adibas{ending}")
    with Image.open(tmp_path / f"adibas{ending}") as icon:
        assert icon.width >= 256
