"""What the learner shows, and what a click on its picture means. Knows nothing of Qt."""

import json
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path

from adibas.data.calibration import RgbdCalibration
from adibas.data.sessions import SessionSetup
from adibas.errors import AdibasError
from adibas.markers.color_files import read_colors, write_colors
from adibas.markers.color_model import ColorModel
from adibas.markers.detection import Detections
from adibas.markers.led import LedParams
from adibas.pipeline.frozen import FrozenPicture, freeze, picture_alone
from adibas.pipeline.learning import read_picture
from adibas.pipeline.learning_board import LearnedRegion, LearningBoard
from adibas.pipeline.live import LiveFrame
from adibas.pipeline.posture import MarkerTarget
from adibas.pipeline.targets import target_from_document, target_to_document
from adibas.sensors.ports import SensorOptions
from adibas.texts import translate as _
from ui.markers.learned import Learned
from ui.markers.ports import LearnerView, Mode
from ui.markers.search import MarkerSearch
from ui.ports import Job, JobControl
from ui.workspace import Workspace


class LearnerPresenter:
    """Learns a colour on a frozen picture.

    A region grows at once, in the window's thread: it takes some milliseconds. The colours and the
    markers that they find follow in a job; a newer wish replaces an older one.
    """

    def __init__(self, view: LearnerView, workspace: Workspace) -> None:
        self._view = view
        self._workspace = workspace
        self._learned = Learned()
        self._search = MarkerSearch(workspace, self._learned, self._on_found)
        self._picture: FrozenPicture | None = None
        self._patient = workspace.place.patient
        self._pending_click: tuple[float, float] | None = None
        self._reading: Job | None = None
        self._is_seen = False
        self._filed: ColorModel | None = None
        """What a file holds, too."""
        self._ends: list[Callable[[], None]] = [
            workspace.live.frame_arrived.subscribe(self._on_frame),
            workspace.target_changed.subscribe(self._on_target),
            workspace.patient_changed.subscribe(self._on_patient),
        ]
        self._on_target()

    def close(self) -> None:
        """Listen no more."""
        self._search.stop()
        for end in self._ends:
            end()

    def enter(self) -> None:
        """Show the sensor's picture where nothing is frozen."""
        self._is_seen = True
        if self._picture is None:
            self._open_sensor()
            newest = self._workspace.live.newest
            self._view.show_picture(newest.color_rgb if newest else None, is_frozen=False)

    def leave(self) -> None:
        """Show no more live pictures."""
        self._is_seen = False

    def show_sensor(self) -> None:
        """Let the frozen picture go and show what the sensor sees."""
        self._hold(None)
        self._show_controls()
        self.enter()

    def freeze(self) -> None:
        """Hold the newest picture of the sensor still."""
        newest = self._workspace.live.newest
        picture = None
        if newest is not None:
            picture = freeze(newest, self._calibration())
        if picture is None:
            self._workspace.tell("warning", _("There is no picture of the sensor yet."))
            return
        self._take(picture)

    def open_file(self, path: Path) -> None:
        """Learn on a picture, or on the first frame of a recording."""

        def work(_control: JobControl) -> FrozenPicture:
            return picture_alone(read_picture(path))

        self._stop_reading()
        self._reading = self._workspace.jobs.start(_("Reading the picture"), work, self._take)

    def click(self, u: float, v: float) -> None:
        """Grow a region from a pixel; a live picture is frozen first."""
        if self._picture is None:
            self.freeze()
        board = self._learned.board
        if board is None:
            self._pending_click = (u, v)  # the picture is still being made ready
            self._make_board()
        elif self._learned.mode == "color" and self._workspace.attempt(
            lambda: _ignore(board.click(u, v))
        ):
            self._learn()

    def set_sensitivity(self, sensitivity: float) -> None:
        """Let the last region, and those to come, be as large as that."""
        self._learned.set_sensitivity(sensitivity)
        self._learn_anew()

    def set_clusters(self, n_clusters: int) -> None:
        """Learn so many colours."""
        self._learned.set_clusters(n_clusters)
        self._learn_anew()

    def set_brightness(self, least_brightness: float) -> None:
        """Take for an LED what is so much brighter than the scene."""
        self._learned.set_brightness(least_brightness)
        self._find()

    def set_mode(self, mode: Mode) -> None:
        """Look for learned colours, or for LEDs."""
        self._learned.mode = mode
        self._show_controls()
        self._view.show_taken(self._learned.taken())
        self._find()

    def discard(self, index: int) -> None:
        """Take the region of one click away."""
        if self._learned.board is not None and index < len(self._learned.board.regions):
            self._learned.discard(index)
            self._learn()

    def reset(self) -> None:
        """Forget all clicks and colours; the picture stays."""
        self._learned.reset()
        self._show_learned()

    def use(self) -> None:
        """Look for these markers from now on, and keep that with the session."""
        if not self._search.is_running:
            self._use()
            return
        learn = self._learned.learning()  # the job may still be at the click before the last one

        def done(model: ColorModel | None) -> None:
            self._learned.model = model
            self._use()

        self._workspace.jobs.start(_("Looking for markers"), lambda _control: learn(), done)

    def _use(self) -> None:
        target = self._learned.target
        if target is None:
            return
        self._workspace.set_target(target)
        session, is_kept = self._workspace.session, True
        if session is not None and not self._workspace.store.is_read_only:
            setup = replace(session.setup, markers=target_to_document(target))
            change = partial(
                self._workspace.store.sessions.change, session.session_id, setup=setup, seen=session
            )
            is_kept = self._workspace.save_shared(
                lambda decisions: self._workspace.renew_session(change(decisions=decisions))
            )
        if is_kept:  # else the user is being asked what to do, which this would cover
            self._workspace.tell("good", _("From now on these markers are looked for."))
        self._workspace.show_screen("capture")

    def save(self, path: Path) -> None:
        """Write the colours to a file that the command line reads, too."""
        model = self._learned.model
        if model is not None and self._workspace.attempt(lambda: write_colors(path, model)):
            self._filed = model
            self._workspace.tell(
                "good", _("The colours are saved in {file}.").format(file=path.name)
            )

    def load(self, path: Path) -> None:
        """Take the colours of a file."""
        try:
            model = read_colors(path)
        except AdibasError as error:
            self._workspace.report_problem(error)
            return
        self._filed = model
        self._take_target(model)

    def draft(self) -> str:
        """Return the markers that were learned and are not in use yet, else nothing."""
        target = self._learned.target
        if target is None or target == LedParams() or target is self._workspace.target:
            return ""
        return json.dumps(target_to_document(target))

    @property
    def is_unsaved(self) -> bool:
        """Whether markers were learned that are neither in use nor in a file."""
        return bool(self.draft()) and self._learned.target is not self._filed

    def take_back(self, draft: str) -> None:
        """Go on with markers that were learned before; the picture has to be frozen anew."""
        self._take_target(target_from_document(json.loads(draft)))

    def _take_target(self, target: MarkerTarget) -> None:
        self._learned.take_target(target)
        self._learned.forget_clicks()
        self._show_learned()

    def _show_learned(self) -> None:
        """Show markers that are known without a click on this picture."""
        self._pending_click = None
        self._search.stop()
        self._view.show_taken(None)
        self._show_controls()
        self._find()

    def _hold(self, picture: FrozenPicture | None) -> None:
        """Hold another picture; what was clicked and found on the one before goes."""
        self._picture, self._learned.board, self._pending_click = picture, None, None
        self._search.stop()
        self._view.show_found(None)  # of another picture, which may have another size
        self._view.show_taken(None)

    def _take(self, picture: FrozenPicture) -> None:
        """Show a frozen picture, and make it ready for clicks."""
        self._stop_reading()
        self._hold(picture)
        self._view.show_picture(picture.color_rgb, is_frozen=True)
        self._show_controls()
        self._make_board()
        self._find()

    def _make_board(self) -> None:
        """Make the frozen picture ready for clicks, unless that is being done."""
        picture, params = self._picture, self._learned.params
        if picture is None or (self._reading is not None and self._reading.is_running):
            return

        def work(_control: JobControl) -> LearningBoard:
            return LearningBoard(picture.color_rgb, params)

        self._reading = self._workspace.jobs.start(
            _("Looking at the picture"), work, self._on_board
        )

    def _on_board(self, board: LearningBoard) -> None:
        if self._picture is None or board.color_rgb is not self._picture.color_rgb:
            return  # another picture was taken meanwhile
        self._learned.take_board(board)
        click, self._pending_click = self._pending_click, None
        if click is not None:
            self.click(*click)

    def _learn(self) -> None:
        """Show what was taken at once; colours and markers follow."""
        if self._learned.board is not None:
            self._view.show_taken(self._learned.board.taken())
        self._show_controls()
        self._find()

    def _learn_anew(self) -> None:
        """Learn with other settings what was clicked; colours of a file stay as they are."""
        if self._learned.has_clicks:
            self._learn()

    def _find(self) -> None:
        """Learn and look for markers; without a picture there is nothing to look at."""
        if self._picture is None:
            self._search.stop()
            self._on_found(self._learned.model, None)
        else:
            self._search.begin(self._picture)

    def _stop_reading(self) -> None:
        if self._reading is not None and self._reading.is_running:
            self._reading.cancel()
        self._reading = None

    def _on_found(self, model: ColorModel | None, found: Detections | None) -> None:
        self._learned.model = model
        self._view.show_found(found)
        self._show_controls()

    def _on_frame(self, frame: LiveFrame) -> None:
        if self._is_seen and self._picture is None:
            self._view.show_picture(frame.color_rgb, is_frozen=False)

    def _on_patient(self) -> None:
        """Let the picture of another patient go; the colours stay, as do the stickers."""
        before, self._patient = self._patient, self._workspace.place.patient
        if self._patient == before:
            return
        self._stop_reading()
        self._hold(None)
        self._view.show_picture(None, is_frozen=False)
        self._show_controls()
        if self._is_seen:
            self.enter()

    def _on_target(self) -> None:
        """Show the markers that are looked for from now on, if they were not learned here."""
        target = self._workspace.target
        if target is None or target is self._learned.target:
            self._show_controls()
            return
        self._take_target(target)

    def _open_sensor(self) -> None:
        """Open what was open last, else the source of the session, unless it is open."""
        live, session = self._workspace.live, self._workspace.session
        if live.state.kind not in ("closed", "ended"):
            return
        setup = SessionSetup() if session is None else session.setup
        width, height = setup.color_size
        usual = (setup.source, SensorOptions(color_size=(width, height)))
        live.open(*(live.opened or usual))

    def _calibration(self) -> RgbdCalibration | None:
        view, info = self._workspace.live.view, self._workspace.live.state.info
        return None if info is None else view.calibration

    def _show_controls(self) -> None:
        self._view.show_controls(self._learned.shown(has_picture=self._picture is not None))


def _ignore(_region: LearnedRegion) -> None:
    """Want nothing of what a click returns."""
