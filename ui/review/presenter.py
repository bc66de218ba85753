"""Which session and capture is reviewed; its notes, names and surface. Knows nothing of Qt."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Protocol

from adibas.arrays import UInt8Array
from adibas.data.markers import is_numbered
from adibas.data.sessions import Capture, Session
from adibas.errors import AdibasError, MarkerError
from adibas.texts import message
from adibas.texts import translate as _
from ui.ports import JobControl
from ui.review.content import CaptureItem, placed
from ui.review.opened import Opened
from ui.review.points_presenter import PointsPresenter, PointsView
from ui.widgets.space import Space
from ui.workspace import Workspace

if TYPE_CHECKING:
    from adibas.data.surface import BurstDisparity
    from adibas.pipeline.posture import MarkerTarget
    from adibas.sessions.conflicts import Decision

NO_SESSION = message("No session is open. Choose a patient and a session.")
NO_CAPTURE = message("This session has no picture yet. Take one first.")
N_SESSIONS_FOR_NAMES = 5
"""The newest of the patient, whose marker names are suggested."""


class ReviewView(PointsView, Protocol):
    """The screen, as these presenters need it."""

    def show_nothing(self, sentence: str, screen: str) -> None:
        """Say what to do first (not translated yet), and offer the screen where it is done."""

    def show_captures(
        self, items: tuple[CaptureItem, ...], chosen: str | None, rotation_deg: int
    ) -> None:
        """Show the strip."""

    def show_picture(self, picture_rgb: UInt8Array | None, rotation_deg: int) -> None:
        """Show the picture of the capture; None while it is read."""

    def show_notices(self, sentences: tuple[str, ...]) -> None:
        """Show what must be known of the capture: texts that are not translated yet."""

    def show_notes(self, session_id: str, notes: str, *, can_edit: bool) -> None:
        """Show the notes of a session."""

    def keep_notes(self, session_id: str, saved: str) -> None:
        """Take these for the saved notes of a session; what stands there stays."""

    def show_names(self, names: tuple[str, ...]) -> None:
        """Suggest names that this patient's markers had."""

    def show_space(self, space: Space | None) -> None:
        """Show the surface in 3-D; None where no depth was kept."""


class ReviewPresenter:
    """Opens captures of the session that is being looked at, when the screen is seen."""

    def __init__(self, view: ReviewView, workspace: Workspace) -> None:
        self._view = view
        self._workspace = workspace
        self.points = PointsPresenter(view, workspace, self._on_corrected)
        self._ends: list[Callable[[], None]] = [
            workspace.session_changed.subscribe(self._on_session),
            workspace.capture_chosen.subscribe(self._on_capture),
        ]
        self._is_seen = False
        self._session: Session | None = None
        self._captures: dict[str, Capture] = {}
        self._thumbnails: dict[str, UInt8Array | None] = {}
        self._opened: str | None = None
        self._surface: BurstDisparity | None = None
        self._was_corrected = False
        self._names_of: str | None = None

    def entered(self) -> None:
        """Show what is being looked at now."""
        self._is_seen = True
        self._show_session()

    def left(self) -> None:
        """Let a drag in progress go, and tell others of corrections."""
        self._is_seen = False
        self.points.let_go()
        if self._was_corrected:
            self._was_corrected = False
            self._workspace.session_changed.emit()

    def close(self) -> None:
        """Listen no more."""
        for end in self._ends:
            end()

    def go_to(self, screen: str) -> None:
        """Show another screen."""
        self._workspace.show_screen(screen)

    def choose_capture(self, capture_id: str) -> None:
        """Look at another capture of the session."""
        if capture_id != self._opened:
            self._workspace.choose_capture(capture_id)

    def change_notes(self, session_id: str, notes: str, seen: str) -> None:
        """Save the notes of a session; its content is told to others where it is looked at.

        Parameters
        ----------
        seen : str
            The notes from which they were typed.
        """
        sessions = self._workspace.store.sessions

        def save(decisions: "tuple[Decision, ...]") -> None:
            before = replace(sessions.get(session_id), notes=seen)
            changed = sessions.change(session_id, notes=notes, seen=before, decisions=decisions)
            self._view.keep_notes(session_id, notes)
            self._workspace.renew_session(changed)

        is_kept = self._is_looked_at(session_id)
        if not self._workspace.save_shared(save, is_kept=is_kept):
            self._view.keep_notes(session_id, seen)

    def _is_looked_at(self, session_id: str) -> bool:
        now = self._workspace.session
        return now is not None and now.session_id == session_id

    def open_space(self) -> None:
        """Show the surface of the capture in 3-D."""
        capture, picture_rgb = self._capture(), self.points.picture_rgb
        if capture is None or picture_rgb is None or not self.points.is_ready:
            return
        surface, rotation_deg = self._surface, self._rotation_deg
        if surface is None:
            self._view.show_space(None)
            return

        def work(_control: JobControl) -> Space:
            from adibas.pipeline.surface_discs import surface_discs

            discs = surface_discs(surface, capture.calibration, picture_rgb)
            return Space(discs, rotation_deg=rotation_deg)

        def done(space: Space) -> None:
            if self._opened == capture.capture_id:
                self._view.show_space(replace(space, landmarks_m=placed(self.points.markers)))

        self._workspace.jobs.start(_("Preparing the 3-D view"), work, done)

    @property
    def _rotation_deg(self) -> int:
        return 0 if self._session is None else self._session.setup.rotation_deg

    def _capture(self) -> Capture | None:
        return None if self._opened is None else self._captures.get(self._opened)

    def _on_session(self) -> None:
        if self._is_seen:
            self._show_session()

    def _on_capture(self) -> None:
        if self._is_seen and self._workspace.capture_id in self._captures:
            self._open(self._workspace.capture_id)

    def _show_session(self) -> None:
        """Show what the session holds, and suggest the names of its patient's markers."""
        session = self._session = self._workspace.session
        if session is None:
            self._show_nothing(NO_SESSION, "patients")
        else:
            self._show_content(session)
        self._suggest_names(None if session is None else session.patient)

    def _show_content(self, session: Session) -> None:
        """Show the session's captures; the one that is open stays open."""
        if not self._workspace.attempt(lambda: self._read(session)):
            self._captures = {}
        is_editable = not self._workspace.store.is_read_only
        self._view.show_notes(session.session_id, session.notes, can_edit=is_editable)
        if not self._captures:
            self._show_nothing(NO_CAPTURE, "capture")
            return
        wished = (self._workspace.capture_id, self._opened, next(iter(self._captures)))
        self._open(next(one for one in wished if one in self._captures))

    def _show_nothing(self, sentence: str, screen: str) -> None:
        self._opened = None
        self.points.close_capture()
        self._view.show_nothing(sentence, screen)

    def _read(self, session: Session) -> None:
        store = self._workspace.store
        captures = store.captures.of_session(session.session_id)
        self._captures = {one.capture_id: one for one in captures}
        self._thumbnails = {one: self._thumbnail(one) for one in self._captures}

    def _thumbnail(self, capture_id: str) -> UInt8Array | None:
        try:
            return self._workspace.store.captures.thumbnail(capture_id)
        except AdibasError:
            return None

    def _open(self, capture_id: str | None) -> None:
        if capture_id is None or capture_id == self._opened:
            self._show_strip()
            return
        capture = self._captures[capture_id]
        self._opened, self._surface = capture_id, None
        self._show_strip()
        self._view.show_notices(capture.notices)
        self._view.show_picture(None, self._rotation_deg)
        self.points.open_capture(capture)
        self._load_picture(capture)

    def _show_strip(self) -> None:
        items = (
            CaptureItem(
                one.capture_id,
                one.view,
                self._thumbnails[one.capture_id],
                len(one.markers()),
                one.history.can_undo,
            )
            for one in self._captures.values()
        )
        self._view.show_captures(tuple(items), self._opened, self._rotation_deg)

    def _load_picture(self, capture: Capture) -> None:
        """Read the picture first, so that it is seen at once; then measure, and read the depth."""
        store = self._workspace.store

        def work(_control: JobControl) -> UInt8Array:
            return store.captures.picture(capture.capture_id)

        def done(picture_rgb: UInt8Array) -> None:
            if self._opened == capture.capture_id:
                self._view.show_picture(picture_rgb, self._rotation_deg)
                self.points.measure_all()
                self._load_surface(capture, picture_rgb)

        def failed(error: AdibasError) -> None:
            self._workspace.report_problem(error)
            self.points.measure_all()

        self._workspace.jobs.start(_("Opening the picture"), work, done, failed)

    def _load_surface(self, capture: Capture, picture_rgb: UInt8Array) -> None:
        store = self._workspace.store
        session, rotation_deg = self._session, self._rotation_deg

        def work(_control: JobControl) -> "tuple[BurstDisparity | None, Opened]":
            from adibas.pipeline.protocol_measuring import wish_of_session
            from adibas.pipeline.review import CaptureSurface

            surface = store.captures.surface(capture.capture_id)
            on_surface = CaptureSurface(surface, capture.calibration, capture.detected)
            target = _target(None if session is None else session.setup.markers)
            wish = None if session is None else wish_of_session(session)[0]
            height, width = picture_rgb.shape[:2]
            on_surface.snapped(picture_rgb, width / 2, height / 2, target=target)  # loads kernels
            protocol = None if wish is None else wish.protocol
            return surface, Opened(picture_rgb, on_surface, target, protocol, rotation_deg)

        def done(found: "tuple[BurstDisparity | None, Opened]") -> None:
            if self._opened == capture.capture_id:
                self._surface = found[0]
                self.points.give_surface(found[1])

        self._workspace.jobs.start(_("Opening the depth"), work, done)

    def _on_corrected(self, capture: Capture) -> None:
        """Keep what was saved; the strip counts markers."""
        if capture.capture_id not in self._captures:
            return  # saved late, when another session is shown already
        self._was_corrected = True
        self._captures[capture.capture_id] = capture
        self._show_strip()

    def _suggest_names(self, pseudonym: str | None) -> None:
        """Suggest the names of a patient; those of another one go at once."""
        if pseudonym == self._names_of:
            return
        self._names_of = pseudonym
        self._view.show_names(())
        if pseudonym is not None:
            self._collect_names(pseudonym)

    def _collect_names(self, pseudonym: str) -> None:
        store = self._workspace.store

        def work(_control: JobControl) -> tuple[str, ...]:
            newest = store.sessions.of_patient(pseudonym)[:N_SESSIONS_FOR_NAMES]
            captures = [c for one in newest for c in store.captures.of_session(one.session_id)]
            labels = {marker.label for capture in captures for marker in capture.markers()}
            return tuple(sorted(label for label in labels if not is_numbered(label)))

        def done(names: tuple[str, ...]) -> None:
            if self._names_of == pseudonym:
                self._view.show_names(names)

        self._workspace.jobs.start(_("Collecting names"), work, done)


def _target(document: Mapping[str, object] | None) -> "MarkerTarget | None":
    """Return what the session's markers look like; None where that is not known any more."""
    from adibas.pipeline.targets import target_from_document

    try:
        return None if document is None else target_from_document(document)
    except MarkerError:
        return None
