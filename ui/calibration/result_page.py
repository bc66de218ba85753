"""What the pictures gave: a verdict in words, numbers with intervals. No decisions."""

from PySide6.QtWidgets import QLabel, QTextBrowser, QVBoxLayout, QWidget

from adibas.pipeline.sensor_calibration import SensorOutcome
from adibas.texts import translate as _
from ui.calibration.wording import KINDS, result_html
from ui.widgets.look import show_kind


class ResultPage(QWidget):
    """One sentence in the colour of its worth, and everything behind it."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._title, self._grade, self._text = QLabel(self), QLabel(self), QTextBrowser(self)
        self._title.setProperty("kind", "title")
        for label in (self._title, self._grade):
            label.setWordWrap(True)
        self._text.setOpenLinks(False)
        self._outcome: SensorOutcome | None = None
        self._is_accepted = False
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.addWidget(self._title)
        layout.addWidget(self._grade)
        layout.addWidget(self._text, 1)

    def retranslate(self) -> None:
        """Set the texts in the language in use."""
        self._title.setText(_("Result of the calibration"))
        self._text.setAccessibleName(_("Result of the calibration"))
        if self._outcome is not None:
            self.show_outcome(self._outcome, is_accepted=self._is_accepted)

    def show_outcome(self, outcome: SensorOutcome, *, is_accepted: bool) -> None:
        """Show a result."""
        self._outcome, self._is_accepted = outcome, is_accepted
        verdict = outcome.camera.verdict
        sentence = _("In use.") if is_accepted else verdict.sentences()[0]
        self._grade.setText(sentence)
        show_kind(self._grade, KINDS[verdict.grade])
        self._text.setHtml(result_html(outcome))
