"""One measure of a patient from session to session."""

from dataclasses import dataclass
from datetime import datetime

from adibas.data.protocols import MeasureDefinition
from adibas.data.reliability import Interval, Verdict


@dataclass(frozen=True, slots=True)
class TrendPoint:
    """What a measure came out as in one session, in its unit.

    Attributes
    ----------
    session_id : str
        Which.
    taken_utc : datetime
        When the session began.
    value : float
        As measured; an angle may leave -180 ... 180 so that it does not jump between sessions.
    interval : (float, float)
        95 %, instrument only.
    """

    session_id: str
    taken_utc: datetime
    value: float
    interval: Interval


@dataclass(frozen=True, slots=True)
class Trend:
    """One measure in all sessions that have it.

    Attributes
    ----------
    definition : MeasureDefinition
        What was measured.
    view : str
        In which view.
    points : tuple of TrendPoint
        In the order of time; one at least.
    mdc95 : float or None
        Smallest detectable change of this measure, in its unit; None where it is not known.
    """

    definition: MeasureDefinition
    view: str
    points: tuple[TrendPoint, ...]
    mdc95: float | None = None

    def __post_init__(self) -> None:
        if not self.points:
            raise ValueError("a trend needs a point")
        times = [point.taken_utc for point in self.points]
        if times != sorted(times):
            raise ValueError("the points of a trend stand in the order of time")

    @property
    def key(self) -> tuple[str, str]:
        """Return view and measure."""
        return self.view, self.definition.measure_id

    @property
    def band(self) -> Interval | None:
        """Return within what later values do not differ detectably from the first."""
        if self.mdc95 is None:
            return None
        first = self.points[0].value
        return first - self.mdc95, first + self.mdc95

    def change_of(self, index: int) -> float:
        """Return the change of a point since the first."""
        return self.points[index].value - self.points[0].value

    def verdict_of(self, index: int) -> Verdict:
        """Return what that change is against the smallest detectable one."""
        if self.mdc95 is None or index == 0:
            return Verdict.UNKNOWN
        return Verdict.BEYOND if abs(self.change_of(index)) > self.mdc95 else Verdict.INSIDE
