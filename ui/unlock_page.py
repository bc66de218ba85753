"""The page before the screens: a passphrase, a button, or the recovery key. No decisions."""

from collections.abc import Callable
from functools import partial
from itertools import pairwise

from PySide6.QtCore import Qt
from PySide6.QtWidgets import (
    QComboBox,
    QLabel,
    QLineEdit,
    QPushButton,
    QScrollArea,
    QVBoxLayout,
    QWidget,
)

from adibas.texts import translate as _
from ui.theme import Theme
from ui.unlock_presenter import UnlockPresenter
from ui.widgets.screen import Screen

LOGO_PX = 88
WIDTH_LETTERS = 44
LEAST_WIDTH_PX = 440


class UnlockPage(Screen):
    """Asks for what the store needs."""

    name = "start"

    def __init__(self, theme: Theme, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._theme = theme
        self._words: Callable[[], tuple[str, str, str]] = _busy_words
        self._send: Callable[[], None] = lambda: None
        self._turn: Callable[[], None] = lambda: None
        self._bug = ""
        self._logo, self._title = QLabel(self), QLabel(self)
        self._explanation, self._problem = QLabel(self), QLabel(self)
        self._first, self._second = QLineEdit(self), QLineEdit(self)
        self._button, self._other = QPushButton(self), QPushButton(self)
        self._key, self._people = QLineEdit(self), QComboBox(self)
        self._title.setProperty("kind", "title")
        self._problem.setProperty("kind", "bad")
        self._button.setProperty("main", "true")
        for label in (self._title, self._explanation, self._problem):
            label.setWordWrap(True)
        for field in (self._first, self._second):
            field.setEchoMode(QLineEdit.EchoMode.Password)
        hints = Qt.InputMethodHint.ImhSensitiveData | Qt.InputMethodHint.ImhNoPredictiveText
        self._key.setInputMethodHints(hints)  # what learns words learns none of it
        for field in (self._key, self._first, self._second):
            field.returnPressed.connect(self._button.click)
        self._other.clicked.connect(self._on_other)
        self._button.clicked.connect(self._on_button)
        self._column = QWidget(self)
        self._other_words: Callable[[], str] = str
        self._lay_out()
        self.dress()
        self.show_busy()

    def _lay_out(self) -> None:
        inner = QVBoxLayout(self._column)
        inner.setSpacing(14)
        for widget in (
            self._logo,
            self._title,
            self._explanation,
            self._key,
            self._people,
            self._first,
            self._second,
            self._problem,
            self._button,
            self._other,
        ):
            inner.addWidget(widget)
        order = (self._key, self._people, self._first, self._second, self._button, self._other)
        for before, after in pairwise(order):
            self.setTabOrder(before, after)
        area = QScrollArea(self)
        area.setWidget(self._column)
        area.setWidgetResizable(True)
        area.setAlignment(Qt.AlignmentFlag.AlignCenter)
        area.setFrameShape(QScrollArea.Shape.NoFrame)
        area.setFocusPolicy(Qt.FocusPolicy.NoFocus)  # it follows the fields in it
        inner.insertStretch(0)
        inner.addStretch()
        layout = QVBoxLayout(self)
        layout.addWidget(area)

    def bind(self, presenter: UnlockPresenter) -> None:
        """Send what is typed to `presenter`, and own it; a bug told before is forgotten."""
        self._presenter = presenter
        self._bug = ""

    def dress(self) -> None:
        """Draw the logo in the theme in use."""
        icon = self._theme.icon("adibas", self._theme.tokens.accent)
        self._logo.setPixmap(icon.pixmap(LOGO_PX, LOGO_PX))
        width_px = WIDTH_LETTERS * self.fontMetrics().averageCharWidth()
        self._column.setMaximumWidth(max(LEAST_WIDTH_PX, width_px))

    def retranslate(self) -> None:
        """Set the texts in the language in use."""
        title, explanation, button = self._words()
        self._title.setText(title)
        self._explanation.setText(explanation)
        self._button.setText(button)
        asked = _("Password of the server") if self._words is _server_words else _("Passphrase")
        self._first.setPlaceholderText(asked)
        self._first.setAccessibleName(asked)
        self._other.setText(self._other_words())
        self._key.setPlaceholderText(_("Recovery key"))
        self._key.setAccessibleName(_("Recovery key"))
        self._people.setAccessibleName(_("Administrator"))
        self._second.setPlaceholderText(_("The same passphrase again"))
        self._second.setAccessibleName(_("The same passphrase again"))

    def show_busy(self) -> None:
        self._show(_busy_words, fields=0)
        self._button.hide()

    def show_locking(self) -> None:
        """Say that the window is locked while something is finished behind it."""
        self._show(_locking_words, fields=0)
        self._button.hide()

    def ask_new_passphrase(self) -> None:
        self._show(_new_words, fields=2)
        self._send = lambda: self._presenter.give_new_passphrase(
            self._first.text(), self._second.text()
        )

    def ask_passphrase(self) -> None:
        self._show(_passphrase_words, fields=1)
        self._offer_recovery()
        self._send = lambda: self._presenter.give_passphrase(self._first.text())

    def ask_own_passphrase(self) -> None:
        self._show(_own_words, fields=1)
        self._offer_recovery()
        self._send = lambda: self._presenter.give_passphrase(self._first.text())

    def ask_server_password(self) -> None:
        self._show(_server_words, fields=1)
        self._send = lambda: self._presenter.give_server_password(self._first.text())

    def ask_unlock(self) -> None:
        self._show(_unlock_words, fields=0)
        self._offer_recovery()
        self._send = self._presenter.open_from_keyring

    def ask_recovery_key(self) -> None:
        typed = self._key.text()
        self._show(_recovery_words, fields=0)
        self._key.setText(typed)
        self._key.show()
        self._key.setFocus()
        self._offer(_back_word, self._on_back)
        self._send = lambda: self._presenter.give_recovery_key(self._key.text())

    def ask_replacement(self, names: tuple[str, ...]) -> None:
        chosen = self._people.currentText()
        self._show(partial(_replacement_words, names), fields=2)
        self._people.addItems(names)
        self._people.setCurrentIndex(max(self._people.findText(chosen), 0))
        self._people.setVisible(len(names) > 1)
        self._offer(_back_word, self._on_back)
        self._send = lambda: self._presenter.give_replacement(
            self._people.currentText(), self._first.text(), self._second.text()
        )

    def show_problem(self, sentence: str) -> None:
        self._problem.setText(sentence)
        self._problem.show()

    def show_bug(self, sentence: str) -> None:
        """Say that the program failed, whatever is asked for meanwhile."""
        self._bug = sentence
        self.show_problem(sentence)

    def _on_button(self) -> None:
        self._send()

    def _on_other(self) -> None:
        self._turn()

    def _on_lost(self) -> None:
        self._presenter.begin_recovery()

    def _on_back(self) -> None:
        self._presenter.leave_recovery()

    def _offer_recovery(self) -> None:
        self._offer(_lost_words, self._on_lost)

    def _offer(self, words: Callable[[], str], turn: Callable[[], None]) -> None:
        """Offer another way than the one that is asked for."""
        self._other_words, self._turn = words, turn
        self._other.setText(words())
        self._other.show()

    def _show(self, words: Callable[[], tuple[str, str, str]], fields: int) -> None:
        self._words = words
        self._other.hide()
        self._key.hide()
        if words is not _busy_words:  # what is being tried may have to be mended
            self._key.clear()
            self._people.clear()
        self._people.hide()
        self._problem.setText(self._bug)
        self._problem.setVisible(bool(self._bug))
        for number, field in enumerate((self._first, self._second)):
            field.clear()
            field.setVisible(number < fields)
        self._button.show()
        self.retranslate()
        (self._first if fields else self._button).setFocus()


def _busy_words() -> tuple[str, str, str]:
    return "ADiBAS", _("Opening the patient store"), ""


def _locking_words() -> tuple[str, str, str]:
    return _("Locked"), _("What still runs is finished first."), ""


def _new_words() -> tuple[str, str, str]:
    return (
        _("Choose a passphrase"),
        _(
            "It locks the patients' data on this computer. Keep it safe: without it, and without "
            "the recovery key that you get next, nobody can read them, not even the makers of this "
            "program."
        ),
        _("Make the patient store"),
    )


def _passphrase_words() -> tuple[str, str, str]:
    return _("Locked"), _("Type the passphrase of the patient store."), _("Unlock")


def _own_words() -> tuple[str, str, str]:
    return (
        _("Locked"),
        _("Type your own passphrase: it tells who you are, and what you may see."),
        _("Unlock"),
    )


def _server_words() -> tuple[str, str, str]:
    return (
        _("Patient database"),
        _("The database of the patient store is on a server, which asks for its own password."),
        _("Connect"),
    )


def _unlock_words() -> tuple[str, str, str]:
    return _("Locked"), _("The desktop's keyring keeps the key of the patient store."), _("Unlock")


def _lost_words() -> str:
    return _("Passphrase or keyring lost?")


def _back_word() -> str:
    return _("Go back")


def _recovery_words() -> tuple[str, str, str]:
    return (
        _("Recovery key"),
        _(
            "Type the recovery key from the page on which it was printed. Spaces, dashes and "
            "capitals do not matter."
        ),
        _("Go on"),
    )


def _replacement_words(names: tuple[str, ...]) -> tuple[str, str, str]:
    if len(names) > 1:
        told = _("The recovery key is right. Choose whose passphrase is replaced, and a new one.")
    elif names:
        told = _("The recovery key is right. Choose a new passphrase for {name}.").format(
            name=names[0]
        )
    else:
        told = _(
            "The recovery key is right. Choose a new passphrase: it alone opens the store then, "
            "beside the recovery key."
        )
    return _("Choose a passphrase"), told, _("Open the patient store")
