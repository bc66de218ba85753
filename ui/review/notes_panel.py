"""The notes of the session, saved while they are typed."""

from PySide6.QtCore import QEvent, QObject, QTimer, Signal
from PySide6.QtWidgets import QLabel, QPlainTextEdit, QVBoxLayout, QWidget

from adibas.texts import translate as _

PAUSE_MS = 1500
"""Without a key, until what was typed is saved."""


class NotesPanel(QWidget):
    """A field for free text, and what must be known of the capture."""

    written = Signal(str, str, str)
    """The session, its notes, and what they were before."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._session_id, self._saved = "", ""
        self._sentences: tuple[str, ...] = ()
        self._label, self._notices = QLabel(self), QLabel(self)
        self._text = QPlainTextEdit(self)
        self._text.setTabChangesFocus(True)
        self._label.setBuddy(self._text)
        self._notices.setWordWrap(True)
        self._notices.setProperty("kind", "warning")
        self._notices.hide()
        self._pause = QTimer(self)
        self._pause.setSingleShot(True)
        self._pause.setInterval(PAUSE_MS)
        self._pause.timeout.connect(self.save)
        self._text.textChanged.connect(self._pause.start)
        self._text.installEventFilter(self)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(8, 8, 8, 8)
        for widget in (self._notices, self._label, self._text):
            layout.addWidget(widget)
        self.retranslate()

    def retranslate(self) -> None:
        """Set the texts in the language in use."""
        self._label.setText(_("&Notes of the session"))
        self._word_notices()
        self._text.setPlaceholderText(_("What is worth remembering; it is saved as you type."))

    def show_notes(self, session_id: str, notes: str, *, can_edit: bool) -> None:
        """Show saved notes; what is being typed for the same session is not disturbed."""
        self._text.setReadOnly(not can_edit)
        is_same = session_id == self._session_id
        if is_same and self._pause.isActive():
            return
        self.save()
        if is_same and self._text.toPlainText() != self._saved:
            return  # it could not be saved
        self._session_id, self._saved = session_id, notes
        if self._text.toPlainText() != notes:  # else the cursor would jump to the beginning
            self._text.setPlainText(notes)
        self._pause.stop()

    def show_notices(self, sentences: tuple[str, ...]) -> None:
        """Show what must be known of the capture: texts of the catalogues, not translated yet."""
        self._sentences = sentences
        self._notices.setVisible(bool(sentences))
        self._word_notices()

    def _word_notices(self) -> None:
        self._notices.setText("\n".join(_(sentence) for sentence in self._sentences))

    @property
    def is_unsaved(self) -> bool:
        """Whether something stands here that is not saved."""
        return not self._text.isReadOnly() and self._text.toPlainText() != self._saved

    def save(self) -> None:
        """Hand out what was typed and not saved yet."""
        self._pause.stop()
        if self.is_unsaved:
            notes = self._text.toPlainText()
            seen, self._saved = self._saved, notes
            self.written.emit(self._session_id, notes, seen)

    def keep(self, session_id: str, saved: str) -> None:
        """Note what is saved: where that is not what stands here, it is handed out again."""
        if session_id == self._session_id:
            self._saved = saved

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:  # noqa: N802  (Qt's name)
        if event.type() == QEvent.Type.FocusOut and self._pause.isActive():
            self.save()
        return super().eventFilter(watched, event)
