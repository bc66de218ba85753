"""The page before the screens: a passphrase, or a button. No decisions."""

from collections.abc import Callable

from PySide6.QtCore import Qt
from PySide6.QtWidgets import (
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
        self._bug = ""
        self._logo, self._title = QLabel(self), QLabel(self)
        self._explanation, self._problem = QLabel(self), QLabel(self)
        self._first, self._second = QLineEdit(self), QLineEdit(self)
        self._button = QPushButton(self)
        self._title.setProperty("kind", "title")
        self._problem.setProperty("kind", "bad")
        self._button.setProperty("main", "true")
        for label in (self._title, self._explanation, self._problem):
            label.setWordWrap(True)
        for field in (self._first, self._second):
            field.setEchoMode(QLineEdit.EchoMode.Password)
            field.returnPressed.connect(self._button.click)
        self._button.clicked.connect(self._on_button)
        self._column = QWidget(self)
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
            self._first,
            self._second,
            self._problem,
            self._button,
        ):
            inner.addWidget(widget)
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
        self._send = lambda: self._presenter.give_passphrase(self._first.text())

    def ask_own_passphrase(self) -> None:
        self._show(_own_words, fields=1)
        self._send = lambda: self._presenter.give_passphrase(self._first.text())

    def ask_server_password(self) -> None:
        self._show(_server_words, fields=1)
        self._send = lambda: self._presenter.give_server_password(self._first.text())

    def ask_unlock(self) -> None:
        self._show(_unlock_words, fields=0)
        self._send = self._presenter.open_from_keyring

    def show_problem(self, sentence: str) -> None:
        self._problem.setText(sentence)
        self._problem.show()

    def show_bug(self, sentence: str) -> None:
        """Say that the program failed, whatever is asked for meanwhile."""
        self._bug = sentence
        self.show_problem(sentence)

    def _on_button(self) -> None:
        self._send()

    def _show(self, words: Callable[[], tuple[str, str, str]], fields: int) -> None:
        self._words = words
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
            "It locks the patients' data on this computer. Keep it safe: without it nobody can "
            "read them, not even the makers of this program."
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
