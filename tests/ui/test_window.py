"""The frame around all screens: help, messages, progress, and letters of every size."""

import threading

import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QLineEdit, QPushButton, QTextBrowser, QVBoxLayout, QWidget

from adibas.texts import LANGUAGES, use_language
from ui.jobs import JobRunner
from ui.widgets.help_page import HelpDock, read_help
from ui.widgets.message_bar import MessageBar
from ui.widgets.progress_strip import ProgressStrip
from ui.widgets.screen import Screen
from ui.window import MainWindow

Key = Qt.Key


class Page(Screen):
    """A screen with one field, that notes what it is told."""

    def __init__(self, name):
        super().__init__()
        self.name = name
        self.told = []
        self.field = QLineEdit(self)
        QVBoxLayout(self).addWidget(self.field)

    def entered(self):
        self.told.append("entered")
        self.field.setFocus()

    def left(self):
        self.told.append("left")

    def closed(self):
        self.told.append("closed")


@pytest.fixture
def jobs():
    jobs = JobRunner(lambda _error: None)
    yield jobs
    jobs.close()


@pytest.fixture
def window(theme, jobs, preferences, qtbot):
    window = MainWindow(theme, jobs, preferences)
    qtbot.addWidget(window)
    window.show()
    window.activateWindow()
    qtbot.waitUntil(window.isActiveWindow)
    yield window
    use_language("en")


@pytest.fixture
def pages(window):
    pages = {name: Page(name) for name in ("patients", "review")}
    for name, page in pages.items():
        window.offer_screen(name, lambda page=page: page)
    window.show_first_screen()
    return pages


def test_a_screen_is_told_when_it_is_seen_and_when_not(window, pages):
    shown = []
    window.shown_changed.subscribe(shown.append)
    window.show_screen("review")
    assert pages["patients"].told == ["entered", "left"]
    window.show_unlock()
    assert pages["review"].told[-1] == "left"
    assert window.shown == ""
    assert shown[-2:] == ["review", ""]
    window.remove_screens()
    assert pages["review"].told[-1] == "closed"


def test_f1_shows_the_help_of_the_screen_and_escape_leads_back(window, pages, qtbot):
    (dock,) = window.findChildren(HelpDock)
    text = dock.findChild(QTextBrowser)
    QTest.keyClick(pages["patients"].field, Key.Key_F1)
    qtbot.waitUntil(dock.isVisible)
    patients = text.toPlainText()
    assert len(patients) > 200
    window.show_screen("review")
    assert text.toPlainText() != patients
    window.show_screen("patients")
    assert text.toPlainText() == patients
    text.setFocus()
    window.show_help()
    QTest.keyClick(text, Key.Key_Escape)
    assert dock.isHidden()
    assert pages["patients"].field.hasFocus()


def test_help_can_be_had_before_the_store_is_open(window, qtbot):
    (dock,) = window.findChildren(HelpDock)
    window.show_unlock()
    QTest.keyClick(window, Key.Key_F1)
    qtbot.waitUntil(dock.isVisible)
    assert dock.findChild(QTextBrowser).toPlainText()


def test_help_that_nobody_wrote_in_a_language_is_english():
    assert read_help("patients", "xx") == read_help("patients", "en") != ""
    assert read_help("patients", "es") != read_help("patients", "en")
    assert read_help("nothing", "en") == ""


def test_good_news_go_by_themselves_and_bad_news_stay(qtbot):
    bar = MessageBar()
    qtbot.addWidget(bar)
    bar.tell("good", "It is saved.")
    bar._timer.setInterval(10)
    bar.tell("good", "It is saved.")
    assert bar.text == "It is saved."
    qtbot.waitUntil(lambda: bar.text == "")
    bar.tell("good", "It is saved.")
    bar.tell("bad", "It is not.")
    assert not bar._timer.isActive()
    assert bar._label.accessibleName() == "It is not."
    QTest.mouseClick(bar.findChild(QPushButton), Qt.MouseButton.LeftButton)
    assert bar.text == ""
    assert bar._label.text() == ""


@pytest.fixture
def strip(jobs, qtbot):
    parent = QWidget()
    qtbot.addWidget(parent)
    parent.show()
    strip = ProgressStrip(parent)
    end = jobs.changed.subscribe(strip.show_job)
    yield strip
    end()


def test_long_work_shows_how_far_it_came_and_can_be_stopped(strip, jobs, qtbot):
    go_on, told = threading.Event(), []

    def work(control):
        control.progress(2, 8)
        go_on.wait(60)
        control.progress(3, 8)

    jobs.start("Counting", work, told.append, ended=lambda: told.append("ended"))
    qtbot.waitUntil(strip.isVisible)
    qtbot.waitUntil(lambda: strip._bar.value() == 2)
    assert (strip._label.text(), strip._bar.maximum()) == ("Counting", 8)
    QTest.mouseClick(strip.findChild(QPushButton), Qt.MouseButton.LeftButton)
    assert strip.isHidden()
    go_on.set()
    qtbot.waitUntil(lambda: not jobs.is_busy)
    assert told == ["ended"]
    assert strip.isHidden()


def test_work_that_cannot_be_undone_offers_no_stop(strip, jobs, qtbot):
    go_on = threading.Event()

    def wait(_control):
        go_on.wait(60)

    jobs.start("Removing", wait, lambda _nothing: None, stop="never")
    qtbot.waitUntil(strip.isVisible)
    stop = strip.findChild(QPushButton)
    assert (strip._label.text(), stop.isVisible()) == ("Removing", False)
    go_on.set()
    qtbot.waitUntil(lambda: not jobs.is_busy)
    go_on.clear()
    jobs.start("Counting", wait, lambda _nothing: None)
    qtbot.waitUntil(strip.isVisible)
    assert stop.isVisible()
    go_on.set()
    qtbot.waitUntil(lambda: not jobs.is_busy)


def test_short_work_shows_nothing(strip, jobs, qtbot):
    jobs.start("Blinking", lambda _control: 1, lambda _result: None)
    qtbot.waitUntil(lambda: not jobs.is_busy)
    assert strip.isHidden()
    assert not strip._patience.isActive()


@pytest.mark.parametrize("language", LANGUAGES)
def test_the_frame_fits_a_small_screen_with_the_largest_letters(
    window, pages, theme, language, qapp
):
    assert set(pages) == {"patients", "review"}
    for name in ("capture", "markers", "reports", "settings"):
        window.offer_screen(name, lambda: None)
    use_language(language)
    theme.use("light", 2.0)
    window.retranslate()
    window.dress()
    qapp.processEvents()
    needed = window.minimumSizeHint()
    theme.use("light", 1.0)
    assert needed.height() <= 800, needed
    assert needed.width() <= 1280, needed
