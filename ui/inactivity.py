"""Notices that nobody has touched mouse or keyboard for a while."""

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
MS_PER_MINUTE = 60_000


class InactivityWatch(QObject):
    """Calls `lock` after so many minutes without a touch; 0 minutes = never."""

    def __init__(self, lock: Callable[[], None], parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._timer = QTimer(self)
        self._timer.setSingleShot(True)
        self._timer.timeout.connect(lock)

    def set_minutes(self, minutes: int) -> None:
        """Wait so long from now on."""
        self._timer.stop()
        if minutes:
            self._timer.start(minutes * MS_PER_MINUTE)

    def eventFilter(self, _watched: QObject, event: QEvent) -> bool:  # noqa: N802  (Qt's name)
        """Start anew with every touch; keep no event away from anybody."""
        if event.type() in TOUCHES and self._timer.isActive():
            self._timer.start()
        return False
