"""How much each joint moves: path, speed, and time above the sensor's noise.

What a sensor's noise alone would move is not counted: after smoothing, a step between two samples
counts where it is longer than 99 of 100 steps of noise are. Noise is taken as white, and its size
from what smoothing takes away; where joints wander while a person is still, tell a time in which he
was, and the steps of that time are the noise.

Source: Winter, Biomechanics and Motor Control of Human Movement, 4th ed. (2009), section 3.4.4, for
smoothing.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.special import chdtri

from adibas.arrays import BoolArray, FloatArray, IntArray
from adibas.data.joints import JOINT_NAMES
from adibas.data.skeleton_track import SkeletonTrack
from adibas.timeseries.lowpass import LowpassParams, even_times, lowpass, resample

N_AXES = 3
SD_OF_MAD = 1.4826
"""Of a normal distribution: standard deviation over median absolute deviation."""
N_IMPULSE = 1025
FEWEST_SAMPLES = 8
"""To say anything of noise."""

Seconds = tuple[float, float]


@dataclass(frozen=True, slots=True)
class ActivityParams:
    """How activity is measured.

    Attributes
    ----------
    lowpass : LowpassParams
        Of the positions.
    noise_share : float
        Of the steps of noise that are taken for movement: 0.01.
    least_speed_m_s : float
        Slower is no movement, however small the noise: 0.01, a hand that is drawn along by the
        breath.
    still_s : (float, float) or None
        A time in which nobody moved, on the recording's clock. Of a joint that was not seen for
        long enough in it, see `tells_noise`, the noise is told as without.
    """

    lowpass: LowpassParams = field(default_factory=LowpassParams)
    noise_share: float = 0.01
    least_speed_m_s: float = 0.01
    still_s: Seconds | None = None

    def __post_init__(self) -> None:
        if not 0 < self.noise_share < 1 or self.least_speed_m_s < 0:
            raise ValueError("noise_share must be between 0 and 1, and a speed not negative")


@dataclass(frozen=True, slots=True, eq=False)
class Steps:
    """What each joint moved from one even sample to the next.

    Attributes
    ----------
    times_s : (G,) array
        Even, on the recording's clock.
    lengths_m : (G - 1, 15) array
        Of the smoothed path; NaN where the joint was not seen at either end.
    least_m : (15,) array
        From which on a step is movement; NaN where nothing is known of the noise.
    noise_m : (15,) array
        Standard deviation of one coordinate; NaN where it is not known.
    """

    times_s: FloatArray
    lengths_m: FloatArray
    least_m: FloatArray
    noise_m: FloatArray

    @property
    def step_s(self) -> float:
        """Return the time of one step; 0 where there is none."""
        return float(self.times_s[1] - self.times_s[0]) if len(self.times_s) > 1 else 0.0

    @property
    def seen(self) -> BoolArray:
        """Return (G - 1, 15): whether the step is known."""
        return np.asarray(np.isfinite(self.lengths_m))

    @property
    def active(self) -> BoolArray:
        """Return (G - 1, 15): whether the step is movement."""
        with np.errstate(invalid="ignore"):
            return np.asarray(self.lengths_m > self.least_m)

    def within(self, spans_s: Sequence[Seconds]) -> BoolArray:
        """Return (G - 1,): whether the middle of a step lies in a span, its end not included."""
        middles = 0.5 * (self.times_s[:-1] + self.times_s[1:])
        inside = np.zeros(len(middles), bool)
        for begin, end in spans_s:
            inside |= (middles >= begin) & (middles < end)
        return inside


@dataclass(frozen=True, slots=True)
class JointActivity:
    """What one joint did in some time.

    Attributes
    ----------
    joint : str
    observed_s : float
        All of the time.
    seen_s, active_s : float
        Of it the joint was seen, and moved.
    path_m : float
        Of the steps that are movement.
    speed_m_s : float or None
        Path over the time seen; None where it was not seen.
    fast_m_s : float or None
        Speed that is exceeded in 5 % of the time that it moved; None where it did not.
    """

    joint: str
    observed_s: float
    seen_s: float
    active_s: float
    path_m: float
    speed_m_s: float | None
    fast_m_s: float | None

    @property
    def active_share(self) -> float | None:
        """Return the share of the time seen in which it moved; None where it was not seen."""
        return self.active_s / self.seen_s if self.seen_s else None


def steps_of(track: SkeletonTrack, params: ActivityParams | None = None) -> Steps:
    """Return the steps of every joint; one joint after the other, so that hours fit in memory."""
    params = params or ActivityParams()
    times_s = even_times(track.times_s)
    n_steps = max(len(times_s) - 1, 0)
    lengths_m = np.full((n_steps, len(JOINT_NAMES)), np.nan)
    noise_m, least_m = np.full((2, len(JOINT_NAMES)), np.nan)
    if n_steps:
        rate_hz = 1.0 / float(times_s[1] - times_s[0])
        filtered = _impulse(rate_hz, params.lowpass)
        for joint in range(len(JOINT_NAMES)):
            measured_m = resample(
                track.times_s, track.joints_m[:, joint], times_s, params.lowpass.longest_gap_s
            )
            smooth_m = lowpass(measured_m, rate_hz, params.lowpass)
            lengths_m[:, joint] = np.linalg.norm(np.diff(smooth_m, axis=0), axis=1)
            noise_m[joint] = _noise_m(measured_m, smooth_m, filtered)
        white_m = noise_m * float(np.linalg.norm(np.diff(filtered)))
        least_m = white_m * float(np.sqrt(chdtri(N_AXES, params.noise_share)))
        least_m = np.maximum(least_m, params.least_speed_m_s / rate_hz)
    steps = Steps(times_s, lengths_m, least_m, noise_m)
    return steps if params.still_s is None else _held_against(steps, params.still_s, params)


def activity(steps: Steps, spans_s: Sequence[Seconds] | None = None) -> tuple[JointActivity, ...]:
    """Return what each joint did in some spans of time, the whole if not given."""
    inside = np.ones(len(steps.lengths_m), bool) if spans_s is None else steps.within(spans_s)
    lengths_m = steps.lengths_m[inside]
    seen, active = steps.seen[inside], steps.active[inside]
    observed_s = float(inside.sum()) * steps.step_s
    found = []
    for joint, name in enumerate(JOINT_NAMES):
        moved = lengths_m[active[:, joint], joint]
        seen_s = float(seen[:, joint].sum()) * steps.step_s
        fast = float(np.quantile(moved, 0.95)) / steps.step_s if len(moved) else None
        path_m = float(moved.sum())
        found.append(
            JointActivity(
                *(name, observed_s, seen_s, len(moved) * steps.step_s, path_m),
                path_m / seen_s if seen_s else None,
                fast,
            )
        )
    return tuple(found)


def per_bin(steps: Steps, spans_s: Sequence[Seconds]) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return path in metres, time moved and time seen in seconds, each (bins, 15).

    Bins follow each other without gaps; what lies before the first or after the last is left out.
    """
    edges = np.array([spans_s[0][0], *(end for _, end in spans_s)])
    middles = 0.5 * (steps.times_s[:-1] + steps.times_s[1:])
    numbers: IntArray = np.searchsorted(edges, middles, side="right").astype(np.int64) - 1
    kept = (numbers >= 0) & (numbers < len(spans_s))
    shape = (len(spans_s), len(JOINT_NAMES))
    cells = (numbers[kept, None] * len(JOINT_NAMES) + np.arange(len(JOINT_NAMES))).ravel()

    def summed(where: BoolArray, values: FloatArray | float) -> FloatArray:
        weights = np.where(where, values, 0.0)[kept].ravel()
        sums = np.bincount(cells, weights, shape[0] * shape[1]).reshape(shape)
        return np.asarray(sums, np.float64)  # integers where no step is inside

    active_s = summed(steps.active, steps.step_s)
    return summed(steps.active, steps.lengths_m), active_s, summed(steps.seen, steps.step_s)


def _impulse(rate_hz: float, params: LowpassParams) -> FloatArray:
    """Return what smoothing makes of one sample of 1."""
    impulse = np.zeros((N_IMPULSE, 1))
    impulse[N_IMPULSE // 2] = 1.0
    return lowpass(impulse, rate_hz, params)[:, 0]


def _noise_m(measured_m: FloatArray, smooth_m: FloatArray, filtered: FloatArray) -> float:
    """Return the noise of a coordinate from what smoothing took, or from second differences."""
    taken = filtered.copy()
    taken[N_IMPULSE // 2] -= 1.0
    gain = float(np.linalg.norm(taken))
    rest_m = measured_m - smooth_m
    if gain == 0.0:  # too few samples a second to smooth
        rest_m, gain = np.diff(measured_m, n=2, axis=0), float(np.sqrt(6.0))
    known = rest_m[np.isfinite(rest_m)]
    if known.size < FEWEST_SAMPLES:
        return float("nan")
    return SD_OF_MAD * float(np.median(np.abs(known))) / gain


def tells_noise(steps: Steps, still_s: Seconds) -> BoolArray:
    """Return (15,): whether a still time has enough steps of a joint to say what its noise is."""
    return np.asarray(steps.seen[steps.within([still_s])].sum(axis=0) >= FEWEST_SAMPLES)


def _held_against(steps: Steps, still_s: Seconds, params: ActivityParams) -> Steps:
    """Return the steps with those of the still time as noise, where it has enough of them."""
    still = steps.lengths_m[steps.within([still_s])]
    least_m = steps.least_m.copy()
    for joint in np.flatnonzero(tells_noise(steps, still_s)):
        known = still[np.isfinite(still[:, joint]), joint]
        least_m[joint] = max(
            float(np.quantile(known, 1.0 - params.noise_share)),
            params.least_speed_m_s * steps.step_s,
        )
    return Steps(steps.times_s, steps.lengths_m, least_m, steps.noise_m)
