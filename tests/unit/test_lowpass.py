"""Smoothing without lag."""

import numpy as np
import pytest
from scipy.signal import butter, freqz

from adibas.timeseries.lowpass import LowpassParams, even_times, lowpass, noise_share, resample

RATE_HZ = 30.0


def times(n):
    return np.arange(n) / RATE_HZ


def amplitude_left(frequency_hz):
    """Return what is left of a long sine in its middle, and by how much it is late."""
    t = times(3000)
    wave = np.exp(2j * np.pi * frequency_hz * t)
    found = lowpass(wave.real, RATE_HZ) + 1j * lowpass(wave.imag, RATE_HZ)
    ratio = (found / wave)[1000:2000].mean()
    return abs(ratio), np.angle(ratio)


def test_half_of_the_power_is_left_at_the_cutoff_and_nothing_is_late():
    left, late_rad = amplitude_left(6.0)
    assert left == pytest.approx(np.sqrt(0.5), abs=1e-3)
    assert late_rad == pytest.approx(0.0, abs=1e-3)


@pytest.mark.parametrize("frequency_hz", [0.5, 2.0, 9.0, 14.0])
def test_the_response_is_that_of_two_runs_of_scipys_filter(frequency_hz):
    prewarped = np.tan(np.pi * 6.0 / RATE_HZ) / (np.sqrt(2) - 1) ** 0.25
    b, a = butter(2, np.arctan(prewarped) * RATE_HZ / np.pi, fs=RATE_HZ)
    _w, response = freqz(b, a, [frequency_hz], fs=RATE_HZ)
    left, late_rad = amplitude_left(frequency_hz)
    assert left == pytest.approx(abs(response[0]) ** 2, abs=2e-3)
    assert late_rad == pytest.approx(0.0, abs=2e-3)


def test_straight_lines_stay_as_they_are_to_their_ends():
    line = 3.0 - 0.2 * times(50)
    np.testing.assert_allclose(lowpass(line, RATE_HZ), line, atol=1e-9)


def test_each_run_is_smoothed_by_itself_and_short_ones_are_left_out():
    values = np.sin(times(60) * 4)
    values[[20, 23]] = np.nan
    found = lowpass(values, RATE_HZ)
    np.testing.assert_array_equal(found[:20], lowpass(values[:20], RATE_HZ))
    assert np.isnan(found[20:24]).all()
    assert np.isfinite(found[24:]).all()


def test_where_the_cutoff_is_beyond_half_the_rate_nothing_changes():
    values = np.random.default_rng(1).normal(size=(40, 2))
    np.testing.assert_array_equal(lowpass(values, 12.0), values)
    assert noise_share(12.0) == float("inf")


def test_the_noise_left_is_known_from_the_noise_taken():
    noise = np.random.default_rng(2).normal(size=200_000)
    smooth = lowpass(noise, RATE_HZ)
    assert smooth.std() == pytest.approx(noise_share(RATE_HZ) * (noise - smooth).std(), rel=0.02)


def test_even_times_hold_first_and_last():
    jittered = np.array([0.0, 0.034, 0.066, 0.1, 0.2, 0.234])
    even_s = even_times(jittered)
    assert even_s[[0, -1]].tolist() == [0.0, 0.234]
    np.testing.assert_allclose(np.diff(even_s), 0.234 / 7)
    assert even_times(np.array([3.0])).tolist() == [3.0]


def test_resampling_bridges_short_gaps_alone():
    t = np.array([0.0, 0.1, 0.2, 0.6, 0.7])
    values = np.column_stack([t, [1.0, np.nan, np.nan, 1.0, 1.0], [np.nan] * 5])
    found = resample(t, values, np.array([0.05, 0.2, 0.3, 0.6, 0.65]), 0.25)
    np.testing.assert_allclose(found[:, 0], [0.05, 0.2, np.nan, 0.6, 0.65])
    np.testing.assert_allclose(found[:, 1], [np.nan, np.nan, np.nan, 1.0, 1.0])
    assert np.isnan(found[:, 2]).all()


def test_one_sample_is_itself():
    assert resample(np.array([1.0]), np.array([5.0]), np.array([1.0]), 0.1).tolist() == [5.0]


@pytest.mark.parametrize("wrong", [{"cutoff_hz": 0.0}, {"longest_gap_s": -0.1}])
def test_impossible_settings_are_refused(wrong):
    with pytest.raises(ValueError, match="cutoff_hz"):
        LowpassParams(**wrong)
