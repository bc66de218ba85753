"""Reports of sessions that the store keeps."""

from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from datetime import datetime

from adibas.data.report import CaptureReport, PictureChoice, SessionComparison, SessionReport
from adibas.data.sessions import Capture, Session
from adibas.data.trends import Trend
from adibas.errors import ReportError
from adibas.pipeline.clinic_repeats import reliability_in_clinic
from adibas.pipeline.protocol_measuring import ProtocolWish, wish_of_session
from adibas.pipeline.session_comparison import (
    check_comparable,
    compare_by_protocol,
    patient_trends,
)
from adibas.pipeline.session_report import capture_report, report_of_session
from adibas.sessions import SessionStore
from adibas.sessions.roles import Permission


@dataclass(frozen=True, slots=True)
class ReportWish:
    """How reports are wanted.

    Attributes
    ----------
    language : str
        Two letters.
    pictures : PictureChoice
        How much they show.
    protocol : ProtocolWish or None
        What to measure; None: the protocol that the session names, in the sensor's plane.
    compared_with : str
        Id of an earlier session whose measures stand beside; empty for none.
    with_notes : bool
        Tell the session's notes: people are named in notes.
    """

    language: str
    pictures: PictureChoice = PictureChoice.AS_IS
    protocol: ProtocolWish | None = None
    compared_with: str = ""
    with_notes: bool = True


def stored_report(store: SessionStore, session_id: str, wish: ReportWish) -> SessionReport:
    """Return the report of a session, of its markers as corrected.

    Raises
    ------
    ReportError
        The session has no captures, or is compared with one of another patient or protocol, or
        with one that is not earlier.
    ProtocolError
        What is compared has no measures.
    StoreError
        The session is gone, or a file of it is damaged.
    NotAllowedError
        Reports are for another role.
    """
    store.require(Permission.REPORT, session_id)
    session = store.sessions.get(session_id)
    captures = store.captures.of_session(session_id)
    if not captures:
        raise ReportError("The session has no capture to report. Capture a view first.")
    protocol, notices = wish_of_session(session) if wish.protocol is None else (wish.protocol, ())
    reports = tuple(
        _with_notices(shown, notices) for shown in _measured(store, session, captures, protocol)
    )
    report = report_of_session(session, reports, wish.language, wish.pictures)
    if not wish.with_notes:
        report = replace(report, notes="")
    if not wish.compared_with:
        return report
    return replace(report, comparison=_compared(store, wish.compared_with, session, protocol))


def _measured(
    store: SessionStore,
    session: Session,
    captures: Iterable[Capture],
    protocol: ProtocolWish | None,
) -> Iterator[CaptureReport]:
    """Yield each capture as it was corrected."""
    rotation_deg = session.setup.rotation_deg
    for capture in captures:
        surface = store.captures.surface(capture.capture_id)
        picture_rgb = store.captures.picture(capture.capture_id)
        surface_per_m = None if surface is None else surface.mean_per_m
        yield capture_report(capture, picture_rgb, surface_per_m, protocol, rotation_deg)


def _with_notices(shown: CaptureReport, notices: tuple[str, ...]) -> CaptureReport:
    told = (*shown.analysis.notices, *notices)
    return replace(shown, analysis=replace(shown.analysis, notices=told))


def _compared(
    store: SessionStore, earlier_id: str, session: Session, protocol: ProtocolWish | None
) -> SessionComparison:
    """Return what changed since an earlier session of the same patient."""
    earlier = store.sessions.get(earlier_id)
    check_comparable(earlier, session)
    if protocol is None:
        raise ReportError(
            "Sessions are compared by the measures of a protocol, and none is told. Choose one."
        )
    mdc95 = reliability_in_clinic(store, protocol, session.operator).mdc95()
    found = compare_by_protocol(store, earlier, session, protocol, mdc95)
    trends = patient_trends(store, session, protocol, mdc95).trends
    captures = store.captures.of_session(earlier_id)
    return SessionComparison(
        since_utc=earlier.started_utc,
        comparison=found,
        trends=tuple(_until(one, session.started_utc) for one in trends if _began(one, session)),
        earlier=tuple(_measured(store, earlier, captures, protocol)),
        earlier_rotation_deg=earlier.setup.rotation_deg,
    )


def _began(trend: Trend, session: Session) -> bool:
    return trend.points[0].taken_utc <= session.started_utc


def _until(trend: Trend, time_utc: datetime) -> Trend:
    """Return what was known then."""
    points = tuple(point for point in trend.points if point.taken_utc <= time_utc)
    return replace(trend, points=points)


class StoredReports(Collection[SessionReport]):
    """The reports of several sessions, each read from the store when it is its turn."""

    def __init__(self, store: SessionStore, session_ids: Sequence[str], wish: ReportWish) -> None:
        self._store = store
        self._session_ids = tuple(session_ids)
        self._wish = wish

    def __len__(self) -> int:
        return len(self._session_ids)

    def __iter__(self) -> Iterator[SessionReport]:
        for session_id in self._session_ids:
            yield stored_report(self._store, session_id, self._wish)

    def __contains__(self, report: object) -> bool:
        return any(report == one for one in self)
