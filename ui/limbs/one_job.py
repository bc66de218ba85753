"""One thing at a time beside the window: the desk is for one thread. Without Qt."""

from collections.abc import Callable

from ui.ports import JobControl, Jobs, Result


class OneJob:
    """Starts nothing while something runs, and shows nothing after it was closed.

    Parameters
    ----------
    jobs : Jobs
    changed : callable
        Told when something begins or ends.
    """

    def __init__(self, jobs: Jobs, changed: Callable[[], None]) -> None:
        self._jobs, self._changed = jobs, changed
        self._is_closed = False
        self.is_running = False

    def start(
        self,
        label: str,
        work: Callable[[JobControl], Result],
        done: Callable[[Result], None],
        too_late: Callable[[Result], None] = lambda _found: None,
    ) -> None:
        """Do the work; `done` takes what it returns, `too_late` once all is closed."""
        if self.is_running:
            return
        self.is_running = True
        self._changed()

        def shown(found: Result) -> None:
            (too_late if self._is_closed else done)(found)

        self._jobs.start(label, work, shown, ended=self._on_ended)

    def close(self) -> None:
        """Show nothing any more."""
        self._is_closed = True

    def _on_ended(self) -> None:
        if self._is_closed:
            return
        self.is_running = False
        self._changed()
