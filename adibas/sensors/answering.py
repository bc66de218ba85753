"""Asks camera libraries with a time limit: one that waits for a wedged USB driver never answers."""

import threading
from collections.abc import Callable
from typing import TypeVar

from adibas.errors import SensorError
from adibas.sensors.permanent_threads import PermanentThread

Answer = TypeVar("Answer")

LIMIT_S = 10.0
"""A library that is well lists its sensors within two or three seconds, on a busy computer too."""


class TimeLimit:
    """Asks one library one thing at a time, in a thread of its own.

    Nothing can stop a library that hangs: its thread is left alone, ends with the program, and
    nothing more is asked until it answers after all.

    Parameters
    ----------
    library : str
        Its name, for the user.
    limit_s : float
        Of one question.
    gave_up : callable, optional
        Called when the library does not answer.
    """

    def __init__(
        self, library: str, limit_s: float = LIMIT_S, gave_up: Callable[[], None] | None = None
    ) -> None:
        self._library = library
        self._limit_s = limit_s
        self._gave_up = gave_up
        self._is_free = threading.Lock()
        self._thread: PermanentThread | None = None

    def ask(self, question: Callable[[], Answer]) -> Answer:
        """Return what `question` returns, or raise what it raises.

        Raises
        ------
        SensorError
            The library did not answer in time.
        """
        if not self._is_free.acquire(timeout=self._limit_s):
            raise self._silence()

        def run() -> Answer:
            try:
                return question()
            finally:
                self._is_free.release()

        self._thread = self._thread or PermanentThread()
        answer = self._thread.begin(run)
        try:
            return answer.result(self._limit_s)
        except TimeoutError:
            if answer.done():
                raise
            if self._gave_up is not None:
                self._gave_up()
            raise self._silence() from None

    def _silence(self) -> SensorError:
        return SensorError(
            "{library} does not answer. Unplug its sensors, wait a moment and plug them in again; "
            "if that does not help, restart the computer.",
            library=self._library,
        )
