"""The command line: exit codes, where output goes, and how words are read."""

import argparse
import io
import json
import sys
from types import SimpleNamespace

import pytest

from adibas.cli import main
from adibas.cli.command_line import COMMANDS
from adibas.cli.console import Console
from adibas.cli.interrupts import kept_when_stopped
from adibas.cli.options import (
    cluster_count,
    frame_range,
    image_size,
    pixel,
    positive,
    positive_count,
)
from adibas.errors import RecordingError


def command_that(action):
    return SimpleNamespace(SUMMARY="test", add_arguments=lambda _parser: None, run=action)


@pytest.fixture
def run_as(monkeypatch):
    """Run the command line with its commands replaced by one whose work is `action`."""

    def run(action, argv=("it",)):
        monkeypatch.setattr("adibas.cli.command_line.COMMANDS", ("it",))
        monkeypatch.setattr(
            "adibas.cli.command_line.importlib.import_module", lambda _name: command_that(action)
        )
        return main(list(argv))

    return run


def test_a_failure_of_the_world_is_one_sentence_on_stderr_and_exit_code_1(run_as, capsys):
    def fail(_arguments, _console):
        raise RecordingError("{file} is cut short. Record again.", file="a.mcap")

    assert run_as(fail) == 1
    captured = capsys.readouterr()
    assert captured.err == "a.mcap is cut short. Record again.\n"
    assert captured.out == ""


def test_ctrl_c_ends_with_exit_code_1_and_a_sentence(run_as, capsys):
    def interrupted(_arguments, _console):
        raise KeyboardInterrupt

    assert run_as(interrupted) == 1
    assert "Stopped" in capsys.readouterr().err


def test_ctrl_c_in_a_compiled_loop_ends_so_too(run_as, capsys):
    def in_a_loop(_arguments, _console):
        raise SystemError("returned a result with an exception set") from KeyboardInterrupt()

    assert run_as(in_a_loop) == 1
    assert "Stopped" in capsys.readouterr().err


@pytest.mark.parametrize(
    "stop", [KeyboardInterrupt(), SystemError("returned a result with an exception set")]
)
def test_a_stopped_work_that_goes_on_says_where_it_is_kept(run_as, capsys, tmp_path, stop):
    kept = tmp_path / "model.npz.training"

    def interrupted(_arguments, _console):
        with kept_when_stopped(kept):
            raise stop from KeyboardInterrupt()

    kept.mkdir()
    assert run_as(interrupted) == 1
    told = capsys.readouterr().err
    assert "model.npz.training; the same command goes on from there." in told
    assert str(tmp_path) not in told


def test_a_stopped_work_of_which_nothing_is_kept_says_so(run_as, capsys, tmp_path):
    def interrupted(_arguments, _console):
        with kept_when_stopped(tmp_path / "model.npz.training"):
            raise KeyboardInterrupt

    assert run_as(interrupted) == 1
    assert "No unfinished file was left behind" in capsys.readouterr().err


def test_a_fault_in_a_work_that_is_kept_stays_a_fault(run_as, tmp_path):
    def broken(_arguments, _console):
        with kept_when_stopped(tmp_path):
            raise SystemError("of a fault")

    with pytest.raises(SystemError, match="of a fault"):
        run_as(broken)


def test_another_fault_of_a_compiled_loop_is_not_hidden(run_as):
    def broken(_arguments, _console):
        raise SystemError("of a fault")

    with pytest.raises(SystemError, match="of a fault"):
        run_as(broken)


def test_a_stdout_that_lacks_a_letter_shows_its_number(run_as, monkeypatch):
    written = io.BytesIO()
    monkeypatch.setattr(sys, "stdout", io.TextIOWrapper(written, encoding="ascii"))
    assert run_as(lambda _arguments, console: console.say("sesión") or 0) == 0
    assert written.getvalue().strip() == rb"sesi\xf3n"


def test_a_bug_is_not_hidden(run_as):
    def broken(_arguments, _console):
        raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        run_as(broken)


@pytest.mark.parametrize("argv", [[], ["nonsense"], ["posture"], ["record", "--seconds", "-1"]])
def test_wrong_usage_is_exit_code_2(argv, capsys):
    with pytest.raises(SystemExit) as stopped:
        main(argv)
    assert stopped.value.code == 2
    assert "usage" in capsys.readouterr().err


@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_has_help(name, capsys):
    with pytest.raises(SystemExit) as stopped:
        main([name, "--help"])
    assert stopped.value.code == 0
    assert f"adibas {name}" in capsys.readouterr().out


def test_json_keeps_sentences_off_stdout(capsys):
    console = Console(is_json=True)
    console.say("a sentence")
    console.give({"n": 1})
    captured = capsys.readouterr()
    assert json.loads(captured.out) == {"n": 1}
    assert captured.err == "a sentence\n"


def test_without_json_the_sentence_is_the_result(capsys):
    console = Console(is_json=False)
    console.say("a sentence")
    console.give({"n": 1})
    assert capsys.readouterr().out == "a sentence\n"


def test_no_bar_is_drawn_where_there_is_no_terminal(capsys):
    with Console(is_json=False).progress("Working") as progress:
        progress(1, 2)
    assert capsys.readouterr().err == ""


def test_a_bar_is_drawn_on_a_terminal(monkeypatch, capsys):
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    monkeypatch.setattr("adibas.cli.console.SECONDS_BEFORE_A_BAR", 0.0)
    with Console(is_json=False).progress("Working") as progress:
        progress(1, 2)
    assert "Working" in capsys.readouterr().err


def test_words_are_read_as_the_help_says():
    assert pixel("320,240.5") == (320.0, 240.5)
    assert frame_range("3:30") == (3, 30)
    assert frame_range(":") == (0, None)
    assert positive("0.5") == 0.5
    assert positive_count("3") == 3
    assert cluster_count("64") == 64
    assert image_size("1280x1024") == (1280, 1024)


@pytest.mark.parametrize(
    ("read", "text"),
    [
        (pixel, "320"),
        (pixel, "a,b"),
        (pixel, "nan,3"),
        (pixel, "3,inf"),
        (cluster_count, "65"),
        (image_size, "1280"),
        (image_size, "1280x"),
        (image_size, "0x1024"),
        (frame_range, "30"),
        (frame_range, "30:3"),
        (frame_range, "-1:3"),
        (frame_range, "a:b"),
        (positive, "0"),
        (positive, "nan"),
        (positive, "x"),
        (positive_count, "0"),
        (positive_count, "1.5"),
    ],
)
def test_other_words_are_wrong_usage(read, text):
    with pytest.raises(argparse.ArgumentTypeError, match=r"is no"):
        read(text)
