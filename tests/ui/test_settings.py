"""The settings screen: what it changes, and what it says in which language."""

from unittest.mock import create_autospec

import pytest
from PySide6.QtCore import Qt
from PySide6.QtGui import QFontDatabase
from PySide6.QtTest import QTest
from PySide6.QtWidgets import (
    QComboBox,
    QLabel,
    QLineEdit,
    QPlainTextEdit,
    QPushButton,
    QSpinBox,
    QTableWidget,
    QTabWidget,
    QTextBrowser,
)

from adibas import __version__
from adibas.sensors.doctor import Finding
from adibas.sessions import open_store
from adibas.sessions.store import SessionStore
from adibas.texts import use_language
from tests.ui.conftest import CHEAP, PASSPHRASE, NoSensor
from ui.log import log_folder
from ui.settings import presenter as settings
from ui.settings.presenter import SettingsPresenter, SettingsView
from ui.settings.screen import build_settings_screen
from ui.workspace import Workspace

NEW = "another four words here"


@pytest.fixture
def view():
    return create_autospec(SettingsView, instance=True)


@pytest.fixture
def presenter(view, workspace):
    presenter = SettingsPresenter(view, workspace)
    yield presenter
    presenter.close()


@pytest.fixture(autouse=True)
def one_finding(monkeypatch):
    """Look at no real sensors: that takes seconds."""
    found = (Finding("Sensor", False, "none", "Plug one in."),)
    monkeypatch.setattr(settings, "findings", lambda _folder: found)
    yield found
    use_language("en")


def test_what_holds_is_shown_and_changes_count_at_once(presenter, view, workspace):
    view.show_preferences.assert_called_once_with(workspace.preferences.now)
    view.show_log.assert_called_once_with(str(log_folder()))
    presenter.change(theme="dark")
    assert workspace.preferences.now.theme == "dark"
    view.show_preferences.assert_called_with(workspace.preferences.now)


def test_the_protection_is_looked_up_when_the_screen_is_entered(presenter, view, store):
    view.show_protection.assert_not_called()
    presenter.enter()
    view.show_protection.assert_called_once_with(
        str(store.folder), has_passphrase=True, is_read_only=False
    )


def test_findings_are_told_anew_in_another_language(presenter, view, one_finding):
    presenter.change(language="es")
    view.show_findings.assert_not_called()
    presenter.examine_computer()
    presenter.change(theme="dark")
    assert view.show_findings.call_count == 1
    presenter.change(language="ca")
    assert view.show_findings.call_args.args == (one_finding,)
    assert view.show_findings.call_count == 2
    assert view.hide_check.call_count == 2


def test_a_closed_screen_follows_no_preferences(presenter, view, workspace):
    presenter.close()
    workspace.preferences.change(theme="dark")
    assert view.show_preferences.call_count == 1


def test_a_check_says_what_is_missing(presenter, view, store):
    presenter.check_store()
    view.show_check.assert_called_once_with(())
    orphan = store.folder / "pictures" / "ab"
    orphan.mkdir(parents=True)
    (orphan / ("ab" + "0" * 30 + ".sealed")).write_bytes(b"nobody's")
    presenter.check_store()
    assert len(view.show_check.call_args.args[0]) == 1


def test_a_new_passphrase_opens_the_store_from_then_on(presenter, view, store, told):
    presenter.change_passphrase(PASSPHRASE, NEW, NEW + "!")
    assert told[-1][0] == "bad"
    presenter.change_passphrase(PASSPHRASE, NEW, NEW)
    view.clear_passphrases.assert_called_once()
    view.show_protection.assert_called_once()
    assert told[-1][0] == "good"
    folder = store.folder
    store.close()
    with open_store(folder, NEW) as again:
        assert isinstance(again, SessionStore)


def test_a_wrong_old_passphrase_changes_nothing(presenter, view, inline_jobs):
    presenter.change_passphrase("not this one", NEW, NEW)
    (problem,) = inline_jobs.problems
    assert "passphrase is wrong" in str(problem)
    view.clear_passphrases.assert_not_called()


@pytest.fixture
def screen(workspace, qtbot):
    screen = build_settings_screen(workspace)
    qtbot.addWidget(screen)
    screen.resize(1140, 740)
    screen.show()
    screen.entered()
    yield screen
    screen.closed()


def labelled(screen, text, kind):
    (label,) = [one for one in screen.findChildren(QLabel) if one.text().replace("&", "") == text]
    assert isinstance(label.buddy(), kind)
    return label.buddy()


def test_a_choice_in_the_form_changes_the_preferences(screen, workspace):
    QTest.keyClick(labelled(screen, "Language", QComboBox), Qt.Key.Key_Down)
    QTest.keyClick(labelled(screen, "Size of letters", QComboBox), Qt.Key.Key_End)
    QTest.keyClick(labelled(screen, "Colours of the window", QComboBox), Qt.Key.Key_End)
    QTest.keyClick(labelled(screen, "Countdown before a capture", QSpinBox), Qt.Key.Key_Up)
    QTest.keyClick(labelled(screen, "Frames in a capture", QSpinBox), Qt.Key.Key_Down)
    QTest.keyClick(labelled(screen, "Calibrate the sensor again after", QSpinBox), Qt.Key.Key_Down)
    operator = labelled(screen, "Who works here (for the audit trail)", QLineEdit)
    QTest.keyClicks(operator, " O. Perator ")
    QTest.keyClick(operator, Qt.Key.Key_Return)
    now = workspace.preferences.now
    assert (now.language, now.font_scale, now.theme) == ("es", 2.0, "dark")
    assert (now.countdown_s, now.burst_frames, now.operator) == (4, 29, "O. Perator")
    assert now.calibration_days == 179


def test_one_day_is_told_as_one(screen, workspace):
    field = labelled(screen, "Calibrate the sensor again after", QSpinBox)
    assert field.text() == "180 days"
    QTest.keyClick(field, Qt.Key.Key_A, Qt.KeyboardModifier.ControlModifier)
    QTest.keyClicks(field, "1")
    assert field.text() == "1 day"
    QTest.keyClicks(field, "2")
    assert field.text() == "12 days"
    assert workspace.preferences.now.calibration_days == 12
    field.setValue(1)
    assert field.text() == "1 day"


def test_a_passphrase_is_changed_with_the_keyboard(screen, told):
    screen.findChild(QTabWidget).setCurrentIndex(1)
    for text, words in (
        ("Old passphrase", PASSPHRASE),
        ("New passphrase", NEW),
        ("New passphrase again", NEW),
    ):
        QTest.keyClicks(labelled(screen, text, QLineEdit), words)
    (button,) = [
        one for one in screen.findChildren(QPushButton) if one.text() == "Change the passphrase"
    ]
    QTest.keyClick(button, Qt.Key.Key_Space)
    assert told[-1][0] == "good"
    assert labelled(screen, "New passphrase", QLineEdit).text() == ""


def test_the_minutes_of_the_lock_are_set_there(screen, workspace):
    screen.findChild(QTabWidget).setCurrentIndex(1)
    minutes = labelled(screen, "Lock after so long without mouse or key", QSpinBox)
    minutes.setValue(0)
    assert minutes.text() == "never"
    assert workspace.preferences.now.autolock_minutes == 0


def test_a_check_is_shown_and_goes_with_its_language(screen, workspace):
    screen.findChild(QTabWidget).setCurrentIndex(1)
    (button,) = [one for one in screen.findChildren(QPushButton) if "Check" in one.text()]
    QTest.mouseClick(button, Qt.MouseButton.LeftButton)
    result = screen.protected.protection.findChild(QPlainTextEdit)
    assert "All is well" in result.toPlainText()
    workspace.preferences.change(language="es")
    assert result.isHidden()


def test_the_doctor_looks_when_its_page_is_opened(screen):
    screen.findChild(QTabWidget).setCurrentIndex(3)
    (table,) = [one for one in screen.findChildren(QTableWidget) if one.isVisible()]
    assert [table.item(0, column).text() for column in range(4)] == [
        "Sensor",
        "lacking",
        "none",
        "Plug one in.",
    ]
    assert any(str(log_folder()) in one.text() for one in screen.findChildren(QLabel))


def test_about_names_version_use_and_licences(screen):
    screen.findChild(QTabWidget).setCurrentIndex(5)
    about = next(one for one in screen.findChildren(QTextBrowser) if one.isVisible())
    text = about.toPlainText()
    assert __version__ in text
    assert "not for diagnosis" in text
    assert "PySide6-Essentials" in text
    use_language("ca")
    screen.retranslate()
    assert "not for diagnosis" not in about.toPlainText()


def test_what_is_said_of_a_protocol_follows_the_language(screen):
    screen.findChild(QTabWidget).setCurrentIndex(4)
    said = next(one for one in screen.findChildren(QLabel) if one.text().startswith("No mistake"))
    use_language("es")
    screen.retranslate()
    assert said.text() == "Ningún error: 15 puntos anatómicos, 1470 medidas."


def test_the_text_of_a_protocol_grows_with_the_letters_in_the_font_of_code(screen, request):
    screen.findChild(QTabWidget).setCurrentIndex(4)
    text = next(one for one in screen.findChildren(QPlainTextEdit) if one.isVisible())
    request.getfixturevalue("large_letters")
    fixed = QFontDatabase.systemFont(QFontDatabase.SystemFont.FixedFont)
    assert text.font().family() == fixed.family()
    assert text.font().pointSizeF() == screen.font().pointSizeF()


def test_in_a_store_that_is_only_read_the_passphrase_stays(
    read_only_store, inline_jobs, preferences, qtbot
):
    workspace = Workspace(read_only_store, inline_jobs, preferences, NoSensor())
    screen = build_settings_screen(workspace)
    qtbot.addWidget(screen)
    screen.entered()
    assert not labelled(screen, "New passphrase", QLineEdit).isEnabled()
    screen.closed()


def test_another_store_is_opened_from_the_next_start_on(presenter, workspace, told, tmp_path):
    presenter.choose_store(tmp_path / "empty")
    assert told[-1][0] == "bad"
    assert workspace.preferences.now.store == ""
    open_store(tmp_path / "shared", PASSPHRASE, key_params=CHEAP).close()
    presenter.choose_store(tmp_path / "shared")
    assert told[-1][0] == "good"
    assert workspace.preferences.now.store == str(tmp_path / "shared")


def test_the_protection_names_the_server_of_the_database(presenter, view, store, monkeypatch):
    monkeypatch.setattr(store, "server", "clinic.example")
    presenter.enter()
    (place,) = view.show_protection.call_args.args
    assert place == f"{store.folder}, its database on clinic.example"
