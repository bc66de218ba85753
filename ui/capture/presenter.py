"""What the capture screen shows, and when. Knows nothing of Qt."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Protocol

from adibas.arrays import UInt8Array
from adibas.data.posture import VIEWS
from adibas.data.sessions import Capture, Session, SessionSetup
from adibas.errors import AdibasError
from adibas.pipeline.capturing import CaptureRequest, take_capture
from adibas.pipeline.disk_forecast import expected_bytes_per_s, free_bytes, minutes_left
from adibas.pipeline.live import LiveFrame, SensorState
from adibas.pipeline.targets import target_from_document
from adibas.sensors.ports import SensorOptions
from adibas.texts import translate as _
from adibas.texts import translate_plural
from ui.capture.countdown import Countdown
from ui.capture.sources import (
    SourceChoice,
    find_sources,
    source_for_view,
    usual_sources,
    view_title,
)
from ui.ports import Job, JobControl
from ui.workspace import Workspace

FRAMES_PER_DISK_LOOK = 90


class CaptureView(Protocol):
    """The screen, as this presenter needs it."""

    def show_sources(self, choices: tuple[SourceChoice, ...], chosen: str) -> None:
        """Offer sources; `chosen` is the one in use."""

    def show_setup(self, setup: SessionSetup) -> None:
        """Show size and rotation in use."""

    def show_frame(self, frame: LiveFrame) -> None:
        """Show a live frame and all that is drawn over it."""

    def show_sensor(self, state: SensorState) -> None:
        """Say how the sensor fares."""

    def show_disk(self, minutes: float | None) -> None:
        """Say how long the disk will hold; None where it cannot be told."""

    def show_views(self, view: str, taken: dict[str, UInt8Array]) -> None:
        """Mark the view that is next, and show pictures of those that were taken."""

    def show_readiness(self, sentence: str, *, is_ready: bool) -> None:
        """Say what lacks before a capture, and whether one can be taken."""

    def show_countdown(self, seconds: int | None) -> None:
        """Show the seconds to go; None = no countdown."""

    def show_capturing(self, *, is_capturing: bool) -> None:
        """Show that a burst is being taken."""

    def beep(self) -> None:
        """Make a short sound."""

    def call_later(self, milliseconds: int, call: Callable[[], None]) -> None:
        """Call in the window's thread, later."""


class CapturePresenter:
    """Opens the source, counts down, takes the capture, and goes on to the next view."""

    def __init__(self, view: CaptureView, workspace: Workspace) -> None:
        self._view = view
        self._workspace = workspace
        self._setup = SessionSetup()
        self._next_view = VIEWS[0]
        self._countdown = Countdown(view.call_later, self._on_tick)
        self._job: Job | None = None
        self._is_seen = False
        self._n_frames = 0
        self._ends = [
            workspace.live.frame_arrived.subscribe(self._on_frame),
            workspace.live.state_changed.subscribe(self._on_state),
            workspace.session_changed.subscribe(self._on_session),
            workspace.patient_changed.subscribe(self._show_readiness),
            workspace.target_changed.subscribe(self._show_readiness),
        ]
        self._show_sources(usual_sources(workspace.preferences.now.recent_recordings))
        self._on_session()
        view.show_sensor(workspace.live.state)

    def close(self) -> None:
        """Listen no more, and give up a countdown."""
        self.cancel()
        for end in self._ends:
            end()

    def enter(self) -> None:
        """Show the sensor of the session."""
        self._is_seen = True
        if self._workspace.live.state.kind == "closed":
            self._open()
        self._show_disk()
        self._show_readiness()

    def leave(self) -> None:
        """Give up a countdown: nobody would see it."""
        self._is_seen = False
        self._countdown.give_up()

    def look_for_sources(self) -> None:
        """Look anew which sensors are plugged in."""
        recent = self._workspace.preferences.now.recent_recordings

        def work(_control: JobControl) -> tuple[SourceChoice, ...]:
            return find_sources(recent)

        self._workspace.jobs.start(_("Looking for sensors"), work, self._show_sources)

    def choose_source(self, source: str) -> None:
        """Show another sensor, the simulator, or a recording."""
        self._change_setup(replace(self._setup, source=source))
        self._open()

    def open_recording(self, path: Path) -> None:
        """Replay a recording as if it were a sensor."""
        self._workspace.preferences.add_recent(path)
        self._show_sources(usual_sources(self._workspace.preferences.now.recent_recordings))
        self.choose_source(str(path))

    def choose_size(self, color_size: tuple[int, int]) -> None:
        """Ask the sensor for another size of its colour image."""
        self._change_setup(replace(self._setup, color_size=color_size))
        self._open()

    def turn(self) -> None:
        """Turn the picture by a quarter, for a sensor mounted on its side."""
        rotation_deg = (self._setup.rotation_deg + 90) % 360
        self._change_setup(replace(self._setup, rotation_deg=rotation_deg))
        self._workspace.live.view.set_rotation(rotation_deg)

    def choose_view(self, view: str) -> None:
        """Capture this view next."""
        before = source_for_view(self._setup.source, self._next_view)
        self._next_view = view
        self._show_views()
        if source_for_view(self._setup.source, view) != before:
            self._open()

    def capture(self) -> None:
        """Count down and take the view; a second call gives the countdown up."""
        if self._countdown.is_running:
            self._countdown.give_up()
        elif self._is_ready():
            self._countdown.start(self._workspace.preferences.now.countdown_s, self._take)

    def cancel(self) -> None:
        """Give up the countdown or the burst."""
        self._countdown.give_up()
        if self._job is not None and self._job.is_running:
            self._job.cancel()
            self._view.show_capturing(is_capturing=False)

    def learn_markers(self) -> None:
        """Go to the learner."""
        self._workspace.show_screen("markers")

    def review(self, view: str) -> None:
        """Look at the last capture of a view."""
        taken = self._taken()
        if view in taken:
            self._workspace.choose_capture(taken[view].capture_id)
            self._workspace.show_screen("review")

    def _on_tick(self, seconds: int | None) -> None:
        self._view.show_countdown(seconds)
        if seconds is not None and self._workspace.preferences.now.has_sound:
            self._view.beep()

    def _take(self) -> None:
        session = self._session()
        if session is None:
            return
        request = CaptureRequest(
            session_id=session.session_id,
            view=self._next_view,
            n_frames=self._workspace.preferences.now.burst_frames,
            target=self._workspace.target,
        )
        store, live = self._workspace.store, self._workspace.live.view

        def work(control: JobControl) -> Capture:
            return take_capture(store, live, request, control.progress)

        self._view.show_capturing(is_capturing=True)
        self._job = self._workspace.jobs.start(
            _("Capturing"), work, self._on_taken, self._on_failed
        )

    def _on_taken(self, capture: Capture) -> None:
        self._view.show_capturing(is_capturing=False)
        if self._workspace.preferences.now.has_sound:
            self._view.beep()
        n_markers = len(capture.detected)
        told = translate_plural(
            "{view}: {n} marker found.", "{view}: {n} markers found.", n_markers
        ).format(view=view_title(capture.view), n=n_markers)
        self._workspace.tell("good" if n_markers else "warning", told)
        session = self._workspace.store.sessions.get(capture.session_id)
        self._workspace.choose_session(session)
        self._workspace.choose_capture(capture.capture_id)
        left = [view for view in VIEWS if view not in self._taken()]
        if left:
            self.choose_view(left[0])

    def _on_failed(self, error: AdibasError) -> None:
        self._view.show_capturing(is_capturing=False)
        self._workspace.report_problem(error)

    def _session(self) -> Session | None:
        """Return the session, a new one where none was started; None where that fails."""
        workspace = self._workspace
        patient = workspace.patient
        if workspace.session is None and patient is not None:
            workspace.attempt(
                lambda: workspace.choose_session(
                    workspace.store.sessions.start(patient.pseudonym, self._setup)
                )
            )
        return workspace.session

    def _open(self) -> None:
        source = source_for_view(self._setup.source, self._next_view)
        self._workspace.live.open(source, SensorOptions(color_size=self._setup.color_size))
        self._workspace.live.view.set_rotation(self._setup.rotation_deg)
        self._workspace.live.set_target(self._workspace.target)

    def _change_setup(self, setup: SessionSetup) -> None:
        self._setup = setup
        self._view.show_setup(setup)
        session = self._workspace.session
        if session is not None and not self._workspace.store.is_read_only:
            change = self._workspace.store.sessions.change
            self._workspace.attempt(
                lambda: self._workspace.choose_session(change(session.session_id, setup=setup))
            )

    def _on_session(self) -> None:
        """Take over the set-up of the session that was chosen."""
        session = self._workspace.session
        if session is not None:
            is_other = session.setup.source != self._setup.source
            self._setup = session.setup
            self._take_over_markers(session)
            if is_other and self._is_seen:
                self._open()
        self._view.show_setup(self._setup)
        self._show_views()
        self._show_readiness()

    def _take_over_markers(self, session: Session) -> None:
        document = session.setup.markers
        if document is not None and self._workspace.target is None:
            self._workspace.attempt(
                lambda: self._workspace.set_target(target_from_document(document))
            )

    def _on_frame(self, frame: LiveFrame) -> None:
        if not self._is_seen:
            return
        self._view.show_frame(frame)
        self._n_frames += 1
        if self._n_frames % FRAMES_PER_DISK_LOOK == 0:
            self._show_disk()

    def _on_state(self, state: SensorState) -> None:
        self._view.show_sensor(state)
        self._show_readiness()

    def _show_sources(self, choices: tuple[SourceChoice, ...]) -> None:
        self._view.show_sources(choices, self._setup.source)

    def _show_views(self) -> None:
        thumbnails: dict[str, UInt8Array] = {}
        for view, capture in self._taken().items():
            thumbnails[view] = self._workspace.store.captures.thumbnail(capture.capture_id)
        self._view.show_views(self._next_view, thumbnails)

    def _taken(self) -> dict[str, Capture]:
        """Return the last capture of every view that the session has."""
        session = self._workspace.session
        if session is None:
            return {}
        captures = self._workspace.store.captures.of_session(session.session_id)
        return {capture.view: capture for capture in captures}

    def _show_disk(self) -> None:
        newest = self._workspace.live.newest
        rate_hz = newest.frame_rate_hz if newest is not None else 0.0
        width, height = self._setup.color_size
        bytes_per_s = expected_bytes_per_s((width, height), (640, 480), rate_hz or 30.0)
        try:
            free = free_bytes(self._workspace.store.folder)
        except AdibasError:
            self._view.show_disk(None)
        else:
            self._view.show_disk(minutes_left(free, bytes_per_s))

    def _is_ready(self) -> bool:
        return not self._lack() and self._workspace.live.state.kind == "live"

    def _lack(self) -> str:
        workspace = self._workspace
        if workspace.store.is_read_only:
            return _("Another window has the patient store open: nothing can be captured here.")
        if workspace.patient is None and workspace.session is None:
            return _("Choose a patient first.")
        return ""

    def _show_readiness(self) -> None:
        lack = self._lack()
        if not lack and self._workspace.target is None:
            hint = _("No marker colour is learned yet: only picture and depth will be captured.")
            self._view.show_readiness(hint, is_ready=self._is_ready())
        else:
            self._view.show_readiness(lack, is_ready=self._is_ready())
