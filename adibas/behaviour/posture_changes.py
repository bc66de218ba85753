"""When a person settles in another place or posture, and when nobody sees him.

Source: own definitions, described in docs/behaviour.md.
"""

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import maximum_filter1d

from adibas.arrays import FloatArray
from adibas.behaviour.bands import LONGEST_GAP_S
from adibas.data.joints import JOINT_NAMES
from adibas.data.skeleton_track import SkeletonTrack
from adibas.timeseries.lowpass import even_times, resample, runs

CORE = tuple(
    JOINT_NAMES.index(name)
    for name in ("neck", "torso", "left_shoulder", "right_shoulder", "left_hip", "right_hip")
)
MIDDLE = tuple(JOINT_NAMES.index(name) for name in ("head", "neck", "torso"))


@dataclass(frozen=True, slots=True)
class PostureParams:
    """When a posture has changed.

    Attributes
    ----------
    reach_s : float
        The mean place of this time before is held against that of this time after: 1.
    least_m : float
        Root mean square over the trunk's joints: 0.10, more than breathing and sway, less than a
        shift of the seat.
    hidden_s : float
        A person is out of view where none of head, neck and torso is seen for so long: 0.5.
    """

    reach_s: float = 1.0
    least_m: float = 0.10
    hidden_s: float = 0.5

    def __post_init__(self) -> None:
        if min(self.reach_s, self.least_m, self.hidden_s) <= 0:
            raise ValueError("reach_s, least_m and hidden_s must be above zero")


def posture_changes_s(track: SkeletonTrack, params: PostureParams | None = None) -> FloatArray:
    """Return when the trunk settled in another place, seconds on the recording's clock."""
    params = params or PostureParams()
    times_s = even_times(track.times_s)
    if len(times_s) < 2:  # noqa: PLR2004
        return np.empty(0)
    reach = max(round(params.reach_s / float(times_s[1] - times_s[0])), 1)
    squares = np.zeros(len(times_s))
    counts = np.zeros(len(times_s))
    for joint in CORE:
        places_m = resample(track.times_s, track.joints_m[:, joint], times_s, LONGEST_GAP_S)
        before, after = _means(places_m, reach)
        apart = ((after - before) ** 2).sum(axis=1)
        known = np.isfinite(apart)
        squares[known] += apart[known]
        counts += known
    moved_m = np.sqrt(squares / np.maximum(counts, 1))
    moved_m[counts < len(CORE) / 2] = 0.0
    highest = maximum_filter1d(moved_m, 2 * reach + 1, mode="nearest")
    is_change = (moved_m >= params.least_m) & (moved_m == highest)
    # A flat top is one change, at its middle.
    middles = [(begin + end - 1) // 2 for begin, end in runs(is_change)]
    return np.asarray(times_s[middles])


def hidden_spans_s(
    track: SkeletonTrack, session_s: tuple[float, float], params: PostureParams | None = None
) -> list[tuple[float, float]]:
    """Return when the person was out of view, from the session's begin to its end."""
    params = params or PostureParams()
    seen = track.seen[:, MIDDLE].any(axis=1)
    at_s = track.times_s[seen]
    bounds = np.concatenate([[session_s[0]], at_s, [session_s[1]]])
    long = np.flatnonzero(np.diff(bounds) >= params.hidden_s)
    return [(float(bounds[k]), float(bounds[k + 1])) for k in long]


def _means(places_m: FloatArray, reach: int) -> tuple[FloatArray, FloatArray]:
    """Return the mean place of `reach` samples before and from each; NaN where most are unseen."""
    known = np.asarray(np.isfinite(places_m).all(axis=1))
    sums = np.zeros((len(places_m) + 1, 4))
    sums[1:, :3] = np.cumsum(np.where(known[:, None], places_m, 0.0), axis=0)
    sums[1:, 3] = np.cumsum(known)
    at = np.arange(len(places_m))
    means = []
    for begin, end in (
        (np.maximum(at - reach, 0), at),
        (at, np.minimum(at + reach, len(places_m))),
    ):
        part = sums[end] - sums[begin]
        enough = part[:, 3] >= reach / 2
        with np.errstate(invalid="ignore", divide="ignore"):
            means.append(np.where(enough[:, None], part[:, :3] / part[:, 3:], np.nan))
    return means[0], means[1]
