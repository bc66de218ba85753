"""Which sessions of a patient may be compared, and how each measure went on between them."""

from dataclasses import dataclass

from adibas.data.reliability import Comparison
from adibas.data.sessions import Session
from adibas.data.trends import Trend
from adibas.errors import ReportError
from adibas.measures.comparison import compare_sessions
from adibas.measures.trends import Key, Visit, trends_of
from adibas.pipeline.clinic_repeats import measured_captures
from adibas.pipeline.protocol_measuring import ProtocolWish
from adibas.progress import Progress
from adibas.sessions import SessionStore
from adibas.sessions.roles import Permission


@dataclass(frozen=True, slots=True)
class PatientTrends:
    """How a patient's measures went on.

    Attributes
    ----------
    trends : tuple of Trend
        Of every measure that has a value.
    n_other_protocol : int
        Sessions that follow another protocol and are in no trend.
    n_without : int
        Sessions that have no value of this protocol.
    """

    trends: tuple[Trend, ...]
    n_other_protocol: int
    n_without: int


def is_earlier(first: Session, second: Session) -> bool:
    """Say whether a session may stand before another one: it began before."""
    return first.started_utc < second.started_utc


def check_comparable(earlier: Session, later: Session) -> None:
    """Refuse sessions of two patients or of two protocols, and those in the wrong order.

    Raises
    ------
    ReportError
        They are, or the first one is not earlier than the second.
    """
    if earlier.patient != later.patient:
        raise ReportError(
            "The two sessions are of different patients, and a change is one of one patient. "
            "Choose another session."
        )
    if not _is_alike(earlier, later):
        raise ReportError(
            "The two sessions follow different protocols, {first} and {second}, and cannot be "
            "compared.",
            first=earlier.setup.protocol,
            second=later.setup.protocol,
        )
    if earlier.session_id == later.session_id:
        raise ReportError(
            "Session {session} cannot be compared with itself. Choose an earlier session of the "
            "patient.",
            session=later.session_id,
        )
    if not is_earlier(earlier, later):
        raise ReportError(
            "Session {first} is not earlier than session {second}, and a change is told from the "
            "earlier one to the later. Choose an earlier session, or change the two over.",
            first=earlier.session_id,
            second=later.session_id,
        )


def last_two_alike(
    sessions: tuple[Session, ...], until: Session | None = None
) -> tuple[Session, Session] | None:
    """Return the newest two sessions of one protocol, the earlier first; None where none are.

    Parameters
    ----------
    sessions : tuple of Session
        Of one patient, in any order.
    until : Session or None
        The later of the two, where an earlier one is like it.
    """
    newest_first = sorted(sessions, key=lambda one: one.started_utc, reverse=True)
    later_ones = newest_first if until is None else [until, *newest_first]
    for later in later_ones:
        for earlier in newest_first:
            if is_earlier(earlier, later) and earlier.setup.protocol == later.setup.protocol:
                return earlier, later
    return None


def compare_by_protocol(
    store: SessionStore,
    earlier: Session,
    later: Session,
    wish: ProtocolWish,
    mdc95: dict[Key, float],
) -> Comparison:
    """Return the change of every measure between two sessions.

    Raises
    ------
    ReportError
        They are of two patients or protocols, or in the wrong order.
    ProtocolError
        A session has no measure of the protocol, or the vertical of one is not known.
    StoreError
        A session is gone.
    """
    store.require(Permission.COMPARE, later.session_id)
    check_comparable(earlier, later)
    before = measured_captures(store, earlier.session_id, wish)
    after = measured_captures(store, later.session_id, wish)
    return compare_sessions(before, after, mdc95)


def patient_trends(
    store: SessionStore,
    like: Session,
    wish: ProtocolWish,
    mdc95: dict[Key, float],
    progress: Progress | None = None,
) -> PatientTrends:
    """Return every measure of a patient over the sessions that may be compared with one of them.

    Raises
    ------
    StoreError
        The store cannot be read.
    """
    store.require(Permission.COMPARE, like.session_id)
    sessions = store.sessions.of_patient(like.patient)
    alike = [one for one in sessions if _is_alike(one, like)]
    visits = []
    for number, session in enumerate(alike):
        if progress is not None:
            progress(number, len(alike))
        captures = measured_captures(store, session.session_id, wish)
        if any(result.main is not None for one in captures for result in one.results):
            visits.append(Visit(session.session_id, session.started_utc, captures))
    return PatientTrends(
        trends_of(visits, mdc95), len(sessions) - len(alike), len(alike) - len(visits)
    )


def _is_alike(first: Session, second: Session) -> bool:
    """Say whether two sessions follow one protocol, or one of them none."""
    names = (first.setup.protocol, second.setup.protocol)
    return "" in names or names[0] == names[1]
