"""Who wants to know, and who tells: observers without Qt, for one thread."""

from collections.abc import Callable
from typing import Generic, ParamSpec

Told = ParamSpec("Told")


class Event(Generic[Told]):
    """Calls everybody who subscribed, in their order.

    A subscriber is kept alive by its subscription; `subscribe` returns what ends it.
    """

    def __init__(self) -> None:
        self._subscribers: list[Callable[Told, None]] = []

    def subscribe(self, subscriber: Callable[Told, None]) -> Callable[[], None]:
        """Call `subscriber` from now on; calling what is returned ends that."""
        self._subscribers.append(subscriber)

        def end() -> None:
            if subscriber in self._subscribers:
                self._subscribers.remove(subscriber)

        return end

    def emit(self, *values: Told.args, **named: Told.kwargs) -> None:
        """Tell everybody; who subscribes meanwhile is told the next time."""
        for subscriber in tuple(self._subscribers):
            subscriber(*values, **named)
