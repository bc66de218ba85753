"""Who is measured: identity apart from everything else, and linked to it by a pseudonym."""

from collections.abc import Iterable
from dataclasses import dataclass, field
from datetime import date, datetime

SEXES = ("", "female", "male")
PURPOSES = ("treatment", "research", "teaching")
"""What a patient may consent to."""
PURPOSE_OF_CAPTURE = "treatment"
"""What a measurement is taken for; the others say what else may be done with what was measured."""


@dataclass(frozen=True, slots=True, repr=False)
class Identity:
    """A person's name, birth date, and number in the clinic's records.

    It is shown in the window and kept in the encrypted store; it goes into no log, file name,
    error or report. Therefore it has no `repr` that tells anything.
    """

    name: str
    birth_date: date | None = None
    record_number: str = ""

    def __post_init__(self) -> None:
        if not self.name.strip():
            raise ValueError("a patient needs a name")

    def __repr__(self) -> str:
        return "Identity(hidden)"

    def age_years(self, on: date) -> int | None:
        """Return the whole years of age on a day; None where the birth date is not known."""
        born = self.birth_date
        if born is None:
            return None
        return on.year - born.year - ((on.month, on.day) < (born.month, born.day))


@dataclass(frozen=True, slots=True, repr=False)
class Consent:
    """That a patient, or the guardian of a child, agreed.

    Attributes
    ----------
    purposes : tuple of str
        Of `PURPOSES`.
    given_by : str
        Name of who signed; as secret as an `Identity`.
    is_guardian : bool
        True where a guardian signed for the patient.
    given_utc, withdrawn_utc : datetime
        When; None while it stands.
    """

    purposes: tuple[str, ...]
    given_by: str
    is_guardian: bool
    given_utc: datetime
    withdrawn_utc: datetime | None = None

    def __post_init__(self) -> None:
        unknown = set(self.purposes) - set(PURPOSES)
        if unknown or not self.purposes:
            raise ValueError(f"purposes must be some of {PURPOSES}, got {self.purposes}")
        if not self.given_by.strip():
            raise ValueError("a consent needs the name of who gave it")

    def __repr__(self) -> str:
        return f"Consent({self.purposes}, hidden)"

    @property
    def is_standing(self) -> bool:
        """Whether it was not withdrawn."""
        return self.withdrawn_utc is None


def allow_capture(consents: Iterable[Consent]) -> bool:
    """Say whether one of a patient's consents stands that a capture needs."""
    return any(one.is_standing and PURPOSE_OF_CAPTURE in one.purposes for one in consents)


@dataclass(frozen=True, slots=True)
class Patient:
    """One patient of the store.

    Attributes
    ----------
    pseudonym : str
        Stands for the patient everywhere but on the screen.
    identity : Identity
        Shown on the screen only.
    sex : str
        Of `SEXES`; empty where not told.
    notes : str
        Free text of the clinician.
    created_utc : datetime
        When the patient was added.
    consents : tuple of Consent
        In the order in which they were given.
    is_deleted : bool
        Hidden, until it is undone or purged.
    """

    pseudonym: str
    identity: Identity
    sex: str
    notes: str = field(repr=False)
    created_utc: datetime
    consents: tuple[Consent, ...] = ()
    is_deleted: bool = False

    def __post_init__(self) -> None:
        if self.sex not in SEXES:
            raise ValueError(f"sex must be one of {SEXES}, got {self.sex!r}")

    def age_years(self, on: date) -> int | None:
        """Return the whole years of age on a day; None where the birth date is not known."""
        return self.identity.age_years(on)
