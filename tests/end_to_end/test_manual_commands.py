"""Every command in the manual runs; what takes minutes or a sensor, on something like it."""

import re
import runpy
import shlex
import shutil
import sys
from datetime import timedelta
from functools import partial
from itertools import count, takewhile
from pathlib import Path

import numpy as np
import openpyxl
import pytest

from adibas.calibration.files import read_calibration
from adibas.cli import main
from adibas.cli.command_line import build_parser
from adibas.pipeline import demo as demo_session
from adibas.pipeline.learning import LearningRequest, learn_from_file
from adibas.recordings import create_recording, open_recording
from adibas.resources import resource_path
from adibas.sensors import simulator
from adibas.simulation.body_shape import BodyShape
from adibas.simulation.patient import MarkerSettings
from adibas.simulation.scenes import open_scene
from installers.bundle import ROOT
from installers.manual.pictures import MANUAL
from tests.end_to_end.hurried_board import hurried_scene
from tests.unit.store_samples import PASSPHRASE, START, add_patient, open_sample
from tests.unit.test_protocol_sessions import add_visit
from tests.virtual_openni2.virtual_sensor import VirtualSensor, build_openni2, write_dump

FENCE = re.compile(r"```\n(.*?)```", re.DOTALL)
IN_SENTENCE = re.compile(r"`adibas ([^`\d][^`]*)`")
WORD, OPTION = re.compile(r"[a-z][a-z-]*"), re.compile(r"--[a-z-]+")
FIRST = ("commands", "markers", "behaviour")
"""Pages that make what the others use."""
PAGES = sorted(
    [*MANUAL.glob("en/*.md"), *MANUAL.glob("developers/*.md")],
    key=lambda path: FIRST.index(path.stem) if path.stem in FIRST else len(FIRST),
)
N_FRAMES = 3
"""Of each capture of the demo: enough for every command."""
ELSEWHERE = {
    "openni2": "a virtual sensor",
    "simulator:board": "a board that hurries from stop to stop",
    "board.mcap": "the same",
    "wand.mcap": "somebody whose glabella and elbow lie half a metre apart",
    "--compared-with": "two sessions of a patient",
}
"""What a command has that is run below, on something that takes minutes or is lacking here."""
HALF_A_METRE_APART_M = 1.435
"""Stature of somebody whose glabella and left elbow are ends of a wand of 500 mm."""
FRAMES_STILL = 31
"""At a stop, one after the other: a second is a burst."""
MAY_SAY_NO = ("doctor",)
"""Its exit code tells what this machine lacks."""


def commands():
    """Return the commands of all pages in their order, each once."""
    blocks = (block for page in PAGES for block in FENCE.findall(page.read_text(encoding="utf-8")))
    lines = (line.strip() for block in blocks for line in block.splitlines())
    return list(dict.fromkeys(lines))


def needs_more(command):
    return any(what in command for what in ELSEWHERE)


RUN = [one for one in commands() if not needs_more(one)]


def command_with(*parts):
    """Return the one command of the manual that has all of these in it."""
    (found,) = (one for one in commands() if all(part in one for part in parts))
    return shlex.split(found)[1:]


@pytest.fixture
def workplace(tmp_path, monkeypatch):
    """A folder where somebody types the manual's commands, and the files that its pages show.

    The store of this user is the one that the demo fills.
    """
    for path in (MANUAL / "developers").glob("*example*"):
        shutil.copy(path, tmp_path)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("ADIBAS_PASSPHRASE", "adibas-demo")
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))
    (tmp_path / "data" / "adibas").mkdir(parents=True)
    (tmp_path / "data" / "adibas" / "store").symlink_to(tmp_path / "demo" / "store")
    monkeypatch.setattr(demo_session, "N_FRAMES", N_FRAMES)
    return tmp_path


def exit_code(command, monkeypatch):
    """Run a command as it stands on the page."""
    program, *words = shlex.split(command)
    try:
        if program == "adibas":
            return main(words)
        monkeypatch.setattr(sys, "argv", words)
        runpy.run_path(words[0], run_name="__main__")
    except SystemExit as ended:
        return ended.code
    return 0


def test_a_visitor_types_every_command_of_the_manual(workplace, monkeypatch, capsys):
    session = ""
    for command in RUN:
        code = exit_code(command.replace("SESSION", session), monkeypatch)
        told = capsys.readouterr()
        assert code == 0 or command.split()[1] in MAY_SAY_NO, f"{command}: {told}"
        if command.startswith("adibas sessions list"):
            session = next(iter(re.findall(r"[0-9a-f]{32}", told.out)), session)
    for name in ("report.xlsx", "back.pdf", "movement.c3d", "timeline.xlsx", "agreement.xlsx"):
        assert (workplace / name).stat().st_size > 1000, name
    assert (workplace / "restored" / "adibas.db").is_file()


@pytest.fixture(scope="module")
def sensor(tmp_path_factory):
    """A virtual OpenNI2 sensor."""
    folder = tmp_path_factory.mktemp("sensor")
    write_dump(folder / "sensor.bin", np.random.default_rng(5))
    return VirtualSensor(build_openni2(folder / "openni2"), folder / "sensor.bin")


@pytest.mark.parametrize("out", ["patient-7.mcap", "wand.mcap"])
def test_a_sensor_is_recorded_as_the_manual_says(sensor, tmp_path, out):
    words = command_with("record openni2", out)
    given = sensor.run(f"""
import contextlib, io, os
from adibas.cli import main
os.chdir({str(tmp_path)!r})
with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
    code = main({words!r})
give(code=code)
""")
    assert given["code"] == 0
    with open_recording(tmp_path / out) as recording:
        assert len(recording) > 3


def test_a_board_is_recorded_and_calibrates_the_sensor_as_the_manual_says(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    still = partial(hurried_scene, still_every=1, frames_a_stop=FRAMES_STILL)
    monkeypatch.setattr(simulator, "open_scene", still)
    assert main(command_with("record simulator:board")) == 0
    assert main(command_with("calibrate board.mcap")) == 0
    found = read_calibration(tmp_path / "sensor.json")
    truth = hurried_scene("board").device.calibration
    assert found.color.intrinsics.fx == pytest.approx(truth.color.intrinsics.fx, rel=2e-3)
    assert (tmp_path / "sensor.pdf").stat().st_size > 1000


def test_a_wand_is_measured_as_the_manual_says(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    ends = MarkerSettings(("glabella", "left_elbow"), diameter_m=0.015)
    shape = BodyShape("female", 30, HALF_A_METRE_APART_M, 60)
    scene = open_scene("anterior", seed=7, markers=ends, shape=shape, is_swaying=False)
    with create_recording(tmp_path / "wand.mcap", scene.info) as writer:
        for index in range(6):
            writer.write(scene.frame(index).sensor_frame)
    truth = scene.frame(0).truth.markers
    clicks = tuple((one.u, one.v) for one in truth)
    learn_from_file(LearningRequest(tmp_path / "wand.mcap", clicks), tmp_path / "green.json")
    assert main(command_with("wand wand.mcap")) == 0
    assert "The wand of 500.0 mm measures" in capsys.readouterr().out


def test_two_sessions_are_compared_as_the_manual_says(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("ADIBAS_PASSPHRASE", PASSPHRASE)
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))
    (tmp_path / "data" / "adibas").mkdir(parents=True)
    days = (START + timedelta(days=30, minutes=n) for n in count())
    with open_sample(tmp_path / "data" / "adibas" / "store", clock=days.__next__) as store:
        patient = add_patient(store).pseudonym
        earlier, later = (add_visit(store, patient, [height_m]) for height_m in (0.0, 0.03))
    words = command_with("--compared-with")
    named = {"SESSION": later, "EARLIER": earlier}
    assert main([named.get(word, word) for word in words]) == 0
    (report,) = (tmp_path / "report").rglob("*.xlsx")
    assert "Changes" in openpyxl.load_workbook(report).sheetnames


def test_every_command_is_run_by_one_of_these_tests():
    rest = [one for one in commands() if one not in RUN]
    assert len(rest) == 6
    assert {what for what in ELSEWHERE if any(what in one for one in rest)} == set(ELSEWHERE)


def test_every_command_in_a_sentence_is_known(capsys):
    """With its subcommand and its options: in the manual, the window's help and all pages."""
    pages = [ROOT / "README.md", *Path(ROOT / "docs").rglob("*.md")]
    pages += resource_path("help").rglob("*.md")
    named = {one for page in pages for one in IN_SENTENCE.findall(page.read_text("utf-8"))}
    assert len(named) > 50
    for command in sorted(named - {"FILE"}):
        words = command.replace("|", " ").split()
        path = list(takewhile(WORD.fullmatch, words))
        with pytest.raises(SystemExit) as ended:
            build_parser().parse_args([*path[:2], "--help"])
        told = capsys.readouterr().out
        assert ended.value.code == 0, command
        is_command = f"usage: adibas {' '.join(path[:2])} " in told
        assert is_command or f"usage: adibas {path[0]} " in told, command
        options = {one for word in words for one in OPTION.findall(word)}
        assert {one for one in options if one not in told} == set(), command
