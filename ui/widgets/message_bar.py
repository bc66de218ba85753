"""One line that tells the user something, until it is put away."""

from collections.abc import Callable

from PySide6.QtCore import Qt, QTimer
from PySide6.QtWidgets import QFrame, QHBoxLayout, QLabel, QPushButton, QSizePolicy, QWidget

from adibas.texts import translate as _
from ui.widgets.look import show_kind

GOOD_NEWS_MS = 6000


class MessageBar(QFrame):
    """Errors and warnings stay until they are closed; good news go by themselves."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setObjectName("message")
        self._label = QLabel(self)
        self._label.setWordWrap(True)
        self._label.setTextInteractionFlags(
            Qt.TextInteractionFlag.TextSelectableByMouse
            | Qt.TextInteractionFlag.TextSelectableByKeyboard
        )
        self._label.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Preferred)
        self._again, self._close = QPushButton(self), QPushButton(self)
        self._try_again: Callable[[], object] = _nothing
        self._again.clicked.connect(self._on_again)
        self._again.hide()
        self._close.clicked.connect(self.put_away)
        self._timer = QTimer(self)
        self._timer.setSingleShot(True)
        self._timer.setInterval(GOOD_NEWS_MS)
        self._timer.timeout.connect(self.put_away)
        layout = QHBoxLayout(self)
        layout.setContentsMargins(12, 8, 8, 8)
        layout.addWidget(self._label)
        layout.addWidget(self._again, 0, Qt.AlignmentFlag.AlignTop)
        layout.addWidget(self._close, 0, Qt.AlignmentFlag.AlignTop)
        self.retranslate()
        self.hide()

    def retranslate(self) -> None:
        """Set the texts in the language in use."""
        self._close.setText(_("Close"))
        self._close.setAccessibleName(_("Close the message"))

    def tell(self, kind: str, sentence: str) -> None:
        """Show a sentence; `kind` is good, warning or bad."""
        show_kind(self, kind)
        self._label.setText(sentence)
        self._label.setAccessibleName(sentence)
        self._forget_retry()
        self.show()
        if kind == "good":
            self._timer.start()
        else:
            self._timer.stop()

    def offer_again(self, sentence: str, again: Callable[[], object]) -> None:
        """Say what failed, with a button that tries it again as it was."""
        self.tell("bad", sentence)
        self._try_again = again
        self._again.setText(_("&Try again"))
        self._again.show()

    def withdraw_retry(self) -> None:
        """Tell no more of what could be tried again; anything else that is told stays."""
        if not self._again.isHidden():
            self.put_away()

    def _on_again(self) -> None:
        again = self._try_again
        self.put_away()
        again()

    def _forget_retry(self) -> None:
        self._try_again = _nothing  # it may hold what was typed of a patient
        self._again.hide()

    def put_away(self) -> None:
        """Tell nothing any more; no word of it is kept."""
        self._timer.stop()
        self._forget_retry()
        self.hide()
        self._label.clear()
        self._label.setAccessibleName("")

    @property
    def text(self) -> str:
        """Return what is told now; empty where nothing is."""
        return "" if self.isHidden() else self._label.text()


def _nothing() -> None:
    """Try nothing again: nothing failed."""
