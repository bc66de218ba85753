"""How long the disk will hold, looked at now and again. Knows nothing of Qt."""

from collections.abc import Callable
from pathlib import Path

from adibas.errors import AdibasError
from adibas.pipeline.disk_forecast import expected_bytes_per_s, free_bytes, minutes_left

LOOK_MS = 4000
DEPTH_SIZE = (640, 480)


class DiskWatch:
    """Tells the minutes of recording that fit onto the store's disk, None where it is not known.

    Parameters
    ----------
    folder : Path
        Of the store.
    call_later : callable
        Calls a function so many milliseconds later, in the same thread.
    rate : callable
        Returns the (width, height) of the colour image and the frames a second that are expected.
    tell : callable
        Told the minutes of every look.
    """

    def __init__(
        self,
        folder: Path,
        call_later: Callable[[int, Callable[[], None]], None],
        rate: Callable[[], tuple[tuple[int, int], float]],
        tell: Callable[[float | None], None],
    ) -> None:
        self._folder = folder
        self._call_later = call_later
        self._rate = rate
        self._tell = tell
        self._number = 0
        self.minutes: float | None = None

    @property
    def is_full(self) -> bool:
        """Whether nothing more fits."""
        return self.minutes == 0

    def start(self) -> None:
        """Look now, and again and again."""
        self._number += 1
        self._look(self._number)

    def stop(self) -> None:
        """Look no more."""
        self._number += 1

    def _look(self, number: int) -> None:
        if number != self._number:
            return
        color_size, rate_hz = self._rate()
        try:
            free = free_bytes(self._folder)
        except AdibasError:
            self.minutes = None
        else:
            needed = expected_bytes_per_s(color_size, DEPTH_SIZE, rate_hz)
            self.minutes = minutes_left(free, needed)
        self._tell(self.minutes)
        self._call_later(LOOK_MS, lambda: self._look(number))
