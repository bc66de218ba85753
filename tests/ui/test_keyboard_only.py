"""With the keyboard alone and with a screen reader: every control is reached, and has a name."""

import pytest
from PySide6.QtCore import Qt
from PySide6.QtGui import QAccessible
from PySide6.QtWidgets import (
    QAbstractButton,
    QAbstractItemView,
    QAbstractSlider,
    QAbstractSpinBox,
    QComboBox,
    QGroupBox,
    QLineEdit,
    QPlainTextEdit,
    QScrollBar,
    QTabBar,
    QTableView,
    QTabWidget,
    QTextEdit,
    QToolButton,
)

from adibas.texts import LANGUAGES
from adibas.texts import translate as _
from tests.ui import window_user
from ui.navigation import TITLES
from ui.widgets.help_page import HelpDock

open_window = window_user.open_window
Key, SHIFT = Qt.Key, Qt.KeyboardModifier.ShiftModifier
CONTROLS = (
    QAbstractButton,
    QAbstractItemView,
    QAbstractSlider,
    QAbstractSpinBox,
    QComboBox,
    QLineEdit,
    QPlainTextEdit,
    QTabBar,
    QTextEdit,
)
MOST_STEPS = 120
FORMS = ("&New patient", "&Edit", "C&onsent")


def controls(window):
    """Return what somebody could use now: seen, enabled, and no part of another control."""
    found = [one for kind in CONTROLS for one in window.findChildren(kind)]
    return [one for one in dict.fromkeys(found) if is_usable(one) and not is_part(one)]


def is_usable(widget):
    return widget.isVisible() and widget.isEnabled() and widget.size().width() > 1


def is_part(widget):
    """Say whether a control belongs to another one: a field's editor, a list's scroll bar."""
    if isinstance(widget, QScrollBar):
        return True
    parent = widget.parentWidget()
    while parent is not None:
        if isinstance(parent, (*CONTROLS,)) or "Scroller" in type(parent).__name__:
            return True
        parent = parent.parentWidget()
    return widget.objectName().startswith("qt_")


def is_reached_otherwise(widget, reached):
    """Say whether arrows lead there from another one of its group, or a key of its own does."""
    if isinstance(widget, QTabBar):
        return widget.count() == 1
    if not isinstance(widget, QAbstractButton):
        return False
    action = widget.defaultAction() if isinstance(widget, QToolButton) else None
    has_key = action is not None and not action.shortcut().isEmpty()
    return has_key or any(one in reached for one in of_one_choice(widget))


def of_one_choice(button):
    """Return the buttons of which one alone is pressed, this one among them."""
    if button.group() is not None and button.group().exclusive():
        return button.group().buttons()
    if not button.autoExclusive():
        return [button]
    return button.parentWidget().findChildren(type(button))


def owner(widget, known):
    """Return the control that a widget with the focus is, or is a part of."""
    while widget is not None and widget not in known:
        widget = widget.parentWidget()
    return widget


def walk(user, key=Key.Key_Tab):
    """Press Tab until the focus is where it was before; return where it has been, in order."""
    passed = []
    for _step in range(MOST_STEPS):
        here = user.focus
        assert here is not None, "Tab leads out of the window"
        if here in passed:
            return passed
        passed.append(here)
        user.key(key, SHIFT if key == Key.Key_Backtab else Qt.KeyboardModifier.NoModifier)
    raise AssertionError("Tab comes never back")


def name_of(widget):
    """Return what a screen reader says of a control."""
    interface = QAccessible.queryAccessibleInterface(widget)
    return interface.text(QAccessible.Text.Name).replace("&", "").strip()


def describe(widget):
    text = getattr(widget, "text", str)
    return f"{type(widget).__name__} {name_of(widget)!r} {widget.objectName()} {text()!r}"


def assert_keyboard_is_enough(user):
    user.qapp.processEvents()
    known = controls(user.window)
    passed = walk(user)
    reached = {owner(one, known) for one in passed}
    lost = [one for one in known if one not in reached and not is_reached_otherwise(one, reached)]
    assert not lost, [describe(one) for one in lost]
    nameless = [one for one in (*known, *passed) if not name_of(one)]
    assert not nameless, [describe(one) for one in nameless]


@pytest.fixture
def somebody(open_window):
    """Open a window with the demo patient and a session of his."""

    def open_in(language, **changes):
        user = open_window(language=language, **changes)
        user.give_new_passphrase()
        user.settle()
        user.screen.findChild(QTableView).selectRow(0)
        user.settle()
        user.click(seen(_("&Start a session")))
        user.settle()
        return user

    return open_in


def seen(text):
    return text.replace("&", "")


@pytest.mark.parametrize("language", LANGUAGES)
def test_the_store_is_opened_with_the_keyboard(open_window, language):
    user = open_window(language=language)
    user.until(lambda: user.focus is not None)
    assert_keyboard_is_enough(user)


@pytest.mark.parametrize("name", TITLES)
def test_tab_reaches_every_control_of_a_screen_and_each_has_a_name(somebody, name):
    user = somebody("en")
    user.go_to(name)
    user.settle()
    assert_keyboard_is_enough(user)
    for tabs in user.screen.findChildren(QTabWidget):
        for index in range(tabs.count() if tabs.isVisible() else 0):
            tabs.setCurrentIndex(index)
            user.settle()
            assert_keyboard_is_enough(user)


def test_shift_tab_goes_the_same_way_back(somebody):
    user = somebody("en")
    there = walk(user)
    assert len(there) > 10
    back = walk(user, Key.Key_Backtab)
    assert back == [there[0], *reversed(there[1:])]


@pytest.mark.parametrize("title", FORMS)
def test_tab_reaches_every_field_of_a_form(somebody, title):
    user = somebody("en")
    user.go_to("patients")
    user.settle()
    user.click(seen(_(title)))
    for group in user.screen.findChildren(QGroupBox):
        group.setChecked(True)
    assert_keyboard_is_enough(user)
    user.click(_("Cancel"))


def test_the_help_is_reached_left_and_named(somebody):
    user = somebody("en")
    user.key(Key.Key_F1)
    user.until(user.window.findChild(HelpDock).isVisible)
    user.qapp.processEvents()
    assert user.focus.accessibleName() == _("Help")
    user.tab_to_button(_("Open the manual"))


@pytest.mark.parametrize("language", LANGUAGES)
def test_a_screen_reader_has_a_name_for_every_control_in_every_language(somebody, language):
    user = somebody(language)
    for name in TITLES:
        user.go_to(name)
        user.settle()
        nameless = [describe(one) for one in controls(user.window) if not name_of(one)]
        assert not nameless, name


@pytest.mark.parametrize("name", TITLES)
def test_with_letters_of_twice_the_size_every_control_is_there_and_whole(somebody, name):
    user = somebody("ca", font_scale=2.0)
    user.go_to(name)
    user.settle()
    assert (user.window.width(), user.window.height()) == (1280, 800)
    squeezed = [
        describe(one)
        for one in controls(user.window)
        if isinstance(one, QAbstractButton | QComboBox | QLineEdit | QAbstractSpinBox)
        and one.height() < one.fontMetrics().height()
    ]
    assert not squeezed
    assert_keyboard_is_enough(user)


def test_a_control_that_tab_passes_by_or_that_has_no_name_would_be_found(somebody):
    user = somebody("en")
    lock = user.window.findChild(QToolButton, "go-lock")
    lock.setFocusPolicy(Qt.FocusPolicy.NoFocus)
    with pytest.raises(AssertionError, match="go-lock"):
        assert_keyboard_is_enough(user)
    lock.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
    assert_keyboard_is_enough(user)
    lock.setAccessibleName("")
    lock.setText("")
    with pytest.raises(AssertionError, match="go-lock"):
        assert_keyboard_is_enough(user)
