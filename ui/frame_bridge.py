"""Brings what worker threads tell to the window's thread."""

from collections.abc import Callable
from threading import Lock

from PySide6.QtCore import QObject, Qt, Signal


class NewestBridge(QObject):
    """Shows the newest thing only: a slow screen drops frames, it never falls behind."""

    _arrived = Signal()

    def __init__(self, show: Callable[[object], None], parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._show = show
        self._lock = Lock()
        self._newest: object | None = None
        self._arrived.connect(self._on_arrived, Qt.ConnectionType.QueuedConnection)

    def publish(self, thing: object) -> None:
        """Accept a frame; called by a worker thread."""
        with self._lock:
            was_empty = self._newest is None
            self._newest = thing
        if was_empty:
            self._arrived.emit()

    def _on_arrived(self) -> None:
        with self._lock:
            thing, self._newest = self._newest, None
        if thing is not None:
            self._show(thing)


class CallBridge(QObject):
    """Calls a function in the window's thread, once for each `publish`, in their order."""

    _arrived = Signal(object)

    def __init__(self, call: Callable[[object], None], parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._call = call
        self._arrived.connect(self._on_arrived, Qt.ConnectionType.QueuedConnection)

    def publish(self, thing: object) -> None:
        """Accept something; called by a worker thread."""
        self._arrived.emit(thing)

    def _on_arrived(self, thing: object) -> None:
        self._call(thing)
