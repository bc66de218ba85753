"""When the disk is full, in words."""

from typing import TYPE_CHECKING

from adibas.texts import decimal_text, translate_plural
from adibas.texts import translate as _

if TYPE_CHECKING:
    from adibas.sessions.disk_use import DiskForecast

BYTES_PER_GB = 1e9
MANY_MONTHS = 36
"""No rate of 90 days tells more."""


def forecast_text(forecast: "DiskForecast") -> str:
    """Say when the disk will be full."""
    free = decimal_text(forecast.free_bytes / BYTES_PER_GB, 1)
    if forecast.months_left is None:
        return _("{free} GB are free; too little was recorded for a forecast.").format(free=free)
    months = round(forecast.months_left)
    if months > MANY_MONTHS:
        told = _("{free} GB are free: enough for years at the rate of the last 90 days.")
        return told.format(free=free)
    told = translate_plural(
        "{free} GB are free: {months} month at the rate of the last 90 days.",
        "{free} GB are free: {months} months at the rate of the last 90 days.",
        months,
    )
    return told.format(free=free, months=months)
