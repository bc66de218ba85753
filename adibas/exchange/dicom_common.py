"""What every DICOM file of a session says: whose it is, of which study, made by what.

Source: DICOM PS3.3, sections C.7.1.1 (patient), C.7.2.1 (study), C.7.3.1 (series), C.7.5.1
(equipment), C.12.1 (SOP common).
"""

import re
from dataclasses import dataclass
from datetime import datetime
from typing import TYPE_CHECKING

from adibas.data.report import PictureChoice
from adibas.errors import ReportError
from adibas.exchange.content import Handover
from adibas.exchange.identifiers import stable_uid
from adibas.files import printable
from adibas.texts import Message, message
from adibas.texts import translate as _

if TYPE_CHECKING:
    from pydicom import Dataset

MAKER = "ADiBAS"
SCHEME = "99ADIBAS"
"""Of codes that no vocabulary has; 99 says that they are a maker's own."""
SCHEME_UID = stable_uid("measures")
LONGEST_TEXT, LONGEST_SHORT_TEXT = 64, 16
"""Of the value representations LO and SH."""
UTF_8 = "ISO_IR 192"
CUT_OFF = "\N{HORIZONTAL ELLIPSIS}"
SEXES = {"": "", "female": "F", "male": "M"}
PSEUDONYMISED = "Pseudonym; no free notes; head and surroundings hidden"

SEPARATORS = re.compile(r"[\\^=\s]+")
"""Backslashes, carets and equals signs take names apart; a line has no ends."""


@dataclass(frozen=True, slots=True)
class Series:
    """One of the series of a session's study."""

    number: int
    kind: str
    modality: str
    description: Message


PICTURES = Series(1, "pictures", "XC", message("Pictures with markers"))
DOCUMENT = Series(2, "document", "DOC", message("Posture report"))
MEASURES = Series(3, "measures", "SR", message("Measures"))


def study_uid(handover: Handover) -> str:
    """Return the study of a session: that of its order, or its own."""
    ordered = "" if handover.order is None else handover.order.study_uid
    return ordered or stable_uid("study", handover.session_id)


def series_uid(handover: Handover, series: Series) -> str:
    """Return the UID of a series of the session."""
    return stable_uid("series", study_uid(handover), series.kind)


def instance_uid(handover: Handover, series: Series, number: int) -> str:
    """Return the UID of a file: the same as long as nothing that is told changes.

    An archive keeps what it has of a UID, so what was corrected needs another one.
    """
    return stable_uid("instance", handover.session_id, series.kind, str(number), handover.revision)


def describe(dataset: "Dataset", handover: Handover, series: Series, number: int) -> None:
    """Put into a file whose it is, and what it belongs to."""
    dataset.SpecificCharacterSet = UTF_8
    dataset.SOPInstanceUID = instance_uid(handover, series, number)
    dataset.InstanceNumber = str(number)
    _describe_patient(dataset, handover)
    _describe_study(dataset, handover)
    dataset.SeriesInstanceUID = series_uid(handover, series)
    dataset.SeriesNumber = str(series.number)
    dataset.SeriesDescription = _(series.description)
    dataset.Modality = series.modality
    dataset.Manufacturer = MAKER
    dataset.ManufacturerModelName = MAKER
    dataset.SoftwareVersions = handover.report.version
    serial = line(handover.report.captures[0].analysis.calibration.sensor_serial)
    dataset.DeviceSerialNumber = serial
    _describe_times(dataset, handover.started_utc)
    dataset.CodingSchemeIdentificationSequence = [_scheme()]
    for equipment in dataset.get("ContributingEquipmentSequence", ()):
        equipment.pop("ContributionDateTime", None)  # the same UID stands for the same bytes


def line(text: str, longest: int = LONGEST_TEXT) -> str:
    """Return a text as one line that DICOM holds, its end cut off where it is too long.

    The standard counts characters, but readers that do not look for the character set count bytes.
    """
    written = SEPARATORS.sub(" ", printable(text)).strip()
    if len(written.encode()) <= longest:
        return written
    room = longest - len(CUT_OFF.encode())
    return written.encode()[:room].decode(errors="ignore").rstrip() + CUT_OFF


def person_name(name: str) -> str:
    """Return a name that nobody took apart into family and given names."""
    written = line(name, LONGEST_TEXT - 1)
    return f"{written}^" if written else ""


def is_recognisable(handover: Handover) -> bool:
    """Say whether pictures show the patient as she is."""
    return handover.report.pictures is PictureChoice.AS_IS


def _describe_patient(dataset: "Dataset", handover: Handover) -> None:
    subject, order = handover.subject, handover.order
    identity = subject.identity
    if order is not None:
        # As the archive knows the patient, or it takes her for another one.
        dataset.PatientName = order.patient_name
        dataset.PatientID = order.patient_id
        dataset.PatientBirthDate = order.birth_date
        dataset.PatientSex = order.sex
        dataset.PatientIdentityRemoved = "NO"
    elif identity is None:
        dataset.PatientName = person_name(subject.pseudonym)
        dataset.PatientID = subject.pseudonym
        dataset.PatientBirthDate = dataset.PatientSex = ""
        if is_recognisable(handover):
            dataset.PatientIdentityRemoved = "NO"
        else:
            dataset.PatientIdentityRemoved = "YES"
            dataset.DeidentificationMethod = PSEUDONYMISED
    else:
        born = identity.birth_date
        dataset.PatientName = person_name(identity.name)
        dataset.PatientID = _number(identity.record_number) or subject.pseudonym
        dataset.PatientBirthDate = "" if born is None else born.strftime("%Y%m%d")
        dataset.PatientSex = SEXES[subject.sex]
        dataset.PatientIdentityRemoved = "NO"


def _number(record_number: str) -> str:
    """Return a record number; a part of one would be the number of somebody else."""
    number = record_number.strip()
    if len(number) > LONGEST_TEXT or line(number) != number:
        raise ReportError(
            "The patient's record number cannot stand in a DICOM file: it is longer than "
            "{most} characters, or has one that DICOM does not hold. Correct it with the "
            "patient's data, or hand over without the identity.",
            most=LONGEST_TEXT,
        )
    return number


def _describe_study(dataset: "Dataset", handover: Handover) -> None:
    dataset.StudyInstanceUID = study_uid(handover)
    dataset.StudyID = handover.session_id[:LONGEST_SHORT_TEXT]
    dataset.StudyDescription = _("Posture analysis")
    order = handover.order
    dataset.AccessionNumber = "" if order is None else order.accession_number
    dataset.ReferringPhysicianName = ""


def _describe_times(dataset: "Dataset", started_utc: datetime) -> None:
    """Put in when the session began, as the clinic's clock showed it."""
    moment = started_utc.astimezone()
    day, time = moment.strftime("%Y%m%d"), moment.strftime("%H%M%S")
    for name in ("Study", "Series", "Content", "InstanceCreation"):
        setattr(dataset, f"{name}Date", day)
        setattr(dataset, f"{name}Time", time)
    dataset.TimezoneOffsetFromUTC = moment.strftime("%z")[:5]


def _scheme() -> "Dataset":
    from pydicom import Dataset

    scheme = Dataset()
    scheme.CodingSchemeDesignator = SCHEME
    scheme.CodingSchemeUID = SCHEME_UID
    scheme.CodingSchemeName = "ADiBAS measures of posture"
    return scheme
