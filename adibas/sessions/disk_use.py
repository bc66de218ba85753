"""How much the clinic records, and when that fills the disk."""

import shutil
from dataclasses import dataclass
from datetime import datetime, timedelta
from pathlib import Path

from sqlalchemy import func, select

from adibas.clock import to_text
from adibas.errors import StoreError
from adibas.sessions.database import Database
from adibas.sessions.lock import cannot_use
from adibas.sessions.schema import CAPTURES, RECORDINGS
from adibas.sessions.sealed_files import SealedFiles

DAYS_LOOKED_AT = 90
DAYS_A_MONTH = 30.44
LEAST_DAYS = 7
"""What was recorded in fewer days tells nothing of a month."""


@dataclass(frozen=True, slots=True)
class DiskForecast:
    """When the disk will be full.

    Attributes
    ----------
    free_bytes : int
        On the disk of the store.
    bytes_per_month : float or None
        At the rate of the last 90 days, or of all days where there are fewer; None of less than a
        week.
    """

    free_bytes: int
    bytes_per_month: float | None

    @property
    def months_left(self) -> float | None:
        """Months until it is full; None where nothing is recorded or too little is known."""
        if not self.bytes_per_month:
            return None
        return self.free_bytes / self.bytes_per_month


def forecast_disk(
    folder: Path, database: Database, pictures: SealedFiles, now_utc: datetime
) -> DiskForecast:
    """Look at what was kept in the last 90 days, and at what is free.

    Raises
    ------
    StoreError
        The disk cannot be asked.
    """
    begin = to_text(now_utc - timedelta(days=DAYS_LOOKED_AT))
    new_recordings = select(func.coalesce(func.sum(RECORDINGS.c.size_bytes), 0)).where(
        RECORDINGS.c.is_closed, RECORDINGS.c.created_utc >= begin
    )
    new_captures = select(CAPTURES.c.picture_id, CAPTURES.c.surface_id).where(
        CAPTURES.c.captured_utc >= begin
    )
    oldest = (
        select(func.min(RECORDINGS.c.created_utc)).where(RECORDINGS.c.is_closed),
        select(func.min(CAPTURES.c.captured_utc)),
    )
    with database.reading() as transaction:
        n_bytes = int(transaction.execute(new_recordings).scalar_one())
        pairs = transaction.execute(new_captures).all()
        beginnings = [one for one in map(transaction.scalar, oldest) if one is not None]
    n_bytes += sum(_size(pictures, one) for pair in pairs for one in pair if one is not None)
    try:
        free_bytes = shutil.disk_usage(folder).free
    except OSError as error:
        raise cannot_use(folder, error) from error
    first = max(begin, min(beginnings, default=begin))
    n_days = (now_utc - datetime.fromisoformat(first)) / timedelta(days=1)
    rate = None if n_days < LEAST_DAYS else n_bytes / n_days * DAYS_A_MONTH
    return DiskForecast(free_bytes, rate)


def _size(pictures: SealedFiles, file_id: str) -> int:
    try:
        return pictures.size(file_id)
    except StoreError:  # `verify` tells of it
        return 0
