"""The time of day, as everything asks for it that writes it down, and the unit of timestamps."""

from collections.abc import Callable
from datetime import UTC, date, datetime

NS_PER_S = 1_000_000_000

Clock = Callable[[], datetime]
"""Returns an aware time; tests pass their own."""


def utc_now() -> datetime:
    """Return the time of day."""
    return datetime.now(UTC)


def day_here(time_utc: datetime) -> date:
    """Return the day of a moment by this computer's clock: a clinic's evening may be past UTC's."""
    return time_utc.astimezone().date()


def to_text(time_utc: datetime) -> str:
    """Return ISO 8601 in UTC with microseconds: texts sort as times do."""
    return time_utc.astimezone(UTC).isoformat(timespec="microseconds")
