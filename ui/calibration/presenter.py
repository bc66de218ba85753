"""What the calibration screen shows, and when. Knows nothing of Qt."""

from collections.abc import Callable, Sequence
from pathlib import Path

from adibas.arrays import UInt8Array
from adibas.calibration.kept import KeptCalibrations
from adibas.clock import Clock, utc_now
from adibas.data.board import Board
from adibas.data.frames import SourceInfo
from adibas.data.printed_boards import PRINTED_BOARDS
from adibas.pipeline.calibration_images import RefusedImage, images_in
from adibas.pipeline.calibration_pictures import KeptPicture
from adibas.pipeline.calibration_session import CalibrationSession
from adibas.pipeline.calibration_watch import Moment
from adibas.pipeline.learning import read_picture
from adibas.pipeline.live_frames import LiveFrame, SensorState
from adibas.pipeline.sensor_calibration import CalibratedSensor, sensor_of
from adibas.texts import translate as _
from adibas.texts import translate_plural
from ui.calibration.bench import Bench
from ui.calibration.ports import CalibrationView, Shown
from ui.calibration.result_presenter import ResultPresenter
from ui.calibration.sources import SIMULATED_BOARD, source_to_calibrate, usual_source
from ui.ports import JobControl
from ui.reminders import Reminder, remind
from ui.workspace import Workspace

USUAL_BOARD = PRINTED_BOARDS["A3"].board
SIMULATORS_BOARD = PRINTED_BOARDS["A0"].board
LEAST_TO_COMPUTE = 3
"""With fewer pictures there is nothing to fit; what more of them lack the verdict says."""

MOST_REASONS = 3


class CalibrationPresenter:
    """Takes pictures of the board, has them fitted, and lets the result be used.

    Parameters
    ----------
    kept : KeptCalibrations or None
        None: those of this user.
    clock : callable
        Tells the time.

    Attributes
    ----------
    result : ResultPresenter
        What comes of the pictures.
    """

    def __init__(
        self,
        view: CalibrationView,
        workspace: Workspace,
        kept: KeptCalibrations | None = None,
        clock: Clock = utc_now,
    ) -> None:
        self._view = view
        self._workspace = workspace
        self._bench = Bench(workspace, kept or KeptCalibrations(), clock, self._show)
        self.result = ResultPresenter(view, self._bench, self._on_accepted)
        self._board = USUAL_BOARD
        self._reminder: Reminder | None = None
        self._is_automatic = True
        self._is_offline = False
        self._is_seen = False
        self._ends: list[Callable[[], None]] = [
            workspace.live.frame_arrived.subscribe(self._on_frame),
            workspace.live.state_changed.subscribe(self._on_state),
        ]
        self._show()

    def close(self) -> None:
        """Listen no more; what was taken is on the disk."""
        self._is_seen = False
        self._workspace.live.set_board(None)
        for end in self._ends:
            end()

    def enter(self) -> None:
        """Show the sensor, and look for the board in its pictures."""
        self._is_seen = True
        live, wanted = self._workspace.live, source_to_calibrate(self._workspace)
        if wanted[0] == SIMULATED_BOARD and self._bench.session is None:
            self._board = SIMULATORS_BOARD
        live.set_board(self._board_in_use)
        if live.opened != wanted or live.state.kind in ("closed", "ended"):
            live.open(*wanted)
        self._view.show_sensor(live.state)
        self._show()

    def leave(self) -> None:
        """Look for persons again, and leave the source as it was."""
        self._is_seen = False
        live, usual = self._workspace.live, usual_source(self._workspace)
        live.set_board(None)
        if live.opened != usual:
            live.open(*usual)

    def choose_board(self, board: Board) -> None:
        """Hold this board from now on."""
        session = self._bench.session
        if session is None or session.fits(board):
            self._use_board(board)
            return
        self._show()  # what was chosen does not hold yet
        n = len(session.pictures)
        question = translate_plural(
            "{n} picture shows another board. It will be removed, and you start anew.",
            "{n} pictures show another board. They will be removed, and you start anew.",
            n,
        ).format(n=n)
        self._view.confirm(question, _("Start anew"), lambda: self._use_board(board))

    def print_board(self, size_name: str, path: Path) -> None:
        """Write a page with a board."""

        def work(_control: JobControl) -> Path:
            from adibas.reports.board_page import write_board_pdf

            write_board_pdf(path, size_name)
            return path

        self._workspace.jobs.start(_("Writing the board"), work, self._on_printed)

    def set_automatic(self, is_automatic: bool) -> None:
        """Take pictures when the board is still, or only when asked."""
        self._is_automatic = is_automatic
        self._show()

    def take(self) -> None:
        """Take a picture of the board now."""
        frame = self._workspace.live.newest
        if frame is None or self._bench.session is None or self._is_offline:
            self._workspace.tell("warning", _("There is no picture of the sensor yet."))
        elif not self._keep(frame, self._bench.session):
            self._workspace.tell(
                "warning", _("The board is not seen. Hold it so that all of it is in the picture.")
            )

    def remove(self, number: int) -> None:
        """Take a picture away."""
        session = self._bench.session
        if session is not None and not self._bench.is_busy:
            self._workspace.attempt(lambda: session.remove(number))
            self._show()

    def look_at(self, number: int) -> None:
        """Show a picture that was taken, where no live one is shown."""
        session = self._bench.session
        pictures = () if session is None else session.pictures
        picture = next((one for one in pictures if one.number == number), None)
        if picture is None or not self._is_offline:
            return
        chosen = picture

        def work(_control: JobControl) -> UInt8Array:
            return read_picture(chosen.color_file)

        self._workspace.jobs.start(
            _("Reading the picture"),
            work,
            lambda color_rgb: self._view.show_kept(color_rgb, chosen.corners),
        )

    def start_anew(self) -> None:
        """Throw all pictures away, after a question."""
        if self._bench.session is None or self._bench.is_busy:
            return
        n = len(self._bench.session.pictures)
        question = translate_plural(
            "{n} picture of the board will be removed.",
            "{n} pictures of the board will be removed.",
            n,
        ).format(n=n)
        self._view.confirm(question, _("Start anew"), self._clear)

    def open_images(self, chosen: Sequence[Path]) -> None:
        """Use saved pictures: of the sensor that is shown where they have its size."""
        if self._bench.is_busy:
            return
        session, board = self._bench.session, self._board_in_use

        def work(control: JobControl) -> _ImagesRead:
            paths = images_in(chosen)
            height, width = read_picture(paths[0]).shape[:2]
            used = session
            if used is None or used.sensor.color_size != (width, height):
                nobody = CalibratedSensor("", (width, height), SourceInfo())
                used = CalibrationSession(nobody, self._bench.kept, board)
                used.choose_board(board)
            return used, *used.read_images(paths, control.progress)

        self._bench.start(_("Reading the pictures"), work, self._on_images)

    def show_sensor(self) -> None:
        """Leave saved pictures, and go on with those of the sensor."""
        self._is_offline, self._bench.session = False, None
        self._view.show_sensor(self._workspace.live.state)
        self._show()

    @property
    def _board_in_use(self) -> Board:
        return self._board if self._bench.session is None else self._bench.session.board

    def _on_state(self, state: SensorState) -> None:
        if self._is_seen and not self._is_offline:
            self._view.show_sensor(state)

    def _on_frame(self, frame: LiveFrame) -> None:
        info = self._workspace.live.state.info
        if not self._is_seen or self._is_offline or self.result.outcome is not None or info is None:
            return
        sensor, session = sensor_of(frame, info), self._bench.session
        if sensor is None or session is None or not session.is_of(sensor):
            self._view.show_frame(frame, Moment())
            if sensor is not None:
                self._open(sensor)
            return
        moment = session.see(frame)
        self._view.show_frame(frame, moment)
        if self._is_automatic and moment.is_ready:
            self._keep(frame, session)

    def _open(self, sensor: CalibratedSensor) -> None:
        """Bring back what was taken of a sensor before."""
        if self._bench.is_busy:
            return
        board = self._board
        allowed_days = self._workspace.preferences.now.calibration_days

        def work(_control: JobControl) -> tuple[CalibrationSession, Reminder]:
            session = CalibrationSession(sensor, self._bench.kept, board)
            now_utc = self._bench.clock()
            return session, remind(self._bench.kept, sensor.info, now_utc, allowed_days)

        self._bench.start(_("Looking for pictures taken before"), work, self._on_opened)

    def _on_opened(self, opened: tuple[CalibrationSession, Reminder]) -> None:
        self._bench.session, self._reminder = opened
        session = self._bench.session
        if self._is_seen:
            self._workspace.live.set_board(session.board)
        if session.n_lost:
            told = translate_plural(
                "{n} picture is damaged and was left out. Take it again.",
                "{n} pictures are damaged and were left out. Take them again.",
                session.n_lost,
            )
            self._workspace.tell("warning", told.format(n=session.n_lost))
        self._show()

    def _keep(self, frame: LiveFrame, session: CalibrationSession) -> bool:
        """Keep a frame as a picture; return whether there is a board in it."""
        if self._bench.is_busy:
            return True  # the picture before is still on its way to the disk
        picture = session.picture(frame)
        if picture is None:
            return False

        def work(_control: JobControl) -> tuple[CalibrationSession, KeptPicture]:
            return session, session.keep(picture)

        self._bench.start(_("Keeping the picture"), work, self._on_kept)
        return True

    def _on_kept(self, kept: tuple[CalibrationSession, KeptPicture]) -> None:
        session, picture = kept
        session.add(picture)
        self._view.show_taken()
        if self._workspace.preferences.now.has_sound:
            self._view.beep()
        self._show()

    def _on_images(self, read: "_ImagesRead") -> None:
        session, taken, refused = read
        session.add(*taken)
        if session is not self._bench.session:
            self._bench.session, self._is_offline = session, True
            self._reminder = None
        n = len(taken)
        told = translate_plural("{n} picture was added.", "{n} pictures were added.", n)
        sentences = [told.format(n=n), *_reasons(refused)]
        self._workspace.tell("warning" if refused else "good", " ".join(sentences))
        self._show()
        if self._is_offline and session.pictures:
            self.look_at(session.pictures[-1].number)

    def _on_accepted(self) -> None:
        self._reminder = None
        live = self._workspace.live
        if live.opened is not None:
            live.open(*live.opened)  # it brings the new calibration along
        self._show()

    def _on_printed(self, path: Path) -> None:
        told = _(
            "{file} is written. Print it at 100 %, glue it onto something flat and stiff, and "
            "measure the ruler on it."
        )
        self._workspace.tell("good", told.format(file=path.name))

    def _use_board(self, board: Board) -> None:
        session = self._bench.session
        self._board = board
        if session is not None:
            self._workspace.attempt(lambda: session.choose_board(board))
        if self._is_seen:
            self._workspace.live.set_board(self._board_in_use)
        self._show()

    def _clear(self) -> None:
        session = self._bench.session
        if session is not None:
            self._workspace.attempt(session.start_anew)
        self.result.take_more()
        self._show()

    def _show(self) -> None:
        session = self._bench.session
        pictures = () if session is None else session.pictures
        self._view.show_session(
            Shown(
                board=self._board_in_use,
                pictures=pictures,
                guidance=None if session is None else session.guidance,
                reminder=self._reminder,
                is_automatic=self._is_automatic,
                is_offline=self._is_offline,
                can_compute=len(pictures) >= LEAST_TO_COMPUTE,
                is_busy=self._bench.is_busy,
            )
        )


_ImagesRead = tuple[CalibrationSession, tuple[KeptPicture, ...], tuple[RefusedImage, ...]]


def _reasons(refused: Sequence[RefusedImage]) -> list[str]:
    """Say of the first refused pictures why, and of the others how many."""
    sentences = [f"{one.name}: {one.reason.text}" for one in refused[:MOST_REASONS]]
    n_more = len(refused) - MOST_REASONS
    if n_more > 0:
        more = translate_plural(
            "{n} more picture was left out.", "{n} more pictures were left out.", n_more
        )
        sentences.append(more.format(n=n_more))
    return sentences
