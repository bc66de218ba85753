"""Ctrl-C and the signal to end: none is lost, and some work finishes its file first."""

import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from sys import UnraisableHookArgs

AGAIN_S = 0.02
"""How long after an ignored Ctrl-C it comes again; longer than most finalizers take."""


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


class WorkKept(KeyboardInterrupt):
    """Ctrl-C in a work that the same command goes on with.

    Parameters
    ----------
    place : Path
        File or folder in which what is done lies.
    """

    def __init__(self, place: Path) -> None:
        super().__init__()
        self.place = place


@contextmanager
def kept_when_stopped(place: Path) -> Iterator[None]:
    """Let a Ctrl-C say where the work inside is kept, if anything of it is."""
    try:
        yield
    except (KeyboardInterrupt, SystemError) as error:
        if is_interrupt(error) and place.exists():
            raise WorkKept(place) from error
        raise


@contextmanager
def no_interrupt_lost() -> Iterator[None]:
    """Let a Ctrl-C come again that fell into a finalizer, where Python ignores every exception.

    Otherwise a command that frees many objects, as a client of a cluster does, sometimes goes on
    as though nobody had pressed a key, with a traceback on the screen.
    """
    before, main_thread = sys.unraisablehook, threading.get_ident()

    def hook(unraisable: "UnraisableHookArgs") -> None:
        if issubclass(unraisable.exc_type, KeyboardInterrupt):
            again = threading.Timer(AGAIN_S, _interrupt, [main_thread])
            again.daemon = True
            again.start()
        else:
            before(unraisable)

    sys.unraisablehook = hook
    try:
        yield
    finally:
        sys.unraisablehook = before


def is_interrupt(error: BaseException) -> bool:
    """Say whether an error is Ctrl-C: itself, or as a compiled loop passes it on.

    Ctrl-C that falls into numba's dispatcher comes out of it as a SystemError.
    """
    return isinstance(error, KeyboardInterrupt) or isinstance(error.__cause__, KeyboardInterrupt)


def _interrupt(thread: int) -> None:
    if sys.platform == "win32":
        signal.raise_signal(signal.SIGINT)
    else:  # to that thread itself, so that it wakes up if it waits
        signal.pthread_kill(thread, signal.SIGINT)
