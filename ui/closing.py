"""Closing asks before anything is lost, and waits for what runs, or asks where that is long."""

from collections.abc import Callable, Iterable

from PySide6.QtCore import QObject, Qt, QTimer
from PySide6.QtWidgets import QDialog, QMessageBox, QWidget

from adibas.texts import translate as _
from ui.idle import IdleCall
from ui.jobs import JobRunner

PATIENCE_MS = 400
"""So long the window just waits: a question that vanishes at once helps nobody."""


def close_at_once(find: Callable[[], Iterable[QWidget]]) -> None:
    """Close what is seen; what is kept by itself when it is closed is kept.

    Parameters
    ----------
    find : callable
        Gives what is to be closed.
    """
    for widget in list(find()):
        if widget.isVisible():
            widget.close()
    for widget in list(find()):  # it asks whether to close, and nobody may answer now
        if widget.isVisible() and isinstance(widget, QDialog):
            widget.done(QDialog.DialogCode.Rejected)


class OrderlyClose(QObject):
    """Holds the window open while something would be lost, and until no job runs.

    Parameters
    ----------
    window : QWidget
        To close.
    jobs : JobRunner
        What may run.
    unsaved : callable
        Names what would be lost.
    lead_back : callable
        Shows it to whoever does not want to lose it.
    """

    def __init__(
        self,
        window: QWidget,
        jobs: JobRunner,
        unsaved: Callable[[], tuple[str, ...]],
        lead_back: Callable[[], None],
    ) -> None:
        super().__init__(window)
        self._window = window
        self._jobs = jobs
        self._unsaved = unsaved
        self._lead_back = lead_back
        self._may_lose = False
        self._idle = IdleCall(jobs, window.close)
        self._question: QMessageBox | None = None
        self._patience = QTimer(self)
        self._patience.setSingleShot(True)
        self._patience.setInterval(PATIENCE_MS)
        self._patience.timeout.connect(self._ask)

    def may_close(self) -> bool:
        """Say whether the window may close now; if not, it asks, or closes as soon as it may."""
        if not self._may_lose and (names := self._unsaved()):
            self._ask_to_lose(names)
            return False
        if not self._jobs.is_busy:
            return True
        if not self._idle.is_waiting:
            self._idle.wait()
            self._patience.start()
        return False

    def close_without_asking(self) -> None:
        """Stop what runs, and close the window when it has stopped."""
        self._may_lose = True
        self._jobs.cancel_all()
        self._idle.wait()

    def finish(self) -> None:
        """Let go of timers and question: the window is closed."""
        self._may_lose = True
        self._idle.close()
        self._patience.stop()
        self._put_question_away()

    def _ask(self) -> None:
        labels = self._jobs.labels
        if not labels:
            return
        self._show_question(
            _("This is still running: {what}").format(what=labels[0]),
            _("The window closes by itself when it is done. What was saved is safe either way."),
            (_("Stop it and close"), self.close_without_asking),
            self._stay,
        )

    def _ask_to_lose(self, names: tuple[str, ...]) -> None:
        self._show_question(
            _("Not everything is saved. Close and lose it?"),
            "\n".join(f"\N{BULLET} {name}" for name in names),
            (_("Close without saving"), self._lose),
            self._go_back,
        )

    def _lose(self) -> None:
        self._may_lose = True
        self._window.close()

    def _stay(self) -> None:
        self._may_lose = False
        self._idle.give_up()

    def _go_back(self) -> None:
        self._stay()
        self._lead_back()

    def _show_question(
        self,
        question: str,
        told: str,
        consent: tuple[str, Callable[[], None]],
        stay: Callable[[], None],
    ) -> None:
        """Ask, in place of an earlier question; Escape and Enter keep the window open."""
        self._put_question_away()
        box = QMessageBox(self._window)
        box.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        box.setIcon(QMessageBox.Icon.Question)
        box.setText(question)
        box.setInformativeText(told)
        text, act = consent
        box.addButton(text, QMessageBox.ButtonRole.DestructiveRole).clicked.connect(act)
        keep = box.addButton(_("Do not close"), QMessageBox.ButtonRole.RejectRole)
        keep.clicked.connect(stay)
        box.setDefaultButton(keep)
        box.setEscapeButton(keep)
        box.finished.connect(lambda _result: self._forget_question(box))
        self._question = box
        box.open()

    def _put_question_away(self) -> None:
        question, self._question = self._question, None
        if question is not None:
            question.close()

    def _forget_question(self, box: QMessageBox) -> None:
        if self._question is box:
            self._question = None
