"""The time of day, as everything asks for it that writes it down, and the unit of timestamps."""

from collections.abc import Callable
from datetime import UTC, datetime

NS_PER_S = 1_000_000_000

Clock = Callable[[], datetime]
"""Returns an aware time; tests pass their own."""


def utc_now() -> datetime:
    """Return the time of day."""
    return datetime.now(UTC)


def to_text(time_utc: datetime) -> str:
    """Return ISO 8601 in UTC with microseconds: texts sort as times do."""
    return time_utc.astimezone(UTC).isoformat(timespec="microseconds")
