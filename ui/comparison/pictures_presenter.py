"""The pictures of two sessions, view by view. Knows nothing of Qt."""

from typing import Protocol

from adibas.data.posture import VIEWS
from adibas.data.sessions import Capture, Session
from adibas.pipeline.picture_overlay import PlacedMarkers, lay_over
from adibas.sessions import SessionStore
from adibas.texts import translate as _
from ui.comparison.content import Pair, Seen
from ui.ports import Job, JobControl
from ui.workspace import Workspace


class PicturesView(Protocol):
    """The page with pictures, as this presenter needs it."""

    def show_pair(self, views: tuple[str, ...], pair: Pair | None) -> None:
        """Offer the views that either session has, and show one of them; None: it is read."""


class PicturesPresenter:
    """Reads the pictures of one view of both sessions beside the window."""

    def __init__(self, view: PicturesView, workspace: Workspace) -> None:
        self._view = view
        self._workspace = workspace
        self._sessions: tuple[Session | None, Session | None] = (None, None)
        self._chosen = ""
        self._views: tuple[str, ...] = ()
        self._job: Job | None = None

    def show(self, earlier: Session | None, later: Session | None) -> None:
        """Show these two; the view that was seen stays where one of them has it."""
        self._sessions = (earlier, later)
        self._read()

    def choose_view(self, view: str) -> None:
        """Show another view."""
        if view != self._chosen:
            self._chosen = view
            self._read()

    def _read(self) -> None:
        if self._job is not None and self._job.is_running:
            self._job.cancel()
        self._view.show_pair(self._views, None)
        store, sessions, wanted = self._workspace.store, self._sessions, self._chosen

        def work(_control: JobControl) -> tuple[tuple[str, ...], Pair]:
            return read_pair(store, sessions, wanted)

        def done(found: tuple[tuple[str, ...], Pair]) -> None:
            self._views, pair = found
            self._chosen = pair.view
            self._view.show_pair(*found)

        self._job = self._workspace.jobs.start(_("Reading pictures"), work, done)


def read_pair(
    store: SessionStore, sessions: tuple[Session | None, Session | None], wanted: str
) -> tuple[tuple[str, ...], Pair]:
    """Return the views of two sessions, and one of them in both.

    Of several captures of one view the last counts, as for the numbers.
    """
    found = [_by_view(store, session) for session in sessions]
    views = tuple(view for view in (*VIEWS, "") if any(view in one for one in found))
    both = [view for view in views if all(view in one for one in found)]
    view = wanted if wanted in views else next(iter((*both, *views)), "")
    captures = [one.get(view) for one in found]
    earlier, later = (
        None if capture is None or session is None else _seen(store, session, capture)
        for session, capture in zip(sessions, captures, strict=True)
    )
    first, second = captures
    if first is None or second is None or earlier is None or later is None:
        return views, Pair(view, earlier, later)
    overlay = lay_over(
        PlacedMarkers(earlier.markers, first.calibration, earlier.rotation_deg),
        PlacedMarkers(later.markers, second.calibration, later.rotation_deg),
    )
    laid_rgb = overlay.laid(earlier.picture_rgb, later.picture_rgb.shape)
    return views, Pair(view, earlier, later, overlay, laid_rgb)


def _by_view(store: SessionStore, session: Session | None) -> dict[str, Capture]:
    return {} if session is None else store.captures.latest(session.session_id)


def _seen(store: SessionStore, session: Session, capture: Capture) -> Seen:
    picture_rgb = store.captures.picture(capture.capture_id)
    return Seen(picture_rgb, capture.markers(), session.setup.rotation_deg)
