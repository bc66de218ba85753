"""What comes of the pictures, and what is done with it. Knows nothing of Qt."""

from collections.abc import Callable
from pathlib import Path

from adibas.calibration.files import write_calibration
from adibas.data.calibration import RgbdCalibration
from adibas.pipeline.calibration_report import report_of_calibration
from adibas.pipeline.sensor_calibration import SensorOutcome
from adibas.reports.calibration import KINDS, write_calibration_report
from adibas.texts import spoken_language
from adibas.texts import translate as _
from ui.calibration.bench import Bench
from ui.calibration.ports import CalibrationView
from ui.ports import JobControl


class ResultPresenter:
    """Has the pictures fitted, shows the verdict, and lets a result be used that is good enough.

    Parameters
    ----------
    accepted : callable
        Called when a result is in use.

    Attributes
    ----------
    outcome : SensorOutcome or None
        That is shown; None while pictures are taken.
    """

    def __init__(self, view: CalibrationView, bench: Bench, accepted: Callable[[], None]) -> None:
        self._view = view
        self._bench = bench
        self._accepted = accepted
        self.outcome: SensorOutcome | None = None
        self._kept: RgbdCalibration | None = None

    @property
    def is_unsaved(self) -> bool:
        """Whether a calibration is good enough to be used, and neither in use nor in a file."""
        outcome = self.outcome
        is_good = outcome is not None and outcome.is_good_enough
        return is_good and outcome is not None and outcome.calibration is not self._kept

    def compute(self) -> None:
        """Fit and judge what was taken so far."""
        session, clock = self._bench.session, self._bench.clock
        if session is None or self._bench.is_busy:
            return

        def work(_control: JobControl) -> SensorOutcome:
            return session.outcome(clock)

        self._bench.start(_("Calculating the calibration"), work, self._on_outcome)

    def take_more(self) -> None:
        """Go back to the pictures."""
        self.outcome = None
        self._view.show_outcome(None, is_accepted=False)

    def accept(self) -> None:
        """Use the result from now on."""
        session, outcome, clock = self._bench.session, self.outcome, self._bench.clock
        if session is None or outcome is None or self._bench.is_busy:
            return

        def work(_control: JobControl) -> Path:
            return session.accept(outcome, clock)

        self._bench.start(_("Keeping the calibration"), work, self._on_accepted)

    def save(self, path: Path) -> None:
        """Write the result to a file, good or not."""
        calibration = None if self.outcome is None else self.outcome.calibration
        if calibration is None:
            return

        def work(_control: JobControl) -> Path:
            write_calibration(path, calibration)
            return path

        def done(path: Path) -> None:
            self._kept = calibration
            self._on_written(path)

        self._bench.workspace.jobs.start(_("Writing the calibration"), work, done)

    def report(self, path: Path) -> None:
        """Write a report in the window's language: a PDF, or a workbook by its name."""
        outcome, clock, language = self.outcome, self._bench.clock, spoken_language()
        if outcome is None:
            return
        if path.suffix.lower() not in KINDS:
            path = path.with_name(f"{path.name}.pdf")

        def work(_control: JobControl) -> Path:
            previous = None if outcome.previous is None else outcome.previous.calibration
            report = report_of_calibration(
                outcome.camera,
                outcome.calibration,
                language,
                depth=outcome.depth_report(),
                previous=previous,
                clock=clock,
            )
            write_calibration_report(report, path)
            return path

        self._bench.workspace.jobs.start(_("Writing the report"), work, self._on_written)

    def _on_written(self, path: Path) -> None:
        self._bench.workspace.tell("good", _("Written: {names}").format(names=path.name))

    def _on_outcome(self, outcome: SensorOutcome) -> None:
        self.outcome = outcome
        self._view.show_outcome(outcome, is_accepted=False)

    def _on_accepted(self, _path: Path) -> None:
        self._bench.session = None  # its pictures have served
        self._kept = None if self.outcome is None else self.outcome.calibration
        self._bench.workspace.tell("good", _("The new calibration is in use from now on."))
        self._view.show_outcome(self.outcome, is_accepted=True)
        self._accepted()
