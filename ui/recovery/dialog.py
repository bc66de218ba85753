"""The dialog that shows a recovery key once: the key, what it is, and where it may go."""

from collections.abc import Callable
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QDialog, QFileDialog, QLabel, QPushButton, QVBoxLayout, QWidget

from adibas.texts import translate as _
from ui.recovery.presenter import RecoveryKeyPresenter
from ui.recovery.printing import print_sheet
from ui.widgets.dates import day_text
from ui.widgets.flow import in_a_flow
from ui.widgets.look import show_kind
from ui.widgets.scrolled import SHARE_OF_WINDOW, Scrolled, window_room
from ui.workspace import Workspace

if TYPE_CHECKING:
    from adibas.reports.recovery_sheet import RecoverySheet

LETTERS_IN_A_LINE = 84
GROUPS_IN_A_LINE = 4
KEY_SCALE = 1.8
FILE_NAME = "adibas-recovery-key.pdf"


class RecoveryKeyDialog(QDialog):
    """The key in large letters; nothing of it can be had again when the dialog is closed."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.setWindowTitle(_("Recovery key"))
        self._explanation, self._key, self._replaced, self._held = (
            QLabel(self) for _label in range(4)
        )
        for label in (self._explanation, self._replaced, self._held):
            label.setWordWrap(True)
            label.setTextFormat(Qt.TextFormat.PlainText)
        self._replaced.setProperty("kind", "warning")
        font = self._key.font()
        font.setPointSizeF(KEY_SCALE * font.pointSizeF())
        font.setBold(True)
        self._key.setFont(font)
        self._key.setAlignment(Qt.AlignmentFlag.AlignCenter)
        for label in (self._replaced, self._held):
            label.hide()
        self._print, self._save, self._keep, self._later = (
            QPushButton(self) for _button in range(4)
        )
        self._keep.setProperty("main", "true")
        self._later.setDefault(True)
        self._word()
        self._lay_out()

    def _word(self) -> None:
        self._explanation.setText(
            _(
                "This key opens the patient store when its passphrase is forgotten or the "
                "desktop's keyring is lost. It is shown this once, and the program keeps it "
                "nowhere: print it or write it down, and keep it away from this computer. Whoever "
                "has it can read everything."
            )
        )
        self._print.setText(_("&Print..."))
        self._save.setText(_("Save as P&DF..."))
        self._keep.setText(_("It is &kept in a safe place"))
        self._later.setText(_("&Later"))

    def _lay_out(self) -> None:
        self._inside = Scrolled(self)
        self._inside.column.setSpacing(14)
        for label in (self._explanation, self._key, self._replaced, self._held):
            self._inside.column.addWidget(label)
        self._inside.column.addStretch()
        self._column = QVBoxLayout(self)
        self._column.setContentsMargins(24, 20, 24, 20)
        self._column.setSpacing(12)
        self._column.addWidget(self._inside, 1)
        self._buttons = in_a_flow(self._print, self._save, self._keep, self._later)
        self._column.addLayout(self._buttons)

    def bind(self, presenter: RecoveryKeyPresenter) -> None:
        """Send what is wanted to the presenter, and own it."""
        self._presenter = presenter
        self._print.clicked.connect(presenter.print_it)
        self._save.clicked.connect(self._ask_place)
        self._keep.clicked.connect(presenter.keep)
        self._later.clicked.connect(self.reject)
        self.finished.connect(self._on_finished)

    def show_key(self, groups: tuple[str, ...], replaced_utc: datetime | None) -> None:
        starts = range(0, len(groups), GROUPS_IN_A_LINE)
        lines = ("  ".join(groups[at : at + GROUPS_IN_A_LINE]) for at in starts)
        self._key.setText("\n".join(lines))
        self._key.setAccessibleName(_("Recovery key"))
        self._replaced.setVisible(replaced_utc is not None)
        if replaced_utc is not None:
            told = _(
                "It takes the place of the recovery key of {day}, which opens the store no more as "
                "soon as this one is printed, saved or kept."
            )
            day = day_text(replaced_utc.astimezone().date())
            self._replaced.setText(told.format(day=day))
        self._make_room()

    def show_held(self) -> None:
        self._say("good", _("The recovery key opens the store from now on."))

    def show_saved(self, name: str) -> None:
        told = _("The page is in {file}. Print it, and remove it from this computer.")
        self._say("good", told.format(file=name))

    def show_problem(self, sentence: str) -> None:
        self._say("bad", sentence)

    def print_sheet(self, sheet: "RecoverySheet") -> None:
        print_sheet(sheet, self)

    def close_dialog(self) -> None:
        self.accept()

    def _say(self, kind: str, sentence: str) -> None:
        show_kind(self._held, kind)
        self._held.setText(sentence)
        self._held.show()
        self._make_room()

    def _on_finished(self, _result: int) -> None:
        self._key.clear()
        self._presenter.end()

    def _ask_place(self) -> None:
        """Ask with the program's own dialog: those of desktops keep lists of recent files."""
        dialog = QFileDialog(self, _("Where to save the recovery key"), str(Path.home()))
        dialog.setOption(QFileDialog.Option.DontUseNativeDialog)
        dialog.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        dialog.setAcceptMode(QFileDialog.AcceptMode.AcceptSave)
        dialog.setNameFilter("PDF (*.pdf)")
        dialog.setDefaultSuffix("pdf")
        dialog.selectFile(FILE_NAME)
        dialog.fileSelected.connect(lambda name: self._presenter.save(Path(name)))
        dialog.open()

    def _make_room(self) -> None:
        """Be as high as all sentences need, within the window."""
        margins = self._column.contentsMargins()
        wished_px = self.fontMetrics().averageCharWidth() * LETTERS_IN_A_LINE
        width = min(wished_px, round(SHARE_OF_WINDOW * window_room(self).width()))
        buttons_px = self._buttons.heightForWidth(width - margins.left() - margins.right())
        self.setMinimumSize(width, self._inside.height_in(self, width, buttons_px))


def open_recovery_key(
    workspace: Workspace,
    parent: QWidget,
    replaced_utc: datetime | None,
    held: Callable[[], None],
) -> RecoveryKeyDialog:
    """Show a new recovery key."""
    dialog = RecoveryKeyDialog(parent)
    dialog.bind(RecoveryKeyPresenter(dialog, workspace, replaced_utc, held))
    dialog.open()
    return dialog
