"""Smoothing without lag: resampling onto even times, and a low-pass filter run both ways."""

from dataclasses import dataclass

import numpy as np

from adibas.arrays import BoolArray, FloatArray

ORDER = 2
"""Of one way; run both ways the filter is of fourth order."""
LEAST_SAMPLES = 4
"""Of a run without gaps: fewer cannot be smoothed."""
SAME_TIME_S = 1e-6
N_SAMPLES_OF_RESPONSE = 2049


@dataclass(frozen=True, slots=True)
class LowpassParams:
    """How movement is smoothed.

    Attributes
    ----------
    cutoff_hz : float
        Half of the power is left at this frequency: 6 Hz, which keeps what limbs do when walking,
        reaching and exercising (Winter, Biomechanics and Motor Control of Human Movement, 4th ed.
        2009, section 3.4.4).
    longest_gap_s : float
        Shorter gaps are bridged by straight lines: 0.15 s, less than half a period of the cutoff
        on either side.
    """

    cutoff_hz: float = 6.0
    longest_gap_s: float = 0.15

    def __post_init__(self) -> None:
        if self.cutoff_hz <= 0 or self.longest_gap_s < 0:
            raise ValueError("cutoff_hz must be above zero and longest_gap_s not below")


def even_times(times_s: FloatArray) -> FloatArray:
    """Return (G,) even times from the first to the last of (T,), as far apart as the median."""
    if len(times_s) <= 1:
        return np.array(times_s, float)
    step_s = float(np.median(np.diff(times_s)))
    n_steps = max(round((times_s[-1] - times_s[0]) / step_s), 1)
    return np.linspace(times_s[0], times_s[-1], n_steps + 1)


def resample(
    times_s: FloatArray, values: FloatArray, even_s: FloatArray, longest_gap_s: float
) -> FloatArray:
    """Return the values at other times, on straight lines between neighbours.

    Parameters
    ----------
    times_s : (T,) array
        Increasing.
    values : (T, ...) array
        NaN where not seen.
    even_s : (G,) array
        Where they are wanted.
    longest_gap_s : float
        Between neighbours farther apart, and outside the first and last, the result is NaN.

    Returns
    -------
    resampled : (G, ...) array
    """
    columns = values.reshape(len(times_s), -1)
    found = np.full((len(even_s), columns.shape[1]), np.nan)
    for at, column in enumerate(columns.T):
        seen = np.isfinite(column)
        if seen.any():
            found[:, at] = _between(times_s[seen], column[seen], even_s, longest_gap_s)
    return found.reshape(len(even_s), *values.shape[1:])


def _between(
    times_s: FloatArray, values: FloatArray, even_s: FloatArray, longest_gap_s: float
) -> FloatArray:
    lines = np.interp(even_s, times_s, values, left=np.nan, right=np.nan)
    after = np.clip(np.searchsorted(times_s, even_s), 1, max(len(times_s) - 1, 1))
    before = np.minimum(after - 1, len(times_s) - 1)
    after = np.minimum(after, len(times_s) - 1)
    away_s = np.minimum(np.abs(even_s - times_s[before]), np.abs(even_s - times_s[after]))
    is_wide = times_s[after] - times_s[before] > longest_gap_s
    lines[is_wide & (away_s > SAME_TIME_S)] = np.nan
    return np.asarray(lines)


def lowpass(values: FloatArray, rate_hz: float, params: LowpassParams | None = None) -> FloatArray:
    """Smooth evenly sampled values with a Butterworth filter that is run forwards and backwards.

    Parameters
    ----------
    values : (G, ...) array
        NaN where not seen: each run without gaps is smoothed by itself.
    rate_hz : float
        Samples a second.
    params : LowpassParams or None
        How.

    Returns
    -------
    smoothed : (G, ...) array
        As it was where the cutoff is not below half the rate; NaN in runs of fewer than four
        samples.

    Source: Winter (2009), section 3.4.4: the second run lowers the cutoff, so that each is made
    with a higher one.
    """
    params = params or LowpassParams()
    columns = values.reshape(len(values), -1)
    smoothed = np.full(columns.shape, np.nan)
    sections = _sections(rate_hz, params.cutoff_hz)
    for at, column in enumerate(columns.T):
        for first, last in runs(np.isfinite(column)):
            if last - first >= LEAST_SAMPLES:
                run = column[first:last]
                smoothed[first:last, at] = run if sections is None else _both_ways(sections, run)
    return smoothed.reshape(values.shape)


def noise_share(rate_hz: float, params: LowpassParams | None = None) -> float:
    """Return the standard deviation of smoothed white noise over that of what was taken away.

    With it the noise left in a smooth curve is known from the differences to what was measured.
    Infinite where nothing is taken away.
    """
    response = impulse_response(rate_hz, params)
    if response is None:
        return float("inf")
    return float(np.linalg.norm(response) / np.linalg.norm(taken_away(response)))


def impulse_response(rate_hz: float, params: LowpassParams | None = None) -> FloatArray | None:
    """Return what the filter makes of a 1 in the middle of zeros; None where it does nothing."""
    params = params or LowpassParams()
    sections = _sections(rate_hz, params.cutoff_hz)
    if sections is None:
        return None
    impulse = np.zeros(N_SAMPLES_OF_RESPONSE)
    impulse[N_SAMPLES_OF_RESPONSE // 2] = 1.0
    return _both_ways(sections, impulse)


def taken_away(response: FloatArray) -> FloatArray:
    """Return what a filter of that response takes from a 1 in the middle of zeros."""
    taken = -response
    taken[len(response) // 2] += 1.0
    return taken


def _sections(rate_hz: float, cutoff_hz: float) -> FloatArray | None:
    from scipy.signal import butter

    if not cutoff_hz < 0.5 * rate_hz:  # also where there is no rate
        return None
    # Two runs of order n halve the power where each alone leaves 1/sqrt(2) of it. Winter's factor
    # holds for an analogue filter, whose frequencies are the tangents of the digital one's.
    analogue = np.tan(np.pi * cutoff_hz / rate_hz) / (np.sqrt(2.0) - 1.0) ** (0.5 / ORDER)
    corrected_hz = np.arctan(analogue) * rate_hz / np.pi
    return np.asarray(butter(ORDER, corrected_hz, fs=rate_hz, output="sos"))


def _both_ways(sections: FloatArray, run: FloatArray) -> FloatArray:
    from scipy.signal import sosfiltfilt

    return np.asarray(sosfiltfilt(sections, run, padlen=min(3 * ORDER * 2, len(run) - 1)))


def runs(is_seen: BoolArray) -> list[tuple[int, int]]:
    """Return (first, one after last) of each run of True."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], is_seen, [False]]).astype(int)))
    return [(int(first), int(last)) for first, last in zip(edges[::2], edges[1::2], strict=True)]
