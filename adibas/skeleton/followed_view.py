"""From which side somebody is seen who turns: the declared view holds at the beginning."""

import math

from adibas.skeleton.labelling import Labelling
from adibas.skeleton.starts import HEADINGS_RAD

SQUARE_RAD = math.radians(35.0)
"""Farther from a view than this nothing was learned of bodies."""
LEAST_NAMES, LEAST_SHARE = 6, 0.5
"""A frame with fewer names tells no heading."""
SETTLED_S = 0.2
"""Time in which two thirds of a turn are believed."""


class FollowedView:
    """Which side is seen, frame by frame.

    Parameters
    ----------
    view : str
        As declared for the first frame; empty: not known, and it never is.
    """

    def __init__(self, view: str) -> None:
        self.view = view
        self._heading_rad = HEADINGS_RAD.get(view, math.nan)
        self._told_s = math.nan

    @property
    def is_square(self) -> bool:
        """Say whether the view is known and seen squarely enough."""
        if not self.view:
            return False
        return abs(_turn_rad(HEADINGS_RAD[self.view], self._heading_rad)) < SQUARE_RAD

    def learn(self, labelling: Labelling, time_s: float) -> None:
        """Go on to the heading that a frame's names tell, if they do."""
        n_named = sum(name is not None for name in labelling.names)
        tells = n_named >= max(LEAST_NAMES, LEAST_SHARE * len(labelling.names))
        if not self.view or not tells or math.isnan(labelling.heading_rad):
            return
        passed_s = 0.0 if math.isnan(self._told_s) else time_s - self._told_s
        believed = 1.0 - math.exp(-passed_s / SETTLED_S)
        self._told_s = time_s
        self._heading_rad += believed * _turn_rad(self._heading_rad, labelling.heading_rad)
        self.view = min(
            HEADINGS_RAD, key=lambda view: abs(_turn_rad(HEADINGS_RAD[view], self._heading_rad))
        )


def _turn_rad(before_rad: float, after_rad: float) -> float:
    """Return the way from one heading to another, within half a turn."""
    return math.remainder(after_rad - before_rad, 2.0 * math.pi)
