"""Gestures in live frames, watched person by person."""

from collections.abc import Sequence
from dataclasses import dataclass

from adibas.gestures.model import GestureModel
from adibas.gestures.watching import GestureWatcher, Seen, WatchParams
from adibas.pipeline.live_people import LiveMoment

MOST_PEOPLE = 8
"""Who is watched; whoever was seen longest ago is forgotten first."""


@dataclass(frozen=True, slots=True)
class LiveGesture:
    """What somebody did."""

    person: int
    seen: Seen


class LiveGestures:
    """Takes one moment after the other; for one thread at a time.

    Parameters
    ----------
    models : sequence of GestureModel
    """

    def __init__(self, models: Sequence[GestureModel]) -> None:
        self._models = tuple(models)
        self._params = WatchParams()
        self._watchers: dict[int, GestureWatcher] = {}
        self._run = 0

    def see(self, moment: LiveMoment) -> list[LiveGesture]:
        """Return what was recognised and was not told yet; another run is watched anew."""
        if moment.run != self._run:
            self._watchers.clear()
            self._run = moment.run
        found = []
        for one in moment.people:
            watcher = self._watchers.pop(one.person, None) or GestureWatcher(
                self._models, self._params
            )
            self._watchers[one.person] = watcher  # the last one in the dictionary: seen last
            upright_m = moment.turn.points(one.joints.joints_m)
            seen = watcher.see(moment.timestamp_ns, upright_m)
            found += [LiveGesture(one.person, gesture) for gesture in seen]
        while len(self._watchers) > MOST_PEOPLE:
            del self._watchers[next(iter(self._watchers))]
        return found
