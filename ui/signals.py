"""Ctrl-C in the terminal, and the end of the desktop session, close the window in good order."""

import signal
import socket
from collections.abc import Callable
from types import FrameType

from PySide6.QtCore import QObject, QSocketNotifier

ENDS = tuple(
    getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)
)
MOST_BYTES = 64


class SignalWatch(QObject):
    """Calls `end` in the window's thread.

    Python runs no handler while Qt waits for events, but the system writes a byte into a socket
    for each signal, and Qt wakes up for that.
    """

    def __init__(self, end: Callable[[], None], parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._end = end
        self._read, self._write = socket.socketpair()
        for one in (self._read, self._write):
            one.setblocking(False)
        self._notifier = QSocketNotifier(self._read.fileno(), QSocketNotifier.Type.Read, self)
        self._notifier.activated.connect(self._on_signal)
        self._fd_before = signal.set_wakeup_fd(self._write.fileno(), warn_on_full_buffer=False)
        self._before = {
            one: signal.signal(one, _woken)
            for one in ENDS
            if signal.getsignal(one) is not signal.SIG_IGN
        }

    def close(self) -> None:
        """Let signals do what they did before."""
        for one, handler in self._before.items():
            signal.signal(one, handler)
        signal.set_wakeup_fd(self._fd_before)
        self._notifier.setEnabled(False)
        self._read.close()
        self._write.close()

    def _on_signal(self) -> None:
        self._read.recv(MOST_BYTES)
        self._end()


def _woken(_signal: int, _frame: FrameType | None) -> None:
    """Do nothing: the byte in the socket is what counts."""
