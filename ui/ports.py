"""What presenters need of the window, without Qt."""

from collections.abc import Callable
from typing import Protocol, TypeVar

from adibas.errors import AdibasError

Result = TypeVar("Result")


class CancelledError(Exception):
    """The user stopped a job; whoever sees it cleans up and lets it pass."""


class JobControl(Protocol):
    """What a running job is given: how far it came goes out, the user's wish to stop comes in."""

    def progress(self, done: int, total: int) -> None:
        """Tell how far the job came (total 0: not known).

        Raises
        ------
        CancelledError
            The user stopped the job.
        """


class Job(Protocol):
    """A job that was started."""

    @property
    def is_running(self) -> bool: ...

    def cancel(self) -> None:
        """Ask it to stop at its next progress; nothing is told of it afterwards."""


class Jobs(Protocol):
    """Runs work beside the window; results come back to the window's own thread."""

    def start(
        self,
        label: str,
        work: Callable[[JobControl], Result],
        done: Callable[[Result], None],
        failed: Callable[[AdibasError], None] | None = None,
    ) -> Job:
        """Run `work` in a worker thread and give its result to `done` in the window's thread.

        Parameters
        ----------
        label : str
            What the user sees while it runs, already translated.
        failed : callable or None
            Told of an `AdibasError`; None: the window shows it. Anything else is a bug and goes
            to the crash report.
        """
        ...
