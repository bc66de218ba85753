"""What runs beside the window, how far it came, and a button that stops what can be stopped."""

from PySide6.QtCore import QTimer
from PySide6.QtWidgets import QHBoxLayout, QProgressBar, QPushButton, QWidget

from adibas.texts import translate as _
from ui.jobs import ThreadJob
from ui.widgets.elided_label import ElidedLabel

PATIENCE_MS = 400
"""Shorter work is not worth a bar that flashes."""


class ProgressStrip(QWidget):
    """Shows the job that began first."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._jobs: dict[ThreadJob, tuple[int, int]] = {}
        self._label = ElidedLabel(self)
        self._bar = QProgressBar(self)
        self._bar.setMaximumWidth(260)
        self._stop = QPushButton(self)
        self._stop.clicked.connect(self._on_stop)
        self._patience = QTimer(self)
        self._patience.setSingleShot(True)
        self._patience.setInterval(PATIENCE_MS)
        self._patience.timeout.connect(self._show_first)
        layout = QHBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        for widget in (self._label, self._bar, self._stop):
            layout.addWidget(widget)
        self.retranslate()
        self.hide()

    def retranslate(self) -> None:
        """Set the texts in the language in use."""
        self._stop.setText(_("Cancel"))
        self._bar.setAccessibleName(_("Progress"))

    def show_job(self, job: ThreadJob, done: int, total: int) -> None:
        """Take note that a job began, came further, or ended."""
        if job.is_running and not job.is_cancelled:
            self._jobs[job] = (done, total)
        else:
            self._jobs.pop(job, None)
        if not self._jobs:
            self._patience.stop()
            self.hide()
        elif self.isVisible():
            self._show_first()
        elif not self._patience.isActive():
            self._patience.start()

    def _show_first(self) -> None:
        if not self._jobs:
            return
        job, (done, total) = next(iter(self._jobs.items()))
        self._label.setText(job.label)
        self._bar.setRange(0, total)
        self._bar.setValue(done)
        self._stop.setVisible(job.stop != "never")
        self.show()

    def _on_stop(self) -> None:
        if self._jobs:
            job = next(iter(self._jobs))
            job.cancel()
            self.show_job(job, 0, 0)
