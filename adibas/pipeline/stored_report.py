"""Reports of sessions that the store keeps."""

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace

from adibas.data.report import PictureChoice, SessionComparison, SessionReport
from adibas.data.sessions import Session
from adibas.errors import ReportError
from adibas.pipeline.clinic_repeats import compare_stored
from adibas.pipeline.protocol_measuring import ProtocolWish, wish_of_session
from adibas.pipeline.session_comparison import check_comparable
from adibas.pipeline.session_report import capture_report, report_of_session
from adibas.sessions import SessionStore


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
    """

    language: str
    pictures: PictureChoice = PictureChoice.AS_IS
    protocol: ProtocolWish | None = None
    compared_with: str = ""


def stored_report(store: SessionStore, session_id: str, wish: ReportWish) -> SessionReport:
    """Return the report of a session, of its markers as corrected.

    Raises
    ------
    ReportError
        The session has no captures, or is compared with one of another patient or protocol.
    ProtocolError
        What is compared has no measures.
    StoreError
        The session is gone, or a file of it is damaged.
    """
    session = store.sessions.get(session_id)
    captures = store.captures.of_session(session_id)
    if not captures:
        raise ReportError("The session has no capture to report. Capture a view first.")
    protocol, notices = wish_of_session(session) if wish.protocol is None else (wish.protocol, ())
    reports = []
    for capture in captures:
        surface = store.captures.surface(capture.capture_id)
        picture_rgb = store.captures.picture(capture.capture_id)
        surface_per_m = None if surface is None else surface.mean_per_m
        shown = capture_report(capture, picture_rgb, surface_per_m, protocol)
        told = (*shown.analysis.notices, *notices)
        reports.append(replace(shown, analysis=replace(shown.analysis, notices=told)))
    report = report_of_session(session, tuple(reports), wish.language, wish.pictures)
    if not wish.compared_with:
        return report
    return replace(report, comparison=_compared(store, wish.compared_with, session, protocol))


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
    found = compare_stored(store, earlier_id, session.session_id, protocol)
    return SessionComparison(earlier.started_utc, found)


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
