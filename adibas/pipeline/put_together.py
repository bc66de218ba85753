"""Who bends down falls apart in the depth, and is put together by the frame before."""

import math
from collections.abc import Callable

from adibas.body.staying import Moment, shows_less
from adibas.clock import NS_PER_S
from adibas.pipeline.pose_following import LONGEST_APART_S, SOON_S
from adibas.pipeline.posture import Sight


class PutTogether:
    """Who was seen a moment ago, by which a person who falls apart is put together."""

    def __init__(self) -> None:
        self._before: Moment | None = None
        self._before_s = self._by_itself_s = -math.inf
        self._is_seen = False

    @property
    def newest(self) -> Moment | None:
        """The newest frame and who is in it; None where nobody was seen there."""
        return self._before if self._is_seen else None

    def person(
        self, see: Callable[[Moment | None], Sight | None], timestamp_ns: int
    ) -> Sight | None:
        """Return who is seen in the next frame.

        Parameters
        ----------
        see : callable
            Looks at the frame, by itself (None) or together with a moment ago.
        timestamp_ns : int
            Of the frame.
        """
        person = see(None)
        moment = self.moment_of(person, timestamp_ns)
        if moment is not None:
            person = see(moment)
        self.saw(person, timestamp_ns, by_itself=moment is None)
        return person

    def moment_of(self, person: Sight | None, timestamp_ns: int) -> Moment | None:
        """Return that moment where less is seen of the person now, else None."""
        before, time_s = self._before, timestamp_ns / NS_PER_S
        is_soon = time_s - self._before_s <= SOON_S
        if before is None or not is_soon or time_s - self._by_itself_s > LONGEST_APART_S:
            return None
        pixels = None if person is None else person.body.pixels
        return before if shows_less(pixels, before) else None

    def saw(self, person: Sight | None, timestamp_ns: int, *, by_itself: bool) -> None:
        """Go on to what was seen in a frame."""
        self._is_seen = person is not None
        if person is None:
            return
        self._before = Moment(person.depth_m, [person.body.pixels])
        self._before_s = timestamp_ns / NS_PER_S
        if by_itself:
            self._by_itself_s = self._before_s
