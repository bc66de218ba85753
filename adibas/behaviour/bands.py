"""How fast joints go to and fro: power of their velocity in bands of one hertz.

Source: Welch, The use of fast Fourier transform for the estimation of power spectra, IEEE
Transactions on Audio and Electroacoustics 15 (1967); bands of one hertz up to 15 as in Li et al.
(2016, PMC5153899).
"""

from dataclasses import dataclass

import numpy as np

from adibas.arrays import FloatArray
from adibas.data.joints import JOINT_NAMES
from adibas.data.skeleton_track import SkeletonTrack
from adibas.timeseries.lowpass import even_times, resample, runs

MOST_HZ = 15
WINDOW_S = 4.0
"""Of one spectrum: a quarter of a hertz is told apart."""
LONGEST_GAP_S = 0.15
"""Bridged by a straight line, as everywhere in the smoothing of joints."""


@dataclass(frozen=True, slots=True, eq=False)
class BandPower:
    """Power of each joint's velocity.

    Attributes
    ----------
    edges_hz : (B + 1,) array
        Of the bands.
    power : (15, B) array
        Metres squared a second squared, over three axes; NaN where the joint was never seen long
        enough. The sensor's noise is in it.
    noise : (15, B) array
        How much of it white noise of the given size makes.
    """

    edges_hz: FloatArray
    power: FloatArray
    noise: FloatArray


def band_power(track: SkeletonTrack, noise_m: FloatArray) -> BandPower:
    """Return the power in bands of one hertz, below half of the sample rate and below 15 Hz.

    Parameters
    ----------
    track : SkeletonTrack
    noise_m : (15,) array
        Standard deviation of a coordinate.
    """
    times_s = even_times(track.times_s)
    rate_hz = 1.0 / float(times_s[1] - times_s[0]) if len(times_s) > 1 else 0.0
    n_bands = min(int(rate_hz / 2 + 1e-6), MOST_HZ)
    edges_hz = np.arange(n_bands + 1.0)
    power = np.full((len(JOINT_NAMES), n_bands), np.nan)
    n_window = round(WINDOW_S * rate_hz)
    if n_bands:
        for joint in range(len(JOINT_NAMES)):
            positions_m = resample(track.times_s, track.joints_m[:, joint], times_s, LONGEST_GAP_S)
            power[joint] = _powers(positions_m, rate_hz, n_window, edges_hz)
    # White noise of density 2 s^2 / rate, over three axes, times (2 pi f)^2.
    cubes = np.diff(edges_hz**3) / 3.0
    density = 3 * 2 * noise_m**2 / rate_hz if rate_hz else np.full(len(noise_m), np.nan)
    return BandPower(edges_hz, power, density[:, None] * (2 * np.pi) ** 2 * cubes[None])


def _powers(
    positions_m: FloatArray, rate_hz: float, n_window: int, edges_hz: FloatArray
) -> FloatArray:
    """Return (B,) from all runs that are long enough, each with its length as weight."""
    from scipy.signal import welch

    seen = np.asarray(np.isfinite(positions_m).all(axis=1))
    total = np.zeros(len(edges_hz) - 1)
    weight = 0
    for begin, end in runs(seen):
        if end - begin < n_window:
            continue
        frequencies, density = welch(  # type: ignore[call-overload]  # lacks 'linear'
            positions_m[begin:end], rate_hz, nperseg=n_window, detrend="linear", axis=0
        )
        speed = density.sum(axis=1) * (2 * np.pi * frequencies) ** 2
        band = np.clip(np.searchsorted(edges_hz, frequencies, side="right") - 1, 0, len(total))
        inside = band < len(total)
        sums = np.bincount(band[inside], speed[inside], len(total)) * (frequencies[1])
        total += (end - begin) * sums
        weight += end - begin
    return total / weight if weight else np.full(len(total), np.nan)
