"""The dialog that hands a session over: what, as whose, and what that means. No decisions."""

from datetime import datetime
from itertools import pairwise
from pathlib import Path

from PySide6.QtCore import QSignalBlocker, Qt, Signal
from PySide6.QtWidgets import (
    QButtonGroup,
    QCheckBox,
    QComboBox,
    QDialog,
    QDialogButtonBox,
    QFileDialog,
    QFormLayout,
    QLabel,
    QPushButton,
    QRadioButton,
    QVBoxLayout,
    QWidget,
)

from adibas.data.report import PictureChoice
from adibas.texts import LANGUAGES, message, translate_plural
from adibas.texts import translate as _
from ui.export.content import Kind, Shown
from ui.export.presenter import ExportPresenter
from ui.orders.dialog import open_orders
from ui.widgets.dates import moment_text
from ui.widgets.flow import in_a_flow
from ui.widgets.scrolled import Scrolled, window_room
from ui.workspace import Workspace

LETTERS_IN_A_LINE = 74
KINDS: dict[Kind, str] = {
    "fhir": message("A &FHIR file, for medical records"),
    "dicom": message("&DICOM files, for picture archives"),
    "server": message("&Send to the DICOM server"),
}
PICTURES = {
    PictureChoice.AS_IS: message("As they are"),
    PictureChoice.BLURRED: message("Face made unrecognisable"),
    PictureChoice.DEPTH: message("Depth only"),
}
Ok, Cancel = QDialogButtonBox.StandardButton.Ok, QDialogButtonBox.StandardButton.Cancel


class ExportDialog(QDialog):
    """Three ways out, one tick for the identity, and what follows from both in words."""

    order_asked = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self._session, self._content, self._warning, self._no_server = (
            QLabel(self) for _label in range(4)
        )
        for label in (self._session, self._content, self._warning, self._no_server):
            label.setWordWrap(True)
            label.setTextFormat(Qt.TextFormat.PlainText)
        self._content.setProperty("kind", "quiet")
        self._no_server.setProperty("kind", "quiet")
        self._warning.setProperty("kind", "warning")
        self._kinds = QButtonGroup(self)
        self._server = QComboBox(self)
        self._order, self._no_order = QPushButton(self), QPushButton(self)
        self._protocol, self._pictures, self._language = (QComboBox(self) for _box in range(3))
        self._identity = QCheckBox(self)
        self._box = QDialogButtonBox(Ok | Cancel, self)
        self._kind: Kind = "fhir"
        self._has_work_list = False
        self._lay_out()

    def _lay_out(self) -> None:
        inside = Scrolled(self)
        inside.column.setSpacing(10)
        inside.column.addWidget(self._session)
        for number, text in enumerate(KINDS.values()):
            button = QRadioButton(_(text), self)
            self._kinds.addButton(button, number)
            inside.column.addWidget(button)
        for widget in (self._server, self._no_server):
            inside.column.addWidget(widget)
        inside.column.addLayout(in_a_flow(self._order, self._no_order))
        inside.column.addWidget(self._identity)
        form = QFormLayout()
        form.setRowWrapPolicy(QFormLayout.RowWrapPolicy.WrapLongRows)
        form.addRow(_("P&rotocol"), self._protocol)
        form.addRow(_("&Pictures"), self._pictures)
        form.addRow(_("&Language"), self._language)
        inside.column.addLayout(form)
        inside.column.addWidget(self._content)
        inside.column.addWidget(self._warning)
        inside.column.addStretch()
        column = QVBoxLayout(self)
        column.setContentsMargins(24, 20, 24, 20)
        column.setSpacing(12)
        column.addWidget(inside, 1)
        column.addWidget(self._box)
        self._inside = inside
        self._word()
        fields = (
            *(self._server, self._order, self._no_order, self._identity),
            *(self._protocol, self._pictures, self._language, self._box),
        )
        for before, after in pairwise((*self._kinds.buttons(), *fields)):
            self.setTabOrder(before, after)
        self._kinds.button(0).setFocus()

    def _word(self) -> None:
        self.setWindowTitle(_("Export a session"))
        self._server.setAccessibleName(_("DICOM server"))
        self._no_server.setText(_("No DICOM server is set up. One is named in Settings, General."))
        self._order.setText(_("For an &order of the work list..."))
        self._no_order.setText(_("For &no order"))
        self._identity.setText(_("&With the identity of the patient"))
        self._protocol.addItem(_("As the session says"), "")
        for choice, text in PICTURES.items():
            self._pictures.addItem(_(text), choice)
        for language, own_name in LANGUAGES.items():
            self._language.addItem(own_name, language)
        self._box.button(Ok).setDefault(True)
        self._box.button(Ok).setProperty("main", "true")
        self._box.button(Cancel).setText(_("Cancel"))

    def bind(self, presenter: ExportPresenter) -> None:
        """Send what the user does to `presenter`, and own it."""
        self._presenter = presenter
        self._kinds.idClicked.connect(lambda number: presenter.choose(kind=list(KINDS)[number]))
        self._server.activated.connect(
            lambda _index: presenter.choose(server=self._server.currentText())
        )
        self._identity.toggled.connect(lambda is_on: presenter.choose(with_identity=is_on))
        self._order.clicked.connect(self.order_asked)
        self._no_order.clicked.connect(lambda: presenter.choose(order=None))
        self._protocol.activated.connect(
            lambda _index: presenter.choose(protocol=self._protocol.currentData())
        )
        self._pictures.activated.connect(
            lambda _index: presenter.choose(pictures=PictureChoice(self._pictures.currentData()))
        )
        self._language.activated.connect(
            lambda _index: presenter.choose(language=self._language.currentData())
        )
        self._box.accepted.connect(self._on_accepted)
        self._box.rejected.connect(self.reject)

    def show_session(self, who: str, started_utc: datetime, n_views: int) -> None:
        views = translate_plural("{n} view", "{n} views", n_views).format(n=n_views)
        self._session.setText(f"{who}\n{moment_text(started_utc)}, {views}")

    def show_servers(self, names: tuple[str, ...]) -> None:
        self._server.addItems(list(names))
        self._no_server.setVisible(not names)
        self._kinds.button(list(KINDS).index("server")).setEnabled(bool(names))
        self._has_work_list = bool(names)

    def show_protocols(self, titles: tuple[tuple[str, str], ...]) -> None:
        for name, title in titles:
            self._protocol.addItem(title, name)

    def show_choice(self, shown: Shown) -> None:
        choice = shown.choice
        self._kind = choice.kind
        self._kinds.button(list(KINDS).index(choice.kind)).setChecked(True)
        self._server.setVisible(choice.kind == "server")
        self._server.setCurrentIndex(self._server.findText(choice.server))
        self._order.setVisible(self._has_work_list and choice.kind != "fhir")
        if choice.answered is None and self._no_order.hasFocus():
            self._order.setFocus()  # the next one is the tick of the identity
        self._no_order.setVisible(choice.answered is not None)
        with QSignalBlocker(self._identity):
            self._identity.setChecked(choice.with_identity)
        self._pictures.setCurrentIndex(list(PICTURES).index(shown.pictures))
        self._language.setCurrentIndex(self._language.findData(choice.language))
        self._content.setText("\n".join(shown.content))
        self._warning.setText("\n".join(shown.warnings))
        self._warning.setVisible(bool(shown.warnings))
        sends = choice.kind == "server"
        self._box.button(Ok).setText(_("S&end") if sends else _("E&xport..."))
        self._box.button(Ok).setAccessibleDescription("\n".join((*shown.content, *shown.warnings)))
        self._make_room()

    def close_dialog(self) -> None:
        self.accept()

    def _make_room(self) -> None:
        """Be as high as all sentences need, within the window."""
        wished_px = self.fontMetrics().averageCharWidth() * LETTERS_IN_A_LINE
        width = min(wished_px, window_room(self).width())
        box_px = self._box.sizeHint().height()
        self.setMinimumSize(width, self._inside.height_in(self, width, box_px))

    def _on_accepted(self) -> None:
        if self._kind == "server":
            self._presenter.send()
        else:
            self._ask_place()

    def _ask_place(self) -> None:
        """Ask anew each time, from the user's own folder: a path may tell of a patient."""
        dialog = QFileDialog(self, _("Where to export to"), str(Path.home()))
        dialog.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        if self._kind == "fhir":
            dialog.setAcceptMode(QFileDialog.AcceptMode.AcceptSave)
            dialog.setNameFilter("FHIR (*.json)")
            dialog.setDefaultSuffix("json")
            dialog.selectFile(self._presenter.proposed_name)
        else:
            dialog.setFileMode(QFileDialog.FileMode.Directory)
            dialog.setOption(QFileDialog.Option.ShowDirsOnly)
        dialog.fileSelected.connect(lambda name: self._presenter.export_to(Path(name)))
        dialog.open()


def open_export(workspace: Workspace, parent: QWidget, session_id: str) -> ExportDialog | None:
    """Ask how a session is handed over; nothing is asked where it is gone."""
    dialog = ExportDialog(parent)
    presenter = ExportPresenter(dialog, workspace)
    dialog.bind(presenter)
    dialog.order_asked.connect(lambda: open_orders(workspace, dialog, presenter.take_order))
    if not presenter.open(session_id):
        dialog.deleteLater()
        return None
    dialog.open()
    return dialog
