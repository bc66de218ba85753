"""The whole window over a real store: locking, closing, a second window, languages, bugs."""

import os
import signal
import sys
import threading

import pytest
from PySide6.QtCore import Qt
from PySide6.QtGui import QGuiApplication
from PySide6.QtTest import QTest
from PySide6.QtWidgets import (
    QDialog,
    QFileDialog,
    QLabel,
    QLineEdit,
    QMessageBox,
    QPushButton,
    QSplitter,
    QWidget,
)

import ui.theme
from adibas.data.patients import Identity
from adibas.data.sessions import SessionSetup
from adibas.sessions import open_store
from adibas.sessions.demo_patient import demo_patient
from adibas.texts import speaking
from tests.ui import window_user
from tests.ui.behaviour_scene import make_recording
from tests.ui.conftest import CHEAP
from tests.ui.window_user import CTRL, SECRET, visible, visible_dialogs
from tests.unit.store_samples import add_patient
from ui.log import LOG_FILE, start_log
from ui.navigation import TITLES
from ui.ports import CancelledError
from ui.signals import SignalWatch
from ui.theme import DARK, LIGHT
from ui.workspace import Place

open_window = window_user.open_window
Key = Qt.Key
NAME = "Rosa Ibarra"


@pytest.fixture(autouse=True)
def prepared(tmp_path):
    """A store with one patient and a session; guessing its passphrase would be cheap."""
    with open_store(tmp_path / "store", SECRET, key_params=CHEAP) as store:
        patient = add_patient(store, Identity(NAME, None, "HC-77"))
        store.sessions.start(patient.pseudonym, SessionSetup())


@pytest.fixture
def user(open_window):
    user = open_window()
    user.give_passphrase()
    user.until(lambda: user.window.shown)
    user.settle()
    return user


@pytest.fixture
def slow(user):
    """Start a job that runs until it is let go or stopped; return both signs."""
    let_go, was_stopped, has_begun = (threading.Event() for _sign in range(3))

    def work(control):
        has_begun.set()
        try:
            while not let_go.wait(0.01):
                control.progress(1, 2)
        except CancelledError:
            was_stopped.set()
            raise
        return "done"

    results = []
    user.application.jobs.start("Something slow", work, results.append)
    user.until(has_begun.is_set)  # what has not begun is never stopped
    yield let_go, was_stopped, results
    let_go.set()


def choose_somebody(user):
    user.keys("ibarra")
    user.key(Key.Key_Down)
    assert user.workspace.patient.identity.name == NAME
    user.settle()


def words(user):
    """Return everything that can be read in the program's windows, and in their tips."""
    told = [user.window.windowTitle()]
    for widget in visible(user.window, QWidget):
        told += [widget.toolTip(), widget.accessibleName()]
        if isinstance(widget, QLabel | QLineEdit | QPushButton):
            told.append(widget.text())
    return "\n".join(told)


def locked(user):
    return not user.window.shown and user.workspace is None


def test_a_wrong_passphrase_is_said_and_the_next_one_opens(open_window):
    user = open_window()
    user.give_passphrase("not this one")
    user.until(lambda: "passphrase is wrong" in words(user))
    user.give_passphrase()
    user.until(lambda: user.window.shown == "patients")
    assert "passphrase is wrong" not in words(user)
    user.close()


def test_nothing_of_a_patient_is_read_in_a_locked_window(user):
    choose_somebody(user)
    assert NAME in words(user)
    dialog = QDialog(user.window)
    dialog.setWindowTitle(NAME)
    dialog.open()
    user.application.lock()
    assert NAME not in words(user)
    assert not visible_dialogs()
    user.until(lambda: locked(user))
    user.settle()
    assert NAME not in words(user)
    assert not user.window.told
    assert not user.drop("anything.mcap")
    user.window.activateWindow()
    user.until(user.window.isActiveWindow)
    user.give_passphrase()
    user.until(lambda: user.window.shown == "patients")
    assert user.workspace.patient.identity.name == NAME
    assert NAME in words(user)
    user.close()


def unlock(user):
    user.until(lambda: locked(user))
    user.settle()
    user.window.activateWindow()
    user.until(user.window.isActiveWindow)
    user.give_passphrase()
    user.until(lambda: user.window.shown)
    user.settle()


def type_patient(user):
    user.key(Key.Key_N, CTRL)
    user.keys("Nuria Typed")
    user.key(Key.Key_Tab)
    user.keys("3/4/1980")


def test_a_form_that_was_being_filled_in_is_given_back_after_a_lock(user):
    type_patient(user)
    user.application.lock()
    assert "Nuria" not in words(user)
    user.until(lambda: locked(user))
    user.settle()
    assert "Nuria" not in words(user)
    unlock(user)
    assert "Nuria Typed" in words(user)
    assert "3/4/1980" in words(user)
    user.click("Save")
    assert user.workspace.patient.identity.name == "Nuria Typed"
    user.application.lock()
    unlock(user)
    assert not user.screen.pages.has_form
    user.close()


def test_a_form_is_given_back_behind_the_screen_that_was_seen(user):
    type_patient(user)
    user.go_to("settings")
    user.application.lock()
    unlock(user)
    assert user.window.shown == "settings"
    user.go_to("patients")
    assert "Nuria Typed" in words(user)
    user.key(Key.Key_Escape)
    user.close()


def test_while_locked_nothing_typed_is_in_the_store_or_readable_in_the_window(user, tmp_path):
    type_patient(user)
    user.application.lock()
    user.until(lambda: locked(user))
    drafts = vars(user.application)["_drafts"]
    assert drafts.are_there
    assert b"Nuria" not in b"".join(vars(drafts)["_sealed"].values())
    files = [path for path in tmp_path.rglob("*") if path.is_file()]
    assert files
    assert not [path for path in files if b"Nuria" in path.read_bytes()]
    unlock(user)
    user.key(Key.Key_Escape)
    user.close()


def test_a_form_waits_until_no_other_window_has_the_store(user, tmp_path):
    type_patient(user)
    user.application.lock()
    user.until(lambda: locked(user))
    with open_store(tmp_path / "store", SECRET):
        unlock(user)
        assert "What you were typing is kept" in user.window.told
        assert "Nuria Typed" not in words(user)
        user.application.lock()
        user.until(lambda: locked(user))
    unlock(user)
    assert "Nuria Typed" in words(user)
    user.key(Key.Key_Escape)
    user.close()


def test_after_a_lock_the_same_screen_and_session_are_shown(user):
    choose_somebody(user)
    (session,) = user.store.sessions.of_patient(user.workspace.patient.pseudonym)
    user.workspace.choose_session(session)
    user.go_to("reports")
    user.key(Key.Key_L, CTRL)
    user.until(lambda: locked(user))
    user.give_passphrase()
    user.until(lambda: user.window.shown == "reports")
    assert user.workspace.session == session
    user.close()


def test_what_runs_is_finished_behind_the_lock(user, slow):
    let_go, was_stopped, results = slow
    user.application.lock()
    assert not user.window.shown
    user.workspace.show_screen("settings")
    assert not user.window.shown
    (row,) = user.store.patients.search("ibarra")
    user.workspace.choose_patient(user.store.patients.get(row.pseudonym))
    assert NAME not in words(user)
    let_go.set()
    user.until(lambda: locked(user))
    assert results == ["done"]
    assert not was_stopped.is_set()
    user.give_passphrase()
    user.until(lambda: user.window.shown == "settings")
    user.close()


def test_it_locks_by_itself(user):
    user.application._watch._timer.setInterval(10)
    user.until(lambda: locked(user))
    assert user.window.shown == ""
    assert user.application.workspace is None
    user.close()


def test_a_touch_after_a_long_sleep_locks_on_a_screen_that_was_just_built(user):
    user.window.show_screen("settings")
    user.application._watch._touched_s -= 1e6
    QTest.keyClick(user.window, Key.Key_X)
    user.until(lambda: locked(user))
    assert "settings" not in words(user).casefold()
    user.close()


def test_new_minutes_count_at_once(user):
    user.application.preferences.change(autolock_minutes=3)
    assert user.application._watch._timer.interval() == 3 * 60_000
    user.application.preferences.change(autolock_minutes=0)
    assert not user.application._watch._timer.isActive()
    user.close()


def test_a_second_window_reads_only_and_says_so(user, open_window):
    second = open_window()
    second.give_passphrase()
    second.until(lambda: second.window.shown)
    assert second.store.is_read_only
    assert "Another window has the patient store open" in second.window.told
    assert "Read only" in words(second)
    assert not user.store.is_read_only
    assert "Read only" not in words(user)
    second.close()
    user.close()


def test_closing_waits_for_what_runs_and_asks(user, slow):
    let_go, was_stopped, results = slow
    user.window.close()
    assert user.window.isVisible()
    user.until(lambda: visible_dialogs(QMessageBox))
    (question,) = visible_dialogs(QMessageBox)
    assert "Something slow" in question.text()
    let_go.set()
    user.until(lambda: not user.window.isVisible())
    assert results == ["done"]
    assert not was_stopped.is_set()
    assert not visible_dialogs()


def test_who_does_not_want_to_wait_stops_it(user, slow):
    _let_go, was_stopped, results = slow
    user.window.close()
    user.until(lambda: visible_dialogs(QMessageBox))
    user.click("Stop it and close", visible_dialogs(QMessageBox)[0])
    user.until(lambda: not user.window.isVisible())
    assert was_stopped.is_set()
    assert not results


def test_who_thinks_again_stays(user, slow):
    let_go, _was_stopped, results = slow
    user.window.close()
    user.until(lambda: visible_dialogs(QMessageBox))
    user.click("Do not close", visible_dialogs(QMessageBox)[0])
    let_go.set()
    user.settle()
    user.qapp.processEvents()
    assert user.window.isVisible()
    assert results == ["done"]
    user.close()


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_stops_what_runs_and_closes_without_a_question(user, slow, number):
    watch = SignalWatch(user.application.end)
    try:
        os.kill(os.getpid(), number)
        user.until(lambda: not user.window.isVisible())
    finally:
        watch.close()
    assert slow[1].is_set()
    assert user.workspace is None


def test_signals_do_afterwards_what_they_did_before():
    before = [signal.getsignal(one) for one in (signal.SIGINT, signal.SIGTERM)]
    SignalWatch(lambda: None).close()
    assert [signal.getsignal(one) for one in (signal.SIGINT, signal.SIGTERM)] == before


def test_every_screen_speaks_the_new_language_at_once(user):
    for name in ("patients", "capture", "markers", "review", "reports", "settings"):
        user.go_to(name)
        user.settle()
    user.window.show_help()
    english = {one.text() for one in user.window.findChildren(QPushButton) if one.text()}
    user.application.preferences.change(language="ca")
    user.settle()
    user.qapp.processEvents()
    catalan = {one.text() for one in user.window.findChildren(QPushButton) if one.text()}
    same = {text.replace("&", "") for text in english} & {text.replace("&", "") for text in catalan}
    assert same <= {"Color", "Error"}, same
    assert user.window._help.windowTitle() == "Ajuda"
    dialog = QFileDialog(user.window)
    dialog.show()
    assert "Cancel·la" in {one.text().replace("&", "") for one in visible(dialog, QPushButton)}
    dialog.close()
    assert user.window.locale().language() == user.window.locale().Language.Catalan
    user.close()


def test_the_buttons_of_qt_speak_the_new_language_too(user):
    """Of Portuguese Qt brings the Brazilian texts alone."""
    user.application.preferences.change(language="pt")
    user.settle()
    dialog = QFileDialog(user.window)
    dialog.show()
    assert "Cancelar" in {one.text().replace("&", "") for one in visible(dialog, QPushButton)}
    dialog.close()
    user.close()


def test_the_demo_patient_is_called_as_in_the_new_language(user):
    with speaking("en"):
        demo = demo_patient(user.store)
    user.workspace.choose_patient(demo)
    user.application.preferences.change(language="es")
    assert user.workspace.patient.identity.name == "Paciente de demostración"
    user.workspace.choose_patient(None)
    user.application.preferences.change(language="en")
    assert user.workspace.patient is None
    assert demo_patient(user.store) == demo
    user.close()


def test_with_the_desktop_the_window_turns_dark(user, monkeypatch):
    changed = QGuiApplication.styleHints().colorSchemeChanged
    monkeypatch.setattr(ui.theme, "is_dark", lambda theme: theme != "light")
    changed.emit(Qt.ColorScheme.Dark)
    assert user.application._theme.tokens is DARK
    user.application.preferences.change(theme="light")
    assert user.application._theme.tokens is LIGHT
    monkeypatch.setattr(ui.theme, "is_dark", lambda _theme: True)
    changed.emit(Qt.ColorScheme.Dark)
    assert user.application._theme.tokens is LIGHT
    user.close()


@pytest.mark.parametrize(
    ("names", "said"),
    [
        (("holiday.txt",), "neither a recording nor a picture"),
        (("a.mcap", "b.mcap"), "Only one file"),
    ],
)
def test_what_no_screen_opens_is_refused_in_one_sentence(user, tmp_path, names, said):
    assert user.drop(*(tmp_path / name for name in names))
    assert said in user.window.told
    assert user.window.shown == "patients"
    user.close()


def test_a_dropped_picture_goes_to_the_learner(user, tmp_path):
    from PIL import Image

    Image.new("RGB", (64, 48), (200, 40, 40)).save(tmp_path / "red.png")
    assert user.drop(tmp_path / "red.png")
    assert user.window.shown == "markers"
    user.settle()
    assert user.screen._presenter._picture.color_rgb.shape == (48, 64, 3)
    user.close()


def test_a_recording_that_the_desktop_opens_is_shown_when_the_store_is_open(open_window, tmp_path):
    user = open_window()
    user.application.to_open = (make_recording(tmp_path / "child.mcap", 3),)
    user.give_passphrase()
    user.until(lambda: user.window.shown == "capture")
    user.settle()
    assert user.application.to_open == ()
    user.close()


def test_a_recording_dropped_onto_the_behaviour_screen_is_coded(user, tmp_path):
    user.go_to("behaviour")
    assert user.drop(make_recording(tmp_path / "child.mcap", 3))
    user.settle()
    assert user.window.shown == "behaviour"
    user.until(lambda: user.screen._presenter.source is not None)
    user.key(Key.Key_S)
    paths = [make_recording(tmp_path / f"part {number}.mcap", 3) for number in (1, 2)]
    assert user.drop(*paths)
    user.settle()
    user.until(lambda: len(user.screen._presenter.source.parts) == len(paths))
    user.close()
    assert (tmp_path / "child.coding.csv").is_file()


@pytest.fixture
def log(tmp_path):
    end_log = start_log(tmp_path / "log")
    yield tmp_path / "log" / LOG_FILE
    end_log()


def test_a_bug_is_told_and_its_log_names_nobody(user, log):
    choose_somebody(user)
    error = ValueError(f"no room for {user.workspace.patient.identity.name}")
    sys.excepthook(ValueError, error, None)
    user.until(lambda: "Restart the program" in user.window.told)
    user.application.lock()
    user.until(lambda: locked(user))
    sys.excepthook(ValueError, ValueError(NAME), None)
    user.until(lambda: "Restart the program" in words(user))
    user.close()
    written = log.read_text(encoding="utf-8")
    assert written.count("a bug") == 2
    assert "ValueError" in written
    assert "Rosa" not in written
    assert "Ibarra" not in written


def test_a_bug_stays_told_on_the_first_page_whatever_is_asked_for(user):
    user.application.lock()
    user.until(lambda: locked(user))
    user.window.tell_of_bug("It failed.")
    user.settle()  # meanwhile it was found out that a passphrase is needed
    page = user.window.unlock_page
    assert visible(page, QLineEdit)
    assert "It failed." in words(user)
    user.give_passphrase()
    user.until(lambda: user.window.shown)
    user.application.lock()
    user.until(lambda: locked(user))
    user.settle()
    assert "It failed." not in words(user)
    user.close()


def test_a_problem_of_a_job_is_told(user):
    def work(_control):
        user.store.patients.get("P-GONE")

    user.application.jobs.start("Reading", work, lambda _result: None)
    user.until(lambda: user.window.told)
    assert "patient" in user.window.told
    assert "Traceback" not in user.window.told
    user.close()


def test_who_works_here_stands_in_the_audit_log_from_now_on(user):
    user.application.preferences.change(operator="O. Perator")
    assert user.store.operator == "O. Perator"
    user.close()


def test_where_everything_was_is_found_again_at_the_next_start(user, open_window):
    user.window.resize(1400, 900)
    user.go_to("review")
    user.window.show_help()
    user.close()
    again = open_window()
    again.give_passphrase()
    again.until(lambda: again.window.shown == "patients")
    assert (again.window.width(), again.window.height()) == (1280, 800)
    assert again.application.preferences.now.splitters
    assert again.window._help.isVisible()
    again.close()


def test_the_place_of_each_divider_is_kept_under_a_name_of_its_own(user):
    for screen in TITLES:
        user.go_to(screen)
        names = [one.objectName() for one in user.window._screens[screen].findChildren(QSplitter)]
        assert all(names), screen
        assert len(set(names)) == len(names), screen
    user.close()


def test_a_warning_of_a_capture_goes_with_its_patient_and_no_other_one_does(user):
    choose_somebody(user)
    for is_here in (True, False):
        tell = user.workspace.tell_here if is_here else user.workspace.tell
        tell("warning", "Front: 0 markers found.")
        assert user.window.told
        user.workspace.choose_patient(demo_patient(user.store) if is_here else None)
        assert bool(user.window.told) is not is_here
    user.workspace.tell_here("warning", "Front: 0 markers found.")
    user.workspace.tell("bad", "The disk is full.")
    user.workspace.choose_patient(demo_patient(user.store))
    assert user.window.told == "The disk is full."
    user.close()


def test_a_place_tells_nobodys_name(user):
    choose_somebody(user)
    assert isinstance(user.workspace.place, Place)
    assert NAME not in repr(user.workspace.place)
    user.close()


def backups(folder):
    return sorted(folder.glob("*.adibas-backup"))


def test_a_window_that_stays_open_backs_up_when_the_next_hour_finds_one_due(user, tmp_path):
    kept = tmp_path / "kept"
    user.application.preferences.change(backup_folder=str(kept))
    timer = user.application._opened._backup_timer
    assert timer.isActive()
    timer.timeout.emit()
    user.until(lambda: "is made" in user.window.told)
    (first,) = backups(kept)
    user.settle()
    timer.timeout.emit()
    user.settle()
    assert backups(kept) == [first], "none is due"


def test_no_backup_begins_beside_other_work_nor_behind_the_lock(user, slow, tmp_path):
    let_go, _was_stopped, _results = slow
    user.application.preferences.change(backup_folder=str(tmp_path / "kept"))
    timer = user.application._opened._backup_timer
    timer.timeout.emit()
    let_go.set()
    user.settle()
    user.application.lock()
    timer.timeout.emit()
    user.until(lambda: locked(user))
    assert not timer.isActive()
    assert not backups(tmp_path / "kept")
