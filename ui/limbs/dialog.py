"""Builds the window in which limbs are labelled: where its parts and the core meet."""

from pathlib import Path

from PySide6.QtCore import QSize, Qt
from PySide6.QtGui import QKeyEvent
from PySide6.QtWidgets import QDialog, QDialogButtonBox, QVBoxLayout, QWidget

from adibas.texts import translate as _
from ui.limbs.ports import StoredRecording
from ui.limbs.presenter import LimbsPresenter
from ui.limbs.view import LimbsPage
from ui.widgets.message_bar import MessageBar
from ui.widgets.question import ask
from ui.workspace import Workspace

USUAL_LETTERS, USUAL_LINES = 150, 50


class LimbsDialog(QDialog):
    """The page, what is told meanwhile, and a button to close; nothing is lost by closing."""

    def __init__(self, workspace: Workspace, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setWindowTitle(_("Label limbs"))
        self.page, self._message = LimbsPage(self), MessageBar(self)
        self.page.bind(LimbsPresenter(self.page, workspace))
        self.page.retranslate()
        self._end = workspace.noticed.subscribe(self._message.tell)
        box = QDialogButtonBox(QDialogButtonBox.StandardButton.Close, self)
        box.button(QDialogButtonBox.StandardButton.Close).setText(_("Close"))
        box.rejected.connect(self.reject)
        column = QVBoxLayout(self)
        column.addWidget(self._message)
        column.addWidget(self.page, 1)
        column.addWidget(box)
        self.finished.connect(self._on_finished)
        letters = self.fontMetrics()
        wanted = QSize(USUAL_LETTERS * letters.averageCharWidth(), USUAL_LINES * letters.height())
        self.resize(wanted if parent is None else wanted.boundedTo(parent.window().size()))

    def keyPressEvent(self, event: QKeyEvent) -> None:  # noqa: N802  (Qt's name)
        """Let Enter in a field take what was typed; a dialog would press its first button."""
        if event.key() not in (Qt.Key.Key_Return, Qt.Key.Key_Enter):
            super().keyPressEvent(event)

    def unsaved(self) -> tuple[str, ...]:
        """Keep what was drawn, and name it where it cannot be kept."""
        return () if self.page.presenter.leave() else (_("What was drawn in this frame"),)

    def reject(self) -> None:
        """Close; where what was drawn cannot be kept, only after a question."""
        if self.page.presenter.leave():
            super().reject()
        else:
            question = _("What was changed in this frame cannot be kept. Close and lose it?")
            ask(self, question, _("Close"), super().reject)

    def _on_finished(self, _code: int) -> None:
        self.page.presenter.close()
        self._message.put_away()
        self._end()


def open_limb_editor(
    workspace: Workspace, parent: QWidget, recording: Path | StoredRecording | None = None
) -> LimbsDialog:
    """Show the editor before its parent, with a recording that is looked at already."""
    dialog = LimbsDialog(workspace, parent)
    dialog.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
    dialog.open()
    if isinstance(recording, StoredRecording):
        dialog.page.presenter.open_stored(recording)
    elif recording is not None:
        dialog.page.presenter.open(recording)
    return dialog
