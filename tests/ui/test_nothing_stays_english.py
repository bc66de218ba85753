"""Every text of the window goes through the catalogues, and Qt's own dialogs speak the language.

A catalogue that puts a mark into each text shows which texts never came to it.
"""

import gettext
import re

import pytest
from PySide6.QtCore import Qt
from PySide6.QtPrintSupport import QPrintDialog, QPrinter
from PySide6.QtWidgets import (
    QAbstractButton,
    QComboBox,
    QFileDialog,
    QListWidget,
    QTabBar,
    QTableView,
    QTableWidget,
    QTabWidget,
    QTextEdit,
    QTreeView,
    QWidget,
)

from adibas import texts
from adibas.measures.protocol_store import protocol_titles
from adibas.texts import LANGUAGES
from tests.ui import export_scene, window_user
from tests.ui.test_dialog_keyboard import OPENERS, put_away
from tests.ui.window_user import visible_dialogs
from ui.navigation import TITLES
from ui.unlock_page import UnlockPage
from ui.widgets.help_page import FRAME_TEXTS, HelpDock

open_window, named_servers = window_user.open_window, export_scene.named_servers
LANGUAGE, MARK = "pt", "\N{LEFT DOUBLE ANGLE BRACKET}"
GETTERS = (
    *("text", "title", "placeholderText", "suffix", "prefix", "specialValueText"),
    *("toolTip", "accessibleName", "accessibleDescription", "windowTitle"),
)
WORD = re.compile(r"[^\W\d_]{3,}")
NOT_TEXTS = re.compile(
    r"((Ctrl|Shift)\+)*(\w|Return|PgUp|PgDown)"  # keys
    r"|(DEMO  ·  )?P-[A-Z\d]{6}|([A-Z\d]{4}\s*)+"  # pseudonyms and recovery keys
    r"|\d+ [a-z]+\. \d{4}, \d\d:\d\d"  # Qt's dates
    r"|Ana Uno.*"  # an order
    r"|ADiBAS|SEM|ICC\(\d,1\)|MDC95",
    re.DOTALL,
)
LIBRARIES = {"OpenCV", "numba", "OpenNI2", "RealSense"}
TYPED = {
    *("DEMO", "ADIBAS", "sits", "waves", "session-7.mcap", "pacs", "ris", "here", "there"),
    *("All of it goes.", "Eva"),
}
"""By the demo, by an administrator, and by those who open the dialogs of these tests."""

ALIKE = {"...", "1", "Color"}
"""Of Qt's dialogs: the same in two languages."""


class Marking(gettext.NullTranslations):
    """Marks each text that comes to it."""

    def gettext(self, message):
        return MARK + message

    def ngettext(self, singular, plural, n):
        return MARK + (singular if n == 1 else plural)


def texts_of(widget):
    """Yield what somebody sees or hears of a widget."""
    for name in GETTERS:
        getter = getattr(type(widget), name, None)
        if type(getter).__name__ == "method_descriptor":  # Qt's: it takes nothing else
            yield getter(widget)
    if isinstance(widget, QComboBox):
        yield from (widget.itemText(index) for index in range(widget.count()))
    if isinstance(widget, QTabWidget):
        yield from (widget.tabText(index) for index in range(widget.count()))
    if isinstance(widget, QListWidget):
        yield from (widget.item(row).text() for row in range(widget.count()))
    if isinstance(widget, QTableWidget):
        yield from table_texts(widget)


def table_texts(table):
    model = table.model()
    for column in range(table.columnCount()):
        yield model.headerData(column, Qt.Orientation.Horizontal)
        yield from (model.index(row, column).data() for row in range(table.rowCount()))


def all_texts(root):
    widgets = (root, *root.findChildren(QWidget))
    seen = (one for one in widgets if not isinstance(one, QTextEdit) and not is_of_qt(one))
    found = {text for one in seen for text in texts_of(one) if isinstance(text, str)}
    return {text.replace("&", "") for text in found if text}


def is_of_qt(widget):
    """Say whether a widget is one that Qt makes: the arrows beside tabs, the frame of the help."""
    return isinstance(widget.parentWidget(), QTabBar) or widget.objectName() in FRAME_TEXTS


def unmarked(root):
    """Return the texts below a widget that came to no catalogue."""
    titles = {title for _name, by_language in protocol_titles() for title in named(by_language)}
    known = {*LANGUAGES.values(), *(name for name, _title in protocol_titles()), *titles}
    return {
        text
        for text in all_texts(root) - known - LIBRARIES - TYPED
        if WORD.search(text) and MARK not in text and not NOT_TEXTS.fullmatch(text)
    }


def named(by_language):
    return by_language.by_language.values()


@pytest.fixture
def somebody(open_window, named_servers, monkeypatch):  # noqa: ARG001  (they are there)
    """A window whose texts are marked, with the demo patient."""
    monkeypatch.setattr(texts, "_catalogue", lambda _folder, _language: Marking())
    user = open_window(language=LANGUAGE)
    assert unmarked(user.window) == set()
    user.give_new_passphrase()
    user.settle()
    user.screen.findChild(QTableView).selectRow(0)
    user.settle()
    return user


def test_every_text_of_every_screen_comes_from_a_catalogue(somebody):
    user, found = somebody, {}
    for name in TITLES:
        user.go_to(name)
        user.settle()
        found[name] = unmarked(user.window)
        for tabs in user.screen.findChildren(QTabWidget):
            for index in range(tabs.count()):
                tabs.setCurrentIndex(index)
                user.settle()
                found[f"{name} {index}"] = unmarked(user.window)
    assert {where: told for where, told in found.items() if told} == {}


def test_every_text_of_every_dialog_comes_from_a_catalogue(somebody):
    user, found = somebody, {}
    for kind, opener in OPENERS.items():
        dialog = opener(user)
        if not dialog.isVisible():
            dialog.open()
        user.settle()
        found[kind.__name__] = unmarked(dialog)
        put_away(user)
    assert {where: told for where, told in found.items() if told} == {}


def test_every_state_of_the_first_page_comes_from_a_catalogue(somebody):
    page = somebody.window.findChild(UnlockPage)
    asked = [getattr(page, name) for name in dir(UnlockPage) if name.startswith(("ask_", "show_"))]
    assert len(asked) > 8
    for ask in asked:
        words = {"ask_replacement": (("Eva",),), "show_problem": ("1",), "show_bug": ("1",)}
        ask(*words.get(ask.__name__, ()))
        assert unmarked(page) == set(), ask.__name__


def test_a_text_that_comes_from_no_catalogue_would_be_found(somebody):
    somebody.window.setToolTip("What is here")
    assert unmarked(somebody.window) == {"What is here"}


def qt_texts(user):
    """Return what Qt's dialogs for files and for printing show."""
    printer = QPrinter()
    dialogs = [QFileDialog(user.window), QFileDialog(user.window), QPrintDialog(printer)]
    dialogs[0].setOption(QFileDialog.Option.DontUseNativeDialog)
    dialogs[1].setFileMode(QFileDialog.FileMode.Directory)
    for dialog in dialogs:
        dialog.show()
    model = dialogs[0].findChild(QTreeView).model()
    heads = {model.headerData(column, Qt.Orientation.Horizontal) for column in range(4)}
    found = heads.union(*(all_texts(dialog) for dialog in dialogs))
    for dialog in dialogs:
        dialog.close()
        dialog.deleteLater()
    return {one for one in found if not one.startswith("/")} - ALIKE


@pytest.mark.parametrize("language", [one for one in LANGUAGES if one != "en"])
def test_dialogs_of_qt_speak_the_language_of_the_window(open_window, language):
    user = open_window()
    english = qt_texts(user)
    assert {"Look in:", "Files of type:"} <= english
    user.application.preferences.change(language=language)
    assert qt_texts(user) & english == set()
    user.application.preferences.change(language="en")
    assert qt_texts(user) == english
    assert not visible_dialogs()


def test_a_screen_reader_hears_the_frame_of_the_help_in_the_language_of_the_window(open_window):
    user = open_window(language="es")
    frame = user.window.findChild(HelpDock)
    heard = [frame.findChild(QAbstractButton, name).accessibleName() for name in FRAME_TEXTS]
    assert heard == ["Flotante", "Cerrar"]
    user.application.preferences.change(language="ca")
    user.qapp.processEvents()
    heard = [frame.findChild(QAbstractButton, name).accessibleName() for name in FRAME_TEXTS]
    assert heard == ["Flotant", "Tanca"]
