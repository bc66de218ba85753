"""Joints smoothed over some frames, with a lag that is stated.

Each value is the middle of a line through the frames before and after it, weighted by confidence
and by nearness in time; frames that are far from the median of all are left out. The result of a
frame needs `lag_frames` later ones: at 30 frames a second 2 frames are 67 ms. With a lag of 0 the
line ends at the frame itself: causal, and noisier.
"""

from collections import deque
from dataclasses import dataclass, replace

import numpy as np

from adibas.arrays import BoolArray, FloatArray
from adibas.skeleton.following import ChosenJoints

LEAST_FRAMES = 3


@dataclass(frozen=True, slots=True)
class SmoothingParams:
    """How joints are smoothed.

    Attributes
    ----------
    lag_frames : int
        Later frames that are waited for: 2.
    past_frames : int
        Earlier ones that count: 2.
    reach_s : float
        Frames farther away in time do not count: 0.25.
    outlier_m : float
        A joint that is farther from the median of the frames around is left out: 0.15.
    gain : float
        How much of the speed the line keeps, 0 to 1: 1. Less damps noise and lags behind.
    """

    lag_frames: int = 2
    past_frames: int = 2
    reach_s: float = 0.25
    outlier_m: float = 0.15
    gain: float = 1.0


class Smoother:
    """Smooths the joints of one person as they come.

    `push` gives the frame `lag_frames` before the one put in, `finish` the rest.
    """

    def __init__(self, params: SmoothingParams | None = None) -> None:
        self._params = params or SmoothingParams()
        self._frames: deque[tuple[float, ChosenJoints]] = deque()
        self._n_given = 0
        self._n_dropped = 0

    def push(self, time_s: float, joints: ChosenJoints) -> tuple[float, ChosenJoints] | None:
        """Take in a frame; return the one that is ready."""
        self._frames.append((time_s, joints))
        n_here = self._n_dropped + len(self._frames)
        if n_here - self._n_given <= self._params.lag_frames:
            return None
        return self._next()

    def finish(self) -> list[tuple[float, ChosenJoints]]:
        """Return the frames that are left."""
        n_left = self._n_dropped + len(self._frames) - self._n_given
        return [self._next() for _ in range(n_left)]

    def _next(self) -> tuple[float, ChosenJoints]:
        params = self._params
        at = self._n_given - self._n_dropped
        first = max(0, at - params.past_frames)
        window = list(self._frames)[first : at + params.lag_frames + 1]
        smooth = smoothed(window, at - first, params)
        time_s = self._frames[at][0]
        self._n_given += 1
        while self._n_given - self._n_dropped > params.past_frames:
            self._frames.popleft()
            self._n_dropped += 1
        return time_s, smooth


def smoothed(
    window: list[tuple[float, ChosenJoints]], at: int, params: SmoothingParams
) -> ChosenJoints:
    """Return frame `at` of a window of frames and their times, smoothed; unseen stays unseen."""
    now_s, now = window[at]
    joints_m = np.stack([frame.joints_m for _, frame in window])
    weights = np.nan_to_num(np.stack([frame.confidence for _, frame in window]))
    since_s = np.array([time_s - now_s for time_s, _ in window])
    weights *= np.clip(1.0 - np.abs(since_s) / params.reach_s, 0.0, 1.0)[:, None]
    seen = np.isfinite(joints_m[..., 0]) & (weights > 0)
    result_m, confidence = now.joints_m.copy(), now.confidence.copy()
    for joint in np.flatnonzero(seen[at]):
        use = seen[:, joint]
        use &= _is_near(joints_m[:, joint], use, params.outlier_m)
        if use.sum() < LEAST_FRAMES:
            continue
        if not use[at]:
            confidence[joint] *= 0.5
        result_m[joint] = _line_at_zero(
            since_s[use], joints_m[use, joint], weights[use, joint], params.gain
        )
    return replace(now, joints_m=result_m, confidence=confidence)


def _is_near(places_m: FloatArray, use: BoolArray, outlier_m: float) -> BoolArray:
    """Say which places are near the median of those that count."""
    if use.sum() < LEAST_FRAMES:
        return use
    median_m = np.median(places_m[use], axis=0)
    with np.errstate(invalid="ignore"):
        return np.asarray(np.linalg.norm(places_m - median_m, axis=1) <= outlier_m)


def _line_at_zero(
    since_s: FloatArray, places_m: FloatArray, weights: FloatArray, gain: float
) -> FloatArray:
    """Return where a weighted line through the places is at time 0."""
    total = weights.sum()
    mean_s = float(weights @ since_s / total)
    mean_m = weights @ places_m / total
    spread = float(weights @ (since_s - mean_s) ** 2)
    if spread <= 0.0:
        return np.asarray(mean_m)
    slope = (weights * (since_s - mean_s)) @ places_m / spread
    return np.asarray(mean_m - gain * mean_s * slope)
