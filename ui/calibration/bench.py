"""The session that is worked on, and one thing at a time that is done with it. No Qt."""

from collections.abc import Callable

from adibas.calibration.kept import KeptCalibrations
from adibas.clock import Clock
from adibas.pipeline.calibration_session import CalibrationSession
from ui.ports import Job, JobControl, Result
from ui.workspace import Workspace


class Bench:
    """What the presenters of the screen share.

    Parameters
    ----------
    changed : callable
        Called when something begins or ends.

    Attributes
    ----------
    session : CalibrationSession or None
        None before a sensor is seen.
    """

    def __init__(
        self,
        workspace: Workspace,
        kept: KeptCalibrations,
        clock: Clock,
        changed: Callable[[], None],
    ) -> None:
        self.workspace = workspace
        self.kept = kept
        self.clock = clock
        self.session: CalibrationSession | None = None
        self._changed = changed
        self._job: Job | None = None

    @property
    def is_busy(self) -> bool:
        """Whether something is being done."""
        return self._job is not None and self._job.is_running

    def start(
        self, label: str, work: Callable[[JobControl], Result], done: Callable[[Result], None]
    ) -> None:
        """Do something that takes a while; nothing else may be under way."""
        self._job = self.workspace.jobs.start(label, work, done, ended=self._on_ended)
        self._changed()

    def _on_ended(self) -> None:
        self._job = None
        self._changed()
