"""Long calls run in worker threads; what they tell arrives in the window's thread."""

import sys
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from threading import Event as ThreadEvent
from threading import Lock
from typing import Any

from PySide6.QtCore import QObject, Qt, Signal

from adibas.errors import AdibasError
from ui.events import Event
from ui.ports import CancelledError, Job, JobControl, Result, Stop

N_WORKERS = 2


@dataclass(frozen=True, slots=True)
class _Handlers:
    """Who is told what came of a job."""

    done: Callable[[Any], None]
    failed: Callable[[AdibasError], None]
    ended: Callable[[], None] | None


@dataclass(eq=False)
class ThreadJob(JobControl, Job):
    """One job: its thread asks it whether to go on, the window whether it still runs."""

    label: str
    stop: Stop
    _tell: Callable[["ThreadJob", str, object], None]
    _stop: ThreadEvent = field(default_factory=ThreadEvent)
    _is_running: bool = True
    _lock: Lock = field(default_factory=Lock)
    _reached: tuple[int, int] | None = None

    def progress(self, done: int, total: int) -> None:
        if self._stop.is_set():
            raise CancelledError
        with self._lock:
            was_taken = self._reached is None
            self._reached = done, total
        if was_taken:  # a job of thousands of steps does not flood the window
            self._tell(self, "progress", None)

    def take_progress(self) -> tuple[int, int]:
        """Return how far the job came; it tells of its next step again."""
        with self._lock:
            reached, self._reached = self._reached, None
        return reached or (0, 0)

    @property
    def is_running(self) -> bool:
        return self._is_running

    @property
    def is_cancelled(self) -> bool:
        """Whether the user asked it to stop."""
        return self._stop.is_set()

    @property
    def is_dropped(self) -> bool:
        """Whether nobody wants to know what came of it."""
        return self.is_cancelled and self.stop == "drops"

    def cancel(self) -> None:
        if self.stop != "never":
            self._stop.set()

    def end(self) -> None:
        """Note that nothing more will come."""
        self._is_running = False


class JobRunner(QObject):
    """Two worker threads, and a queue into the window's thread.

    Events
    ------
    changed(job, done, total)
        A job started, came further, or ended (`job.is_running`).
    """

    _told = Signal(object, str, object)

    def __init__(
        self, problem: Callable[[AdibasError], None], parent: QObject | None = None
    ) -> None:
        super().__init__(parent)
        self.changed: Event[[ThreadJob, int, int]] = Event()
        self._problem = problem
        self._pool = ThreadPoolExecutor(N_WORKERS, thread_name_prefix="job")
        self._handlers: dict[ThreadJob, _Handlers] = {}
        self._told.connect(self._on_told, Qt.ConnectionType.QueuedConnection)

    def start(
        self,
        label: str,
        work: Callable[[JobControl], Result],
        done: Callable[[Result], None],
        failed: Callable[[AdibasError], None] | None = None,
        ended: Callable[[], None] | None = None,
        *,
        stop: Stop = "drops",
    ) -> ThreadJob:
        """Run `work` in a worker thread and give its result to `done` in the window's thread."""
        job = ThreadJob(label, stop, self._told.emit)
        self._handlers[job] = _Handlers(done, failed or self._problem, ended)
        self._pool.submit(self._run, job, work)
        self.changed.emit(job, 0, 0)
        return job

    @property
    def is_busy(self) -> bool:
        """Whether any job runs."""
        return bool(self._handlers)

    @property
    def labels(self) -> tuple[str, ...]:
        """What runs, as the user reads it; what began first comes first."""
        return tuple(job.label for job in self._handlers)

    def cancel_all(self) -> None:
        """Ask everything that runs to stop."""
        for job in self._handlers:
            job.cancel()

    def close(self) -> None:
        """Cancel what runs and wait for it; nothing is told any more."""
        self.cancel_all()
        self._pool.shutdown(wait=True, cancel_futures=True)
        self._handlers.clear()

    def _run(self, job: ThreadJob, work: Callable[[JobControl], object]) -> None:
        try:
            job.progress(0, 0)
            result = work(job)
        except CancelledError:
            self._told.emit(job, "cancelled", None)
        except AdibasError as error:
            self._told.emit(job, "failed", error)
        except BaseException as error:  # noqa: BLE001  (raised again in the window's thread)
            self._told.emit(job, "crashed", error)
        else:
            self._told.emit(job, "done", result)

    def _on_told(self, job: ThreadJob, what: str, value: Any) -> None:
        if job not in self._handlers:
            return
        if what == "progress":
            self.changed.emit(job, *job.take_progress())
            return
        told = self._handlers.pop(job)
        job.end()
        self.changed.emit(job, 0, 0)
        if told.ended is not None:
            told.ended()
        if what == "crashed":
            sys.excepthook(type(value), value, value.__traceback__)
        elif what == "failed" and not job.is_dropped:
            told.failed(value)
        elif what == "done" and not job.is_dropped:
            told.done(value)
