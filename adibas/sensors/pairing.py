"""Two streams of one sensor, joined into moments by their timestamps."""

from collections import deque
from dataclasses import dataclass
from typing import Any

import numpy.typing as npt

from adibas.data.frames import SensorFrame

WAITING_IMAGES = 8
"""Images kept of either stream; more means that the other one stands still."""

TOLERANCE_PERIODS = 0.6
"""Two free-running clocks are at most half a period apart; the rest is for their jitter."""

CLOSE_PERIODS = 0.25
"""A depth image this much older than the colour is its nearest: the next one is farther."""


@dataclass(frozen=True, slots=True, eq=False)
class StreamImage:
    """One image of one stream: the stream's own count, its clock in nanoseconds, the pixels."""

    index: int
    timestamp_ns: int
    pixels: npt.NDArray[Any]


class FramePairer:
    """Gives every image of the second stream the depth image nearest in time.

    The second stream (colour or infrared) sets the pace: where it is the slower one, as colour at
    1280 x 1024 is, the depth images between two of its images are left out.

    Parameters
    ----------
    depth_period_ns : float
        Nominal time from one depth image to the next.
    is_depth_alone : bool
        There is no second stream: every depth image is a moment of its own.
    """

    def __init__(self, depth_period_ns: float, *, is_depth_alone: bool = False) -> None:
        self._is_depth_alone = is_depth_alone
        self._tolerance_ns = TOLERANCE_PERIODS * depth_period_ns
        self._close_ns = CLOSE_PERIODS * depth_period_ns
        self._depths: deque[StreamImage] = deque(maxlen=WAITING_IMAGES)
        self._seconds: deque[StreamImage] = deque(maxlen=WAITING_IMAGES)

    def add_depth(self, image: StreamImage) -> None:
        """Take in the next depth image."""
        self._depths.append(image)

    def add_second(self, image: StreamImage) -> None:
        """Take in the next image of the other stream."""
        self._seconds.append(image)

    def next_pair(self, *, is_final: bool = False) -> tuple[StreamImage, StreamImage | None] | None:
        """Return (depth, second) once they are known to belong together, else None.

        With `is_final` no further image will come, so that nothing is waited for.
        """
        if self._is_depth_alone:
            return (self._depths.popleft(), None) if self._depths else None
        while self._seconds:
            second = self._seconds[0]
            if not (is_final or self._is_decided(second)):
                return None
            self._seconds.popleft()
            depth = self._take_nearest(second.timestamp_ns)
            if depth is not None:
                return depth, second
        return None

    def _is_decided(self, second: StreamImage) -> bool:
        earliest_ns = second.timestamp_ns - self._close_ns
        return any(depth.timestamp_ns >= earliest_ns for depth in self._depths)

    def _take_nearest(self, timestamp_ns: int) -> StreamImage | None:
        nearest = min(
            self._depths, key=lambda depth: abs(depth.timestamp_ns - timestamp_ns), default=None
        )
        if nearest is None or abs(nearest.timestamp_ns - timestamp_ns) > self._tolerance_ns:
            return None
        while self._depths.popleft() is not nearest:
            pass
        return nearest


def join_images(
    depth: StreamImage, second: StreamImage | None, *, is_infrared: bool
) -> SensorFrame:
    """Return the moment of a depth image and of the second stream's image, which counts it."""
    if second is None:
        return SensorFrame(depth.index, depth.timestamp_ns, depth.pixels)
    if is_infrared:
        return SensorFrame(
            second.index, depth.timestamp_ns, depth.pixels, infrared_raw=second.pixels
        )
    return SensorFrame(
        second.index,
        depth.timestamp_ns,
        depth.pixels,
        color=second.pixels,
        color_timestamp_ns=second.timestamp_ns,
    )
