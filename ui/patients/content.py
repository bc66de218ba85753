"""What the patients screen shows and what is typed into it; without Qt."""

import json
import re
from dataclasses import asdict, dataclass
from datetime import date, datetime
from typing import TYPE_CHECKING, Literal, Self

from adibas.arrays import UInt8Array
from adibas.data.patients import Patient, allow_capture
from adibas.texts import translate as _

if TYPE_CHECKING:  # patients are listed before anything is known of their sessions
    from adibas.data.sessions import Session
    from adibas.sessions import PatientRow

CHILD_BELOW_YEARS = 18
OLDEST_YEARS = 130

ConsentState = Literal["given", "other", "withdrawn", "none"]
"""A capture may be made with the first alone; of ``other`` one stands, but for something else."""
Kind = Literal["patient", "session"]

_DAY_FIRST = re.compile(r"(\d{1,2})[/.\- ](\d{1,2})[/.\- ](\d{4})")
_YEAR_FIRST = re.compile(r"(\d{4})-(\d{1,2})-(\d{1,2})")


@dataclass(frozen=True, slots=True)
class PatientLine:
    """One line of the list."""

    row: "PatientRow"
    age_years: int | None


@dataclass(frozen=True, slots=True)
class ShownPatient:
    """The chosen patient."""

    patient: Patient
    age_years: int | None
    consent: ConsentState
    can_change: bool


@dataclass(frozen=True, slots=True, eq=False)
class History:
    """The chosen patient's sessions, newest first, and what can be done now.

    Of the sessions some can be repeats: by their operator another one was before on their day.
    """

    sessions: "tuple[Session, ...]"
    can_start: bool
    can_continue: bool
    can_change: bool
    is_read_only: bool
    can_repeat: frozenset[str] = frozenset()


@dataclass(frozen=True, slots=True, eq=False)
class Thumbnail:
    """A capture in small, turned upright; None where its picture cannot be read."""

    capture_id: str
    view: str
    picture_rgb: UInt8Array | None


@dataclass(frozen=True, slots=True)
class UndoOffer:
    """What was deleted last: a patient by name, or a session by its start."""

    kind: Kind
    name: str
    started_utc: datetime | None = None


@dataclass(frozen=True, slots=True)
class PurgeQuestion:
    """What would be removed for good, and the word that has to be typed for it."""

    kind: Kind
    name: str
    n_sessions: int
    started_utc: datetime | None
    word: str


@dataclass(frozen=True, slots=True)
class PatientEntry:
    """A patient as typed."""

    name: str = ""
    birth_date: str = ""
    record_number: str = ""
    sex: str = ""
    notes: str = ""


@dataclass(frozen=True, slots=True)
class ConsentEntry:
    """A consent as typed; `guardian` is the guardian's name."""

    purposes: tuple[str, ...]
    is_guardian: bool
    guardian: str = ""


@dataclass(frozen=True, slots=True)
class Draft:
    """An open form as it stands.

    Attributes
    ----------
    edited : str or None
        Pseudonym of the patient; None for a new one.
    entry : PatientEntry or None
        None in the form of consents.
    consent : ConsentEntry or None
        None where none is given.
    is_new : bool
        Whether the form asks for a consent, too.
    seen : PatientEntry or None
        The patient from whom the entry was typed; None of a new one.
    """

    edited: str | None
    entry: PatientEntry | None
    consent: ConsentEntry | None
    is_new: bool
    seen: PatientEntry | None = None

    def to_text(self) -> str:
        """Return what `from_text` reads."""
        return json.dumps(asdict(self))

    @classmethod
    def from_text(cls, text: str) -> Self:
        """Return the form of a text that `to_text` gave."""
        known = json.loads(text)
        entry, consent = known["entry"], known["consent"]
        return cls(
            edited=known["edited"],
            entry=entry and PatientEntry(**entry),
            consent=consent and ConsentEntry(**consent | {"purposes": tuple(consent["purposes"])}),
            is_new=known["is_new"],
            seen=known["seen"] and PatientEntry(**known["seen"]),
        )


class EntryError(ValueError):
    """Something typed cannot be taken; `field` says where, `sentence` why, already translated."""

    def __init__(self, field: str, sentence: str) -> None:
        super().__init__(sentence)
        self.field = field
        self.sentence = sentence


def read_birth_date(text: str, today: date) -> date | None:
    """Return the day that was typed (27/3/2014, 27.3.2014, 2014-3-27); None for nothing.

    Raises
    ------
    EntryError
        It is no day, in the future, or too long ago for anybody alive.
    """
    typed = text.strip()
    if not typed:
        return None
    day_first, year_first = _DAY_FIRST.fullmatch(typed), _YEAR_FIRST.fullmatch(typed)
    found = day_first.groups()[::-1] if day_first else year_first.groups() if year_first else ()
    try:
        born = date(*(int(part) for part in found))
    except (TypeError, ValueError) as error:
        raise EntryError(
            "birth_date", _("Type the birth date as day, month, year, such as 27/03/2014.")
        ) from error
    if not 0 <= today.year - born.year <= OLDEST_YEARS or born > today:
        raise EntryError("birth_date", _("Nobody alive was born on that day. Check the year."))
    return born


def consent_state(patient: Patient) -> ConsentState:
    """Say whether a consent of a patient stands, and whether a capture may be made with it."""
    if allow_capture(patient.consents):
        return "given"
    if any(one.is_standing for one in patient.consents):
        return "other"
    return "withdrawn" if patient.consents else "none"
