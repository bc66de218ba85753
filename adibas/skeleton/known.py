"""What is known of points beside their places, when they are named by core and limbs."""

from dataclasses import dataclass

import numpy as np

from adibas.arrays import FloatArray, IntArray
from adibas.skeleton.seen_space import EVERYWHERE, SeenSpace


@dataclass(frozen=True, slots=True, eq=False)
class Known:
    """What is known of M points beside their places.

    Attributes
    ----------
    size_odds : (M,) array
        See `adibas.skeleton.sizes.size_log_odds`.
    given : (M,) int array
        See `adibas.skeleton.given_names.given_index`.
    seen : SeenSpace
        By the cameras, in the axes of the points.
    body_odds : (M, N) array or None
        See `adibas.skeleton.body_marks.BodyOdds`; None: no body was looked for.
    """

    size_odds: FloatArray
    given: IntArray
    seen: SeenSpace = EVERYWHERE
    body_odds: FloatArray | None = None

    @property
    def tells(self) -> bool:
        """Say whether anything but places tells a marker from a chance spot."""
        return self.body_odds is not None or bool(self.size_odds.any())

    def size_odds_of(self, partners: IntArray) -> FloatArray:
        """Return the (P,) log odds by size of (P, N) ways to name: each name's point, or -1."""
        return np.asarray(np.append(self.size_odds, 0.0)[partners].sum(axis=1))

    def label_odds(self, n_names: int) -> FloatArray:
        """Return the (M, N) log odds by where the body is; 0 where no body was looked for."""
        if self.body_odds is None:
            return np.zeros((len(self.size_odds), n_names))
        return np.ascontiguousarray(self.body_odds)

    def body_odds_of(self, partners: IntArray) -> FloatArray:
        """Return the (P,) log odds by where the body is of (P, N) ways."""
        if self.body_odds is None:
            return np.zeros(len(partners))
        of_points = np.vstack([self.body_odds, np.zeros(partners.shape[1])])
        return np.asarray(of_points[partners, np.arange(partners.shape[1])].sum(axis=1))

    def weighed(self, masses: FloatArray) -> FloatArray:
        """Return the (M, N + 1) probabilities of names, given also this; the last: of no name."""
        log_odds = np.broadcast_to(self.size_odds[:, None], masses[:, :-1].shape)
        if self.body_odds is not None:
            log_odds = log_odds + self.body_odds
        weighed = masses.copy()
        weighed[:, :-1] *= np.exp(log_odds)
        return np.asarray(weighed / weighed.sum(axis=1, keepdims=True))
