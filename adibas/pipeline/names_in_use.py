"""What names the markers of each set of landmarks, and which corrected sessions could teach it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import TYPE_CHECKING

from adibas.data.views import VIEWS
from adibas.pipeline.namers import OwnNames, keep_own_model, own_models
from adibas.pipeline.skeleton_examples import LandmarkSet, corrected_sets, landmarks_of
from adibas.pipeline.skeleton_labelling import shipped_knows
from adibas.pipeline.skeleton_sessions import LEAST_EXAMPLES, HeldOut, train_from_sessions
from adibas.progress import Progress
from adibas.sessions import SessionStore

if TYPE_CHECKING:
    from adibas.sessions.correcting import CorrectedCapture


@dataclass(frozen=True, slots=True)
class NamesInUse:
    """Who names the markers of one set of landmarks.

    Attributes
    ----------
    which : LandmarkSet
        Of a protocol that need not be there any more; without one: sessions that follow none.
    n_captures, n_sessions, n_patients : int
        With a corrected marker.
    n_sessions_since : int
        Of these sessions, those with a correction since the own model read them; all of them
        where there is none.
    n_needed : int
        Captures, to learn from them.
    learned : Mapping or None
        The provenance of the own model; None: there is none.
    learned_utc : datetime or None
        When the own model read its captures; None where nobody knows.
    is_shipped_known : bool
        Whether the shipped model names these landmarks.
    """

    which: LandmarkSet
    n_captures: int
    n_sessions: int
    n_patients: int
    n_sessions_since: int
    n_needed: int
    learned: Mapping[str, object] | None
    learned_utc: datetime | None
    is_shipped_known: bool


def names_in_use(store: SessionStore) -> tuple[NamesInUse, ...]:
    """Return every set of landmarks that has corrected captures or an own model.

    Nothing of a patient is read: captures and sessions are counted.
    """
    corrected = corrected_sets(store)
    learned = {own.which: own for own in own_models()}
    return tuple(
        _in_use(which, corrected.get(which, ()), learned.get(which))
        for which in sorted({*corrected, *learned}, key=_place)
    )


def learn_own_names(store: SessionStore, which: LandmarkSet, progress: Progress) -> HeldOut:
    """Learn a model from the corrected captures of a set, and name its markers by it from now on.

    Raises
    ------
    FileError
        There are too few captures, the model would be worse than what names them now, or it
        cannot be written: then all stays as it was.
    """
    model, held_out = train_from_sessions(store, progress, which)
    held_out.check()
    keep_own_model(model)
    return held_out


def _place(which: LandmarkSet) -> tuple[str, int]:
    """Return what sets are sorted by: views in their usual order."""
    return which.protocol, ("", *VIEWS).index(which.view)


def _in_use(
    which: LandmarkSet, captures: "Sequence[CorrectedCapture]", own: OwnNames | None
) -> NamesInUse:
    read_utc = None if own is None else own.learned_utc
    since = [one for one in captures if read_utc is None or one.corrected_utc >= read_utc]
    return NamesInUse(
        which,
        len(captures),
        len({one.session_id for one in captures}),
        len({one.patient for one in captures}),
        len({one.session_id for one in since}),
        LEAST_EXAMPLES,
        None if own is None else own.provenance,
        read_utc,
        shipped_knows(landmarks_of(which)),
    )
