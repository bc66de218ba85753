"""Alt and a letter: each goes to one control of a screen, in every language."""

from collections import Counter

import pytest
from PySide6.QtGui import QKeySequence
from PySide6.QtWidgets import (
    QAbstractButton,
    QComboBox,
    QGroupBox,
    QLabel,
    QRadioButton,
    QTabBar,
    QTableView,
    QTabWidget,
    QToolBar,
    QWidget,
)

from adibas.texts import LANGUAGES
from adibas.texts import translate as _
from tests.ui import window_user
from ui.navigation import TITLES

open_window = window_user.open_window

FORMS = ("&New patient", "&Edit", "C&onsent")
"""Buttons of the patients' screen that open a form."""


def texts_of(widget):
    """Return the texts of a control in which a letter may be underlined."""
    if isinstance(widget, QTabBar):
        return [widget.tabText(index) for index in range(widget.count())]
    if isinstance(widget, QToolBar):
        return [action.text() for action in widget.actions()]
    if isinstance(widget, QLabel):
        return [widget.text()] if widget.buddy() is not None else []
    is_titled = isinstance(widget, QGroupBox)
    return [widget.title()] if is_titled else [widget.text()]


def mnemonics(window):
    """Return letters and the texts that have them, of all that is seen."""
    kinds = (QAbstractButton, QLabel, QGroupBox, QTabBar, QToolBar)
    seen = (one for one in window.findChildren(QWidget) if one.isVisibleTo(window))
    texts = [text for one in seen if isinstance(one, kinds) for text in texts_of(one)]
    found = [(QKeySequence.mnemonic(text).toString(), text) for text in texts]
    return [(keys, text) for keys, text in found if keys]


def assert_each_letter_is_one_control(window):
    found = mnemonics(window)
    counts = Counter(keys for keys, _text in found)
    twice = sorted(text for keys, text in found if counts[keys] > 1)
    assert not twice, twice
    idle = [one.text() for one in window.findChildren(QAbstractButton) if is_idle(one)]
    assert not idle, f"letters that are underlined and do nothing: {idle}"


def is_idle(button):
    """Say whether a letter is underlined and another key took its place."""
    meant = QKeySequence.mnemonic(button.text())
    return not meant.isEmpty() and meant != button.shortcut()


@pytest.fixture
def somebody(open_window):
    """Open a window in a language, with the demo patient chosen."""

    def open_in(language):
        user = open_window(language=language)
        assert_each_letter_is_one_control(user.window)
        user.give_new_passphrase()
        user.settle()
        return user

    return open_in


@pytest.mark.parametrize("language", LANGUAGES)
@pytest.mark.parametrize("name", TITLES)
def test_a_letter_goes_to_one_control_of_each_screen(somebody, name, language):
    user = somebody(language)
    user.go_to(name)
    user.settle()
    assert_each_letter_is_one_control(user.window)
    for tabs in user.screen.findChildren(QTabWidget):
        for index in range(tabs.count()):
            tabs.setCurrentIndex(index)
            assert_each_letter_is_one_control(user.window)


@pytest.mark.parametrize("language", LANGUAGES)
def test_a_letter_goes_to_one_control_of_each_form(somebody, language):
    user = somebody(language)
    for title in FORMS:
        user.screen.findChild(QTableView).selectRow(0)
        user.settle()
        user.click(_(title).replace("&", ""))
        for group in user.screen.findChildren(QGroupBox):
            group.setChecked(True)
        for chooser in window_user.visible(user.screen, QComboBox):
            chooser.setCurrentIndex(chooser.count() - 1)  # a guardian has a name
        assert_each_letter_is_one_control(user.window)
        user.click(_("Cancel"))


@pytest.mark.parametrize("language", LANGUAGES)
def test_a_letter_goes_to_one_control_of_the_learner_for_leds(somebody, language):
    user = somebody(language)
    user.go_to("markers")
    user.screen.findChildren(QRadioButton)[1].click()
    user.settle()
    assert_each_letter_is_one_control(user.window)
