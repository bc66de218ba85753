"""DICOM servers of the clinic: which there are, how one is reached, and whether it answers."""

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import (
    QCheckBox,
    QComboBox,
    QFileDialog,
    QFormLayout,
    QGroupBox,
    QLabel,
    QLineEdit,
    QPushButton,
    QSizePolicy,
    QVBoxLayout,
    QWidget,
)

from adibas.texts import translate as _
from ui.settings.servers_presenter import ServerEntry
from ui.widgets.flow import in_a_flow
from ui.widgets.number_fields import WholeNumberField

LAST_PORT = 65_535
LONGEST_TITLE = 16


class ServersPage(QWidget):
    """One group: a chooser, a description, three buttons."""

    chosen = Signal(str)
    """A name; empty: a new server is described."""
    saved = Signal(object)
    """A `ServerEntry`; also of the next one."""
    tested = Signal(object)
    removed = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._group, self._told = QGroupBox(self), QLabel(self)
        self._told.setWordWrap(True)
        self._servers = QComboBox(self)
        self._name, self._host, self._title, self._own_title, self._certificates = (
            QLineEdit(self) for _field in range(5)
        )
        for title in (self._title, self._own_title):
            title.setMaxLength(LONGEST_TITLE)
        self._port = WholeNumberField(self)
        self._port.setRange(1, LAST_PORT)
        self._encrypted = QCheckBox(self)
        self._browse, self._save, self._test, self._remove = (
            QPushButton(self) for _button in range(4)
        )
        self._labels = {
            field: QLabel(self)
            for field in (
                self._servers,
                self._name,
                self._host,
                self._port,
                self._title,
                self._own_title,
            )
        }
        self._certificates_label = QLabel(self)
        self._certificates_label.setBuddy(self._certificates)
        for part in (self, self._group):  # the page is scrolled before anything is squeezed
            part.setSizePolicy(QSizePolicy.Policy.Preferred, QSizePolicy.Policy.Minimum)
        self._lay_out()
        self._connect()
        self.retranslate()

    def _lay_out(self) -> None:
        form = QFormLayout(self._group)
        form.setRowWrapPolicy(QFormLayout.RowWrapPolicy.WrapLongRows)
        form.addRow(self._told)
        for field, label in self._labels.items():
            label.setBuddy(field)
            form.addRow(label, field)
        form.addRow("", self._encrypted)
        form.addRow(self._certificates_label, self._certificates)
        form.addRow("", in_a_flow(self._browse))
        form.addRow(in_a_flow(self._save, self._test, self._remove))
        column = QVBoxLayout(self)
        column.setContentsMargins(9, 4, 9, 4)
        column.addWidget(self._group)

    def _connect(self) -> None:
        self._servers.activated.connect(
            lambda _index: self.chosen.emit(self._servers.currentData())
        )
        self._encrypted.toggled.connect(self._allow_certificates)
        self._browse.clicked.connect(self._ask_certificates)
        self._save.clicked.connect(lambda: self.saved.emit(self._entry()))
        self._test.clicked.connect(lambda: self.tested.emit(self._entry()))
        self._remove.clicked.connect(self.removed)

    def retranslate(self) -> None:
        """Set the texts in the language in use."""
        self._group.setTitle(_("DICOM servers"))
        self._told.setText(
            _(
                "Sessions are sent to these servers when you export them, and orders are looked "
                "up there. The program connects to nothing else."
            )
        )
        for field, text in (
            (self._servers, _("Server")),
            (self._name, _("What you call it")),
            (self._host, _("Its address in the network")),
            (self._port, _("Its port")),
            (self._title, _("Its title (AE title)")),
            (self._own_title, _("Title of this program (AE title)")),
        ):
            self._labels[field].setText(text)
        self._encrypted.setText(_("Encrypted (TLS)"))
        self._certificates_label.setText(_("Its certificate (empty: those of the system)"))
        self._browse.setText(_("Choose the certificate..."))
        self._save.setText(_("Save the server"))
        self._test.setText(_("See whether it answers"))
        self._remove.setText(_("Forget the server"))
        index = self._servers.findData("")
        if index >= 0:
            self._servers.setItemText(index, _("A new one"))

    def show_servers(self, names: tuple[str, ...], chosen: str) -> None:
        self._servers.clear()
        for name in names:
            self._servers.addItem(name, name)
        self._servers.addItem(_("A new one"), "")
        self._servers.setCurrentIndex(self._servers.findData(chosen))
        self._remove.setEnabled(bool(chosen))

    def show_entry(self, entry: ServerEntry) -> None:
        for field, text in (
            (self._name, entry.name),
            (self._host, entry.host),
            (self._title, entry.title),
            (self._own_title, entry.own_title),
            (self._certificates, entry.certificates),
        ):
            field.setText(text)
        self._port.show_value(entry.port)
        self._encrypted.setChecked(entry.is_encrypted)
        self._allow_certificates()
        self._remove.setEnabled(bool(self._servers.currentData()))

    def _entry(self) -> ServerEntry:
        return ServerEntry(
            self._name.text(),
            self._host.text(),
            self._port.value(),
            self._title.text(),
            self._own_title.text(),
            self._encrypted.isChecked(),
            self._certificates.text(),
        )

    def _allow_certificates(self) -> None:
        for part in (self._certificates, self._browse):
            part.setEnabled(self._encrypted.isChecked())

    def _ask_certificates(self) -> None:
        dialog = QFileDialog(self, _("Certificate of the server"))
        dialog.setFileMode(QFileDialog.FileMode.ExistingFile)
        dialog.setNameFilter("PEM (*.pem *.crt *.cer)")
        dialog.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        dialog.fileSelected.connect(self._certificates.setText)
        dialog.open()
