"""The back and the whole body, as the captures and the turn of a saved session show them."""

from dataclasses import replace

from adibas.clock import Clock, utc_now
from adibas.data.sentence import Sentence
from adibas.data.sessions import Capture, Session
from adibas.errors import BodyError
from adibas.pipeline.back import Back, measure_back
from adibas.pipeline.body import POSTERIOR, VIEWS_ALL_AROUND, MeasuredBody, measure_views
from adibas.pipeline.body_landmarks import MarkedView
from adibas.pipeline.body_views import BodyView, person_in
from adibas.pipeline.posture import PostureParams
from adibas.pipeline.protocol_measuring import wish_of_session
from adibas.pipeline.provenance import provenance_of
from adibas.pipeline.session import calibration_of
from adibas.pipeline.turning import RecordedTurn, follow_turn
from adibas.progress import Progress
from adibas.sessions import SessionStore
from adibas.texts import message

TURN = "turn"
"""What the recording is called in errors."""
FROM_TURN = message(
    "The standing views do not show the body all around: it is measured in the slow turn."
)


def stored_view(store: SessionStore, capture: Capture, rotation_deg: int = 0) -> BodyView | None:
    """Return the person in a capture's surface, with the picture; None where no depth was kept.

    `rotation_deg` is how far the pictures of its session are turned clockwise to be upright.

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
    view = person_in(
        *(capture.view, surface, capture.calibration), name=capture.view, rotation_deg=rotation_deg
    )
    return replace(view, picture_rgb=store.captures.picture(capture.capture_id))


def stored_back(
    store: SessionStore, session: Session, progress: Progress, clock: Clock = utc_now
) -> Back:
    """Measure the back in the last posterior capture, with the markers as corrected.

    Without such a capture the back is measured in the session's turn.

    Raises
    ------
    BodyError
        There is neither, or the back cannot be measured in it.
    StoreError
        A file is missing or damaged.
    """
    capture = store.captures.latest(session.session_id).get(POSTERIOR)
    if capture is None and session.setup.turn:
        back = _turned_body(store, session, progress, clock).back
        if back is None:
            raise ValueError("a turn begins with the back")
        return back
    if capture is None:
        raise BodyError(
            "The session has no posterior view, and the back is measured in it. Capture one."
        )
    view = stored_view(store, capture, session.setup.rotation_deg)
    if view is None:
        raise BodyError(
            "No depth was kept with the posterior view, and a surface takes depth. Capture it "
            "again with a calibrated sensor."
        )
    return measure_back(view, capture.markers())


def stored_body(
    store: SessionStore, session: Session, progress: Progress, clock: Clock = utc_now
) -> MeasuredBody:
    """Join the last capture of each view into one surface, and measure it.

    Views whose depth was not kept are left out. Where they do not show the body all around and a
    turn was recorded, the turn takes their place.

    Raises
    ------
    BodyError
        No capture has depth, one shows nobody, the views do not fit together, the back cannot be
        measured, or nobody turns in the turn.
    StoreError
        A file is missing or damaged.
    """
    captures = store.captures.latest(session.session_id)
    rotation_deg = session.setup.rotation_deg
    seen = {view: stored_view(store, one, rotation_deg) for view, one in captures.items()}
    views = {name: view for name, view in seen.items() if view is not None}
    if len(views) < VIEWS_ALL_AROUND and session.setup.turn:
        return _turned_body(store, session, progress, clock)
    if not views:
        raise BodyError(
            "The session has no view with depth, and a surface takes depth. Capture the standing "
            "views, or a slow turn, with a calibrated sensor."
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


def _turned_body(
    store: SessionStore, session: Session, progress: Progress, clock: Clock
) -> MeasuredBody:
    """Measure the body in the session's turn; no markers are looked for in it."""
    recording_id = session.setup.turn
    with store.recordings.open(recording_id) as recording:
        frames = range(len(recording.timestamps_ns))
        calibration = calibration_of(recording, None)
        turn = RecordedTurn(
            recording, calibration, frames, TURN, rotation_deg=session.setup.rotation_deg
        )
        seen = follow_turn(turn, progress)
    where_from = provenance_of(
        *(store.recordings.facts(recording_id).sha256, calibration, None, PostureParams(), clock())
    )
    body = measure_views(
        [MarkedView(view) for view in seen.views],
        dict.fromkeys(seen.frames, where_from),
        session.patient,
    )
    return replace(body, notices=(Sentence(FROM_TURN), *seen.notices, *body.notices))
