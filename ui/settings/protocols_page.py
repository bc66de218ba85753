"""The page of protocols: a text, what is wrong with it, and a button."""

from collections.abc import Callable, Mapping

from PySide6.QtCore import Qt, QTimer, Signal
from PySide6.QtGui import QFontDatabase, QTextCursor
from PySide6.QtWidgets import (
    QComboBox,
    QDialog,
    QLabel,
    QListWidget,
    QListWidgetItem,
    QPlainTextEdit,
    QPushButton,
    QVBoxLayout,
    QWidget,
)

from adibas.measures.protocol_edits import NewEntry, NewMeasure
from adibas.texts import translate as _
from ui.settings.protocol_forms import LandmarkForm, MeasureForm
from ui.settings.protocols_presenter import Mistake, ProtocolsPresenter
from ui.widgets.flow import FlowLayout, in_a_flow
from ui.widgets.question import ask

PAUSE_MS = 400
"""Without a key, until the text is checked."""
LIST_LINES = 4


class ProtocolsPage(QWidget):
    """A choice above, the text, the mistakes below; Enter on a mistake leads to its line."""

    opened = Signal(str)
    begun = Signal()
    """A new protocol."""
    typed = Signal(str)
    saved = Signal(str)
    delete_asked = Signal(str)
    """The chosen one; the text that stands there."""
    landmark_asked = Signal(str)
    """A form for a new landmark; the text that stands there."""
    measure_asked = Signal(str)
    names_asked = Signal()
    """Who gives markers the names of landmarks is asked for."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._folder = ""
        self._is_stopped = False
        self._names, self._names_label = QComboBox(self), QLabel(self)
        self._names_label.setBuddy(self._names)
        self._text, self._mistakes = QPlainTextEdit(self), QListWidget(self)
        self._summary, self._hint, self._save = QLabel(self), QLabel(self), QPushButton(self)
        self._new, self._to_names = QPushButton(self), QPushButton(self)
        self._delete = QPushButton(self)
        self._landmark, self._measure = QPushButton(self), QPushButton(self)
        self._delete.setEnabled(False)
        self._new.clicked.connect(self.begun)
        self._to_names.clicked.connect(self.names_asked)
        self.setFocusProxy(self._names)
        self._pause = QTimer(self)
        self._pause.setSingleShot(True)
        self._pause.setInterval(PAUSE_MS)
        self._lay_out()
        self._names.activated.connect(lambda _index: self.opened.emit(self._names.currentText()))
        self._text.textChanged.connect(self._on_typed)
        self._pause.timeout.connect(lambda: self.typed.emit(self._text.toPlainText()))
        self._mistakes.itemActivated.connect(self._on_mistake)
        self._mistakes.itemClicked.connect(self._on_mistake)
        self._save.clicked.connect(lambda: self.saved.emit(self._text.toPlainText()))
        self._landmark.clicked.connect(lambda: self.landmark_asked.emit(self._text.toPlainText()))
        self._measure.clicked.connect(lambda: self.measure_asked.emit(self._text.toPlainText()))
        self._delete.clicked.connect(lambda: self.delete_asked.emit(self._text.toPlainText()))

    def _lay_out(self) -> None:
        self._text.setTabChangesFocus(True)
        self._text.setLineWrapMode(QPlainTextEdit.LineWrapMode.NoWrap)
        fixed = QFontDatabase.systemFont(QFontDatabase.SystemFont.FixedFont)
        self._text.setStyleSheet(f"font-family: '{fixed.family()}'")  # its size is the window's
        self._mistakes.setWordWrap(True)
        self._hint.setWordWrap(True)
        self._hint.setProperty("kind", "quiet")
        self._summary.setWordWrap(True)
        self._save.setProperty("main", "true")
        above = FlowLayout()
        for part in (self._names_label, self._names, self._new, self._delete, self._to_names):
            above.addWidget(part)
        column = QVBoxLayout(self)
        column.addLayout(above)
        column.addWidget(self._hint)
        column.addLayout(in_a_flow(self._landmark, self._measure))
        column.addWidget(self._text, 3)
        column.addWidget(self._summary)
        column.addWidget(self._mistakes, 1)
        column.addWidget(self._save, 0, Qt.AlignmentFlag.AlignLeft)

    def bind(self, presenter: ProtocolsPresenter) -> None:
        """Send what is wanted to the presenter, and own it."""
        self._presenter = presenter
        self.opened.connect(presenter.open)
        self.begun.connect(presenter.begin)
        self.typed.connect(presenter.check)
        self.saved.connect(presenter.save)
        self.delete_asked.connect(presenter.ask_delete)
        self.landmark_asked.connect(presenter.ask_landmark)
        self.measure_asked.connect(presenter.ask_measure)

    def entered(self) -> None:
        """Show what is so now."""
        self._presenter.enter()

    def draft(self) -> str:
        """Return what was typed and is not saved, below the name of its protocol."""
        text = self.changed_text
        return f"{self._presenter.chosen}\n{text}" if text else ""

    def take_back(self, draft: str) -> None:
        """Go on with what was typed before."""
        chosen, text = draft.split("\n", 1)
        self._presenter.take_back(chosen, text)

    def retranslate(self) -> None:
        """Set the texts in the language in use."""
        self._names_label.setText(_("&Protocol"))
        self._text.setAccessibleName(_("Text of the protocol"))
        self._mistakes.setAccessibleName(_("Mistakes; Enter leads to the line"))
        self._save.setText(_("&Save as my own"))
        self._new.setText(_("Ne&w protocol"))
        self._delete.setText(_("Delete"))
        self._delete.setToolTip(_("Delete this protocol of your own; no session may follow it"))
        self._landmark.setText(_("Add a land&mark..."))
        self._measure.setText(_("Add a meas&ure..."))
        self._to_names.setText(_("Who &names the markers"))
        self._word_hint()
        if not self._is_stopped and (text := self._text.toPlainText()):
            self.typed.emit(text)  # what is said of the text is in the old language

    def show_names(self, names: tuple[str, ...], chosen: str, folder: str) -> None:
        self._folder = folder
        self._names.clear()
        self._names.addItems(list(names))
        self._names.setCurrentIndex(names.index(chosen) if chosen in names else -1)
        self._word_hint()

    def show_own(self, *, is_own: bool) -> None:
        self._delete.setEnabled(is_own)

    def confirm(self, question: str, consent: str, act: Callable[[], None]) -> None:
        ask(self, question, consent, act)

    @property
    def changed_text(self) -> str:
        """What was typed and is not saved; empty for nothing."""
        return self._text.toPlainText() if self._text.document().isModified() else ""

    def show_changed(self, text: str) -> None:
        """Give back what was typed."""
        self.show_text(text)
        self._text.document().setModified(True)

    def show_text(self, text: str) -> None:
        """Show a text in place of the one before, which Ctrl+Z brings back."""
        self._text.blockSignals(True)
        cursor = QTextCursor(self._text.document())
        cursor.select(QTextCursor.SelectionType.Document)
        cursor.insertText(text)
        cursor.movePosition(QTextCursor.MoveOperation.Start)
        self._text.setTextCursor(cursor)
        self._text.document().setModified(False)
        self._text.blockSignals(False)

    def ask_landmark(self, take: Callable[[NewEntry], None]) -> None:
        """Open the form for a landmark."""
        form = LandmarkForm(self)
        form.made.connect(take)
        self._open(form)

    def ask_measure(
        self, landmarks: Mapping[str, str], take: Callable[[NewEntry, NewMeasure], None]
    ) -> None:
        """Open the form for a measure between these landmarks."""
        form = MeasureForm(landmarks, self)
        form.measured.connect(take)
        self._open(form)

    def show_check(self, mistakes: tuple[Mistake, ...], summary: str) -> None:
        self._mistakes.clear()
        for one in mistakes:
            item = QListWidgetItem(one.sentence)
            item.setData(Qt.ItemDataRole.UserRole, one.line)
            self._mistakes.addItem(item)
        self._mistakes.setVisible(bool(mistakes))
        self._mistakes.setMinimumHeight(LIST_LINES * self.fontMetrics().height())
        self._summary.setText(summary)
        self._summary.setVisible(bool(summary))
        self._save.setEnabled(not mistakes)

    def stop(self) -> None:
        """Check nothing any more."""
        self._is_stopped = True
        self._pause.stop()

    def _open(self, form: QDialog) -> None:
        form.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        form.setModal(True)
        form.open()

    def _word_hint(self) -> None:
        self._hint.setText(
            _(
                "Change the text and give it an id of its own; protocols that come with the "
                "program stay as they are. A value of others needs its source. Yours lie in "
                "{folder}."
            ).format(folder=self._folder)
        )

    def _on_typed(self) -> None:
        self._save.setEnabled(False)  # until the text was checked
        self._pause.start()

    def _on_mistake(self, item: QListWidgetItem) -> None:
        line = int(item.data(Qt.ItemDataRole.UserRole))
        cursor = QTextCursor(self._text.document().findBlockByNumber(line - 1))
        cursor.movePosition(QTextCursor.MoveOperation.EndOfBlock, QTextCursor.MoveMode.KeepAnchor)
        self._text.setTextCursor(cursor)
        self._text.setFocus()
