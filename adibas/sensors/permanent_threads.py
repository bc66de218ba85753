"""Threads that never end, for libraries that keep account of every thread that ever called them.

OpenNI2 remembers each caller and asks the system, at later calls, whether that thread still lives
(`pthread_kill` with signal 0). For a thread whose memory is given back or used again, glibc then
crashes, or waits for ever. Hence the threads that call it are lent out, and never end.
"""

import threading
from collections.abc import Callable
from concurrent.futures import Future, wait
from queue import SimpleQueue
from typing import Any, TypeVar

Answer = TypeVar("Answer")

THREAD_NAME = "camera library"
SLICE_S = 0.2


class PermanentThread:
    """Does one thing after the other for whoever asks; ends with the program alone."""

    def __init__(self) -> None:
        self._wishes: SimpleQueue[tuple[Callable[[], Any], Future[Any]]] = SimpleQueue()
        threading.Thread(target=self._run, name=THREAD_NAME, daemon=True).start()

    def begin(self, work: Callable[[], Answer]) -> "Future[Answer]":
        """Let `work` be done after what was wished before."""
        answer: Future[Answer] = Future()
        self._wishes.put((work, answer))
        return answer

    def call(self, work: Callable[[], Answer]) -> Answer:
        """Return what `work` returns, or raise what it raises."""
        return wait_for(self.begin(work))

    def _run(self) -> None:
        while True:
            work, answer = self._wishes.get()
            try:
                answer.set_result(work())
            except BaseException as error:  # noqa: BLE001  (raised again where it was wished)
                answer.set_exception(error)
            del work, answer  # they may hold a camera, which must be closed by then


def wait_for(answer: "Future[Answer]") -> Answer:
    """Return the answer, or raise what it raises; Ctrl-C ends the waiting.

    It waits in slices: on Windows Ctrl-C does not end a wait that has no end.
    """
    while not wait((answer,), SLICE_S).done:
        pass
    return answer.result()


class LentThreads:
    """Permanent threads, each lent to one borrower at a time."""

    def __init__(self) -> None:
        self._idle: list[PermanentThread] = []
        self._lock = threading.Lock()

    def borrow(self) -> PermanentThread:
        """Return a thread that nobody else has; a new one is made where none is idle."""
        with self._lock:
            return self._idle.pop() if self._idle else PermanentThread()

    def give_back(self, thread: PermanentThread) -> None:
        """Let others have the thread."""
        with self._lock:
            self._idle.append(thread)
