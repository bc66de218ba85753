"""DICOM servers of the clinic: which there are, how one is reached, and whether it answers."""

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QCheckBox, QFileDialog, QLineEdit, QPushButton, QWidget

from adibas.texts import translate as _
from ui.settings.listed_things import ListedThings
from ui.settings.servers_presenter import ServerEntry, ServersPresenter
from ui.widgets.flow import in_a_flow
from ui.widgets.number_fields import WholeNumberField

LAST_PORT = 65_535
LONGEST_TITLE = 16


class ServersPage(ListedThings):
    """How each server is reached."""

    saved = Signal(object)
    """A `ServerEntry`; also of the next one."""
    tested = Signal(object)
    removed = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._name, self._host, self._title, self._own_title, self._certificates = (
            QLineEdit(self) for _field in range(5)
        )
        for title in (self._title, self._own_title):
            title.setMaxLength(LONGEST_TITLE)
        self._port = WholeNumberField(self)
        self._port.setRange(1, LAST_PORT)
        self._encrypted = QCheckBox(self)
        self._browse, self._test = QPushButton(self), QPushButton(self)
        addresses = (self._name, self._host, self._port, self._title, self._own_title)
        for field in (self.chooser, *addresses):
            self.add_row(field)
        self.form.addRow("", self._encrypted)
        self.add_row(self._certificates)
        self.form.addRow("", in_a_flow(self._browse))
        self.lay_out(buttons=(self.save, self._test, self.remove))
        self._encrypted.toggled.connect(self._allow_certificates)
        self._browse.clicked.connect(self._ask_certificates)
        self.save.clicked.connect(lambda: self.saved.emit(self.entry()))
        self._test.clicked.connect(lambda: self.tested.emit(self.entry()))
        self.remove.clicked.connect(self.removed)
        self.retranslate()

    def bind(self, presenter: ServersPresenter) -> None:
        """Send what is wanted to the presenter, and own it."""
        self._presenter = presenter
        self.chosen.connect(presenter.choose)
        self.saved.connect(presenter.save)
        self.tested.connect(presenter.test)
        self.removed.connect(presenter.remove)

    def entered(self) -> None:
        """Show what is so now."""
        self._presenter.enter()

    def retranslate(self) -> None:
        """Set the texts in the language in use."""
        self.group.setTitle(_("DICOM servers"))
        self.told.setText(
            _(
                "Sessions are sent to these servers when you export them, and orders are looked "
                "up there. The program connects to nothing else."
            )
        )
        self.name_fields(
            *(_("Server"), _("What you call it"), _("Its address in the network"), _("Its port")),
            *(_("Its title (AE title)"), _("Title of this program (AE title)")),
            _("Its certificate (empty: those of the system)"),
            new_one=_("A new one"),
        )
        self._encrypted.setText(_("Encrypted (TLS)"))
        self._browse.setText(_("Choose the certificate..."))
        self.save.setText(_("Save the server"))
        self._test.setText(_("See whether it answers"))
        self.remove.setText(_("Forget the server"))

    def show_servers(self, names: tuple[str, ...], chosen: str) -> None:
        self.list_names(names, chosen, _("A new one"))
        self.remove.setEnabled(bool(chosen))

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
        self.remove.setEnabled(bool(self.current))
        self.note_shown()

    def entry(self) -> ServerEntry:
        """Return what stands in the form."""
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
