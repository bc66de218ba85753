"""What presenters need of the window, without Qt."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Literal, Protocol, TypeVar

from adibas.errors import AdibasError
from ui.events import Event

if TYPE_CHECKING:  # they bring the compiler along, and the window does without at its start
    from adibas.data.board import Board
    from adibas.pipeline.live import LiveView
    from adibas.pipeline.live_frames import LiveFrame, Naming, SensorState
    from adibas.pipeline.posture import MarkerTarget
    from adibas.sensors.ports import SensorOptions

Result = TypeVar("Result")

Stop = Literal["drops", "tells", "never"]
"""What a stop makes of a job: what comes of it is dropped; told all the same, as far as it came;
or it cannot be stopped, since what it does cannot be undone."""


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
        """Ask it to stop at its next progress; what is told of it afterwards is its `Stop`."""


class Jobs(Protocol):
    """Runs work beside the window; results come back to the window's own thread."""

    def start(
        self,
        label: str,
        work: Callable[[JobControl], Result],
        done: Callable[[Result], None],
        failed: Callable[[AdibasError], None] | None = None,
        ended: Callable[[], None] | None = None,
        *,
        stop: Stop = "drops",
    ) -> Job:
        """Run `work` in a worker thread and give its result to `done` in the window's thread.

        Parameters
        ----------
        label : str
            What the user sees while it runs, already translated.
        failed : callable or None
            Told of an `AdibasError`; None: the window shows it. Anything else is a bug and goes
            to the crash report.
        ended : callable or None
            Told first when nothing runs any more, whatever came of it: also where the user
            stopped the job, and where it met a bug.
        stop : str
            ``drops``: after a stop only `ended` is told. ``tells``: `work` may catch the
            `CancelledError` and return what was done until then; it is told like any result.
            ``never``: nothing stops it, and its result is told.
        """
        ...


class LiveSource(Protocol):
    """The sensor as the window sees it; everything it tells arrives in the window's thread.

    Orders return at once and are followed in their order; a newer one replaces those that wait.
    What still comes of a source that was left is not told.
    """

    frame_arrived: "Event[[LiveFrame]]"
    state_changed: "Event[[SensorState]]"

    @property
    def newest(self) -> "LiveFrame | None":
        """The newest frame; None before the first and after the last."""

    @property
    def state(self) -> "SensorState":
        """What the source fares that was ordered last: ``opening`` from the order on."""

    @property
    def opened(self) -> "tuple[str, SensorOptions] | None":
        """What was opened last, also where it was closed since; None before the first."""

    @property
    def view(self) -> "LiveView":
        """The core behind it, for a job that captures from it."""

    def open(self, source: str, options: "SensorOptions") -> None: ...

    def set_target(self, target: "MarkerTarget | None") -> None: ...

    def set_naming(self, naming: "Naming | None") -> None: ...

    def set_rotation(self, rotation_deg: int) -> None: ...

    def set_board(self, board: "Board | None") -> None: ...

    def close(self) -> None:
        """Let go of the sensor; it can be opened anew."""

    def end(self) -> None:
        """Close, and wait until no thread is left."""
