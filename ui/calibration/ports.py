"""The calibration screen as its presenter needs it. Knows nothing of Qt."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

from adibas.arrays import UInt8Array
from adibas.calibration.guidance import Guidance
from adibas.data.board import Board, BoardCorners
from adibas.pipeline.calibration_pictures import KeptPicture
from adibas.pipeline.calibration_watch import Moment
from adibas.pipeline.live_frames import LiveFrame, SensorState
from adibas.pipeline.sensor_calibration import SensorOutcome
from ui.reminders import Reminder


@dataclass(frozen=True, slots=True, eq=False)
class Shown:
    """What holds now.

    Attributes
    ----------
    board : Board
        That is held.
    pictures : tuple of KeptPicture
        Taken so far.
    guidance : Guidance or None
        What they lack; None before a sensor is seen.
    reminder : Reminder or None
        When the sensor was calibrated before; None where that is of no use.
    is_automatic : bool
        Pictures are taken when the board is still.
    is_offline : bool
        Saved pictures are used in place of the sensor.
    can_compute : bool
        There are pictures enough to try.
    is_busy : bool
        Something is being computed or written: wait.
    """

    board: Board
    pictures: tuple[KeptPicture, ...] = ()
    guidance: Guidance | None = None
    reminder: Reminder | None = None
    is_automatic: bool = True
    is_offline: bool = False
    can_compute: bool = False
    is_busy: bool = False


class CalibrationView(Protocol):
    """The screen, as its presenter needs it."""

    def show_session(self, shown: Shown) -> None:
        """Show what holds now; nothing of it is a wish of the user."""

    def show_sensor(self, state: SensorState) -> None:
        """Say how the sensor fares; without one there is no picture."""

    def show_frame(self, frame: LiveFrame, moment: Moment) -> None:
        """Show a live frame, the board in it, and what hinders."""

    def show_kept(self, color_rgb: UInt8Array, corners: BoardCorners) -> None:
        """Show a picture that was taken before."""

    def show_taken(self) -> None:
        """Show for a moment that a picture was taken."""

    def show_outcome(self, outcome: SensorOutcome | None, *, is_accepted: bool) -> None:
        """Show a result in place of the live picture; None: the live picture again."""

    def confirm(self, question: str, consent: str, act: Callable[[], None]) -> None:
        """Ask before something is thrown away; `consent` is what the button says that does it."""

    def beep(self) -> None:
        """Make a short sound."""
