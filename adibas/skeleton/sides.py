"""Left stays left: what is known of which side a person shows, and of where the limbs were.

A forest that sees a back at times takes it for a front, and then both sides are exchanged. Where
the joints were a moment ago tells that a whole person cannot have turned; over seconds, or where
the view is declared, the side that is shown decides.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from adibas.arrays import FloatArray
from adibas.data.joint_proposals import JointProposals
from adibas.data.joints import JOINT_NAMES
from adibas.skeleton.proportions import MIRRORED

FRONT, BACK = "anterior", "posterior"
_STEADY = [
    k for k, name in enumerate(JOINT_NAMES) if name.startswith("left") and "hand" not in name
]
_TRUNK = [JOINT_NAMES.index(name) for name in ("left_shoulder", "left_hip")]


@dataclass(frozen=True, slots=True)
class SideParams:
    """When sides are exchanged.

    Attributes
    ----------
    margin_m : float
        By how much the way from the frame before must be shorter with the sides exchanged, mean
        over the joints that are seen: 0.05.
    most_m : float
        A way longer than this counts as this long: 0.4.
    memory_s : float
        How long places are kept that were not seen again: 0.7.
    patience_s : float
        Where the labels say for so long that the sides are exchanged, they are believed: 2.
    keep : float
        Share of what was known of front and back that stays from one frame to the next: 0.97.
    label_weight : float
        What the labels' own word counts in a frame, log odds: 0.05; forests expect fronts.
    most_odds : float
        Limit of the log odds of front against back: 5 (99.3 %).
    sure_odds : float
        Where they are beyond this, they decide which side is left: 3 (95 %).
    told_share : float
        From this probability on of front or back it is told to be sure: 0.85. Where no shape
        tells, the labels, which expect fronts, come to 0.84.
    wide_share : float
        Shoulders and hips that lie so far apart sideways, of their distance, tell front from
        back: 0.35.
    """

    margin_m: float = 0.05
    most_m: float = 0.4
    memory_s: float = 0.7
    patience_s: float = 2.0
    keep: float = 0.97
    label_weight: float = 0.05
    sure_odds: float = 3.0
    told_share: float = 0.85
    most_odds: float = 5.0
    wide_share: float = 0.35

    def is_sure(self, front_probability: float) -> bool:
        """Say whether front or back is known well enough to decide which side is left."""
        least = 1.0 / (1.0 + math.exp(-self.sure_odds))
        return max(front_probability, 1.0 - front_probability) >= least


class SideKeeper:
    """Exchanges left and right where the labels have exchanged them.

    Parameters
    ----------
    view : str
        ``anterior`` or ``posterior`` where the side that is shown is declared; else empty, and it
        is inferred.
    """

    def __init__(self, view: str = "", params: SideParams | None = None) -> None:
        self._params = params or SideParams()
        self._view = view if view in (FRONT, BACK) else ""
        self._odds = 0.0
        self._latest_m = np.full((len(JOINT_NAMES), 3), np.nan)
        self._latest_s = np.full(len(JOINT_NAMES), -math.inf)
        self._doubted_since_s = math.inf
        self.n_exchanged = 0

    @property
    def front_probability(self) -> float:
        """How probably the person shows the front; 1 or 0 where it was declared."""
        if self._view:
            return float(self._view == FRONT)
        return 1.0 / (1.0 + math.exp(-self._odds))

    def is_view_sure(self, joints_m: FloatArray) -> bool:
        """Say whether it is told to be sure which side is seen, and the joints (15, 3) lie so."""
        front = self.front_probability
        shown = sideways(joints_m, self._params.wide_share)
        agrees = not shown or (shown > 0) == (front > 0.5)  # noqa: PLR2004  (even odds)
        return agrees and max(front, 1.0 - front) >= self._params.told_share

    def is_exchanged(self, proposals: JointProposals, time_s: float, evidence: float = 0.0) -> bool:
        """Say whether left and right must be exchanged to be as before, or as the view says.

        `evidence` are the log odds of front against back that the shape tells in this frame. They
        count by how squarely the person is seen: limbs swing to both sides of who walks past.
        """
        params = self._params
        best_m = proposals.positions_m[:, 0]
        shown = sideways(best_m, params.wide_share)
        told = evidence * breadth(best_m) ** 2
        odds = params.keep * self._odds + told + params.label_weight * shown
        self._odds = float(np.clip(odds, -params.most_odds, params.most_odds))
        exchanged = self._is_exchanged(best_m, shown, time_s)
        self.n_exchanged += exchanged
        return exchanged

    def learn(self, joints_m: FloatArray, time_s: float) -> None:
        """Take in the joints (15, 3) that were chosen."""
        seen = np.isfinite(joints_m).all(axis=1)
        self._latest_m[seen] = joints_m[seen]
        self._latest_s[seen] = time_s

    def _is_exchanged(self, best_m: FloatArray, shown: float, time_s: float) -> bool:
        if shown and self._params.is_sure(self.front_probability):
            self._doubted_since_s = math.inf
            return (shown > 0) != (self.front_probability > 0.5)  # noqa: PLR2004  (even odds)
        says = self._says_exchanged(best_m, time_s)
        if not says:
            self._doubted_since_s = math.inf
            return False
        self._doubted_since_s = min(self._doubted_since_s, time_s)
        if time_s - self._doubted_since_s > self._params.patience_s:
            self._doubted_since_s = math.inf
            return False
        return True

    def _says_exchanged(self, best_m: FloatArray, time_s: float) -> bool:
        """Say whether the way from the places before is shorter with the sides exchanged."""
        params = self._params
        straight, crossed = [], []
        for left in _STEADY:
            right = MIRRORED[left]
            for now, other in ((left, right), (right, left)):
                if time_s - max(self._latest_s[now], self._latest_s[other]) > params.memory_s:
                    continue
                ways = [
                    float(np.linalg.norm(best_m[now] - self._latest_m[before]))
                    for before in (now, other)
                ]
                if np.isfinite(ways).all():
                    straight.append(min(ways[0], params.most_m))
                    crossed.append(min(ways[1], params.most_m))
        if len(straight) < 3:  # noqa: PLR2004  (one limb says little of the whole person)
            return False
        return float(np.mean(straight)) > float(np.mean(crossed)) + params.margin_m


def breadth(joints_m: FloatArray) -> float:
    """Return how squarely shoulders and hips are seen: 1 from the front or back, 0 from the side.

    The mean of their widths across the picture as shares of their distances; 0 where none is seen.
    """
    shares = [abs(across) / width for across, width in _widths(joints_m)]
    return float(np.mean(shares)) if shares else 0.0


def sideways(joints_m: FloatArray, wide_share: float) -> float:
    """Return 1 where the person shows the front by shoulders and hips, -1 the back, 0 unknown.

    Seen from the front the left side is at the image's right.
    """
    votes = 0.0
    for across_m, width_m in _widths(joints_m):
        if abs(across_m) > wide_share * width_m:
            votes += math.copysign(1.0, across_m)
    return float(np.sign(votes))


def _widths(joints_m: FloatArray) -> Iterator[tuple[float, float]]:
    """Yield how far to the picture's right the left one lies of shoulders and hips, and how far."""
    for left in _TRUNK:
        across_m = joints_m[left] - joints_m[MIRRORED[left]]
        width_m = float(np.linalg.norm(across_m))
        if np.isfinite(width_m) and width_m > 0:
            yield float(across_m[0]), width_m
