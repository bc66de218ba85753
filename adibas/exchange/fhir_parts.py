"""The resources of a FHIR R5 bundle, as the JSON that stands in it.

Source: HL7 FHIR release 5 (5.0.0): Patient, Device, Observation, DiagnosticReport.
"""

import base64
import hashlib
from datetime import UTC, datetime
from typing import Any

from adibas.data.patients import Identity
from adibas.exchange.content import CaptureResults, Handover, Result, Subject, interval_text
from adibas.exchange.identifiers import stable_uid, stable_uuid
from adibas.files import printable
from adibas.reports.facts import HASH_LENGTH, intended_use
from adibas.reports.rows import NumberRow
from adibas.texts import translate as _

Json = dict[str, Any]

N_DECIMALS = 4
"""Of numbers: far below what an instrument tells apart."""

PSEUDONYMS = f"urn:oid:{stable_uid('pseudonyms')}"
SESSIONS = f"urn:oid:{stable_uid('sessions')}"
OWN_CODES = f"urn:oid:{stable_uid('measures')}"
UCUM = "http://unitsofmeasure.org"

INTERVAL = {
    "coding": [
        {
            "system": "http://terminology.hl7.org/CodeSystem/attribute-estimate-type",
            "code": "C53324",
            "display": "Confidence interval",
        }
    ],
    "text": "95 %",
}
PSEUDONYMISED = {
    "system": "http://terminology.hl7.org/CodeSystem/v3-ObservationValue",
    "code": "PSEUDED",
    "display": "pseudonymized",
}
EXAM = {
    "coding": [
        {
            "system": "http://terminology.hl7.org/CodeSystem/observation-category",
            "code": "exam",
            "display": "Exam",
        }
    ]
}
UNKNOWN = {
    "system": "http://terminology.hl7.org/CodeSystem/data-absent-reason",
    "code": "unknown",
    "display": "Unknown",
}
RECORD_NUMBER = {
    "coding": [{"system": "http://terminology.hl7.org/CodeSystem/v2-0203", "code": "MR"}]
}


def reference(resource: Json) -> Json:
    """Return what points to a resource of the same bundle."""
    return {"reference": f"urn:uuid:{resource['id']}", "type": resource["resourceType"]}


def patient(subject: Subject) -> Json:
    """Return the patient: a pseudonym, and the person where that was asked for."""
    known: Json = {
        "resourceType": "Patient",
        "id": stable_uuid("patient", subject.pseudonym),
        "identifier": [{"use": "secondary", "system": PSEUDONYMS, "value": subject.pseudonym}],
    }
    if subject.identity is None:
        return {**known, "meta": {"security": [PSEUDONYMISED]}}
    gender = {"gender": subject.sex} if subject.sex else {}
    return {**known, **_person(known, subject.identity), **gender}


def _person(known: Json, identity: Identity) -> Json:
    person: Json = {"name": [{"use": "official", "text": printable(identity.name)}]}
    if identity.birth_date is not None:
        person["birthDate"] = identity.birth_date.isoformat()
    if identity.record_number:
        number = {
            "use": "usual",
            "type": RECORD_NUMBER,
            "value": printable(identity.record_number),
        }
        person["identifier"] = [number, *known["identifier"]]
    return person


def device(found: CaptureResults, version: str) -> Json:
    """Return the program with the camera that it measured with, and its calibration."""
    analysis = found.capture.analysis
    serial = printable(analysis.calibration.sensor_serial)
    calibration = analysis.provenance.calibration
    made: Json = {
        "resourceType": "Device",
        "id": stable_uuid("device", serial, calibration, version),
        "name": [{"value": "ADiBAS", "type": "user-friendly-name", "display": True}],
        "version": [{"value": version}],
        "property": [
            {
                "type": {"text": _("Calibration")},
                "valueString": calibration[:HASH_LENGTH] or _("not known"),
            }
        ],
    }
    return {**made, "serialNumber": serial} if serial else made


def observation(
    handover: Handover, found: CaptureResults, result: Result, patient_: Json, device_: Json
) -> Json:
    """Return one measure of one capture."""
    is_known = {"valueQuantity": _quantity(result.number, result.unit)} if result.number else {}
    remarks = [*result.remarks, *([interval_text()] if result.number else [])]
    return {
        "resourceType": "Observation",
        "id": stable_uuid("observation", handover.session_id, found.key, result.code),
        "status": "final",
        "category": [EXAM],
        "code": _code(found, result),
        "subject": reference(patient_),
        "effectiveDateTime": instant(handover.started_utc),
        **performer(handover),
        **(is_known or {"dataAbsentReason": _absent(result)}),
        **({"note": [{"text": printable(remark)} for remark in remarks]} if remarks else {}),
        "method": {"text": printable(found.method)},
        "device": reference(device_),
        "component": _components(found, result),
    }


def diagnostic_report(
    handover: Handover, observations: list[Json], patient_: Json, pdf: bytes, title: str
) -> Json:
    """Return the report that names all observations and carries the PDF."""
    return {
        "resourceType": "DiagnosticReport",
        "id": stable_uuid("report", handover.session_id),
        "identifier": [{"system": SESSIONS, "value": handover.session_id}],
        "status": "final",
        "code": {
            "coding": [{"system": OWN_CODES, "code": "posture-report"}],
            "text": title,
        },
        "subject": reference(patient_),
        "effectiveDateTime": instant(handover.started_utc),
        **performer(handover),
        "result": [reference(one) for one in observations],
        "note": [{"text": intended_use()}],
        "presentedForm": [
            {
                "contentType": "application/pdf",
                "language": handover.report.language,
                "data": base64.b64encode(pdf).decode(),
                "size": len(pdf),
                # FHIR asks for SHA-1; it finds accidents and protects from nobody.
                "hash": base64.b64encode(
                    hashlib.sha1(pdf, usedforsecurity=False).digest()
                ).decode(),
                "title": title,
            }
        ],
    }


def instant(moment: datetime) -> str:
    """Return a moment as FHIR writes it."""
    return moment.astimezone(UTC).isoformat(timespec="seconds")


def performer(handover: Handover) -> Json:
    """Return who took the session, where that is known."""
    operator = printable(handover.report.operator).strip()
    return {"performer": [{"type": "Practitioner", "display": operator}]} if operator else {}


def _code(found: CaptureResults, result: Result) -> Json:
    protocol_id, revision = found.protocol
    coding: Json = {"system": OWN_CODES}
    if protocol_id:
        coding = {"system": f"urn:oid:{stable_uid('protocol', protocol_id)}", "version": revision}
    name = printable(result.name)
    coding |= {"code": _token(result.code), "display": name}
    return {"coding": [coding], "text": name}


def _token(code: str) -> str:
    """Return a code without the white space that FHIR forbids in one."""
    return "_".join(printable(code).split())


def _absent(result: Result) -> Json:
    reason = printable(result.reason)
    return {"coding": [UNKNOWN], **({"text": reason} if reason else {})}


def _components(found: CaptureResults, result: Result) -> list[Json]:
    """Return the view, the interval, and the values in the plane and in space."""
    view = {"code": {"text": _("View")}, "valueCodeableConcept": {"text": found.view}}
    parts: list[Json] = [view]
    if result.number is not None:
        parts.append({"code": INTERVAL, "valueRange": _range(result.number, result.unit)})
    for name, number in ((_("In the plane"), result.in_plane), (_("In space"), result.in_space)):
        if number is not None:
            quantity = _quantity(number, result.unit)
            parts.append({"code": {"text": name}, "valueQuantity": quantity})
    return parts


def _range(number: NumberRow, unit: str) -> Json:
    return {"low": _amount(number.low, unit), "high": _amount(number.high, unit)}


def _quantity(number: NumberRow, unit: str) -> Json:
    return _amount(number.value, unit)


def _amount(value: float, unit: str) -> Json:
    rounded = round(value, N_DECIMALS) + 0.0  # never -0.0
    return {"value": rounded, "unit": unit, "system": UCUM, "code": unit}
