"""Notices that nobody has touched mouse or keyboard for a while."""

import time
from collections.abc import Callable

from PySide6.QtCore import QEvent, QObject, QTimer

TOUCHES = frozenset(
    {
        QEvent.Type.MouseButtonPress,
        QEvent.Type.MouseMove,
        QEvent.Type.KeyPress,
        QEvent.Type.Wheel,
        QEvent.Type.TouchBegin,
    }
)
S_PER_MINUTE = 60
MS_PER_S = 1000


class InactivityWatch(QObject):
    """Calls `lock` after so many minutes without a touch; 0 minutes = never.

    The timer stands still while the computer sleeps; hence the first touch afterwards looks at the
    clock, too, and locks instead of doing what it would have done.
    """

    def __init__(
        self,
        lock: Callable[[], None],
        parent: QObject | None = None,
        clock_s: Callable[[], float] = time.time,
    ) -> None:
        super().__init__(parent)
        self._lock = lock
        self._clock_s = clock_s
        self._touched_s = clock_s()
        self._timer = QTimer(self)
        self._timer.setSingleShot(True)
        self._timer.timeout.connect(lock)

    def set_minutes(self, minutes: int) -> None:
        """Wait so long from now on."""
        self._timer.stop()
        self._touched_s = self._clock_s()
        if minutes:
            self._timer.start(minutes * S_PER_MINUTE * MS_PER_S)

    def eventFilter(self, _watched: QObject, event: QEvent) -> bool:  # noqa: N802  (Qt's name)
        """Start anew with every touch; keep back the one that comes too late."""
        if event.type() not in TOUCHES or not self._timer.isActive():
            return False
        now_s = self._clock_s()
        is_late = (now_s - self._touched_s) * MS_PER_S > self._timer.interval()
        self._touched_s = now_s
        if is_late:
            self._timer.stop()
            self._lock()
            return True
        self._timer.start()
        return False
