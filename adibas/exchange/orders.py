"""What was ordered at the clinic, as a work list tells it: whom to measure, and under what number.

Source: DICOM PS3.4, annex K (modality worklist).
"""

from dataclasses import dataclass
from datetime import date, datetime

from adibas.data.patients import Identity
from adibas.errors import ExchangeError

SEXES = {"F": "female", "M": "male"}


@dataclass(frozen=True, slots=True, repr=False)
class Order:
    """One line of a work list; as secret as an `Identity`.

    Attributes
    ----------
    accession_number : str
        Of the order.
    study_uid : str
        That its files must have; empty where the list gives none.
    patient_id, patient_name, birth_date, sex : str
        As DICOM writes them.
    procedure_id, procedure : str
        What was asked for.
    start : str
        When, ``YYYYMMDD`` or ``YYYYMMDDHHMMSS``.
    """

    accession_number: str
    study_uid: str
    patient_id: str
    patient_name: str
    birth_date: str
    sex: str
    procedure_id: str
    procedure: str
    start: str

    def __repr__(self) -> str:
        return f"Order({self.accession_number}, hidden)"


@dataclass(frozen=True, slots=True, repr=False)
class OrderedPerson:
    """Whom an order is of, as the store keeps a patient; as secret as an `Identity`.

    Attributes
    ----------
    name : str
        Given name first; empty where the list tells none.
    birth_date : date or None
        None where it is not told, or no day.
    record_number : str
        Of the clinic.
    sex : str
        Of `adibas.data.patients.SEXES`; empty where it is told otherwise or not.
    """

    name: str
    birth_date: date | None
    record_number: str
    sex: str

    def __repr__(self) -> str:
        return "OrderedPerson(hidden)"


def ordered_person(order: Order) -> OrderedPerson:
    """Return whom an order is of.

    Source: DICOM PS3.5, section 6.2.1 (family, given, middle name, prefix, suffix; further
    scripts after an equals sign).
    """
    parts = order.patient_name.partition("=")[0].split("^")
    family, given, middle, prefix, suffix = (*parts, "", "", "", "", "")[:5]
    name = " ".join(" ".join((prefix, given, middle, family, suffix)).split())
    return OrderedPerson(
        _printable(name),
        _day(order.birth_date),
        _printable(order.patient_id.strip()),
        SEXES.get(order.sex.upper(), ""),
    )


def start_of(order: Order) -> datetime | None:
    """Return when an order is to be done, by the clinic's clock; None where no day is told."""
    has_time = len(order.start) >= len("YYYYMMDDHHMM")
    try:
        return datetime.strptime(
            order.start[:12] if has_time else order.start, "%Y%m%d%H%M" if has_time else "%Y%m%d"
        )
    except ValueError:
        return None


def _day(text: str) -> date | None:
    try:
        return datetime.strptime(text, "%Y%m%d").date()
    except ValueError:
        return None


def _printable(text: str) -> str:
    """Return a text without what would steer a screen."""
    return "".join(one for one in text if one.isprintable())


def check_same_patient(order: Order, identity: Identity) -> None:
    """See that an order is of the patient of the session, as far as both tell.

    Raises
    ------
    ExchangeError
        Record numbers or birth dates differ.
    """
    number = identity.record_number.strip()
    born = "" if identity.birth_date is None else identity.birth_date.strftime("%Y%m%d")
    pairs = ((number, order.patient_id.strip()), (born, order.birth_date))
    if any(ours and theirs and ours != theirs for ours, theirs in pairs):
        raise ExchangeError(
            "Order {order} is of another patient than the session: record number or birth date "
            "differ. Check both, and that it is the right session.",
            order=order.accession_number,
        )
