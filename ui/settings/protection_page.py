"""Who gets at the patients' data: locking, the passphrase, and a check of the store."""

from functools import partial
from pathlib import Path

from PySide6.QtCore import Signal
from PySide6.QtWidgets import (
    QFileDialog,
    QFormLayout,
    QGroupBox,
    QHBoxLayout,
    QLabel,
    QLineEdit,
    QPlainTextEdit,
    QPushButton,
    QToolButton,
    QVBoxLayout,
    QWidget,
)

from adibas.texts import translate as _
from ui.preferences import Preferences
from ui.settings.preference_page import PreferencePage
from ui.widgets.flow import in_a_flow
from ui.widgets.number_fields import WholeNumberField

LONGEST_WAIT_MINUTES = 240


class ProtectionPage(PreferencePage):
    """Three groups: lock, passphrase, check."""

    check_asked = Signal()
    passphrase_given = Signal(str, str, str)
    """Old, new, and the new one again."""
    store_chosen = Signal(object)
    """The folder of another store."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._folder, self._minutes_label = QLabel(self), QLabel(self)
        self._folder.setWordWrap(True)
        self._other = QToolButton(self)
        self._other.setText("...")
        self._other.clicked.connect(self._ask_folder)
        self._minutes = WholeNumberField(self)
        self._minutes.setRange(0, LONGEST_WAIT_MINUTES)
        self._minutes_label.setBuddy(self._minutes)
        self._minutes.valueChanged.connect(partial(self.changed.emit, "autolock_minutes"))
        self._fields = [QLineEdit(self) for _ in range(3)]
        self._field_labels = [QLabel(self) for _ in self._fields]
        self._change_button, self._check = QPushButton(self), QPushButton(self)
        self._result = QPlainTextEdit(self)
        self._result.setReadOnly(True)
        self._result.setMaximumHeight(140)
        self._result.hide()
        self._check.clicked.connect(self.check_asked)
        self._change_button.clicked.connect(
            lambda: self.passphrase_given.emit(*(field.text() for field in self._fields))
        )
        self._groups = [QGroupBox(self) for _ in range(3)]
        self._has_passphrase = False
        self._where = self._start = ""
        self._lay_out()
        self.retranslate()

    def _lay_out(self) -> None:
        lock, passphrase, check = self._groups
        form = _form(lock)
        form.addRow(self._minutes_label, self._minutes)
        form = _form(passphrase)
        for label, field in zip(self._field_labels, self._fields, strict=True):
            field.setEchoMode(QLineEdit.EchoMode.Password)
            label.setBuddy(field)
            form.addRow(label, field)
        form.addRow(in_a_flow(self._change_button))  # its words may be longer than a field
        column = QVBoxLayout(check)
        place = QHBoxLayout()
        place.addWidget(self._folder, 1)
        place.addWidget(self._other)
        column.addLayout(place)
        for widget in (self._check, self._result):
            column.addWidget(widget)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(9, 4, 9, 4)
        layout.setSpacing(8)
        for group in self._groups:
            layout.addWidget(group)
        layout.addStretch()

    def retranslate(self) -> None:
        """Set the texts in the language in use."""
        titles = (_("Locking"), _("Passphrase"), _("Patient store"))
        for group, title in zip(self._groups, titles, strict=True):
            group.setTitle(title)
        self._minutes_label.setText(_("Lock &after so long without mouse or key"))
        self._minutes.setSuffix(_(" min"))
        self._minutes.setSpecialValueText(_("never"))
        texts = (_("&Old passphrase"), _("&New passphrase"), _("New passphrase a&gain"))
        for label, text in zip(self._field_labels, texts, strict=True):
            label.setText(text)
        self._change_button.setText(
            _("Change the passphrase")
            if self._has_passphrase
            else _("Protect with a passphrase instead of the keyring")
        )
        self._check.setText(_("&Check the store"))
        other = _("Use the patient store in another folder, such as one that workstations share")
        self._other.setToolTip(other)
        self._other.setAccessibleName(other)
        self._result.setAccessibleName(_("Result of the check"))
        self._folder.setText(_("It lies in {folder}").format(folder=self._where))

    def _ask_folder(self) -> None:
        path = QFileDialog.getExistingDirectory(self, self._other.toolTip(), self._start)
        if path:
            self.store_chosen.emit(Path(path))

    def show_preferences(self, preferences: Preferences) -> None:
        """Show what holds now."""
        self._start = preferences.store
        self._minutes.show_value(preferences.autolock_minutes)

    def show_protection(self, folder: str, *, has_passphrase: bool, is_read_only: bool) -> None:
        """Show where the store lies and what keeps its key."""
        self._where, self._has_passphrase = folder, has_passphrase
        for widget in (self._fields[0], self._field_labels[0]):
            widget.setVisible(has_passphrase)
        self._groups[1].setEnabled(not is_read_only)
        self.retranslate()

    def show_check(self, sentences: tuple[str, ...]) -> None:
        """Show what a check found."""
        self._result.setPlainText(
            "\n".join(sentences)
            or _("All is well: the audit trail is unbroken, no file is missing.")
        )
        self._result.show()

    def hide_check(self) -> None:
        """Show nothing of an earlier check."""
        self._result.hide()
        self._result.clear()

    def clear_passphrases(self) -> None:
        """Forget what was typed."""
        for field in self._fields:
            field.clear()


def _form(parent: QWidget) -> QFormLayout:
    """Return a form whose fields go below their words where large letters leave no room."""
    form = QFormLayout(parent)
    form.setRowWrapPolicy(QFormLayout.RowWrapPolicy.WrapLongRows)
    return form
