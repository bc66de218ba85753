"""The dialog in which an order is chosen from a work list. No decisions."""

from collections.abc import Callable
from typing import TYPE_CHECKING

from PySide6.QtCore import QSize, Qt
from PySide6.QtWidgets import (
    QComboBox,
    QDialog,
    QDialogButtonBox,
    QLabel,
    QListWidget,
    QVBoxLayout,
    QWidget,
)

from adibas.texts import translate as _
from ui.orders.presenter import OrderLine, OrdersPresenter
from ui.widgets.dates import moment_text
from ui.widgets.flow import in_a_flow
from ui.widgets.look import show_kind
from ui.workspace import Workspace

if TYPE_CHECKING:
    from adibas.exchange.orders import Order

USUAL_LETTERS, USUAL_LINES = 70, 24
Ok, Cancel = QDialogButtonBox.StandardButton.Ok, QDialogButtonBox.StandardButton.Cancel


class OrdersDialog(QDialog):
    """Which server and which days, and below them what is ordered."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.setWindowTitle(_("From the work list"))
        self._server, self._days = QComboBox(self), QComboBox(self)
        self._server.setAccessibleName(_("DICOM server"))
        self._days.setAccessibleName(_("Days"))
        self._days.addItem(_("Today"), True)
        self._days.addItem(_("All days"), False)
        self._list, self._state = QListWidget(self), QLabel(self)
        self._list.setAccessibleName(_("Orders"))
        self._list.setWordWrap(True)
        self._state.setWordWrap(True)
        self._box = QDialogButtonBox(Ok | Cancel, self)
        self._box.button(Ok).setText(_("&Take over"))
        self._box.button(Ok).setProperty("main", "true")
        self._box.button(Ok).setDefault(True)
        self._box.button(Cancel).setText(_("Cancel"))
        column = QVBoxLayout(self)
        column.setContentsMargins(24, 20, 24, 20)
        column.setSpacing(12)
        column.addLayout(in_a_flow(self._server, self._days))
        column.addWidget(self._list, 1)
        column.addWidget(self._state)
        column.addWidget(self._box)
        letters = self.fontMetrics()
        wanted = QSize(USUAL_LETTERS * letters.averageCharWidth(), USUAL_LINES * letters.height())
        self.resize(wanted if parent is None else wanted.boundedTo(parent.window().size()))
        self._allow()
        self._list.setFocus()

    def bind(self, presenter: OrdersPresenter) -> None:
        """Send what the user does to `presenter`, and own it."""
        self._presenter = presenter
        for box in (self._server, self._days):
            box.activated.connect(lambda _index: self._look())
        self._list.currentRowChanged.connect(lambda _row: self._allow())
        self._list.itemDoubleClicked.connect(lambda _item: self._on_accepted())
        self._box.accepted.connect(self._on_accepted)
        self._box.rejected.connect(self.reject)
        self.finished.connect(lambda _code: presenter.close())

    def show_servers(self, names: tuple[str, ...]) -> None:
        self._server.addItems(list(names))

    def show_looking(self) -> None:
        self._list.clear()
        self._say(_("Looking at the work list"), "quiet")

    def show_orders(self, lines: tuple[OrderLine, ...]) -> None:
        for line in lines:
            when = "" if line.start is None else moment_text(line.start)
            who = "  ".join(part for part in (line.name, line.record_number) if part)
            self._list.addItem("\n".join(part for part in (who, when, line.procedure) if part))
        self._list.setCurrentRow(0)
        self._say("" if lines else _("Nothing is ordered."), "quiet")

    def show_problem(self, sentence: str) -> None:
        self._say(sentence, "bad")

    def _look(self) -> None:
        self._presenter.look(self._server.currentText(), is_of_today=bool(self._days.currentData()))

    def _say(self, sentence: str, kind: str) -> None:
        self._state.setText(sentence)
        show_kind(self._state, kind)
        self._state.setVisible(bool(sentence))
        self._allow()

    def _allow(self) -> None:
        self._box.button(Ok).setEnabled(self._list.currentRow() >= 0)

    def _on_accepted(self) -> None:
        row = self._list.currentRow()
        if row >= 0:
            self._presenter.take(row)
            self.accept()


def open_orders(
    workspace: Workspace, parent: QWidget, take_over: "Callable[[Order], None]"
) -> OrdersDialog | None:
    """Ask which order is meant; nothing is asked where no server is named."""
    dialog = OrdersDialog(parent)
    presenter = OrdersPresenter(dialog, workspace, take_over)
    dialog.bind(presenter)
    if not presenter.open():
        dialog.deleteLater()
        return None
    dialog.open()
    return dialog
