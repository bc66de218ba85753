"""A bug is written down without anybody's name, and told to the user."""

import faulthandler
import logging
import sys
import threading

import pytest

from adibas.errors import StoreError
from ui.crash import install_crash_report
from ui.log import FAULTS_FILE, LOG_FILE, start_log

NAME = "Rosa Ibarra Sáez"
pytestmark = pytest.mark.usefixtures("faults_as_before")


@pytest.fixture
def faults_as_before():
    was_on = faulthandler.is_enabled()
    yield
    if was_on:
        faulthandler.enable(sys.__stderr__)


@pytest.fixture
def log(tmp_path):
    end = start_log(tmp_path / "log")
    yield tmp_path / "log" / LOG_FILE
    end()


@pytest.fixture
def told():
    said = []
    take_away = install_crash_report(said.append)
    yield said
    take_away()


def provoke(name):
    try:
        {}[name]
    except KeyError as error:
        raise ValueError(f"cannot show {name}") from error


def crash():
    try:
        provoke(NAME)
    except ValueError as error:
        sys.excepthook(type(error), error, error.__traceback__)


def test_the_log_says_where_and_never_of_whom(log, told):
    crash()
    written = log.read_text(encoding="utf-8")
    assert "CRITICAL ui.crash a bug" in written
    assert "ValueError" in written
    assert "KeyError" in written
    assert "in provoke" in written
    for part in NAME.split():
        assert part not in written
    assert len(told) == 1
    assert NAME not in told[0]


def test_errors_of_the_world_are_logged_without_what_they_say(log):
    error = StoreError("The store of {whom} is closed.", whom=NAME)
    logging.getLogger("ui.anything").error("it failed", exc_info=error)
    written = log.read_text(encoding="utf-8")
    assert "it failed" in written
    assert "StoreError" in written
    assert "Ibarra" not in written


def test_a_bug_in_another_thread_is_told_too(told):
    thread = threading.Thread(target=provoke, args=(NAME,))
    thread.start()
    thread.join()
    assert len(told) == 1


def test_ctrl_c_is_no_bug(monkeypatch):
    passed, told = [], []
    monkeypatch.setattr(sys, "excepthook", lambda *error: passed.append(error[0]))
    take_away = install_crash_report(told.append)
    sys.excepthook(KeyboardInterrupt, KeyboardInterrupt(), None)
    take_away()
    assert passed == [KeyboardInterrupt]
    assert not told


def test_the_hooks_are_taken_away_unless_another_one_follows(monkeypatch):
    before = sys.excepthook, threading.excepthook
    take_away = install_crash_report(lambda _said: None)
    assert sys.excepthook is not before[0]
    take_away()
    assert (sys.excepthook, threading.excepthook) == before
    take_away = install_crash_report(lambda _said: None)
    monkeypatch.setattr(sys, "excepthook", print)
    monkeypatch.setattr(threading, "excepthook", print)
    take_away()
    assert (sys.excepthook, threading.excepthook) == (print, print)


def test_libraries_write_nothing_into_the_log(log):
    logging.getLogger("sqlalchemy.engine").error("SELECT %s", NAME)
    logging.getLogger("adibas.sessions").info("session saved")
    written = log.read_text(encoding="utf-8")
    assert "session saved" in written
    assert "Ibarra" not in written


def test_after_its_end_nothing_is_written(tmp_path):
    end = start_log(tmp_path)
    end()
    logging.getLogger("ui").error("too late")
    assert "too late" not in (tmp_path / LOG_FILE).read_text()
    assert (tmp_path / FAULTS_FILE).read_text() == ""


def test_without_a_place_for_it_the_program_works_without_a_log(tmp_path):
    (tmp_path / "log").write_text("a file stands here")
    end = start_log(tmp_path / "log")
    logging.getLogger("ui").error("nobody reads this")
    end()
    assert (tmp_path / "log").read_text() == "a file stands here"
