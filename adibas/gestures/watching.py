"""Gestures in joints that come one frame after the other: each is told once, soon after its end.

The last seconds are kept, described and searched anew twice a second, by the same code that
searches a whole recording; memory and time a frame do not depend on how long somebody is watched.
"""

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from adibas.arrays import FloatArray
from adibas.clock import NS_PER_S
from adibas.data.skeleton_track import SkeletonTrack
from adibas.gestures.descriptor import NECK
from adibas.gestures.model import GestureModel, described_for

FEWEST = 8
"""Frames from which on anything is looked for."""


@dataclass(frozen=True, slots=True)
class WatchParams:
    """How somebody is watched.

    Attributes
    ----------
    keep_s : float
        So much of the past is searched: 12, twice the longest gesture of ours and the 3 s over
        which the facing direction is averaged.
    every_s : float
        How often: 0.5.
    settled_s : float
        A gesture is told when it ended so long ago: 0.5, what comes next may be a better end.
    anew_s : float
        A clock that jumps by more, either way, begins anew: 2.
    """

    keep_s: float = 12.0
    every_s: float = 0.5
    settled_s: float = 0.5
    anew_s: float = 2.0


@dataclass(frozen=True, slots=True)
class Seen:
    """A gesture that was recognised, on the clock of the frames."""

    label: str
    begin_s: float
    end_s: float
    cost: float


class GestureWatcher:
    """Watches one person; for one thread at a time.

    Parameters
    ----------
    models : sequence of GestureModel
    params : WatchParams, optional
    """

    def __init__(self, models: Sequence[GestureModel], params: WatchParams | None = None) -> None:
        self._models = tuple(models)
        self._params = params or WatchParams()
        self._frames: deque[tuple[int, FloatArray]] = deque()
        self._told_until_s = [-np.inf] * len(self._models)
        self._looked_s = -np.inf

    def see(self, timestamp_ns: int, joints_m: FloatArray) -> list[Seen]:
        """Take the next frame and return what was done up to now and was not told yet.

        Parameters
        ----------
        timestamp_ns : int
            A frame that is not later than the one before is left out.
        joints_m : (15, 3) array
            In the order of `JOINT_NAMES`; NaN where a joint was not seen.
        """
        step_s = (timestamp_ns - self._frames[-1][0]) / NS_PER_S if self._frames else 0.0
        if abs(step_s) > self._params.anew_s:
            self._begin_anew()
        elif self._frames and step_s <= 0:
            return []
        self._frames.append((timestamp_ns, np.array(joints_m, np.float64)))
        while timestamp_ns - self._frames[0][0] > self._params.keep_s * NS_PER_S:
            self._frames.popleft()
        now_s = timestamp_ns / NS_PER_S
        if now_s - self._looked_s < self._params.every_s or len(self._frames) < FEWEST:
            return []
        self._looked_s = now_s
        return self._new(now_s)

    def _begin_anew(self) -> None:
        self._frames.clear()
        self._told_until_s = [-np.inf] * len(self._models)
        self._looked_s = -np.inf

    def _new(self, now_s: float) -> list[Seen]:
        joints_m = np.stack([joints for _time, joints in self._frames])
        track = SkeletonTrack(
            np.array([time_ns for time_ns, _joints in self._frames], np.int64),
            joints_m,
            np.where(np.isfinite(joints_m).all(axis=2), 1.0, np.nan),
        )
        if not track.seen[:, NECK].any():
            return []
        found = []
        for number, (model, described) in enumerate(described_for(self._models, track)):
            for one in model.detect(described):
                begin_s, end_s = described.time_s(one.begin), described.time_s(one.end)
                is_new = begin_s >= self._told_until_s[number]
                if is_new and end_s <= now_s - self._params.settled_s:
                    self._told_until_s[number] = end_s
                    found.append(Seen(model.labels[one.label], begin_s, end_s, one.cost))
        return sorted(found, key=lambda one: one.begin_s)
