"""The recovery key: since when there is one, and a button for another. No decisions."""

from datetime import datetime

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QGroupBox, QLabel, QPushButton, QVBoxLayout, QWidget

from adibas.texts import translate as _
from ui.settings.recovery_presenter import RecoveryPresenter
from ui.widgets.dates import day_text
from ui.widgets.look import show_kind


class RecoveryPage(QWidget):
    """One group.

    Attributes
    ----------
    make : QPushButton
        For administrators.
    """

    make_asked = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._group = QGroupBox(self)
        self._state, self.make = QLabel(self), QPushButton(self)
        self._state.setWordWrap(True)
        self.make.clicked.connect(self.make_asked)
        self._made_utc: datetime | None = None
        self._is_known = False
        column = QVBoxLayout(self._group)
        for widget in (self._state, self.make):
            column.addWidget(widget)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(9, 4, 9, 4)
        layout.addWidget(self._group)
        self.retranslate()

    def bind(self, presenter: RecoveryPresenter) -> None:
        """Send what is wanted to the presenter, and own it."""
        self._presenter = presenter
        self.make_asked.connect(presenter.make)

    def entered(self) -> None:
        """Show what is so now."""
        self._presenter.enter()

    def retranslate(self) -> None:
        """Set the texts in the language in use."""
        self._group.setTitle(_("Recovery key"))
        has_one = self._made_utc is not None
        self.make.setText(
            _("Make a new recovery key...") if has_one else _("Make a recovery key...")
        )
        self._state.setText(_told(self._made_utc) if self._is_known else "")

    def show_state(self, made_utc: datetime | None, *, can_change: bool) -> None:
        self._made_utc, self._is_known = made_utc, True
        self._group.setEnabled(can_change)
        show_kind(self._state, "warning" if made_utc is None else "")
        self.retranslate()


def _told(made_utc: datetime | None) -> str:
    if made_utc is None:
        return _(
            "There is no recovery key yet: if the passphrase or the keyring is lost, nobody can "
            "read the patients."
        )
    return _(
        "There is a recovery key since {day}. A new one takes its place: the one on paper opens "
        "the store no more then."
    ).format(day=day_text(made_utc.astimezone().date()))
