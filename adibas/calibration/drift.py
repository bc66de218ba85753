"""Does the depth change while the sensor warms up.

Structured light drifts in disparity, that is, in 1/z: a straight line over time is fitted to the
mean error of 1/z of boards, or to the mean 1/z of a wall that stands still.

Source: weighted least squares with Student's t, as in Draper & Smith, Applied regression analysis,
3rd ed., sections 1.4 and 9.2. How long sensors warm up: Toelgyessy et al., Sensors 21 (2021), 40
to 50 minutes for the Azure Kinect.
"""

from dataclasses import dataclass

import numpy as np
from scipy.stats import t as student

from adibas.arrays import FloatArray, check_shape
from adibas.data.sentence import Sentence
from adibas.texts import message

LEAST_MOMENTS = 4
SURE = 0.975
STATED_DISTANCE_M = 2.0
SECONDS_PER_MINUTE = 60.0
MILLIMETRES = 1000.0

DRIFTS = message(
    "The depth drifts by {rate_mm} mm a minute at {distance_m} m ({low_mm} to {high_mm} mm): the "
    "sensor is still warming up. Let it run for half an hour and calibrate again."
)


@dataclass(frozen=True, slots=True)
class DriftParams:
    """When a drift is worth a notice.

    Attributes
    ----------
    least_change_m : float
        Over the time of the recording, at 2 m: 1 mm.
    """

    least_change_m: float = 0.001


@dataclass(frozen=True, slots=True)
class Drift:
    """A straight line over time.

    Attributes
    ----------
    rate_per_m_s : float
        Of 1/z, 1/metres a second; positive: surfaces seem to come nearer.
    interval_per_m_s : (float, float)
        Holds the truth in 95 % of cases.
    span_s : float
        From the first to the last moment.
    """

    rate_per_m_s: float
    interval_per_m_s: tuple[float, float]
    span_s: float

    def rate_m_s(self, distance_m: float) -> float:
        """Return the drift of the depth at a distance, metres a second; positive: farther."""
        return -(distance_m**2) * self.rate_per_m_s

    def notice(self, params: DriftParams | None = None) -> Sentence | None:
        """Return what to tell the reader; None where the depth stays as it is."""
        params = params or DriftParams()
        low, high = self.interval_per_m_s
        change_m = abs(self.rate_m_s(STATED_DISTANCE_M)) * self.span_s
        if low <= 0.0 <= high or change_m < params.least_change_m:
            return None
        scale = -(STATED_DISTANCE_M**2) * SECONDS_PER_MINUTE * MILLIMETRES
        fields = {
            "rate_mm": scale * self.rate_per_m_s,
            "low_mm": min(scale * low, scale * high),
            "high_mm": max(scale * low, scale * high),
            "distance_m": STATED_DISTANCE_M,
        }
        return Sentence(DRIFTS, fields)


def fit_drift(
    times_s: FloatArray, errors_per_m: FloatArray, sigmas_per_m: FloatArray
) -> Drift | None:
    """Fit a straight line to errors of 1/z over time.

    Parameters
    ----------
    times_s : (N,) array
        Of the moments.
    errors_per_m : (N,) array
        Of 1/z, 1/metres; those that are NaN are left out.
    sigmas_per_m : (N,) array
        Standard deviations up to a common factor, which the scatter about the line gives.

    Returns
    -------
    drift : Drift or None
        None for fewer than four moments, or moments at one time.
    """
    check_shape("errors_per_m", errors_per_m, (len(times_s),))
    check_shape("sigmas_per_m", sigmas_per_m, (len(times_s),))
    is_known = np.isfinite(errors_per_m) & (sigmas_per_m > 0)
    times_s, errors_per_m = times_s[is_known], errors_per_m[is_known]
    weights = 1.0 / sigmas_per_m[is_known] ** 2
    if len(times_s) < LEAST_MOMENTS or not np.ptp(times_s) > 0:
        return None
    weights = weights / weights.sum()
    moved_s = times_s - weights @ times_s
    spread = weights @ moved_s**2
    rate = float(weights @ (moved_s * errors_per_m) / spread)
    residuals = errors_per_m - weights @ errors_per_m - rate * moved_s
    n_free = len(times_s) - 2
    sd = float(np.sqrt(weights @ residuals**2 / spread / n_free))
    half = float(student.ppf(SURE, n_free)) * sd
    return Drift(rate, (rate - half, rate + half), float(np.ptp(times_s)))
