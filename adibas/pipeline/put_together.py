"""Who bends down falls apart in the depth, and is put together by the frame before."""

import math

import numpy as np

from adibas.body.staying import Moment
from adibas.clock import NS_PER_S
from adibas.pipeline.pose_following import LONGEST_APART_S, SOON_S
from adibas.pipeline.posture import Sight

STAYS_WHOLE = 0.8
"""Share of the pixels of a moment ago; of who shows fewer a part may not have been seen."""


class PutTogether:
    """Who was seen a moment ago, by which a person who falls apart is put together."""

    def __init__(self) -> None:
        self._before: Sight | None = None
        self._before_s = self._by_itself_s = -math.inf

    def moment_of(self, person: Sight | None, timestamp_ns: int) -> Moment | None:
        """Return that moment where less is seen of the person now, else None."""
        before, time_s = self._before, timestamp_ns / NS_PER_S
        is_soon = time_s - self._before_s <= SOON_S
        if before is None or not is_soon or time_s - self._by_itself_s > LONGEST_APART_S:
            return None
        n_now = 0 if person is None else np.count_nonzero(person.body.pixels)
        if n_now >= STAYS_WHOLE * np.count_nonzero(before.body.pixels):
            return None
        return Moment(before.depth_m, [before.body.pixels])

    def saw(self, person: Sight | None, timestamp_ns: int, *, by_itself: bool) -> None:
        """Go on to what was seen in a frame."""
        if person is None:
            return
        self._before, self._before_s = person, timestamp_ns / NS_PER_S
        if by_itself:
            self._by_itself_s = self._before_s
