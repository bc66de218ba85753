"""Measures of the body's surface in two sessions; without Qt."""

from collections.abc import Iterable
from dataclasses import dataclass

from adibas.data.body_measures import BodyMeasure, Definition
from adibas.reports.body_numbers import DIGITS_TO_READ, on_paper
from adibas.texts import translate as _
from ui.widgets.rows import Row, interval_text, number


@dataclass(frozen=True, slots=True)
class MeasurePair:
    """A measure in both sessions, in the units of reports; None where it has no value.

    Attributes
    ----------
    definition : Definition
    before, now : float or None
    interval : (low, high) or None
        Of `now`, 95 %.
    unit : str
    """

    definition: Definition
    before: float | None
    now: float | None
    interval: tuple[float, float] | None
    unit: str

    @property
    def difference(self) -> float | None:
        """How much more it is now."""
        return None if self.before is None or self.now is None else self.now - self.before


def measure_pairs(
    earlier: Iterable[BodyMeasure], later: Iterable[BodyMeasure]
) -> tuple[MeasurePair, ...]:
    """Return every measure that either session has."""
    before, now = _by_id(earlier), _by_id(later)
    return tuple(
        _pair(before.get(measure_id), now.get(measure_id))
        for measure_id in dict.fromkeys((*now, *before))
    )


def pair_headers() -> tuple[str, ...]:
    """Return the titles of the table of these."""
    return _("Measure"), _("Before"), _("Now"), _("95 % interval"), _("Difference")


def pair_row(pair: MeasurePair) -> Row:
    """Return the line of a measure."""
    name = f"{_(pair.definition.name)} [{_(pair.unit)}]"
    digits = DIGITS_TO_READ[pair.definition.quantity]
    numbers = (pair.before, pair.now, pair.difference)
    before, now, difference = (number(one, digits) for one in numbers)
    return Row(
        (pair.definition.measure_id, ""),
        (name, before, now, interval_text(pair.interval, digits), difference),
        (name, pair.before, pair.now, None, pair.difference),
    )


def _pair(before: BodyMeasure | None, now: BodyMeasure | None) -> MeasurePair:
    known = now or before
    if known is None:
        raise ValueError("a pair has a measure")
    before_value = None if before is None else on_paper(before)[0]
    now_value, interval, unit = (None, None, on_paper(known)[2]) if now is None else on_paper(now)
    return MeasurePair(known.definition, before_value, now_value, interval, unit)


def _by_id(measures: Iterable[BodyMeasure]) -> dict[str, BodyMeasure]:
    return {one.definition.measure_id: one for one in measures}
