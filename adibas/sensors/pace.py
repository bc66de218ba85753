"""Frames at the pace of their own clock."""

import time
from collections.abc import Callable

from adibas.clock import NS_PER_S

LONGEST_PAUSE_S = 1.0
"""A clock that jumps in a recording must not stop the replay."""


class Pacer:
    """Waits until a frame is due, counted from the first one.

    Parameters
    ----------
    clock, sleep : callable
        Seconds now, and waiting for seconds; replaced in tests.
    """

    def __init__(
        self,
        clock: Callable[[], float] = time.monotonic,
        sleep: Callable[[float], None] = time.sleep,
    ) -> None:
        self._clock = clock
        self._sleep = sleep
        self._zero_s: float | None = None

    def wait_for(self, timestamp_ns: int) -> None:
        """Return when the frame of this timestamp is due."""
        now_s, time_s = self._clock(), timestamp_ns / NS_PER_S
        if self._zero_s is None:
            self._zero_s = now_s - time_s
        wait_s = self._zero_s + time_s - now_s
        if not -LONGEST_PAUSE_S <= wait_s <= LONGEST_PAUSE_S:
            self._zero_s = now_s - time_s
        elif wait_s > 0:
            self._sleep(wait_s)
