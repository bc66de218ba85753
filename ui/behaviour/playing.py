"""Which frame is due when. Knows nothing of Qt, and nothing of pictures."""

from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from adibas.arrays import IntArray
from adibas.data.coding import MS_PER_S

NS_PER_MS = 1_000_000
SPEEDS = (0.25, 0.5, 1.0, 2.0, 4.0)


def frame_times_ms(timestamps_ns: IntArray) -> tuple[int, ...]:
    """Return when each frame is seen, whole milliseconds; a clock that runs back stands still."""
    forward_ns = np.maximum.accumulate(np.asarray(timestamps_ns, np.int64))
    return tuple(int(time_ms) for time_ms in np.rint(forward_ns / NS_PER_MS).astype(np.int64))


def frame_at(times_ms: Sequence[int], time_ms: int) -> int:
    """Return the frame that is seen at a time: the last one that is not later, or the first."""
    return max(bisect_right(times_ms, time_ms) - 1, 0)


@dataclass(slots=True)
class Playing:
    """A video that runs.

    Attributes
    ----------
    times_ms : sequence of int
        Of the frames.
    speed : float
        1: as it was recorded.
    """

    times_ms: Sequence[int]
    speed: float = 1.0
    _from_ms: float = 0.0
    _since_s: float | None = None

    @property
    def is_on(self) -> bool:
        """Whether it runs."""
        return self._since_s is not None

    def start(self, index: int, now_s: float) -> None:
        """Run from frame `index` on."""
        self._from_ms, self._since_s = float(self.times_ms[index]), now_s

    def stop(self) -> None:
        """Stand still."""
        self._since_s = None

    def set_speed(self, speed: float, now_s: float) -> None:
        """Run faster or slower from now on."""
        if self._since_s is not None:
            self._from_ms, self._since_s = self._time_ms(now_s), now_s
        self.speed = speed

    def due(self, now_s: float) -> int:
        """Return the frame that is to be seen now; the last one at the end."""
        return frame_at(self.times_ms, int(self._time_ms(now_s)))

    def _time_ms(self, now_s: float) -> float:
        since_s = now_s if self._since_s is None else self._since_s
        return self._from_ms + MS_PER_S * self.speed * (now_s - since_s)
