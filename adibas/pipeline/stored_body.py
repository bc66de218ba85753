"""The back and the whole body, as the captures of a saved session show them."""

from dataclasses import replace

from adibas.data.sentence import Sentence
from adibas.data.sessions import Capture, Session
from adibas.errors import BodyError
from adibas.pipeline.back import Back, measure_back
from adibas.pipeline.body import POSTERIOR, MeasuredBody, measure_views
from adibas.pipeline.body_landmarks import MarkedView
from adibas.pipeline.body_views import BodyView, person_in
from adibas.pipeline.protocol_measuring import wish_of_session
from adibas.sessions import SessionStore


def stored_view(store: SessionStore, capture: Capture) -> BodyView | None:
    """Return the person in a capture's surface, with the picture; None where no depth was kept.

    Raises
    ------
    BodyError
        Nobody is seen, or no floor.
    StoreError
        A file of the capture is missing or damaged.
    """
    surface = store.captures.surface(capture.capture_id)
    if surface is None or capture.calibration.depth is None:
        return None
    view = person_in(capture.view, surface, capture.calibration, name=capture.view)
    return replace(view, picture_rgb=store.captures.picture(capture.capture_id))


def stored_back(store: SessionStore, session: Session) -> Back:
    """Measure the back in the last posterior capture, with the markers as corrected.

    Raises
    ------
    BodyError
        There is no such capture, or the back cannot be measured in it.
    StoreError
        A file of the capture is missing or damaged.
    """
    capture = store.captures.latest(session.session_id).get(POSTERIOR)
    if capture is None:
        raise BodyError(
            "The session has no posterior view, and the back is measured in it. Capture one."
        )
    view = stored_view(store, capture)
    if view is None:
        raise BodyError(
            "No depth was kept with the posterior view, and a surface takes depth. Capture it "
            "again with a calibrated sensor."
        )
    return measure_back(view, capture.markers())


def stored_body(store: SessionStore, session: Session) -> MeasuredBody:
    """Join the last capture of each view into one surface, and measure it.

    Views whose depth was not kept are left out.

    Raises
    ------
    BodyError
        No capture has depth, one shows nobody, the views do not fit together, or the back cannot
        be measured.
    StoreError
        A file of a capture is missing or damaged.
    """
    captures = store.captures.latest(session.session_id)
    seen = {view: stored_view(store, one) for view, one in captures.items()}
    views = {name: view for name, view in seen.items() if view is not None}
    if not views:
        raise BodyError(
            "The session has no view with depth, and a surface takes depth. Capture the standing "
            "views with a calibrated sensor."
        )
    protocol, notices = wish_of_session(session)
    body = measure_views(
        [
            MarkedView(view, captures[name].markers(), captures[name].history.placed_by_hand())
            for name, view in views.items()
        ],
        {name: captures[name].provenance for name in views},
        session.patient,
        protocol,
    )
    told = (*body.notices, *(Sentence(notice) for notice in notices))
    return replace(body, notices=told)
