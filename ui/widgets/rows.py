"""Lines of a table of measures, worded in the language in use; without Qt."""

from dataclasses import dataclass

from adibas.data.protocols import MeasureDefinition
from adibas.data.reliability import Verdict
from adibas.texts import decimal_text
from adibas.texts import translate as _

Key = tuple[str, str]
"""View and measure, or whatever tells lines apart."""
NOTHING = "\N{EN DASH}"
Order = float | str | None
Interval = tuple[float, float]


@dataclass(frozen=True, slots=True)
class Row:
    """One line.

    Attributes
    ----------
    key : (str, str)
        View and measure, or whatever tells lines apart.
    cells : tuple of str
        What is read.
    order : tuple
        What each column is sorted by; None comes last.
    verdict : Verdict or None
        Of a change.
    """

    key: Key
    cells: tuple[str, ...]
    order: tuple[Order, ...]
    verdict: Verdict | None = None


def measure_text(definition: MeasureDefinition) -> str:
    """Name a measure, with its unit."""
    return f"{definition.name.text} [{_(definition.unit)}]"


def number(value: float | None, n_decimals: int = 1) -> str:
    """Write a number, or a dash for none."""
    return NOTHING if value is None else decimal_text(value, n_decimals)


def interval_text(interval: Interval | None, n_decimals: int = 1) -> str:
    """Write the ends of an interval."""
    if interval is None:
        return NOTHING
    low, high = interval
    return _("{low} to {high}").format(low=number(low, n_decimals), high=number(high, n_decimals))
