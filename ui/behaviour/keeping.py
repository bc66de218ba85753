"""Writes drafts in a thread of its own: a slow disk holds neither the video nor a key."""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from threading import Lock

from adibas.behaviour.editing import Draft, History
from adibas.errors import AdibasError
from adibas.pipeline.coding_drafts import DraftPlace
from adibas.pipeline.draft_history import write_history
from ui.behaviour.ports import Keeper


class DraftKeeper(Keeper):
    """One thread; of several drafts of one place that wait, the newest is written.

    Parameters
    ----------
    failed : callable
        Told in that thread what could not be written.
    """

    def __init__(self, failed: Callable[[AdibasError], None]) -> None:
        self._failed = failed
        self._pool = ThreadPoolExecutor(1, thread_name_prefix="drafts")
        self._lock = Lock()
        self._waiting: dict[DraftPlace, tuple[History[Draft], int]] = {}
        self._unwritten: set[DraftPlace] = set()

    def keep(self, place: DraftPlace, history: History[Draft], at_ms: int) -> None:
        """Write a draft and its steps as soon as it can be, in place of what still waits."""
        with self._lock:
            is_first = place not in self._waiting
            self._waiting[place] = (history, at_ms)
        if is_first:
            self._pool.submit(self._write, place)

    def flush(self) -> bool:
        """Wait until everything is on the disk; return whether it is."""
        return self._pool.submit(lambda: not self._unwritten).result()

    def close(self) -> None:
        """Flush, and keep no more."""
        self._pool.shutdown(wait=True)

    def _write(self, place: DraftPlace) -> None:
        with self._lock:
            history, at_ms = self._waiting.pop(place)
        try:
            write_history(place, history, at_ms)
        except AdibasError as error:
            self._unwritten.add(place)
            self._failed(error)
        else:
            self._unwritten.discard(place)
