"""Reminds of a sensor that should be calibrated. Knows nothing of Qt."""

from adibas.calibration.kept import KeptCalibrations
from adibas.clock import Clock, utc_now
from adibas.pipeline.live_frames import SensorState
from adibas.sensors.sources import is_sensor
from ui.capture.ports import CaptureView
from ui.reminders import remind
from ui.workspace import Workspace


class CalibrationAge:
    """Tells when the sensor that is shown was never calibrated, or long ago.

    Recordings bring the calibration that they were made with, and the simulator its own.

    Parameters
    ----------
    kept : KeptCalibrations or None
        None: those of this user.
    clock : callable
        Tells the time.
    """

    def __init__(
        self,
        view: CaptureView,
        workspace: Workspace,
        kept: KeptCalibrations | None = None,
        clock: Clock = utc_now,
    ) -> None:
        self._view = view
        self._workspace = workspace
        self._kept = kept or KeptCalibrations()
        self._clock = clock

    def show(self, state: SensorState) -> None:
        """Say what is due, or nothing."""
        live, info = self._workspace.live, state.info
        if state.kind != "live" or info is None or live.opened is None:
            return
        if not is_sensor(live.opened[0]):
            self._view.show_calibration_due("")
            return
        allowed_days = self._workspace.preferences.now.calibration_days
        reminder = remind(self._kept, info, self._clock(), allowed_days)
        self._view.show_calibration_due(reminder.text if reminder.is_urgent else "")

    def calibrate(self) -> None:
        """Go to the calibration."""
        self._workspace.show_screen("calibration")
