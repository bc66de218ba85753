"""Who is who: people keep their numbers while they cross and while they are hidden for a moment."""

from dataclasses import dataclass, field

import numpy as np
from scipy.optimize import linear_sum_assignment

from adibas.arrays import FloatArray

IMPOSSIBLE = 1e3


@dataclass(frozen=True, slots=True)
class IdentityParams:
    """When somebody seen now is somebody seen before.

    Attributes
    ----------
    memory_s : float
        How long somebody is remembered who is not seen: 2.
    near_m : float
        Way to the place expected that is always possible: 0.35.
    speed_m_s : float
        Added to it for each second not seen: 1.
    most_m : float
        Limit of both: 1.2.
    size_weight : float
        How much a metre of difference in height counts beside a metre of way: 1.
    damping_s : float
        Time in which an unseen person's speed is taken to fade: 0.7.
    """

    memory_s: float = 2.0
    near_m: float = 0.35
    speed_m_s: float = 1.0
    most_m: float = 1.2
    size_weight: float = 1.0
    damping_s: float = 0.7


@dataclass(slots=True)
class _Known:
    person: int
    place_m: FloatArray
    top_m: float
    seen_s: float
    speed_m_s: FloatArray = field(default_factory=lambda: np.zeros(3))

    def expected_m(self, time_s: float, damping_s: float) -> FloatArray:
        since_s = time_s - self.seen_s
        coasted_s = damping_s * (1.0 - np.exp(-since_s / damping_s))
        return np.asarray(self.place_m + coasted_s * self.speed_m_s)


class Identities:
    """Gives numbers to people, 1, 2, ..., the same one as long as they are in view."""

    def __init__(self, params: IdentityParams | None = None) -> None:
        self._params = params or IdentityParams()
        self._known: list[_Known] = []
        self._n_people = 0

    def match(self, places_m: FloatArray, tops_m: FloatArray, time_s: float) -> list[int]:
        """Return the number of each person seen.

        Parameters
        ----------
        places_m : (N, 3) array
            Middle of each person, metres.
        tops_m : (N,) array
            How high each reaches, metres, from anywhere; NaN where the picture cuts somebody off,
            who then is told by the place alone.
        """
        params = self._params
        self._known = [one for one in self._known if time_s - one.seen_s <= params.memory_s]
        numbers = [0] * len(places_m)
        costs = self._costs(places_m, tops_m, time_s)
        rows, columns = linear_sum_assignment(costs)
        for row, column in zip(rows.tolist(), columns.tolist(), strict=True):
            known = self._known[column]
            if costs[row, column] < IMPOSSIBLE:
                numbers[row] = known.person
                self._update(known, places_m[row], float(tops_m[row]), time_s)
        for row in range(len(numbers)):
            if numbers[row] == 0:
                self._n_people += 1
                numbers[row] = self._n_people
                place_m, top_m = np.array(places_m[row], float), float(tops_m[row])
                self._known.append(_Known(self._n_people, place_m, top_m, time_s))
        return numbers

    def _costs(self, places_m: FloatArray, tops_m: FloatArray, time_s: float) -> FloatArray:
        costs = np.empty((len(places_m), len(self._known)))
        for column, known in enumerate(self._known):
            expected_m = known.expected_m(time_s, self._params.damping_s)
            # Across the floor: who is hidden below has another middle, but stands where he stood.
            ways_m = np.linalg.norm((places_m - expected_m)[:, [0, 2]], axis=1)
            higher_m = np.nan_to_num(np.abs(tops_m - known.top_m))
            cost = ways_m + self._params.size_weight * np.minimum(higher_m, 0.3)
            # What cannot be must not push another pair apart.
            costs[:, column] = np.where(cost < self._reach_m(known, time_s), cost, IMPOSSIBLE)
        return costs

    def _reach_m(self, known: _Known, time_s: float) -> float:
        params = self._params
        return min(params.near_m + params.speed_m_s * (time_s - known.seen_s), params.most_m)

    def _update(self, known: _Known, place_m: FloatArray, top_m: float, time_s: float) -> None:
        since_s = time_s - known.seen_s
        if since_s > 0:
            speed = (place_m - known.place_m) / since_s
            known.speed_m_s = 0.7 * known.speed_m_s + 0.3 * speed
        known.place_m, known.seen_s = np.array(place_m, float), time_s
        if not np.isnan(top_m):
            before_m = top_m if np.isnan(known.top_m) else known.top_m
            known.top_m = 0.8 * before_m + 0.2 * top_m
