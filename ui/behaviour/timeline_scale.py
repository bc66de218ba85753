"""Which time lies where on the timeline. Knows nothing of Qt."""

from dataclasses import dataclass, replace

from adibas.data.coding import MS_PER_S

LEAST_SPAN_MS = 200
TICKS_S = (0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 15, 30, 60, 120, 300, 600, 1800, 3600)
HOUR_S = 3600


@dataclass(frozen=True, slots=True)
class TimeScale:
    """What of a session is seen between two edges.

    Attributes
    ----------
    begin_ms, end_ms : int
        Of the session.
    from_ms, to_ms : float
        That are seen.
    left_px, width_px : int
        Where on the widget.
    """

    begin_ms: int = 0
    end_ms: int = 1
    from_ms: float = 0.0
    to_ms: float = 1.0
    left_px: int = 0
    width_px: int = 1

    def x_of(self, time_ms: float) -> float:
        """Return where a time lies."""
        share = (time_ms - self.from_ms) / (self.to_ms - self.from_ms)
        return self.left_px + share * self.width_px

    def ms_at(self, x: float) -> int:
        """Return which time of the session lies at a place."""
        share = (x - self.left_px) / self.width_px
        time_ms = self.from_ms + share * (self.to_ms - self.from_ms)
        return round(min(max(time_ms, self.begin_ms), self.end_ms))

    @property
    def px_per_ms(self) -> float:
        """Return how wide a millisecond is."""
        return self.width_px / (self.to_ms - self.from_ms)

    def of_session(self, begin_ms: int, end_ms: int) -> "TimeScale":
        """Return the scale of a session; all of it is seen where it is another one."""
        last_ms = max(end_ms, begin_ms + 1)
        if (begin_ms, last_ms) == (self.begin_ms, self.end_ms):
            return self
        ends = {"begin_ms": begin_ms, "end_ms": last_ms}
        return replace(self, **ends, from_ms=float(begin_ms), to_ms=float(last_ms))

    def fitted(self) -> "TimeScale":
        """Return the scale on which the whole session is seen."""
        return replace(self, from_ms=float(self.begin_ms), to_ms=float(self.end_ms))

    def zoomed(self, factor: float, around_ms: float) -> "TimeScale":
        """Return the scale that shows `factor` times less, while one time stays in its place."""
        whole_ms = float(self.end_ms - self.begin_ms)
        span_ms = (self.to_ms - self.from_ms) / factor
        span_ms = min(max(span_ms, min(LEAST_SPAN_MS, whole_ms)), whole_ms)
        share = (around_ms - self.from_ms) / (self.to_ms - self.from_ms)
        return self._from(around_ms - share * span_ms, span_ms)

    def moved(self, by_ms: float) -> "TimeScale":
        """Return the scale that shows what comes later, or earlier."""
        return self._from(self.from_ms + by_ms, self.to_ms - self.from_ms)

    def showing(self, time_ms: int) -> "TimeScale":
        """Return the scale on which a time is seen; page by page where it runs out."""
        span_ms = self.to_ms - self.from_ms
        if self.from_ms <= time_ms <= self.to_ms:
            return self
        return self._from(time_ms - 0.1 * span_ms, span_ms)

    def ticks_ms(self, least_px: float) -> list[int]:
        """Return round times since the session's begin, `least_px` apart at least."""
        wanted_s = least_px / self.px_per_ms / MS_PER_S
        step_s = next((tick for tick in TICKS_S if tick >= wanted_s), None)
        if step_s is None:
            step_s = HOUR_S * (int(wanted_s / HOUR_S) + 1)
        step_ms = step_s * MS_PER_S
        number = int((self.from_ms - self.begin_ms) / step_ms)
        ticks = []
        while (at_ms := self.begin_ms + number * step_ms) <= self.to_ms:
            if at_ms >= self.from_ms:
                ticks.append(round(at_ms))
            number += 1
        return ticks

    def _from(self, from_ms: float, span_ms: float) -> "TimeScale":
        first_ms = min(max(from_ms, float(self.begin_ms)), self.end_ms - span_ms)
        return replace(self, from_ms=first_ms, to_ms=first_ms + span_ms)
