"""One place between two threads that holds the newest thing only."""

import threading
from typing import Generic, TypeVar

Thing = TypeVar("Thing")


class Newest(Generic[Thing]):
    """Who puts never waits; who takes gets the newest thing, and misses those before it."""

    def __init__(self) -> None:
        self._changed = threading.Condition()
        self._thing: Thing | None = None
        self._is_closed = False

    def put(self, thing: Thing) -> None:
        """Replace what is there."""
        with self._changed:
            self._thing = thing
            self._changed.notify()

    def take(self) -> Thing | None:
        """Wait for a thing that was not taken yet; None once the place is closed."""
        with self._changed:
            self._changed.wait_for(lambda: self._is_closed or self._thing is not None)
            thing, self._thing = self._thing, None
            return None if self._is_closed else thing

    def close(self) -> None:
        """Let nobody wait any more."""
        with self._changed:
            self._is_closed = True
            self._changed.notify_all()
