"""What the capture screen shows, and when. Knows nothing of Qt."""

from contextlib import suppress
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

from adibas.arrays import UInt8Array
from adibas.clock import utc_now
from adibas.data.patients import Patient, allow_capture
from adibas.data.posture import VIEWS
from adibas.data.sessions import Capture, Session
from adibas.errors import AdibasError
from adibas.pipeline.capturing import CaptureRequest, frames_of_view, take_capture
from adibas.pipeline.live import LiveFrame, SensorState
from adibas.pipeline.live_frames import Naming
from adibas.pipeline.targets import target_from_document, target_to_document
from adibas.sessions.consents import no_consent
from adibas.texts import describe, message, translate_plural
from adibas.texts import translate as _
from ui.capture.calibration_age import CalibrationAge
from ui.capture.countdown import Countdown
from ui.capture.disk_watch import DiskWatch
from ui.capture.ports import CaptureView
from ui.capture.source_presenter import Look, SourcePresenter
from ui.capture.sources import find_sources, view_title
from ui.capture.taken import TakenViews
from ui.capture.turn_presenter import TurnPresenter
from ui.capture.wand_presenter import WandPresenter, WandView, without_old_wand
from ui.ports import Job, JobControl
from ui.view_names import TURN
from ui.workspace import Workspace

if TYPE_CHECKING:
    from adibas.sessions.conflicts import Decision

USUAL_RATE_HZ = 30.0
WAITING = {
    "closed": message("Wait for the picture of the sensor."),
    "opening": message("Wait for the picture of the sensor."),
    "lost": message("The sensor is lost. As soon as it is back you can go on."),
    "ended": message("There are no more pictures. Choose a source."),
}


class CapturePresenter:
    """Opens the source, counts down, takes the capture, and goes on to the next view.

    Parameters
    ----------
    look : callable
        Looks for sensors, in a job; given the recent recordings.
    """

    def __init__(self, view: CaptureView, workspace: Workspace, look: Look = find_sources) -> None:
        self._view = view
        self._workspace = workspace
        self._session_id: str | None = None
        self._taken = TakenViews(workspace.store)
        self._next_view = VIEWS[0]
        self._countdown = Countdown(view.call_later, self._on_tick)
        self._job: Job | None = None
        self._is_seen = False
        self.sources = SourcePresenter(view, workspace, self._is_free, self._may_open, look)
        self.calibration_age = CalibrationAge(view, workspace)
        self._turn = TurnPresenter(workspace, self.sources, self._on_turn, self._on_ended)
        self._disk = DiskWatch(
            workspace.store.folder, view.call_later, self._expected_rate, self._on_disk
        )
        self._ends = [
            workspace.live.frame_arrived.subscribe(self._on_frame),
            workspace.live.state_changed.subscribe(self._on_state),
            workspace.session_changed.subscribe(self._on_session),
            workspace.patient_changed.subscribe(self._show_readiness),
            workspace.target_changed.subscribe(self._show_readiness),
        ]
        self._on_session()
        view.show_sensor(workspace.live.state)

    def close(self) -> None:
        """Listen no more, and give up what is being taken."""
        self.leave()
        self.cancel()
        for end in self._ends:
            end()

    def enter(self) -> None:
        """Show the sensor of the session; the first time, look which there are."""
        self._is_seen = True
        self._renew_patient()
        self.sources.look_once()
        if self._workspace.session is None:
            self._take_over_setup()
        self._read_taken()
        self.sources.open(self._next_view)
        self._disk.start()

    def leave(self) -> None:
        """Give up a countdown, or a turn before it begins: nobody would see it. A burst goes on."""
        self._is_seen = False
        self._disk.stop()
        self._countdown.give_up()
        self._turn.stop_waiting()

    def choose_view(self, view: str) -> None:
        """Capture this view next."""
        if self._is_free():
            self._go_to(view)

    def capture(self) -> None:
        """Count down and take the view; a second call stops that, and a burst, too."""
        if self._countdown.is_running or self._is_capturing:
            self.cancel()
        elif lack := self._lack():
            self._workspace.tell("warning", lack)
        else:
            self._countdown.start(self._workspace.preferences.now.countdown_s, self._take)

    def cancel(self) -> None:
        """Give up the countdown or the burst."""
        self._countdown.give_up()
        self._turn.cancel()
        if self._job is not None and self._job.is_running:
            self._job.cancel()

    def learn_markers(self) -> None:
        """Go to the learner."""
        self._workspace.show_screen("markers")

    def record_consent(self) -> None:
        """Go to where the patient's consent is recorded, and come back with it."""
        if self._is_free():
            self._workspace.ask_consent(back_to="capture")

    def may_check_wand(self) -> bool:
        """Say whether a wand may be measured now; tell why not."""
        return self._is_free()

    def check_wand(self, dialog: WandView) -> WandPresenter:
        """Return what measures a wand for a dialog; what it finds is kept with the session."""
        sources = self.sources
        return WandPresenter(dialog, self._workspace, sources.note_wand, sources.setup.wand)

    def review(self, view: str) -> None:
        """Look at the last capture of a view; a turn is looked at as the body that it gives."""
        if view == TURN:
            self._workspace.show_screen("comparison")
            return
        capture = self._taken.captures.get(view)
        if capture is not None:
            self._workspace.choose_capture(capture.capture_id)
            self._workspace.show_screen("review")

    @property
    def _is_capturing(self) -> bool:
        return self._turn.is_running or (self._job is not None and self._job.is_running)

    def _is_free(self) -> bool:
        """Say whether something else may be shown; tell why not. A countdown is given up."""
        if self._is_capturing:
            busy = _("A view is being captured. Wait until it is done, or stop it.")
            self._workspace.tell("warning", busy)
            return False
        self._countdown.give_up()
        return True

    def _may_open(self) -> bool:
        return self._is_seen and not self._is_capturing

    def _on_tick(self, seconds: int | None) -> None:
        self._view.show_countdown(seconds)
        if seconds is not None and self._workspace.preferences.now.has_sound:
            self._view.beep()

    def _take(self) -> None:
        if lack := self._lack():
            self._workspace.tell("warning", lack)
            return
        session = self._session()
        if session is None:
            self._renew_patient()
            return
        self._view.show_capturing(is_capturing=True)
        if self._next_view == TURN:
            self._turn.take(session.session_id)
            return
        request = CaptureRequest(
            session_id=session.session_id,
            view=self._next_view,
            n_frames=frames_of_view(self._next_view, self._workspace.preferences.now.burst_frames),
            target=self._workspace.target,
            oldest_calibration_days=self._workspace.preferences.now.calibration_days,
        )
        store, live = self._workspace.store, self._workspace.live.view

        def work(control: JobControl) -> Capture:
            return take_capture(store, live, request, control.progress)

        self._job = self._workspace.jobs.start(
            _("Capturing"), work, self._on_taken, ended=self._on_ended
        )

    def _on_ended(self) -> None:
        self._view.show_capturing(is_capturing=False)
        if self._is_seen:
            self._renew_patient()
        self._show_readiness()
        self.sources.open(self._next_view)  # the session may have changed meanwhile

    def _renew_patient(self) -> None:
        """Know of a consent that was given or withdrawn at another workstation meanwhile."""
        known = self._workspace.patient
        if known is None:
            return
        with suppress(AdibasError):  # the store refuses all the same
            patient = self._workspace.store.patients.get(known.pseudonym)
            if patient.consents != known.consents:
                self._workspace.choose_patient(patient)

    def _on_taken(self, capture: Capture) -> None:
        workspace = self._workspace
        if workspace.preferences.now.has_sound:
            self._view.beep()
        workspace.tell_here("good" if capture.detected else "warning", _told(capture))
        session = workspace.session
        if session is None or session.session_id != capture.session_id:
            return  # somebody else is being looked at meanwhile
        workspace.attempt(
            lambda: workspace.choose_session(workspace.store.sessions.get(capture.session_id))
        )
        workspace.choose_capture(capture.capture_id)
        self._go_on()

    def _on_turn(self) -> None:
        if self._workspace.preferences.now.has_sound:
            self._view.beep()
        self._go_on()

    def _go_on(self) -> None:
        """Show the next view that is left."""
        if (left := self._taken.first_left) is not None:
            self._go_to(left)

    def _session(self) -> Session | None:
        """Return the session, a new one where none was started; None where that fails."""
        workspace = self._workspace
        workspace.save_shared(partial(self._start_session, workspace.patient, workspace.session))
        return workspace.session

    def _start_session(
        self,
        patient: Patient | None,
        session: Session | None,
        decisions: "tuple[Decision, ...]",
    ) -> None:
        """Start a session where there is none, and note in it what is looked for."""
        workspace, setup = self._workspace, self.sources.setup
        sessions = workspace.store.sessions
        if workspace.target is not None and (session is None or session.setup.markers is None):
            setup = replace(setup, markers=target_to_document(workspace.target))
        if session is None and patient is not None:
            setup = without_old_wand(setup, utc_now())
            workspace.choose_session(sessions.start(patient.pseudonym, setup))
        elif session is not None and setup is not self.sources.setup:
            changed = sessions.change(
                session.session_id, setup=setup, seen=session, decisions=decisions
            )
            workspace.renew_session(changed)

    def _go_to(self, view: str) -> None:
        self._next_view = view
        self._show_views()
        self._name_markers()
        self._show_readiness()
        self.sources.open(view)

    def _on_session(self) -> None:
        """Take over the set-up of the session that was chosen."""
        session, id_before = self._workspace.session, self._session_id
        self._session_id = None if session is None else session.session_id
        self._read_taken()
        if self._session_id != id_before:
            self._countdown.give_up()
            self._turn.stop_waiting()
            if session is None or id_before is not None or self._taken.captures:
                self._next_view = self._taken.first_left or VIEWS[0]
            self._take_over_markers(session)
        self._take_over_setup()
        self._show_views()
        self._show_readiness()
        self.sources.open(self._next_view)

    def _take_over_setup(self) -> None:
        """Use the set-up of the session; without one, the last with the preferred protocol."""
        session, setup = self._workspace.session, self.sources.setup
        preferred = self._workspace.preferences.now.protocol
        self.sources.use(replace(setup, protocol=preferred) if session is None else session.setup)
        self._name_markers()

    def _name_markers(self) -> None:
        """Let live markers be named after the session's protocol."""
        protocol = self.sources.setup.protocol
        has_names = bool(protocol) and self._next_view in VIEWS
        naming = Naming(protocol, self._next_view) if has_names else None
        self._workspace.live.set_naming(naming)

    def _take_over_markers(self, session: Session | None) -> None:
        """Look for the markers of a session; one without any goes on with those in use."""
        document = None if session is None else session.setup.markers
        if document is not None:
            self._workspace.attempt(
                lambda: self._workspace.set_target(target_from_document(document))
            )

    def _read_taken(self) -> None:
        self._workspace.attempt(lambda: self._taken.read(self._workspace.session))
        self._show_views()

    def _show_views(self) -> None:
        taken: dict[str, UInt8Array | None] = {**self._taken.pictures}
        session = self._workspace.session
        if session is not None and session.setup.turn:
            taken[TURN] = None
        self._view.show_views(self._next_view, taken)

    def _on_frame(self, frame: LiveFrame) -> None:
        if self._is_seen:
            self._view.show_frame(frame)

    def _on_state(self, state: SensorState) -> None:
        self._turn.note_state(state)
        self._view.show_sensor(state)
        self._workspace.attempt(lambda: self.calibration_age.show(state))
        if self._countdown.is_running and state.kind != "live":
            self._countdown.give_up()
            self._workspace.tell("bad", describe(state.error) if state.error else self._lack())
        self._show_readiness()

    def _on_disk(self, minutes: float | None) -> None:
        self._view.show_disk(minutes)
        self._show_readiness()

    def _expected_rate(self) -> tuple[tuple[int, int], float]:
        """Return the size of the colour image and the frames a second of what is shown."""
        width, height = self.sources.setup.color_size
        info = self._workspace.live.state.info
        return (width, height), USUAL_RATE_HZ if info is None else info.frame_rate_hz

    def _lack(self) -> str:
        """Say what must be done before a view can be captured; empty where nothing lacks."""
        workspace = self._workspace
        if workspace.store.is_read_only:
            return _("Another window has the patient store open: nothing can be captured here.")
        if workspace.patient is None and workspace.session is None:
            return _("Choose a patient first, under Patients.")
        if self._lacks_consent:
            return describe(no_consent())
        if self._disk.is_full:
            return _("The disk is full. Free some space on it before you capture.")
        waiting = WAITING.get(workspace.live.state.kind)
        return "" if waiting is None else _(waiting)

    @property
    def _lacks_consent(self) -> bool:
        patient, store = self._workspace.patient, self._workspace.store
        has_one = patient is None or allow_capture(patient.consents)
        return not has_one and not store.is_read_only

    def _show_readiness(self) -> None:
        self._view.offer_consent(is_lacking=self._lacks_consent)
        lack = self._lack()
        sentence = lack
        if not lack and self._next_view == TURN:
            sentence = _(
                "The patient stands with the back to the sensor and, when the countdown ends, "
                "turns once around within 15 seconds, the arms hanging still."
            )
        elif not lack and self._workspace.target is None:
            sentence = _(
                "No marker colour is learned yet: only picture and depth will be captured."
            )
        self._view.show_readiness(sentence, is_ready=not lack)


def _told(capture: Capture) -> str:
    """Return what the user is told of a capture."""
    n_markers = len(capture.detected)
    told = translate_plural("{view}: {n} marker found.", "{view}: {n} markers found.", n_markers)
    sentences = [told.format(view=view_title(capture.view), n=n_markers)]
    return " ".join((*sentences, *(_(notice) for notice in capture.notices)))
