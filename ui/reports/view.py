"""The report screen: sessions, wishes, a preview, and one button. No decisions."""

import html
from pathlib import Path

from PySide6.QtCore import QEvent, Qt, QUrl, Signal
from PySide6.QtGui import QDesktopServices
from PySide6.QtWidgets import (
    QCheckBox,
    QComboBox,
    QFileDialog,
    QHBoxLayout,
    QLabel,
    QListWidgetItem,
    QPushButton,
    QTextBrowser,
    QVBoxLayout,
    QWidget,
)

from adibas.data.report import PictureChoice
from adibas.data.sessions import Session
from adibas.pipeline.stored_report import ReportWish
from adibas.reports.facts import Pairs
from adibas.texts import LANGUAGES, message, translate_plural
from adibas.texts import translate as _
from ui.reports.pages_bar import PagesBar
from ui.reports.presenter import PreviewPage, ReportsPresenter, SessionLine
from ui.widgets.dates import moment_text
from ui.widgets.image_view import ImageView
from ui.widgets.screen import Screen
from ui.widgets.side_panel import SidePanel
from ui.widgets.wrapped_lines import WrappedLines

KINDS = {
    ".xlsx": message("&Excel workbook"),
    ".pdf": message("P&DF to print"),
    ".csv": message("&CSV table"),
    ".png": message("P&ictures with markers"),
}
PICTURES = {
    PictureChoice.AS_IS: message("As they are"),
    PictureChoice.BLURRED: message("Face made unrecognisable"),
    PictureChoice.DEPTH: message("Depth only"),
}
FACTS_HEIGHT_PX = 190
LEAST_LINES = 5
"""Of the list of sessions: one takes three or four."""


class ReportsScreen(Screen):
    """What will be handed out, before it is."""

    name = "reports"
    export_asked = Signal(str)
    """A session's id."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._title = QLabel(self)
        self._title.setProperty("kind", "title")
        self._sessions, self._older = WrappedLines(self), QLabel(self)
        self._older.setWordWrap(True)
        self._older.hide()
        self._n_newest = 0
        self._notes = QCheckBox(self)
        self._language, self._pictures, self._earlier = (QComboBox(self) for _number in range(3))
        self._earlier_sessions: tuple[Session, ...] = ()
        self._kinds = {kind: QCheckBox(self) for kind in KINDS}
        self._kinds[".xlsx"].setChecked(True)
        self._write, self._export, self._open = (QPushButton(self) for _number in range(3))
        self._write.setProperty("main", "true")
        self._labels = [QLabel(self) for _ in range(5)]
        self._pages_bar = PagesBar(self)
        self._picture, self._facts = ImageView(self), QTextBrowser(self)
        self._facts.setMaximumHeight(FACTS_HEIGHT_PX)
        self._head: Pairs = []
        self._pages: tuple[PreviewPage, ...] = ()
        self._folder: Path | None = None
        for language, own_name in LANGUAGES.items():
            self._language.addItem(own_name, language)
        for choice in PictureChoice:
            self._pictures.addItem("", choice)
        self._lay_out()
        self._make_room()
        self.retranslate()

    def _lay_out(self) -> None:
        sessions, language, pictures, earlier, files = self._labels
        panel = SidePanel(self)
        panel.column.addWidget(sessions)
        panel.column.addWidget(self._sessions, 1)
        panel.column.addWidget(self._older)
        for label, widget in (
            (language, self._language),
            (pictures, self._pictures),
            (earlier, self._earlier),
        ):
            label.setBuddy(widget)
            panel.column.addWidget(label)
            panel.column.addWidget(widget)
            if widget is self._pictures:
                panel.column.addWidget(self._notes)
        sessions.setBuddy(self._sessions)
        panel.column.addWidget(files)
        for box in self._kinds.values():
            panel.column.addWidget(box)
        side = QVBoxLayout()  # what the screen is for never scrolls out of sight
        side.addWidget(panel, 1)
        side.addWidget(self._write)
        side.addWidget(self._export)
        side.addWidget(self._open)
        preview = QVBoxLayout()
        preview.addWidget(self._title)
        preview.addWidget(self._pages_bar)
        preview.addWidget(self._picture, 1)
        preview.addWidget(self._facts)
        layout = QHBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.setSpacing(16)
        layout.addLayout(side)
        layout.addLayout(preview, 1)

    def bind(self, presenter: ReportsPresenter) -> None:
        """Send what the user does to `presenter`, and own it."""
        self._presenter = presenter
        self._sessions.itemChanged.connect(lambda _item: self._send_sessions())
        self._language.activated.connect(
            lambda _i: presenter.choose_language(self._language.currentData())
        )
        self._pictures.activated.connect(
            lambda _i: presenter.choose_pictures(PictureChoice(self._pictures.currentData()))
        )
        self._notes.clicked.connect(lambda is_on: presenter.choose_notes(with_notes=is_on))
        self._write.clicked.connect(self._ask_folder)
        self._export.clicked.connect(presenter.export)
        self._open.clicked.connect(self._open_folder)
        self._earlier.activated.connect(
            lambda _i: presenter.choose_earlier(self._earlier.currentData())
        )
        self._pages_bar.currentChanged.connect(self._show_page)

    def retranslate(self) -> None:
        """Set the texts in the language in use."""
        self._title.setText(_("Report"))
        names = (_("&Sessions to report"), _("&Language"), _("&Pictures"))
        texts = (*names, _("Co&mpared with"), _("Files"))
        for label, text in zip(self._labels, texts, strict=True):
            label.setText(text)
        for kind, box in self._kinds.items():
            box.setText(_(KINDS[kind]))
        for index, choice in enumerate(PictureChoice):
            self._pictures.setItemText(index, _(PICTURES[choice]))
        self._notes.setText(_("With the &notes on the session"))
        self._notes.setToolTip(
            _("People are named in notes: they are left out where the pictures hide who it is.")
        )
        self._word_older()
        self._word_earlier()
        self._write.setText(_("&Write the report..."))
        self._export.setText(_("Export (FHIR, DICOM)..."))
        self._open.setText(_("&Open the folder"))
        self._picture.setAccessibleName(_("Preview of the picture"))
        self._facts.setAccessibleName(_("Preview of the text"))
        self._pages_bar.setAccessibleName(_("Views"))

    def changeEvent(self, event: QEvent) -> None:  # noqa: N802  (Qt's name)
        """Let a whole session be read in letters of another size; the panel scrolls for it."""
        super().changeEvent(event)
        if event.type() == QEvent.Type.FontChange:
            self._make_room()

    def _make_room(self) -> None:
        self._sessions.setMinimumHeight(LEAST_LINES * self.fontMetrics().height())

    def entered(self) -> None:
        self._presenter.enter()

    def left(self) -> None:
        self._presenter.leave()

    def closed(self) -> None:
        self._presenter.close()

    def show_sessions(self, lines: tuple[SessionLine, ...], *, n_newest: int | None) -> None:
        self._n_newest = n_newest or 0
        self._word_older()
        self._sessions.blockSignals(True)
        self._sessions.clear()
        for line in lines:
            n_views = len(line.session.capture_ids)
            views = translate_plural("{n} view", "{n} views", n_views).format(n=n_views)
            told = "\n".join((line.who, moment_text(line.session.started_utc), views))
            item = QListWidgetItem(told)
            item.setToolTip(told)
            item.setData(Qt.ItemDataRole.UserRole, line.session_id)
            item.setFlags(item.flags() | Qt.ItemFlag.ItemIsUserCheckable)
            state = Qt.CheckState.Checked if line.is_chosen else Qt.CheckState.Unchecked
            item.setCheckState(state)
            self._sessions.addItem(item)
        self._sessions.blockSignals(False)

    def show_earlier(self, sessions: tuple[Session, ...], chosen: str) -> None:
        self._earlier_sessions = sessions
        self._word_earlier()
        self._earlier.setCurrentIndex(self._earlier.findData(chosen))

    def show_wish(self, wish: ReportWish) -> None:
        self._language.setCurrentIndex(self._language.findData(wish.language))
        self._pictures.setCurrentIndex(list(PictureChoice).index(wish.pictures))
        self._notes.setChecked(wish.with_notes)

    def show_preview(self, head: Pairs, pages: tuple[PreviewPage, ...]) -> None:
        self._head, self._pages = head, pages
        self._pages_bar.show_titles(tuple(page.title for page in pages))
        self._show_page(self._pages_bar.currentIndex())

    def show_no_preview(self, sentence: str) -> None:
        self._pages = ()
        self._pages_bar.show_titles(())
        self._picture.set_picture(None)
        self._picture.set_placeholder("")
        self._facts.setPlainText(sentence)

    def show_written(self, folder: Path | None) -> None:
        self._folder = folder
        self._open.setVisible(folder is not None)

    def ask_export(self, session_id: str) -> None:
        self.export_asked.emit(session_id)

    def _word_older(self) -> None:
        told = _(
            "Of the newest {n} sessions. An older one is listed once it is opened on Patients."
        )
        self._older.setText(told.format(n=self._n_newest))
        self._older.setVisible(bool(self._n_newest))

    def _word_earlier(self) -> None:
        chosen = self._earlier.currentData() or ""
        self._earlier.clear()
        self._earlier.addItem(_("Nothing"), "")
        for session in self._earlier_sessions:
            self._earlier.addItem(moment_text(session.started_utc), session.session_id)
        self._earlier.setCurrentIndex(max(self._earlier.findData(chosen), 0))
        self._earlier.setEnabled(bool(self._earlier_sessions))

    def _show_page(self, index: int) -> None:
        if not 0 <= index < len(self._pages):
            return
        page = self._pages[index]
        self._picture.set_picture(page.picture_rgb)
        rows = "".join(
            f"<tr><td>{html.escape(name)}&nbsp;&nbsp;</td><td>{html.escape(str(value))}</td></tr>"
            for name, value in (*page.facts, *self._head)
        )
        self._facts.setHtml(f"<table>{rows}</table>")

    def _send_sessions(self) -> None:
        items = (self._sessions.item(row) for row in range(self._sessions.count()))
        self._presenter.choose_sessions(
            tuple(
                str(item.data(Qt.ItemDataRole.UserRole))
                for item in items
                if item.checkState() == Qt.CheckState.Checked
            )
        )

    def _ask_folder(self) -> None:
        dialog = QFileDialog(self, _("Folder for the report"), self._presenter.folder)
        dialog.setFileMode(QFileDialog.FileMode.Directory)
        dialog.setOption(QFileDialog.Option.ShowDirsOnly)
        dialog.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        kinds = tuple(kind for kind, box in self._kinds.items() if box.isChecked())
        dialog.fileSelected.connect(lambda name: self._presenter.write(Path(name), kinds))
        dialog.open()

    def _open_folder(self) -> None:
        QDesktopServices.openUrl(QUrl.fromLocalFile(str(self._folder)))
