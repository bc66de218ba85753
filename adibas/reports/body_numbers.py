"""Measures of a body as reports show them."""

import math

from adibas.data.body_measures import BodyMeasure

GREY = 190.0
"""Where no colour was seen."""
UNITS = {
    "angle": ("deg", 180.0 / math.pi, 3),
    "length": ("mm", 1000.0, 2),
    "volume": ("l", 1000.0, 3),
}
"""Unit on paper, how many of it are in the core's, and digits."""
DIGITS_TO_READ = {"angle": 1, "length": 1, "volume": 2}
"""Where somebody reads them: a leg has two litres, and both sides differ by less than a tenth."""


def on_paper(measure: BodyMeasure) -> tuple[float | None, tuple[float, float] | None, str]:
    """Return value, interval and unit of a measure as reports show them."""
    unit, factor, digits = UNITS[measure.definition.quantity]
    value = None if measure.value is None else round(measure.value * factor, digits)
    interval = measure.interval
    if interval is not None:
        interval = (round(interval[0] * factor, digits), round(interval[1] * factor, digits))
    return value, interval, unit
