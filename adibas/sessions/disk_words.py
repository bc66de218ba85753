"""When the disk is full, in words."""

from typing import TYPE_CHECKING

from adibas.texts import translate as _

if TYPE_CHECKING:
    from adibas.sessions.disk_use import DiskForecast

BYTES_PER_GB = 1e9


def forecast_text(forecast: "DiskForecast") -> str:
    """Say when the disk will be full."""
    free = forecast.free_bytes / BYTES_PER_GB
    if forecast.months_left is None:
        return _("{free:.1f} GB are free; too little was recorded for a forecast.").format(
            free=free
        )
    return _("{free:.1f} GB are free: {months:.0f} months at the rate of the last 90 days.").format(
        free=free, months=forecast.months_left
    )
