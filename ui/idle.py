"""Waits until no job runs."""

from collections.abc import Callable

from PySide6.QtCore import QObject, QTimer

from ui.jobs import JobRunner


class IdleCall(QObject):
    """Calls back once when no job runs, after everybody was told how the last one ended.

    Who is told may begin another job; hence it looks only when Qt has nothing else to do.
    """

    def __init__(self, jobs: JobRunner, call: Callable[[], object]) -> None:
        super().__init__()
        self._jobs = jobs
        self._call = call
        self._is_wanted = False
        self._timer = QTimer(self)
        self._timer.setSingleShot(True)
        self._timer.timeout.connect(self._look)
        self._end = jobs.changed.subscribe(lambda *_told: self._look_later())

    @property
    def is_waiting(self) -> bool:
        """Whether it will call back."""
        return self._is_wanted

    def wait(self) -> None:
        """Call back as soon as no job runs."""
        self._is_wanted = True
        self._look_later()

    def give_up(self) -> None:
        """Do not call back."""
        self._is_wanted = False
        self._timer.stop()

    def close(self) -> None:
        """Give up, and look at jobs no more."""
        self.give_up()
        self._end()

    def _look_later(self) -> None:
        if self._is_wanted:
            self._timer.start()

    def _look(self) -> None:
        if self._is_wanted and not self._jobs.is_busy:
            self._is_wanted = False
            self._call()
