"""The pictures of a session as DICOM secondary captures.

Source: DICOM PS3.3, section A.8.1; PS3.3, section C.7.6.1.1.1 (patient orientation).
"""

from typing import TYPE_CHECKING

from adibas.data.report import CaptureReport
from adibas.exchange.content import Handover
from adibas.exchange.dicom_common import (
    MAKER,
    PICTURES,
    describe,
    instance_uid,
    is_recognisable,
    person_name,
    series_uid,
    study_uid,
)
from adibas.reports.facts import capture_names
from adibas.reports.pictures import draw_markers, picture_of

if TYPE_CHECKING:
    from highdicom.sc import SCImage

HEIGHT_PX = 1100
ORIENTATIONS = {
    "anterior": ("L", "F"),
    "posterior": ("R", "F"),
    "right_lateral": ("A", "F"),
    "left_lateral": ("P", "F"),
}
"""Where rows and columns of an upright picture go, on the patient."""


def secondary_captures(handover: Handover) -> list["SCImage"]:
    """Return the picture of every capture, upright, with its markers.

    Raises
    ------
    ReportError
        The pictures cannot be as the report asks.
    """
    report = handover.report
    named = zip(capture_names(report), report.captures, strict=True)
    return [
        _secondary_capture(handover, capture, name, number)
        for number, (name, capture) in enumerate(named, 1)
    ]


def _secondary_capture(
    handover: Handover, capture: CaptureReport, name: str, number: int
) -> "SCImage":
    from highdicom.sc import SCImage

    report, view = handover.report, capture.analysis.view
    picture = picture_of(capture.analysis, report.pictures, report.rotation_deg, is_cropped=True)
    dataset = SCImage(
        draw_markers(picture, HEIGHT_PX),
        photometric_interpretation="RGB",
        bits_allocated=8,
        coordinate_system="PATIENT",
        patient_orientation=ORIENTATIONS.get(view, ORIENTATIONS["anterior"]),
        study_instance_uid=study_uid(handover),
        series_instance_uid=series_uid(handover, PICTURES),
        series_number=PICTURES.number,
        sop_instance_uid=instance_uid(handover, PICTURES, number),
        instance_number=number,
        manufacturer=MAKER,
    )
    describe(dataset, handover, PICTURES, number)
    if view not in ORIENTATIONS:
        dataset.PatientOrientation = []
    dataset.BodyPartExamined = "WHOLEBODY"
    dataset.OperatorsName = person_name(report.operator)
    dataset.BurnedInAnnotation = "NO"  # names of markers, none of people
    dataset.RecognizableVisualFeatures = "YES" if is_recognisable(handover) else "NO"
    dataset.ImageComments = name
    del dataset.DateOfSecondaryCapture, dataset.TimeOfSecondaryCapture
    return dataset
