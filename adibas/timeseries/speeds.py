"""How fast a smoothed curve changes, and how fast noise alone would make it look.

Noise of the samples is taken for white, and its size from what the filter took away. The filter
and the difference are linear: with the response h of the filter to one sample, and g of the
difference of h, the standard deviation of the speed is that of what was taken times
|g| / |1 - h|, where |.| is the root of the sum of squares.

Source: Lanshammar, On precision limits for derivatives numerically calculated from noisy data,
J. Biomech. 15 (1982), for the way (white noise through a linear filter and its derivative).
"""

import math
from dataclasses import dataclass

import numpy as np

from adibas.arrays import FloatArray
from adibas.timeseries.lowpass import LowpassParams, impulse_response, runs, taken_away

CHANCE = 0.01
"""That noise alone is faster in a curve than `SpeedNoise.peak`; one report has fifteen curves."""


@dataclass(frozen=True, slots=True)
class SpeedNoise:
    """What noise does to speeds.

    Attributes
    ----------
    share_hz : float
        Standard deviation of the speed over that of what the filter took away, 1/s.
    crossings_hz : float
        How often a second speeds of noise rise through zero.
    """

    share_hz: float
    crossings_hz: float

    def peak(self, sd: float, duration_s: float) -> float:
        """Return the speed that noise of a standard deviation exceeds, either way, by `CHANCE`.

        Source: Rice, Mathematical analysis of random noise, Bell Syst. Tech. J. 24 (1945),
        section 3.3: a level of z standard deviations is crossed upwards
        ``crossings_hz * exp(-z**2 / 2)`` times a second; rare crossings are independent.
        """
        wanted = -math.log1p(-CHANCE)
        return sd * math.sqrt(2.0 * max(math.log(2.0 * self.crossings_hz * duration_s / wanted), 0))


def speed_noise(rate_hz: float, params: LowpassParams | None = None) -> SpeedNoise | None:
    """Return what noise does to the speeds of smoothed values; None where none are smoothed."""
    response = impulse_response(rate_hz, params)
    if response is None:
        return None
    speed = np.gradient(response) * rate_hz
    turns_hz = float(np.linalg.norm(np.gradient(speed)) / np.linalg.norm(speed)) * rate_hz
    share_hz = float(np.linalg.norm(speed) / np.linalg.norm(taken_away(response)))
    return SpeedNoise(share_hz, turns_hz / (2.0 * np.pi))


def speeds(values: FloatArray, times_s: FloatArray, edge_s: float) -> FloatArray:
    """Return the (T,) derivative of smoothed (T,) values at even times.

    Nearer than `edge_s` to where a run without gaps begins or ends it is NaN: there the filter
    knows one side alone, and noise makes its slope more than twice as uncertain.
    """
    if len(times_s) <= 1:
        return np.full(len(values), np.nan)
    found = np.asarray(np.gradient(values, times_s))
    n_edge = math.ceil(edge_s / (times_s[1] - times_s[0]) - 1e-6)
    for first, last in runs(np.isfinite(values)):
        found[first : first + n_edge] = found[max(last - n_edge, first) : last] = np.nan
    return found
