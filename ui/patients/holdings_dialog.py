"""The dialog that lists everything that is held of a patient. No decisions."""

from typing import TYPE_CHECKING

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QDialog, QLabel, QPushButton, QVBoxLayout, QWidget

from adibas.sessions.roles import Permission
from adibas.texts import translate as _
from ui.patients.holdings_presenter import Actions, HoldingsPresenter
from ui.view_names import VIEW_NAMES
from ui.widgets.dates import day_text, moment_text
from ui.widgets.flow import in_a_flow
from ui.widgets.for_roles import keep_for_roles
from ui.widgets.scrolled import SHARE_OF_WINDOW, Scrolled, window_room
from ui.workspace import Workspace

if TYPE_CHECKING:
    from adibas.sessions.holdings import Holdings

LETTERS_IN_A_LINE, LINES = 84, 30
FEWEST_LETTERS, FEWEST_LINES = 40, 8
GAP_PX = 12


class HoldingsDialog(QDialog):
    """Lines under titles, to read and to copy, and two buttons that remove."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.setWindowTitle(_("What is held of the patient"))
        self._wait = QLabel(_("Looking for what is held"), self)
        self._hide, self._remove, self._close = (QPushButton(self) for _number in range(3))
        self._hide.setText(_("De&lete"))
        self._hide.setToolTip(_("Hide the patient; it can be undone"))
        self._remove.setText(_("Remove for &good"))
        self._remove.setProperty("danger", "true")
        self._close.setText(_("Close"))
        self._close.setDefault(True)
        self._close.clicked.connect(self.reject)
        self._close.setFocus()
        self._inside = Scrolled(self)
        self._inside.column.setSpacing(4)
        self._inside.column.setContentsMargins(0, 0, 12, 0)
        self._inside.column.addWidget(self._wait)
        self._inside.column.addStretch()
        column = QVBoxLayout(self)
        column.setContentsMargins(24, 20, 24, 20)
        column.setSpacing(GAP_PX)
        column.addWidget(self._inside, 1)
        column.addLayout(in_a_flow(self._hide, self._remove, self._close))
        self._fit()

    def for_roles(self) -> tuple[tuple[QWidget, Permission], ...]:
        """Return the buttons that are not for everybody."""
        return (self._hide, Permission.CHANGE_PATIENTS), (self._remove, Permission.PURGE)

    def bind(self, presenter: HoldingsPresenter) -> None:
        """Send what the user does to `presenter`, and own it."""
        self._presenter = presenter
        self._hide.clicked.connect(presenter.hide)
        self._remove.clicked.connect(presenter.ask_removal)

    def show_holdings(self, held: "Holdings") -> None:
        from adibas.sessions.holdings_words import Spelling, holdings_sections

        self._wait.hide()
        column = self._inside.column
        spelling = Spelling(moment_text, day_text, _view_text)
        for section in holdings_sections(held, spelling):
            title, lines = QLabel(section.title, self), QLabel("\n".join(section.lines), self)
            title.setProperty("kind", "heading")
            lines.setAccessibleName(section.title)
            for label in (title, lines):
                label.setTextFormat(Qt.TextFormat.PlainText)
                label.setWordWrap(True)
                column.insertWidget(column.count() - 1, label)
            column.insertSpacing(column.count() - 1, 8)
            lines.setTextInteractionFlags(
                Qt.TextInteractionFlag.TextSelectableByMouse
                | Qt.TextInteractionFlag.TextSelectableByKeyboard
            )

    def show_actions(self, *, can_hide: bool, can_remove: bool) -> None:
        self._hide.setEnabled(can_hide)
        self._remove.setEnabled(can_remove)

    def finish(self) -> None:
        self.accept()

    def _fit(self) -> None:
        """Be as large as a long list wants, within the window; some of it is always seen."""
        metrics, room = self.fontMetrics(), window_room(self)
        buttons = (self._hide, self._remove, self._close)
        row = sum(button.sizeHint().width() for button in buttons) + 2 * GAP_PX
        letters = metrics.averageCharWidth() * FEWEST_LETTERS
        self._inside.setMinimumSize(max(row, letters), metrics.height() * FEWEST_LINES)
        width = metrics.averageCharWidth() * LETTERS_IN_A_LINE
        height = metrics.height() * LINES
        most = round(SHARE_OF_WINDOW * room.height())
        self.resize(min(width, room.width()), min(height, most))


def _view_text(view: str) -> str:
    return _(VIEW_NAMES[view]) if view in VIEW_NAMES else view


def open_holdings(workspace: Workspace, parent: QWidget, actions: Actions) -> HoldingsDialog:
    """List everything that is held of the chosen patient."""
    dialog = HoldingsDialog(parent)
    presenter = HoldingsPresenter(dialog, workspace, actions)
    dialog.bind(presenter)
    keep_for_roles(dialog.for_roles(), workspace.store.may)
    dialog.open()
    presenter.look()
    return dialog
