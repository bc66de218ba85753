"""Closing while something runs: the window waits for it, and asks where that takes long."""

from PySide6.QtCore import QObject, Qt, QTimer
from PySide6.QtWidgets import QMessageBox, QWidget

from adibas.texts import translate as _
from ui.idle import IdleCall
from ui.jobs import JobRunner

PATIENCE_MS = 400
"""So long the window just waits: a question that vanishes at once helps nobody."""


class OrderlyClose(QObject):
    """Holds the window open until no job runs.

    Parameters
    ----------
    window : QWidget
        To close.
    jobs : JobRunner
        What may run.
    """

    def __init__(self, window: QWidget, jobs: JobRunner) -> None:
        super().__init__(window)
        self._window = window
        self._jobs = jobs
        self._idle = IdleCall(jobs, window.close)
        self._question: QMessageBox | None = None
        self._patience = QTimer(self)
        self._patience.setSingleShot(True)
        self._patience.setInterval(PATIENCE_MS)
        self._patience.timeout.connect(self._ask)

    def may_close(self) -> bool:
        """Say whether the window may close now; if not, it will be closed as soon as it may."""
        if not self._jobs.is_busy:
            return True
        if not self._idle.is_waiting:
            self._idle.wait()
            self._patience.start()
        return False

    def close_without_asking(self) -> None:
        """Stop what runs, and close the window when it has stopped."""
        self._jobs.cancel_all()
        self._idle.wait()

    def finish(self) -> None:
        """Let go of timers and question: the window is closed."""
        self._idle.close()
        self._patience.stop()
        if self._question is not None:
            self._question.close()

    def _ask(self) -> None:
        labels = self._jobs.labels
        if not labels:
            return
        box = QMessageBox(self._window)
        box.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        box.setIcon(QMessageBox.Icon.Question)
        box.setText(_("This is still running: {what}").format(what=labels[0]))
        box.setInformativeText(
            _("The window closes by itself when it is done. What was saved is safe either way.")
        )
        stop = box.addButton(_("Stop it and close"), QMessageBox.ButtonRole.DestructiveRole)
        stay = box.addButton(_("Do not close"), QMessageBox.ButtonRole.RejectRole)
        box.setDefaultButton(stay)
        box.setEscapeButton(stay)
        stop.clicked.connect(self.close_without_asking)
        stay.clicked.connect(self._idle.give_up)
        self._question = box
        box.finished.connect(self._forget_question)
        box.open()

    def _forget_question(self) -> None:
        self._question = None
