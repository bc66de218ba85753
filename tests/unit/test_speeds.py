"""Speeds of smoothed curves, and what noise makes of them."""

import numpy as np
import pytest

from adibas.timeseries.lowpass import lowpass
from adibas.timeseries.speeds import speed_noise, speeds

RATES_HZ = [30.0, 60.0, 120.0]


def noises(rate_hz, n_runs=1000, n_samples=300):
    """Return (n_samples, n_runs) white noise, what is left of it, and the speeds of that."""
    white = np.random.default_rng(5).normal(size=(n_samples, n_runs))
    left = lowpass(white, rate_hz)
    times_s = np.arange(n_samples) / rate_hz
    found = np.column_stack([speeds(run, times_s, 0.5 / 6.0) for run in left.T])
    return white, left, found[np.isfinite(found).all(axis=1)]


@pytest.mark.parametrize("rate_hz", RATES_HZ)
def test_the_noise_of_speeds_is_known_from_what_was_taken_away(rate_hz):
    white, left, found = noises(rate_hz)
    sd = speed_noise(rate_hz).share_hz * np.sqrt(((white - left) ** 2).mean())
    assert found.std() == pytest.approx(sd, rel=0.03)


@pytest.mark.parametrize("rate_hz", RATES_HZ)
def test_noise_alone_is_seldom_faster_than_its_peak(rate_hz):
    white, left, found = noises(rate_hz)
    noise = speed_noise(rate_hz)
    sd = noise.share_hz * np.sqrt(((white - left) ** 2).mean())
    peak = noise.peak(sd, len(found) / rate_hz)
    assert 0.001 < (np.abs(found).max(axis=0) > peak).mean() < 0.025


@pytest.mark.parametrize("rate_hz", RATES_HZ)
def test_the_noise_is_near_the_limit_of_the_literature(rate_hz):
    """Lanshammar 1982: variance of a derivative from a sharp cutoff w is s^2 dt w^3 / (3 pi).

    This filter falls less steeply, and differences of neighbours lower high frequencies.
    """
    limit_hz = np.sqrt((2 * np.pi * 6.0) ** 3 / (3 * np.pi * rate_hz))
    _white, _left, found = noises(rate_hz)
    assert found.std() == pytest.approx(limit_hz, rel=0.25)


def test_what_is_not_smoothed_has_no_known_noise():
    assert speed_noise(10.0) is None
    assert speed_noise(float("nan")) is None


def test_a_steady_slope_is_its_speed_and_its_ends_are_not_given():
    times_s = np.arange(20) / 30.0
    found = speeds(4.0 * times_s, times_s, 0.1)
    assert np.isnan(found[[0, 1, 2, -3, -2, -1]]).all()
    np.testing.assert_allclose(found[3:-3], 4.0)


def test_a_run_shorter_than_its_ends_has_no_speed():
    times_s = np.arange(4) / 30.0
    assert np.isnan(speeds(times_s, times_s, 0.1)).all()


def test_a_short_moment_of_noise_has_no_peak_below_nothing():
    assert speed_noise(30.0).peak(1.0, 1e-6) == 0.0
