"""How long the window's thread was held up: a short timer that comes late tells."""

import time

from PySide6.QtCore import QEventLoop, QTimer
from PySide6.QtWidgets import QApplication

BEAT_MS = 5
PATIENCE_MS = 50


class Heartbeat:
    """Beats every 5 ms; what a beat is late by, no click was seen."""

    def __init__(self, app: QApplication) -> None:
        self._app = app
        self._late_ms: dict[str, float] = {}
        self._where = ""
        self._busy_ms: dict[str, float] = {}
        self._last_s, self._last_cpu_s = time.perf_counter(), time.thread_time()
        self._timer = QTimer()
        self._timer.setInterval(BEAT_MS)
        self._timer.timeout.connect(self._beat)
        self._timer.start()

    def live_through(self, where: str, seconds: float) -> None:
        """Let the window live for a while in a place that has a name."""
        self._where = where
        end_s = time.perf_counter() + seconds
        while time.perf_counter() < end_s:
            self._app.processEvents(QEventLoop.ProcessEventsFlag.WaitForMoreEvents, PATIENCE_MS)

    def stop(self) -> None:
        """Beat no more."""
        self._timer.stop()

    def blocks_ms(self) -> dict[str, tuple[float, float]]:
        """Return the longest block of each place, and the longest work between two beats there.

        The work is that of the window's own thread: other programs on a shared computer, and
        threads that hold Python's lock, do not count.
        """
        return {where: (late_ms, self._busy_ms[where]) for where, late_ms in self._late_ms.items()}

    def _beat(self) -> None:
        now_s, cpu_s = time.perf_counter(), time.thread_time()
        busy_ms = 1e3 * (cpu_s - self._last_cpu_s)
        self._busy_ms[self._where] = max(self._busy_ms.get(self._where, 0.0), busy_ms)
        self._last_cpu_s = cpu_s
        late_ms = 1e3 * (now_s - self._last_s) - BEAT_MS
        self._late_ms[self._where] = max(self._late_ms.get(self._where, 0.0), late_ms)
        self._last_s = now_s
