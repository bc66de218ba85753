"""The page before the screens: a passphrase, or a button. No decisions."""

from collections.abc import Callable

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QLabel, QLineEdit, QPushButton, QVBoxLayout, QWidget

from adibas.texts import translate as _
from ui.theme import Theme
from ui.unlock_presenter import UnlockPresenter
from ui.widgets.screen import Screen

LOGO_PX = 88
WIDTH_PX = 440


class UnlockPage(Screen):
    """Asks for what the store needs."""

    name = "start"

    def __init__(self, theme: Theme, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._theme = theme
        self._words: Callable[[], tuple[str, str, str]] = _busy_words
        self._send: Callable[[], None] = lambda: None
        self._logo, self._title = QLabel(self), QLabel(self)
        self._explanation, self._problem = QLabel(self), QLabel(self)
        self._first, self._second = QLineEdit(self), QLineEdit(self)
        self._button = QPushButton(self)
        self._title.setProperty("kind", "title")
        self._problem.setProperty("kind", "bad")
        self._button.setProperty("main", "true")
        for label in (self._explanation, self._problem):
            label.setWordWrap(True)
        for field in (self._first, self._second):
            field.setEchoMode(QLineEdit.EchoMode.Password)
            field.returnPressed.connect(self._button.click)
        self._button.clicked.connect(self._on_button)
        column = QWidget(self)
        column.setFixedWidth(WIDTH_PX)
        inner = QVBoxLayout(column)
        inner.setSpacing(14)
        for widget in (
            self._logo,
            self._title,
            self._explanation,
            self._first,
            self._second,
            self._problem,
            self._button,
        ):
            inner.addWidget(widget)
        layout = QVBoxLayout(self)
        layout.addWidget(column, 0, Qt.AlignmentFlag.AlignCenter)
        self.dress()
        self.show_busy()

    def bind(self, presenter: UnlockPresenter) -> None:
        """Send what is typed to `presenter`, and own it."""
        self._presenter = presenter

    def dress(self) -> None:
        """Draw the logo in the theme in use."""
        icon = self._theme.icon("adibas", self._theme.tokens.accent)
        self._logo.setPixmap(icon.pixmap(LOGO_PX, LOGO_PX))

    def retranslate(self) -> None:
        """Set the texts in the language in use."""
        title, explanation, button = self._words()
        self._title.setText(title)
        self._explanation.setText(explanation)
        self._button.setText(button)
        self._first.setPlaceholderText(_("Passphrase"))
        self._first.setAccessibleName(_("Passphrase"))
        self._second.setPlaceholderText(_("The same passphrase again"))
        self._second.setAccessibleName(_("The same passphrase again"))

    def show_busy(self) -> None:
        self._show(_busy_words, fields=0)
        self._button.hide()

    def ask_new_passphrase(self) -> None:
        self._show(_new_words, fields=2)
        self._send = lambda: self._presenter.give_new_passphrase(
            self._first.text(), self._second.text()
        )

    def ask_passphrase(self) -> None:
        self._show(_passphrase_words, fields=1)
        self._send = lambda: self._presenter.give_passphrase(self._first.text())

    def ask_unlock(self) -> None:
        self._show(_unlock_words, fields=0)
        self._send = self._presenter.begin

    def show_problem(self, sentence: str) -> None:
        self._problem.setText(sentence)
        self._problem.show()

    def _on_button(self) -> None:
        self._send()

    def _show(self, words: Callable[[], tuple[str, str, str]], fields: int) -> None:
        self._words = words
        self._problem.hide()
        for number, field in enumerate((self._first, self._second)):
            field.clear()
            field.setVisible(number < fields)
        self._button.show()
        self.retranslate()
        (self._first if fields else self._button).setFocus()


def _busy_words() -> tuple[str, str, str]:
    return "ADiBAS", _("Opening the patient store"), ""


def _new_words() -> tuple[str, str, str]:
    return (
        _("Choose a passphrase"),
        _(
            "It locks the patients' data on this computer. Keep it safe: without it nobody can "
            "read them, not even the makers of this program."
        ),
        _("Make the patient store"),
    )


def _passphrase_words() -> tuple[str, str, str]:
    return _("Locked"), _("Type the passphrase of the patient store."), _("Unlock")


def _unlock_words() -> tuple[str, str, str]:
    return _("Locked"), _("The desktop's keyring keeps the key of the patient store."), _("Unlock")
