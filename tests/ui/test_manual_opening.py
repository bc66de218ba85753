"""The way from a screen to its page of the manual: by key, by button, and when there is none."""

import pytest
from PySide6.QtCore import Qt, QUrl
from PySide6.QtGui import QDesktopServices
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QLabel, QPushButton

from adibas.texts import LANGUAGES, use_language
from tests.ui import window_user
from ui import manual
from ui.widgets import help_page
from ui.widgets.help_page import HelpDock

open_window = window_user.open_window
Key = Qt.Key
SHIFT = Qt.KeyboardModifier.ShiftModifier


@pytest.fixture
def built(tmp_path, monkeypatch):
    """A manual of all languages with empty pages."""
    for language in LANGUAGES:
        folder = tmp_path / "manual" / language
        folder.mkdir(parents=True)
        for page in manual.PAGES.values():
            (folder / f"{page}.html").touch()
    monkeypatch.setattr(manual, "resource_path", lambda *parts: tmp_path.joinpath(*parts[1:]))
    return tmp_path / "manual"


@pytest.fixture
def opened(monkeypatch):
    """What the desktop is asked to open; it says yes."""
    urls: list[QUrl] = []

    def open_url(url):
        urls.append(url)
        return True

    monkeypatch.setattr(QDesktopServices, "openUrl", open_url)
    return urls


def test_a_page_is_in_the_windows_language_and_english_where_it_is_missing(built):
    for language in LANGUAGES:
        assert manual.manual_page("capture", language) == built / language / "sensor.html"
    (built / "es" / "sensor.html").unlink()
    assert manual.manual_page("capture", "es") == built / "en" / "sensor.html"


@pytest.mark.parametrize(
    ("name", "language"),
    [("patients", "es"), ("calibration", "ca"), ("behaviour", "pt"), ("capture", "pt")],
)
def test_shift_f1_opens_the_page_of_the_screen_in_the_windows_language(
    open_window, built, opened, name, language
):
    user = open_window(language=language)
    user.give_new_passphrase()
    user.go_to(name)
    user.settle()
    user.key(Key.Key_F1, SHIFT)
    (url,) = opened
    assert url.isLocalFile()
    assert url.toLocalFile() == str(built / language / f"{manual.PAGES[name]}.html")


def test_the_manual_can_be_had_before_the_store_is_open(open_window, built, opened):
    user = open_window()
    user.key(Key.Key_F1, SHIFT)
    assert opened[0].toLocalFile() == str(built / "en" / "data.html")


@pytest.fixture
def dock(qtbot, theme):
    assert theme is not None
    dock = HelpDock()
    qtbot.addWidget(dock)
    yield dock
    use_language("en")


def press(dock):
    QTest.mouseClick(dock.findChild(QPushButton), Qt.MouseButton.LeftButton)


def told(dock):
    (label,) = [one for one in dock.findChildren(QLabel) if one.property("kind") == "warning"]
    return label.text() if not label.isHidden() else ""


def test_the_button_below_the_help_opens_it(dock, built, opened):
    dock.show_page("markers")
    press(dock)
    assert opened[0].toLocalFile() == str(built / "en" / "markers.html")
    assert told(dock) == ""


def test_where_nothing_opens_pages_the_file_is_named(dock, built, monkeypatch):
    monkeypatch.setattr(QDesktopServices, "openUrl", lambda _url: False)
    dock.show_page("markers")
    press(dock)
    assert str(built / "en" / "markers.html") in told(dock)
    dock.follow("review")
    assert told(dock) == ""


def test_a_manual_that_was_not_built_is_told_and_the_help_is_there(dock, opened, monkeypatch):
    monkeypatch.setattr(help_page, "manual_page", lambda _screen, _language: None)
    dock.open_manual()
    assert "make manual" in told(dock)
    assert dock.isVisible()
    assert opened == []
