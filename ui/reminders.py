"""How old a sensor's calibration is, in words. Knows nothing of Qt."""

from dataclasses import dataclass
from datetime import datetime

from adibas.calibration.kept import KeptCalibrations, Sizes
from adibas.texts import translate as _
from adibas.texts import translate_plural

DAYS_A_MONTH = 30.44
FEW_DAYS = 60


@dataclass(frozen=True, slots=True)
class Reminder:
    """A sentence, and whether it is more than a notice."""

    text: str
    is_urgent: bool


def remind(kept: KeptCalibrations, sensor: str, sizes: Sizes | None, now_utc: datetime) -> Reminder:
    """Say when a sensor was calibrated.

    Parameters
    ----------
    sensor : str
        As `sensor_key` tells it.
    sizes : pair of (int, int) or None
        Of its images.

    Raises
    ------
    CalibrationError
        A calibration of this sensor is damaged.
    """
    newest = kept.newest(sensor, sizes)
    if newest is None:
        never = _("This sensor was never calibrated on this computer.")
        return Reminder(never, is_urgent=True)
    days = max((now_utc - newest.made_utc).days, 0)
    if newest.is_old(now_utc):
        old = _("This sensor was calibrated {age} ago. Calibrate it again.")
        return Reminder(old.format(age=_age(days)), is_urgent=True)
    if days == 0:
        return Reminder(_("This sensor was calibrated today."), is_urgent=False)
    recent = _("This sensor was calibrated {age} ago.")
    return Reminder(recent.format(age=_age(days)), is_urgent=False)


def _age(days: int) -> str:
    if days < FEW_DAYS:
        return translate_plural("{n} day", "{n} days", days).format(n=days)
    months = round(days / DAYS_A_MONTH)
    return translate_plural("{n} month", "{n} months", months).format(n=months)
