"""Every command in the manual runs, or is at least understood; and says why where it cannot run."""

import re
import runpy
import shlex
import shutil
import sys
from itertools import takewhile
from pathlib import Path

import pytest

from adibas.cli import main
from adibas.cli.command_line import build_parser
from adibas.pipeline import demo as demo_session
from adibas.resources import resource_path
from installers.bundle import ROOT
from installers.manual.pictures import MANUAL

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
NOT_RUN = {
    "openni2": "a sensor is needed",
    "simulator:board": "75 s of a simulated board take minutes",
    "board.mcap": "is what the line before it records",
    "wand.mcap": "is what the line before it records",
    "--compared-with": "takes two sessions of one protocol, which the demo has not",
}
"""What a command has that is only read here, and why; other tests run what it calls."""
MAY_SAY_NO = ("doctor",)
"""Its exit code tells what this machine lacks."""


def commands():
    """Return the commands of all pages in their order, each once."""
    blocks = (block for page in PAGES for block in FENCE.findall(page.read_text(encoding="utf-8")))
    lines = (line.strip() for block in blocks for line in block.splitlines())
    return list(dict.fromkeys(lines))


def reason_not_to_run(command):
    return next((why for what, why in NOT_RUN.items() if what in command), None)


RUN = [one for one in commands() if reason_not_to_run(one) is None]


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


@pytest.mark.parametrize("command", [one for one in commands() if one not in RUN])
def test_what_needs_more_than_a_computer_is_understood(command):
    """A sensor, or minutes of computing: the program knows each of its words."""
    if command.startswith("adibas "):
        build_parser().parse_args(shlex.split(command)[1:])
    assert reason_not_to_run(command)


def test_few_commands_are_only_read():
    assert len(RUN) > 4 * (len(commands()) - len(RUN))


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
