"""How well the measures of a protocol repeat in one clinic, from the sessions that its store keeps.

Sessions that the operator calls repeats, with the one before them on that day, are repeats with the
markers placed anew; captures of one view in one session are repeats with the same markers. Of
several such series of a patient the one counts in which the markers were placed most often, of
these the one with most repeats: between them a patient may have changed, on one day by what was
treated.
"""

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import groupby

from adibas.clock import day_here
from adibas.data.protocol_measures import ProtocolMeasures
from adibas.data.protocols import KINDS
from adibas.data.reliability import Reliability, Repeat
from adibas.data.sessions import Capture, Session
from adibas.measures.reliability import LEAST_REPEATS, reliability_of, unwrap_repeats
from adibas.pipeline.protocol_measuring import ProtocolWish, measured_capture
from adibas.progress import Progress
from adibas.sessions import SessionStore
from adibas.sessions.roles import Permission

Key = tuple[str, str]
"""View and measure."""


@dataclass(frozen=True, slots=True)
class ClinicReliability:
    """What repeats say of each measure of one protocol by one operator, by view and measure."""

    operator: str
    wish: ProtocolWish
    by_measure: dict[Key, Reliability]

    def mdc95(self) -> dict[Key, float]:
        """Return the smallest detectable changes that are known."""
        return {
            key: found.mdc95 for key, found in self.by_measure.items() if found.mdc95 is not None
        }


def measured_captures(
    store: SessionStore, session_id: str, wish: ProtocolWish
) -> tuple[ProtocolMeasures, ...]:
    """Return what a protocol measures in each capture of a session whose view it knows.

    Raises
    ------
    StoreError
        The session is gone.
    """
    session = store.sessions.get(session_id)
    return tuple(_measured(session, one, wish) for one in _known(store, session_id, wish))


def reliability_in_clinic(
    store: SessionStore, wish: ProtocolWish, operator: str, progress: Progress | None = None
) -> ClinicReliability:
    """Return how well each measure repeats in the hands of one operator."""
    store.require(Permission.COMPARE)
    repeats: dict[Key, list[Repeat]] = {}
    listed: set[str] = set()
    sessions = store.sessions.of_operator(operator)
    n_looked_at = 0
    for _patient, some in groupby(sessions, key=lambda session: session.patient):
        theirs = tuple(some)
        if progress is not None:
            progress(n_looked_at, len(sessions))
        n_looked_at += len(theirs)
        for key, values in _of_patient(store, wish, theirs, listed).items():
            repeats.setdefault(key, []).extend(values)
    measures = wish.protocol.measures
    angles = {one.measure_id for one in measures if KINDS[one.kind].quantity == "angle"}
    found = {
        key: reliability_of(unwrap_repeats(values) if key[1] in angles else values)
        for key, values in repeats.items()
    }
    return ClinicReliability(operator, wish, found)


def _known(store: SessionStore, session_id: str, wish: ProtocolWish) -> tuple[Capture, ...]:
    captures = store.captures.of_session(session_id)
    return tuple(capture for capture in captures if capture.view in wish.protocol.views)


def _measured(session: Session, capture: Capture, wish: ProtocolWish) -> ProtocolMeasures:
    return measured_capture(capture, capture.markers(), wish, session.setup.rotation_deg)


def _of_patient(
    store: SessionStore, wish: ProtocolWish, sessions: tuple[Session, ...], listed: set[str]
) -> dict[Key, list[Repeat]]:
    """Return the repeats of each measure in the series that counts; sessions oldest first.

    A series without repeats tells nothing and is not measured, but for views that are not `listed`
    yet: a measure without repeats is told as well.
    """
    best: dict[Key, list[Repeat]] = {}
    for some in _series(sessions):
        visits = [(session, _known(store, session.session_id, wish)) for session in some]
        counts = Counter(capture.view for _session, captures in visits for capture in captures)
        if max(counts.values(), default=0) < LEAST_REPEATS and set(counts) <= listed:
            continue
        listed |= set(counts)
        found: dict[Key, list[Repeat]] = {}
        for session, captures in visits:
            for key, repeat in _of_session(wish, session, captures, found):
                found.setdefault(key, []).append(repeat)
        for key, repeats in found.items():
            if _weight(repeats) >= _weight(best.get(key, [])):
                best[key] = repeats
    return best


def _weight(repeats: list[Repeat]) -> tuple[int, int]:
    """Return how often the markers were placed anew in a series, and how many repeats it has."""
    return sum(one.is_placed_anew for one in repeats), len(repeats)


def _series(sessions: tuple[Session, ...]) -> Iterator[tuple[Session, ...]]:
    """Give each session with the repeats that follow it on its day."""
    series: list[Session] = []
    for session in sessions:
        if series and not is_repeat_of(session, series[-1]):
            yield tuple(series)
            series.clear()
        series.append(session)
    if series:
        yield tuple(series)


def is_repeat_of(session: Session, before: Session) -> bool:
    """Say whether a session repeats the one before it."""
    is_same_day = day_here(session.started_utc) == day_here(before.started_utc)
    return session.setup.is_repeat and is_same_day


def _of_session(
    wish: ProtocolWish,
    session: Session,
    captures: tuple[Capture, ...],
    earlier: dict[Key, list[Repeat]],
) -> Iterator[tuple[Key, Repeat]]:
    seen = set(earlier)  # before anything of this session is added to it
    told: set[Key] = set()
    for capture in captures:
        measures = _measured(session, capture, wish)
        for result in measures.results:
            if result.main is None:
                continue
            key = (measures.view, result.definition.measure_id)
            value = result.main.value / result.definition.per_unit
            yield key, Repeat(session.patient, value, key in seen and key not in told)
            told.add(key)
