"""How old a sensor's calibration is, in words. Knows nothing of Qt."""

from dataclasses import dataclass
from datetime import datetime, timedelta

from adibas.calibration.kept import KeptCalibrations, sensor_key, sizes_of
from adibas.data.frames import SourceInfo
from adibas.texts import translate as _
from adibas.texts import translate_plural

DAYS_A_MONTH = 30.44
FEW_DAYS = 60


@dataclass(frozen=True, slots=True)
class Reminder:
    """When a sensor was calibrated, and whether that is more than a notice.

    Attributes
    ----------
    days : int or None
        Ago; None: never.
    is_urgent : bool
        It should be done now.
    """

    days: int | None
    is_urgent: bool

    @property
    def text(self) -> str:
        """Say it in the language in use."""
        if self.days is None:
            return _("This sensor was never calibrated on this computer.")
        if self.is_urgent:
            old = _("This sensor was calibrated {age} ago. Calibrate it again.")
            return old.format(age=_age(self.days))
        if self.days == 0:
            return _("This sensor was calibrated today.")
        return _("This sensor was calibrated {age} ago.").format(age=_age(self.days))


def remind(
    kept: KeptCalibrations, info: SourceInfo, now_utc: datetime, allowed_days: int
) -> Reminder:
    """Return when a sensor was calibrated for images of these sizes.

    Raises
    ------
    CalibrationError
        A calibration of this sensor is damaged.
    """
    sizes = None if info.calibration is None else sizes_of(info.calibration)
    newest = kept.newest(sensor_key(info), sizes)
    if newest is None:
        return Reminder(None, is_urgent=True)
    days = max((now_utc - newest.made_utc).days, 0)
    return Reminder(days, is_urgent=newest.is_old(now_utc, timedelta(days=allowed_days)))


def _age(days: int) -> str:
    if days < FEW_DAYS:
        return translate_plural("{n} day", "{n} days", days).format(n=days)
    months = round(days / DAYS_A_MONTH)
    return translate_plural("{n} month", "{n} months", months).format(n=months)
