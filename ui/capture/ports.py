"""The capture screen as its presenters need it. Knows nothing of Qt."""

from collections.abc import Callable
from typing import Protocol

from adibas.arrays import UInt8Array
from adibas.data.sessions import SessionSetup
from adibas.pipeline.live import LiveFrame, SensorState
from ui.capture.sources import SourceChoice


class CaptureView(Protocol):
    """The screen, as this presenter needs it."""

    def show_sources(self, choices: tuple[SourceChoice, ...], chosen: str) -> None:
        """Offer sources; `chosen` is the one in use."""

    def show_setup(self, setup: SessionSetup) -> None:
        """Show source, size and rotation in use."""

    def show_frame(self, frame: LiveFrame) -> None:
        """Show a live frame and all that is drawn over it."""

    def show_sensor(self, state: SensorState) -> None:
        """Say how the sensor fares."""

    def show_calibration_due(self, sentence: str) -> None:
        """Remind of a calibration; an empty sentence: none is due."""

    def show_disk(self, minutes: float | None) -> None:
        """Say how long the disk will hold; None where it cannot be told."""

    def show_views(self, view: str, taken: dict[str, UInt8Array | None]) -> None:
        """Mark the view that is next, and show those that were taken; a turn has no picture."""

    def show_readiness(self, sentence: str, *, is_ready: bool) -> None:
        """Say what lacks before a capture, and whether one can be taken."""

    def offer_consent(self, *, is_lacking: bool) -> None:
        """Offer the way to record a consent, where one lacks."""

    def show_countdown(self, seconds: int | None) -> None:
        """Show the seconds to go; None = no countdown."""

    def show_capturing(self, *, is_capturing: bool) -> None:
        """Show that a burst is being taken."""

    def beep(self) -> None:
        """Make a short sound."""

    def call_later(self, milliseconds: int, call: Callable[[], None]) -> None:
        """Call in the window's thread, later."""
