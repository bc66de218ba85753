"""Ctrl-C and the signal to end, for work that finishes its file when it is told to stop."""

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def stop_by_signals() -> Iterator[threading.Event]:
    """Give an event that Ctrl-C and SIGTERM set, in place of an exception at any line.

    However often Ctrl-C is pressed, the file that is being finished is finished.
    """
    stop = threading.Event()
    numbers = (signal.SIGINT, signal.SIGTERM)
    before = [signal.signal(number, lambda *_: stop.set()) for number in numbers]
    try:
        yield stop
    finally:
        for number, handler in zip(numbers, before, strict=True):
            signal.signal(number, handler)
