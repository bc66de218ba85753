"""Every screen has room in a small window, in every language and with letters of twice the size."""

import itertools
import threading
from types import SimpleNamespace

import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QComboBox, QLabel, QProgressBar, QTabBar, QToolButton

from adibas.data.patients import Identity
from adibas.data.posture import VIEWS
from adibas.data.sessions import SessionSetup
from adibas.pipeline.live import SensorState
from adibas.sessions import open_store
from adibas.texts import LANGUAGES, speaking
from tests.ui import window_user
from tests.ui.behaviour_scene import make_recording
from tests.ui.conftest import CHEAP
from tests.ui.review_scene import SURFACE, new_capture, picture_rgb
from tests.ui.window_user import SECRET, visible
from tests.unit.store_samples import add_patient
from ui.behaviour.transport import Transport
from ui.capture.status_line import SPACING_PX, StatusLine
from ui.navigation import TITLES, NavigationRail
from ui.review.measures_panel import MeasuresPanel
from ui.widgets.elided_label import ElidedLabel
from ui.widgets.help_page import HelpDock
from ui.widgets.scrolled import Scrolled
from ui.widgets.side_panel import SidePanel

open_window = window_user.open_window
BOX_ARROW_PX = 20
"""Less than any box has beside its words."""


@pytest.fixture(autouse=True)
def prepared(tmp_path):
    """A store with one patient, a session without pictures, and one of all views."""
    with open_store(tmp_path / "store", SECRET, key_params=CHEAP) as store:
        patient = add_patient(store, Identity("Rosa Ibarra", None, "HC-77"))
        store.sessions.start(patient.pseudonym, SessionSetup())
        taken = store.sessions.start(patient.pseudonym, SessionSetup(protocol="sapo-1"))
        for view in VIEWS:
            store.captures.add(taken.session_id, new_capture(view), picture_rgb(), SURFACE)


@pytest.mark.parametrize("language", LANGUAGES)
@pytest.mark.parametrize(("font_scale", "size"), [(2.0, (1280, 800)), (1.0, (1024, 640))])
def test_no_screen_asks_for_more_room_than_there_is(open_window, language, font_scale, size):
    user = open_window(language=language, font_scale=font_scale)
    user.give_passphrase()
    user.until(lambda: user.window.shown)
    user.keys("ibarra")
    user.key(Qt.Key.Key_Down)
    user.settle()
    for name in TITLES:
        user.window.show_screen(name)
        user.settle()
        user.window.resize(*size)
        user.qapp.processEvents()
        assert_fits(user, size, name)
        for tabs in filter(QTabBar.isVisible, user.window.findChildren(QTabBar)):
            assert tabs.sizeHint().width() <= tabs.parentWidget().width(), f"the tabs of {name}"
    user.window.show_screen("patients")
    user.window.resize(*size)
    user.key(Qt.Key.Key_N, window_user.CTRL)  # the form for a patient
    user.settle()
    user.qapp.processEvents()
    assert_fits(user, size, "the form for a patient")
    user.key(Qt.Key.Key_Escape)
    user.window.resize(*size)
    user.window.show_help()
    for name in TITLES:
        user.window.show_screen(name)
        user.settle()
        user.qapp.processEvents()
        assert user.window.width() == size[0], f"{name} with its help"
        assert user.window.findChild(HelpDock).isVisible()
        assert_fits(user, size, f"{name} with its help")
    user.close()


def test_the_rail_moves_together_where_the_window_is_low_and_apart_again(open_window):
    user = open_window()
    user.give_passphrase()
    user.until(lambda: user.window.shown)
    buttons = user.window.findChild(NavigationRail).findChildren(QToolButton)
    heights_px = []
    for height_px in (800, 640, 800):
        user.window.resize(1024, height_px)
        user.qapp.processEvents()
        assert user.window.height() == height_px
        places = sorted((one.y(), one.height()) for one in buttons)
        for (y, high), (below, _height) in itertools.pairwise(places):
            assert y + high <= below
        assert places[-1][0] + places[-1][1] <= height_px
        assert all(one.height() >= one.sizeHint().height() for one in buttons)
        heights_px.append(buttons[0].height())
    assert heights_px[0] == heights_px[2] > heights_px[1]
    user.close()


def test_a_window_that_opens_first_keeps_to_its_screen(open_window):
    user = open_window()
    user.give_passphrase()
    user.until(lambda: user.window.shown)
    screen = user.window.screen().availableSize()
    user.window.resize(2 * screen)
    user.window.keep_on_screen()
    assert user.window.height() < screen.height()  # the title stands above
    least_px = user.window.minimumSizeHint().width()
    assert user.window.width() == max(screen.width(), least_px)
    user.window.resize(least_px, 700)
    user.window.keep_on_screen()
    assert user.window.height() == 700
    user.close()


@pytest.mark.parametrize("language", LANGUAGES)
def test_the_button_that_changes_the_passphrase_shows_all_its_words(open_window, language):
    user = open_window(language=language, font_scale=2.0)
    user.give_passphrase()
    user.until(lambda: user.window.shown)
    user.go_to("settings")
    user.screen._tabs.setCurrentWidget(user.screen.protected)
    user.window.resize(1280, 800)
    user.settle()
    user.qapp.processEvents()
    button = user.screen.protected.protection._change_button
    assert button.width() >= button.sizeHint().width()
    user.close()


def test_with_smaller_letters_the_window_can_be_as_narrow_as_ever(open_window):
    user = open_window()
    user.give_passphrase()
    user.until(lambda: user.window.shown)
    for _visit in range(2):  # what a screen reads at its first visit may come after it was left
        for name in ("patients", "capture", "markers", "reports", "settings"):
            user.go_to(name)
        user.settle()
    usual_px = least_width_px(user)
    user.application.preferences.change(font_scale=2.0)
    for name in ("patients", "capture", "markers", "reports", "settings"):
        user.go_to(name)
    user.settle()
    assert least_width_px(user) > usual_px
    user.application.preferences.change(font_scale=1.0)
    user.until(lambda: least_width_px(user) == usual_px)
    assert user.window.shown == "settings"
    user.window.resize(usual_px, 700)
    assert user.window.width() == usual_px
    user.close()


@pytest.mark.parametrize("language", LANGUAGES)
def test_in_another_language_large_letters_still_have_room(open_window, language):
    user = seen_before_in_english(open_window, font_scale=2.0)
    user.application.preferences.change(language=language)
    assert least_width_px(user) <= 1280
    user.close()


@pytest.mark.parametrize("language", [one for one in LANGUAGES if one != "en"])
def test_in_another_language_every_box_is_as_wide_as_the_words_it_offers(open_window, language):
    user = seen_before_in_english(open_window)
    user.application.preferences.change(language=language)
    for _round in range(2):  # the screens hear of it, then their least sizes are worked out
        user.qapp.processEvents()
    kept = QComboBox.SizeAdjustPolicy.AdjustToContentsOnFirstShow
    boxes = [
        box
        for box in user.window.findChildren(QComboBox)
        if box.count() > 0 and box.sizeAdjustPolicy() == kept and box.minimumContentsLength() == 0
    ]
    assert len(boxes) > len(TITLES)
    for box in boxes:
        words = [box.itemText(index) for index in range(box.count())]
        widest_px = max(map(box.fontMetrics().horizontalAdvance, words))
        assert box.minimumSizeHint().width() > widest_px + BOX_ARROW_PX, words
    user.close()


@pytest.mark.parametrize("language", LANGUAGES)
def test_with_large_letters_what_is_below_the_video_is_whole(open_window, language, tmp_path):
    user = open_window(language=language, font_scale=2.0)
    user.give_passphrase()
    user.until(lambda: user.window.shown)
    user.go_to("behaviour")
    user.screen.open_file(make_recording(tmp_path / "child.mcap"))
    user.until(lambda: visible(user.window, Transport))
    user.window.resize(1280, 740)
    for _round in range(5):
        user.qapp.processEvents()
    assert_fits(user, (1280, 740), "the video")
    (row,) = visible(user.window, Transport)
    told = [one for one in visible(row, QLabel) if one.text()]
    assert len(told) == 3, "speed, frame and time"
    for label in told:
        assert label.geometry().bottom() < row.height(), label.text()
    assert row.geometry().bottom() < row.parentWidget().height()
    user.close()


@pytest.mark.parametrize("language", LANGUAGES)
@pytest.mark.usefixtures("theme")
def test_where_no_measure_is_chosen_what_to_do_is_never_squeezed(qtbot, language):
    with speaking(language):
        panel = MeasuresPanel()
        panel.show_chosen((), can_edit=True)
    panel.setStyleSheet("QLabel { font-size: 24pt; }")
    qtbot.addWidget(panel)
    with qtbot.waitExposed(panel):
        panel.show()
    panel.resize(250, 120)
    QApplication.processEvents()
    (told,) = [one for one in visible(panel, QLabel) if one.wordWrap()]
    assert told.height() > panel.height(), "the letters are too large for the place"
    assert told.height() >= told.heightForWidth(told.width())
    (area,) = [one for one in panel.findChildren(Scrolled) if one.isAncestorOf(told)]
    area.setFocus()
    for _page in range(9):
        QTest.keyClick(area, Qt.Key.Key_PageDown)
    assert area.focusPolicy() == Qt.FocusPolicy.StrongFocus, "Tab stops where there is more"
    bar = area.verticalScrollBar()
    assert bar.value() == bar.maximum() > 0
    panel.resize(600, 900)
    QApplication.processEvents()
    assert area.focusPolicy() == Qt.FocusPolicy.NoFocus, "and passes where all of it is seen"


def seen_before_in_english(open_window, **look):
    """Return who has been on every screen in another language than the one that comes."""
    user = open_window(**look)
    user.give_passphrase()
    user.until(lambda: user.window.shown)
    for name in TITLES:
        user.window.show_screen(name)
        user.settle()
    return user


def least_width_px(user):
    """Return how narrow the window may be once Qt has laid out what was shown last."""
    user.qapp.processEvents()
    return user.window.minimumSizeHint().width()


def assert_fits(user, size, where):
    least = user.window.minimumSizeHint()
    assert least.width() <= size[0], where
    assert least.height() <= size[1], where
    for panel in filter(SidePanel.isVisible, user.window.findChildren(SidePanel)):
        right = panel.mapTo(user.window, QPoint(panel.width(), 0)).x()
        assert right <= user.window.width(), f"a panel of {where}"


def test_the_help_stands_beside_the_screen_where_there_is_room_and_floats_elsewhere(open_window):
    user = open_window()
    user.give_passphrase()
    user.until(lambda: user.window.shown)
    user.window.resize(1280, 800)
    user.window.show_help()
    help_dock = user.window.findChild(HelpDock)
    user.go_to("review")
    assert not help_dock.isFloating()
    user.application.preferences.change(font_scale=2.0)
    user.go_to("capture")
    help_dock.hide()
    user.window.resize(least_width_px(user) + 50, 800)
    user.window.show_help()
    assert help_dock.isFloating()
    assert help_dock.isVisible()
    user.window.resize(1920, 1080)
    user.window.show_help()
    assert not help_dock.isFloating()
    user.close()


@pytest.mark.parametrize("language", LANGUAGES)
def test_what_is_said_at_the_bottom_never_widens_the_window(open_window, language):
    first = open_window()
    first.give_passphrase()
    first.until(lambda: first.window.shown)
    user = open_window(language=language, font_scale=2.0)
    user.give_passphrase()
    user.until(lambda: user.window.shown)
    user.window.show_patient("María de las Mercedes Fernández de Córdoba y Ruiz  ·  P-ABCDEFG")
    let_go = threading.Event()
    user.application.jobs.start("Escrivint els informes de totes", lambda _c: let_go.wait(), str)
    user.until(lambda: visible(user.window, QProgressBar))
    user.window.resize(1280, 800)
    user.qapp.processEvents()
    assert_fits(user, (1280, 800), "the line at the bottom")
    (told,) = [one for one in visible(user.window, ElidedLabel) if "Mercedes" in one.text()]
    told.grab()
    assert "Mercedes" in told.toolTip(), "what is cut is in the tip"
    let_go.set()
    user.settle()
    user.close()
    first.close()


@pytest.mark.parametrize("width_px", [300, 900])
def test_long_numbers_in_the_line_below_the_picture_ask_for_no_more_room(qtbot, width_px):
    status = StatusLine()
    qtbot.addWidget(status)
    status.show()

    status.show_state(SensorState("live"))
    status.show_frame(SimpleNamespace(frame_rate_hz=30.0, n_dropped=1_234_567))
    status.show_disk(9_876_543.0)
    status.resize(width_px, status.height())
    words_px = [
        max(map(label.fontMetrics().horizontalAdvance, label.text().split())) + 2
        for label in status.findChildren(QLabel)
    ]
    assert status.minimumSizeHint().width() <= sum(words_px) + 2 * SPACING_PX
