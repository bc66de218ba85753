"""Backups: where and how often, now, their check, and their way back into the store."""

from collections.abc import Callable
from functools import partial
from pathlib import Path

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import (
    QFileDialog,
    QFormLayout,
    QGridLayout,
    QGroupBox,
    QLabel,
    QLineEdit,
    QPlainTextEdit,
    QPushButton,
    QSizePolicy,
    QVBoxLayout,
    QWidget,
)

from adibas.sessions.defaults import BACKUP_ENDING
from adibas.texts import translate as _
from ui.preferences import MOST_BACKUP_DAYS, MOST_BACKUPS, Preferences
from ui.settings.backup_presenter import BackupPresenter
from ui.settings.preference_page import PreferencePage
from ui.widgets.look import show_kind
from ui.widgets.number_fields import WholeNumberField

RESULT_HEIGHT = 120
FILTER = f"ADiBAS (*{BACKUP_ENDING})"


class BackupPage(PreferencePage):
    """Two groups: the plan with how old the newest backup is, and what is done by hand."""

    made = Signal(object, str)
    """A path and a passphrase; also of the next two."""
    checked = Signal(object, str)
    restored = Signal(object, str)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._state, self._folder = QLabel(self), QLabel(self)
        for label in (self._state, self._folder):
            label.setWordWrap(True)
            label.setSizePolicy(QSizePolicy.Policy.Preferred, QSizePolicy.Policy.Minimum)
        self._choose, self._none = QPushButton(self), QPushButton(self)
        self._days, self._keep = WholeNumberField(self), WholeNumberField(self)
        self._days.setRange(1, MOST_BACKUP_DAYS)
        self._keep.setRange(1, MOST_BACKUPS)
        self._passphrase = QLineEdit(self)
        self._passphrase.setEchoMode(QLineEdit.EchoMode.Password)
        self._labels = [QLabel(self) for _ in range(3)]
        self._make, self._check, self._restore = (QPushButton(self) for _ in range(3))
        self._result = QPlainTextEdit(self)
        self._result.setReadOnly(True)
        self._result.setFixedHeight(RESULT_HEIGHT)
        self._result.hide()
        self._groups = [QGroupBox(self) for _ in range(2)]
        for part in (self, *self._groups):  # the page is scrolled before anything is squeezed
            part.setSizePolicy(QSizePolicy.Policy.Preferred, QSizePolicy.Policy.Minimum)
        self._where = ""
        self._lay_out()
        self._connect()
        self.retranslate()

    def _lay_out(self) -> None:
        plan, by_hand = self._groups
        form = QFormLayout(plan)
        form.setRowWrapPolicy(QFormLayout.RowWrapPolicy.WrapLongRows)
        form.addRow(self._state)
        form.addRow(self._folder)
        form.addRow(self._choose)
        form.addRow(self._none)
        widgets = (self._days, self._keep, self._passphrase)
        for label, widget in zip(self._labels, widgets, strict=True):
            label.setBuddy(widget)
        form.addRow(self._labels[0], self._days)
        form.addRow(self._labels[1], self._keep)
        grid = QGridLayout(by_hand)
        self._labels[2].setWordWrap(True)
        for row, widget in enumerate(
            (
                self._labels[2],
                self._passphrase,
                self._make,
                self._check,
                self._restore,
                self._result,
            )
        ):
            grid.addWidget(widget, row, 0)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(9, 4, 9, 4)
        for group in self._groups:
            layout.addWidget(group)

    def _connect(self) -> None:
        self._choose.clicked.connect(self._ask_folder)
        self._none.clicked.connect(lambda: self.changed.emit("backup_folder", ""))
        self._days.valueChanged.connect(partial(self.changed.emit, "backup_days"))
        self._keep.valueChanged.connect(partial(self.changed.emit, "backup_keep"))
        self._make.clicked.connect(self._ask_place)
        self._check.clicked.connect(lambda: self._ask_backup(self.checked.emit))
        self._restore.clicked.connect(lambda: self._ask_backup(self.restored.emit))

    def bind(self, presenter: BackupPresenter) -> None:
        """Send what is wanted to the presenter, and own it."""
        self._presenter = presenter
        self.changed.connect(lambda name, value: presenter.change(**{name: value}))
        self.made.connect(presenter.back_up)
        self.checked.connect(presenter.check)
        self.restored.connect(presenter.restore)

    def entered(self) -> None:
        """Show what is so now."""
        self._presenter.enter()

    def retranslate(self) -> None:
        """Set the texts in the language in use."""
        for group, title in zip(
            self._groups, (_("Backups every few days"), _("Backups by hand")), strict=True
        ):
            group.setTitle(title)
        texts = (
            _("Days between two backups"),
            _("Backups that are kept"),
            _(
                "Passphrase of the backup (empty: the one of this store). To try one out or to add "
                "from it, its recovery key does, too."
            ),
        )
        for label, text in zip(self._labels, texts, strict=True):
            label.setText(text)
        self._choose.setText(_("Choose the folder of backups..."))
        self._none.setText(_("Make no backups automatically"))
        self._make.setText(_("Back up now..."))
        self._check.setText(_("Try a backup out by restoring it for a moment..."))
        self._restore.setText(_("Add what is missing from a backup..."))
        self._result.setAccessibleName(_("What was found in the backup"))
        self._state.clear()  # it was said in the language before
        self._result.hide()
        self._show_where()

    def show_plan(self, preferences: Preferences) -> None:
        """Show where, how often and how many."""
        self._days.show_value(preferences.backup_days)
        self._keep.show_value(preferences.backup_keep)
        self._where = preferences.backup_folder
        self._show_where()

    def show_state(self, sentences: tuple[str, ...], *, is_urgent: bool) -> None:
        """Show how old the newest backup is, and how long the disk will last."""
        self._state.setText("\n".join(sentences))
        show_kind(self._state, "warning" if is_urgent else "")

    def show_result(self, sentences: tuple[str, ...]) -> None:
        """Show what a check or a restore found."""
        self._result.setPlainText("\n".join(sentences))
        self._result.show()

    def _show_where(self) -> None:
        self._none.setEnabled(bool(self._where))
        if self._where:
            text = _("Backups go to {folder} when one is due and the store is open here.")
        else:
            text = _("No folder is chosen: no backup is made automatically.")
        self._folder.setText(text.format(folder=self._where))

    def _ask_folder(self) -> None:
        dialog = QFileDialog(self, _("Folder of backups, best on another disk"), self._where)
        dialog.setFileMode(QFileDialog.FileMode.Directory)
        dialog.fileSelected.connect(partial(self.changed.emit, "backup_folder"))
        _open(dialog)

    def _ask_place(self) -> None:
        dialog = QFileDialog(self, _("Where to write the backup"), self._where)
        dialog.setAcceptMode(QFileDialog.AcceptMode.AcceptSave)
        dialog.setNameFilter(FILTER)
        dialog.setDefaultSuffix(BACKUP_ENDING.removeprefix("."))
        dialog.fileSelected.connect(lambda name: self._give(self.made.emit, name))
        _open(dialog)

    def _ask_backup(self, emit: Callable[[Path, str], None]) -> None:
        dialog = QFileDialog(self, _("Which backup?"), self._where)
        dialog.setFileMode(QFileDialog.FileMode.ExistingFile)
        dialog.setNameFilter(FILTER)
        dialog.fileSelected.connect(lambda name: self._give(emit, name))
        _open(dialog)

    def _give(self, emit: Callable[[Path, str], None], name: str) -> None:
        emit(Path(name), self._passphrase.text())
        self._passphrase.clear()


def _open(dialog: QFileDialog) -> None:
    dialog.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
    dialog.open()
