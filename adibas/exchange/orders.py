"""What was ordered at the clinic, as a work list tells it: whom to measure, and under what number.

Source: DICOM PS3.4, annex K (modality worklist).
"""

from dataclasses import dataclass

from adibas.data.patients import Identity
from adibas.errors import ExchangeError


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
