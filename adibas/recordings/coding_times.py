"""Whole milliseconds as the seconds of files, and back."""

import math

from adibas.data.coding import MS_PER_S


def seconds_text(time_ms: int) -> str:
    """Return whole milliseconds as seconds, every digit of them."""
    sign, size = ("-" if time_ms < 0 else ""), abs(time_ms)
    return f"{sign}{size // MS_PER_S}.{size % MS_PER_S:03d}"


def milliseconds(value: object) -> int:
    """Return seconds (a number or its text) as whole milliseconds.

    Raises
    ------
    ValueError
        It is no finite number, in milliseconds either.
    """
    time_ms = float(str(value)) * MS_PER_S
    if not math.isfinite(time_ms):
        raise ValueError(f"no time: {value}")
    return round(time_ms)
