"""From which side somebody is seen who turns: the declared view holds at the beginning.

A Kalman filter (Kalman 1960) of heading and turning rate, which changes by white noise. It takes in
the headings that named frames tell, and how the points turn about the vertical from frame to frame,
whatever they are called. Where it is not known any more how far somebody has turned, the view is
not known either; who is seen by too few points to tell, and did not turn, is taken to stay.
"""

import math
from dataclasses import dataclass

import numpy as np

from adibas.arrays import FloatArray
from adibas.skeleton.labelling import Labelling
from adibas.skeleton.starts import HEADINGS_RAD, SPACE

SQUARE_RAD = math.radians(35.0)
"""Farther from a view than this nothing was learned of bodies."""
KNOWN_SD_RAD = math.radians(30.0)
"""A heading that is less sure than this tells no view."""
DECLARED_SD_RAD, RATE_SD_RAD_S = math.radians(15.0), math.radians(60.0)
"""Of somebody at the beginning."""
RATE_CHANGE = math.radians(120.0)
"""How much the rate changes in a second, standard deviation, radians per second."""
LEAST_NAMES, LEAST_SHARE = 4, 0.5
"""A frame with fewer names tells no heading."""
TOLD_SD_RAD = math.radians(40.0)
"""Of the heading that names tell, by the square root of how many of them there are."""
LEAST_TURNED = 3
"""Fewer points tell no turn."""
LEAST_WIDE_M2, LEAST_TURN_RAD = 0.05, math.radians(0.5)
"""Of squared ways to the middle, and of what a turn from frame to frame is off at least."""
STAYS_RAD_S = math.radians(30.0)
"""Who turned more slowly, and is seen by too few points to tell, is taken to stay as he was."""
GATE = 3.0
"""A heading so many standard deviations from the expected one is not believed."""


class FollowedView:
    """Which side is seen, frame by frame.

    Parameters
    ----------
    view : str
        As declared for the first frame; empty: not known, and it never is.
    """

    def __init__(self, view: str) -> None:
        self._is_declared = bool(view)
        self._state = np.array([HEADINGS_RAD.get(view, math.nan), 0.0])
        self._covariance = np.diag([DECLARED_SD_RAD**2, RATE_SD_RAD_S**2])
        self._time_s, self._passed_s = math.nan, 0.0
        self._is_told = False

    @property
    def view(self) -> str:
        """Return the view that is seen; empty where it is not known."""
        if not self._is_declared or self._covariance[0, 0] > KNOWN_SD_RAD**2:
            return ""
        return nearest_view(float(self._state[0]))

    @property
    def is_square(self) -> bool:
        """Say whether the view is known and seen squarely enough."""
        view = self.view
        return bool(view) and off_view_rad(float(self._state[0]), view) < SQUARE_RAD

    def go_to(self, time_s: float) -> None:
        """Expect what is seen at a later time."""
        passed_s = 0.0 if math.isnan(self._time_s) else time_s - self._time_s
        self._time_s, self._passed_s = time_s, passed_s
        is_told, self._is_told = self._is_told, False
        if not is_told and abs(self._state[1]) < STAYS_RAD_S:
            return
        onward = np.array([[1.0, passed_s], [0.0, 1.0]])
        self._state = onward @ self._state
        noise = np.array([[passed_s**3 / 3.0, passed_s**2 / 2.0], [passed_s**2 / 2.0, passed_s]])
        self._covariance = onward @ self._covariance @ onward.T + RATE_CHANGE**2 * noise

    def learn(self, labelling: Labelling) -> None:
        """Take in the heading that the names of this frame tell, if they do."""
        n_named = sum(name is not None for name in labelling.names)
        tells = n_named >= max(LEAST_NAMES, LEAST_SHARE * len(labelling.names))
        if not self._is_declared or not tells or math.isnan(labelling.heading_rad):
            return
        off_rad = math.remainder(labelling.heading_rad - self._state[0], 2.0 * math.pi)
        variance = TOLD_SD_RAD**2 / n_named
        if off_rad**2 < GATE**2 * (self._covariance[0, 0] + variance):
            self._correct(0, off_rad, variance)

    def turn(self, before_m: FloatArray, points_m: FloatArray) -> None:
        """Take in where the (M, D) points of this frame were in the one before; NaN: unknown."""
        turn = turn_about_vertical(before_m, points_m)
        if turn is not None and self._passed_s > 0.0:
            off_rad_s = turn.angle_rad / self._passed_s - self._state[1]
            self._correct(1, off_rad_s, turn.variance / self._passed_s**2)

    def _correct(self, which: int, off: float, variance: float) -> None:
        """Take in a measurement of heading (0) or rate (1) that is so far from the expected one."""
        self._is_told = True
        gain = self._covariance[:, which] / (self._covariance[which, which] + variance)
        self._state = self._state + gain * off
        self._covariance = self._covariance - np.outer(gain, self._covariance[which])


@dataclass(frozen=True, slots=True)
class Turn:
    """How far points turned about the vertical, and the variance of that (rad^2)."""

    angle_rad: float
    variance: float


def turn_about_vertical(before_m: FloatArray, points_m: FloatArray) -> Turn | None:
    """Return how far points turned; None in a plane, and where fewer than three were seen before.

    The turn that lays the places before onto the others best, and its error by what is left (Kabsch
    1976, in the plane of the floor). Positive: as headings grow.

    Parameters
    ----------
    before_m, points_m : (M, D) arrays
        Upright, y down; NaN where one was not seen before.
    """
    was_seen = ~np.isnan(before_m).any(axis=1)
    if before_m.shape[1] != SPACE or was_seen.sum() < LEAST_TURNED:
        return None
    before, after = (one[was_seen][:, [0, 2]] for one in (before_m, points_m))
    before, after = (one - one.mean(axis=0) for one in (before, after))
    across = float((before[:, 1] * after[:, 0] - before[:, 0] * after[:, 1]).sum())
    along = float((before * after).sum())
    wide_m2 = float((before**2).sum())
    left_m2 = float((after**2).sum()) + wide_m2 - 2.0 * math.hypot(across, along)
    n_free = 2 * int(was_seen.sum()) - 3
    variance = max(left_m2, 0.0) / n_free / max(wide_m2, LEAST_WIDE_M2) + LEAST_TURN_RAD**2
    return Turn(math.atan2(across, along), variance)


def nearest_view(heading_rad: float) -> str:
    """Return the view that a heading is nearest to."""
    return min(HEADINGS_RAD, key=lambda view: off_view_rad(heading_rad, view))


def off_view_rad(heading_rad: float, view: str) -> float:
    """Return how far a heading is from that of a view, 0 to pi."""
    return abs(math.remainder(heading_rad - HEADINGS_RAD[view], 2.0 * math.pi))
