"""When the disk is full, in words."""

import pytest

from adibas.sessions.disk_use import DiskForecast
from adibas.sessions.disk_words import forecast_text
from adibas.texts import speaking

GB = 1_000_000_000


@pytest.mark.parametrize(
    ("months", "words"),
    [
        (1, "1 month at"),
        (2, "2 months"),
        (36, "36 months"),
        (37, "enough for years"),
        (1762, "enough for years"),
    ],
)
def test_months_are_counted_as_long_as_the_rate_tells_anything(months, words):
    forecast = DiskForecast(months * GB, float(GB))
    assert words in forecast_text(forecast)


def test_a_spanish_reader_sees_a_comma():
    with speaking("es"):
        assert "83,6 GB" in forecast_text(DiskForecast(83_600_000_000, float(GB)))
