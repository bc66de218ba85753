"""The PDF report of a session inside a DICOM file.

Source: DICOM PS3.3, sections A.45.1 and C.24.
"""

from typing import TYPE_CHECKING

from adibas.exchange.content import Handover
from adibas.exchange.dicom_common import DOCUMENT, SCHEME, describe, is_recognisable
from adibas.reports.pdf import HEADING, encoded_pdf
from adibas.texts import translate as _

if TYPE_CHECKING:
    from pydicom import Dataset


def encapsulated_pdf(handover: Handover) -> "Dataset":
    """Return the file that holds the report.

    Raises
    ------
    ReportError
        The pictures cannot be as the report asks.
    """
    from highdicom.sr import CodedConcept
    from pydicom import Dataset
    from pydicom.uid import EncapsulatedPDFStorage

    pdf = encoded_pdf(handover.report)
    dataset = Dataset()
    dataset.SOPClassUID = EncapsulatedPDFStorage
    describe(dataset, handover, DOCUMENT, 1)
    dataset.AcquisitionDateTime = dataset.StudyDate + dataset.StudyTime
    dataset.ConversionType = "WSD"
    dataset.BurnedInAnnotation = "NO"
    dataset.RecognizableVisualFeatures = "YES" if is_recognisable(handover) else "NO"
    dataset.VerificationFlag = "UNVERIFIED"
    dataset.DocumentTitle = _(HEADING)
    dataset.ConceptNameCodeSequence = [CodedConcept("posture-report", SCHEME, _(HEADING))]
    dataset.MIMETypeOfEncapsulatedDocument = "application/pdf"
    dataset.EncapsulatedDocumentLength = len(pdf)
    dataset.EncapsulatedDocument = pdf + b"\0" * (len(pdf) % 2)
    return dataset
