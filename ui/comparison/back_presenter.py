"""The back and the whole body in two sessions, measured when looked at. Knows nothing of Qt."""

from typing import Protocol

from adibas.data.sessions import Session
from adibas.progress import Progress
from adibas.sessions import SessionStore
from adibas.texts import message
from ui.comparison.back_content import Backs, SeenBack, seen_back
from ui.comparison.body_content import Bodies, SeenBody, seen_body
from ui.comparison.on_sight import OnSight, Sessions, read_both
from ui.workspace import Workspace

MEASURING = message("The backs are being measured.")
JOINING = message("The views are being joined.")


class BackView(Protocol):
    """The pages with backs and bodies, as these presenters need them."""

    def show_backs(self, backs: Backs) -> None:
        """Show the backs of both sessions."""

    def show_bodies(self, bodies: Bodies) -> None:
        """Show the surfaces of both sessions."""


def back_presenter(view: BackView, workspace: Workspace) -> OnSight[Backs]:
    """Return what measures the backs."""
    return OnSight(workspace, MEASURING, read_backs, view.show_backs, _waiting_for_backs)


def body_presenter(view: BackView, workspace: Workspace) -> OnSight[Bodies]:
    """Return what joins the views."""
    return OnSight(workspace, JOINING, read_bodies, view.show_bodies, _waiting_for_bodies)


def read_backs(store: SessionStore, sessions: Sessions, progress: Progress) -> Backs:
    """Measure the backs of two sessions; what cannot be measured is told."""

    def back_of(store: SessionStore, session: Session) -> tuple[SeenBack, tuple[str, ...]]:
        from adibas.pipeline.stored_body import stored_back

        back = stored_back(store, session, progress)
        return seen_back(back), tuple(notice.text for notice in back.notices)

    return Backs(*read_both(store, sessions, back_of))


def read_bodies(store: SessionStore, sessions: Sessions, progress: Progress) -> Bodies:
    """Join the views of two sessions; what does not fit is told."""

    def body_of(store: SessionStore, session: Session) -> tuple[SeenBody, tuple[str, ...]]:
        from adibas.pipeline.stored_body import stored_body

        body = stored_body(store, session, progress)
        of_back = () if body.back is None else body.back.notices  # told on its own page
        return seen_body(body), tuple(one.text for one in body.notices if one not in of_back)

    return Bodies(*read_both(store, sessions, body_of))


def _waiting_for_backs(sentence: str) -> Backs:
    return Backs(sentences=(sentence,) if sentence else ())


def _waiting_for_bodies(sentence: str) -> Bodies:
    return Bodies(sentences=(sentence,) if sentence else ())
