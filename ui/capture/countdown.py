"""Seconds to go before a capture. Knows nothing of Qt."""

from collections.abc import Callable

ONE_SECOND_MS = 1000


class Countdown:
    """Counts down once at a time; what was given up never comes to its end.

    Parameters
    ----------
    call_later : callable
        Calls a function so many milliseconds later, in the same thread.
    tick : callable
        Told the seconds to go, first of all the whole number, and None at the end.
    """

    def __init__(
        self,
        call_later: Callable[[int, Callable[[], None]], None],
        tick: Callable[[int | None], None],
    ) -> None:
        self._call_later = call_later
        self._tick = tick
        self._number = 0
        self.is_running = False

    def start(self, seconds: int, done: Callable[[], None]) -> None:
        """Call `done` after so many seconds."""
        self._number += 1
        self.is_running = True
        self._count(self._number, seconds, done)

    def give_up(self) -> None:
        """Forget the countdown, if there is one."""
        self._number += 1
        if self.is_running:
            self.is_running = False
            self._tick(None)

    def _count(self, number: int, seconds: int, done: Callable[[], None]) -> None:
        if number != self._number:
            return
        if seconds > 0:
            self._tick(seconds)
            self._call_later(ONE_SECOND_MS, lambda: self._count(number, seconds - 1, done))
            return
        self.is_running = False
        self._tick(None)
        done()
