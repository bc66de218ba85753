"""The numbers of a session as a DICOM structured report: TID 1500, measurement report.

Each capture is a group of measurements with its picture; each value has its unit, and how far its
95 % interval reaches up and down. What could not be measured stands in the PDF alone.

Source: DICOM PS3.16, TID 1500, 1501, 300 and 310.
"""

import re
from collections.abc import Sequence
from typing import TYPE_CHECKING

from adibas.exchange.content import CaptureResults, Handover, Result
from adibas.exchange.dicom_common import (
    LONGEST_SHORT_TEXT,
    MAKER,
    MEASURES,
    SCHEME,
    describe,
    instance_uid,
    line,
    person_name,
    series_uid,
    study_uid,
)
from adibas.exchange.identifiers import stable_uid
from adibas.exchange.orders import Order
from adibas.reports.rows import NumberRow
from adibas.texts import LANGUAGES
from adibas.texts import translate as _

if TYPE_CHECKING:
    from highdicom.sc import SCImage
    from highdicom.sr import (
        CodedConcept,
        ComprehensiveSR,
        LanguageOfContentItemAndDescendants,
        Measurement,
        MeasurementProperties,
        MeasurementsAndQualitativeEvaluations,
        ObservationContext,
    )
    from pydicom import Dataset

N_DECIMALS = 4
PLAIN = re.compile(r"[!-\[\]-~]+")
"""ASCII but spaces and backslashes."""
UPPER = ("371886008", "SCT", "+, range of upper measurement uncertainty")
LOWER = ("371885007", "SCT", "-, range of lower measurement uncertainty")


def measurement_report(handover: Handover, pictures: Sequence["SCImage"]) -> "ComprehensiveSR":
    """Return the structured report.

    Parameters
    ----------
    handover : Handover
        The session.
    pictures : sequence of SCImage
        Its secondary captures, one for each capture.
    """
    from highdicom.sr import CodedConcept, ComprehensiveSR, MeasurementReport
    from pydicom.sr.codedict import codes

    groups = [
        _group(handover, found, picture)
        for found, picture in zip(handover.captures, pictures, strict=True)
    ]
    content = MeasurementReport(
        observation_context=_observers(handover),
        procedure_reported=CodedConcept("posture", SCHEME, _("Posture analysis")),
        imaging_measurements=groups,
        title=codes.DCM.ImagingMeasurementReport,
        language_of_content_item_and_descendants=_language(handover.report.language),
        referenced_images=pictures,
    )
    dataset = ComprehensiveSR(
        evidence=pictures,
        content=content,
        series_instance_uid=series_uid(handover, MEASURES),
        series_number=MEASURES.number,
        sop_instance_uid=instance_uid(handover, MEASURES, 1),
        instance_number=1,
        manufacturer=MAKER,
        is_complete=True,
        is_final=True,
        requested_procedures=None
        if handover.order is None
        else [_request(handover, handover.order)],
    )
    describe(dataset, handover, MEASURES, 1)
    return dataset


def _group(
    handover: Handover, found: CaptureResults, picture: "SCImage"
) -> "MeasurementsAndQualitativeEvaluations":
    from highdicom import sr
    from pydicom.sr.codedict import codes

    view = sr.QualitativeEvaluation(
        codes.DCM.ImageView, _own(found.capture.analysis.view or "not-told", found.view)
    )
    intervals = sr.QualitativeEvaluation(
        _own("uncertainty", _("Intervals")), _own("ci95-instrument", _("95 %, instrument only"))
    )
    return sr.MeasurementsAndQualitativeEvaluations(
        tracking_identifier=sr.TrackingIdentifier(
            uid=stable_uid("group", handover.session_id, found.key), identifier=found.key
        ),
        method=_method(found),
        measurements=[
            _measurement(result, result.number, picture)
            for result in found.results
            if result.number is not None
        ],
        qualitative_evaluations=[view, intervals],
        source_images=[
            sr.SourceImageForMeasurementGroup(picture.SOPClassUID, picture.SOPInstanceUID)
        ],
    )


def _measurement(result: Result, number: NumberRow, picture: "SCImage") -> "Measurement":
    from highdicom import sr

    unit = sr.CodedConcept(result.unit, "UCUM", result.unit)
    return sr.Measurement(
        name=_own(result.code, result.name),
        value=round(number.value, N_DECIMALS) + 0.0,
        unit=unit,
        properties=_interval(number, unit),
        referenced_images=[
            sr.SourceImageForMeasurement(picture.SOPClassUID, picture.SOPInstanceUID)
        ],
    )


def _interval(number: NumberRow, unit: "CodedConcept") -> "MeasurementProperties":
    """Return how far the interval reaches, in the unit of the value.

    highdicom's own arguments would say that it has none.
    """
    from highdicom import sr

    properties = sr.MeasurementProperties()
    for code, reach in ((UPPER, number.high - number.value), (LOWER, number.value - number.low)):
        properties.append(
            sr.NumContentItem(
                name=sr.CodedConcept(*code),
                value=round(reach, N_DECIMALS) + 0.0,
                unit=unit,
                relationship_type=sr.RelationshipTypeValues.HAS_PROPERTIES,
            )
        )
    return properties


def _method(found: CaptureResults) -> "CodedConcept":
    from highdicom.sr import CodedConcept

    protocol_id, revision = found.protocol
    if not protocol_id:
        return _own("markers", _("Markers seen by a depth camera"))
    return CodedConcept(
        _plain(protocol_id),
        SCHEME,
        line(f"{protocol_id} {revision}"),
        line(revision, LONGEST_SHORT_TEXT) or None,
    )


def _own(code: str, meaning: str) -> "CodedConcept":
    from highdicom.sr import CodedConcept

    return CodedConcept(_plain(code), SCHEME, line(meaning))


def _plain(code: str) -> str:
    """Return a code in ASCII without spaces; one with other letters gets a number of its own."""
    return code if PLAIN.fullmatch(code) else stable_uid("code", code)


def _observers(handover: Handover) -> "ObservationContext":
    """Return who took the session, where that is known, and with what."""
    from highdicom import sr
    from pydicom.sr.codedict import codes

    calibration = handover.report.captures[0].analysis.calibration
    serial = line(calibration.sensor_serial)
    device = sr.ObserverContext(
        codes.DCM.Device,
        sr.DeviceObserverIdentifyingAttributes(
            uid=stable_uid("device", serial),
            name=MAKER,
            manufacturer_name=MAKER,
            model_name=f"{MAKER} {handover.report.version}",
            serial_number=serial or None,
        ),
    )
    operator = person_name(handover.report.operator)
    if not operator:
        return sr.ObservationContext(observer_device_context=device)
    person = sr.ObserverContext(codes.DCM.Person, sr.PersonObserverIdentifyingAttributes(operator))
    return sr.ObservationContext(observer_person_context=person, observer_device_context=device)


def _request(handover: Handover, order: Order) -> "Dataset":
    """Return what the report answers."""
    from pydicom import Dataset

    request = Dataset()
    request.StudyInstanceUID = study_uid(handover)
    request.AccessionNumber = order.accession_number
    request.RequestedProcedureID = order.procedure_id
    request.RequestedProcedureDescription = line(order.procedure)
    request.PlacerOrderNumberImagingServiceRequest = ""
    request.FillerOrderNumberImagingServiceRequest = ""
    request.ReferencedStudySequence = []
    request.RequestedProcedureCodeSequence = []
    return request


def _language(language: str) -> "LanguageOfContentItemAndDescendants":
    from highdicom.sr import CodedConcept, LanguageOfContentItemAndDescendants

    return LanguageOfContentItemAndDescendants(
        CodedConcept(language, "RFC5646", LANGUAGES.get(language, language))
    )
