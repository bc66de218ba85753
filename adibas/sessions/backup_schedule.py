"""Backups that are made every few days into one folder, of which the last ones are kept.

When a backup is due is read from the backups that are there: a folder that somebody emptied, or a
disk that was changed, counts as one without any. So does one whose backups are all of the future: a
clock was wrong, and nothing says how old they are.
"""

from dataclasses import dataclass
from datetime import datetime, timedelta
from pathlib import Path

from adibas.errors import AdibasError, FileError
from adibas.files import cannot_read
from adibas.sessions.backup_format import BackupReader
from adibas.sessions.defaults import BACKUP_ENDING, DAYS_BETWEEN_BACKUPS, N_BACKUPS_KEPT

A_DAY = timedelta(days=1)
AHEAD = A_DAY
"""So far a clock may have been put back; a backup that is still later has a wrong time."""
SLACK = timedelta(hours=1)
"""A daily timer starts a little earlier than the day before finished."""
N_ID_DIGITS, N_LOG_DIGITS = 8, 4
PATTERN = f"adibas-*{BACKUP_ENDING}"


@dataclass(frozen=True, slots=True)
class BackupPlan:
    """When and where.

    Attributes
    ----------
    folder : Path
        Best on another disk.
    every_days : int
        A backup is due when the newest one is so old.
    keep : int
        Older ones are removed after a new one is made.
    """

    folder: Path
    every_days: int = DAYS_BETWEEN_BACKUPS
    keep: int = N_BACKUPS_KEPT

    def __post_init__(self) -> None:
        if self.every_days < 1 or self.keep < 1:
            raise ValueError(f"no plan: {self}")


@dataclass(frozen=True, slots=True)
class KeptBackup:
    """A backup of a folder; see `BackupHeader`."""

    path: Path
    created_utc: datetime
    log_end: str | None = None


def backups_in(folder: Path, store_id: str, now_utc: datetime) -> tuple[KeptBackup, ...]:
    """Return the backups of one store in a folder, newest first; cut and damaged ones are none.

    Those of the future are last. Those of copies of the store are among them.

    Raises
    ------
    FileError
        The folder cannot be read; one that does not exist yet holds none.
    """
    try:
        paths = sorted(folder.glob(PATTERN)) if folder.exists() else []
    except OSError as error:
        raise cannot_read(folder, error) from error
    found = [kept for path in paths if (kept := _kept(path, store_id)) is not None]
    latest = now_utc + AHEAD
    order = sorted(found, key=lambda one: (one.created_utc <= latest, one.created_utc))
    return tuple(reversed(order))


def days_since(kept: tuple[KeptBackup, ...], now_utc: datetime) -> float | None:
    """Return how old the newest backup is, days; None without any that tells."""
    if not kept or kept[0].created_utc > now_utc + AHEAD:
        return None
    return max(0.0, (now_utc - kept[0].created_utc) / A_DAY)


def is_due(kept: tuple[KeptBackup, ...], now_utc: datetime, every_days: int) -> bool:
    """Say whether it is time for a backup."""
    days = days_since(kept, now_utc)
    return days is None or days >= every_days - SLACK / A_DAY


def name_at(now_utc: datetime, store_id: str, log_end: str) -> str:
    """Return the name of a backup that is made now.

    Timers of two stores strike in one second, and those of two copies of one store, too.
    """
    number = f"{store_id[:N_ID_DIGITS]}-{log_end[:N_LOG_DIGITS]}"
    return f"adibas-{now_utc:%Y-%m-%d-%H%M%S}-{number}{BACKUP_ENDING}"


def remove_older(kept: tuple[KeptBackup, ...], keep: int) -> tuple[Path, ...]:
    """Remove all but the `keep` newest; return what was removed.

    Raises
    ------
    FileError
        One of them cannot be removed.
    """
    old = tuple(one.path for one in kept[keep:])
    for path in old:
        try:
            path.unlink(missing_ok=True)
        except OSError as error:
            raise FileError(
                "The older backup {file} cannot be removed: {reason}. The new one is made; remove "
                "the older one yourself.",
                file=path.name,
                reason=error.strerror or str(error),
            ) from error
    return old


def _kept(path: Path, store_id: str) -> KeptBackup | None:
    try:
        with BackupReader(path) as backup:
            created = datetime.fromisoformat(backup.header.created_utc)
            is_ours = backup.header.store_id == store_id and created.tzinfo is not None
            is_cut = path.stat().st_size < backup.header.n_bytes
    except (AdibasError, ValueError, OSError):  # it protects nobody, and so it does not count
        return None
    return KeptBackup(path, created, backup.header.log_end) if is_ours and not is_cut else None
