"""A session as a FHIR R5 bundle: one file for the records of a hospital or an insurer.

The bundle is a transaction of updates: sent to a server twice, it stands there once.
"""

import json
from pathlib import Path
from typing import Any

from adibas.exchange.content import CaptureResults, Handover
from adibas.exchange.fhir_parts import (
    PSEUDONYMISED,
    SESSIONS,
    Json,
    device,
    diagnostic_report,
    observation,
    patient,
)
from adibas.exchange.identifiers import stable_uuid
from adibas.files import written_whole
from adibas.reports.pdf import HEADING, encoded_pdf
from adibas.texts import speaking
from adibas.texts import translate as _


def write_fhir(handover: Handover, path: Path) -> int:
    """Write the bundle of a session and return how many observations are in it.

    Raises
    ------
    ReportError
        The pictures cannot be as the report asks.
    FileError
        The disk is full, or the folder cannot be written.
    """
    return write_bundle(fhir_bundle(handover), path)


def write_bundle(bundle: Json, path: Path) -> int:
    """Write a `fhir_bundle` and return how many observations are in it.

    Raises
    ------
    FileError
        The disk is full, or the folder cannot be written.
    """
    encoded = json.dumps(bundle, allow_nan=False, ensure_ascii=False, indent=1)
    with written_whole(path) as unfinished:
        unfinished.write_text(encoded, encoding="utf-8")
    kinds = [entry["resource"]["resourceType"] for entry in bundle["entry"]]
    return kinds.count("Observation")


def fhir_bundle(handover: Handover) -> Json:
    """Return the bundle of a session, seen to be right against the models of FHIR R5.

    Raises
    ------
    ReportError
        The pictures cannot be as the report asks.
    """
    from fhir.resources.bundle import Bundle

    with speaking(handover.report.language):
        resources = _resources(handover)
    bundle = {
        "resourceType": "Bundle",
        "id": stable_uuid("bundle", handover.session_id),
        "meta": {"security": [PSEUDONYMISED]} if handover.subject.identity is None else {},
        "identifier": {"system": SESSIONS, "value": handover.session_id},
        "type": "transaction",
        "entry": [_entry(resource) for resource in resources],
    }
    bundle = {name: value for name, value in bundle.items() if value}
    Bundle.model_validate(bundle)
    return bundle


def _resources(handover: Handover) -> list[Json]:
    patient_ = patient(handover.subject)
    devices: dict[str, Json] = {}
    observations = []
    for found in handover.captures:
        device_ = _known(devices, found, handover.report.version)
        observations += [
            observation(handover, found, result, patient_, device_) for result in found.results
        ]
    pdf = encoded_pdf(handover.report)
    report = diagnostic_report(handover, observations, patient_, pdf, _(HEADING))
    return [patient_, *devices.values(), *observations, report]


def _known(devices: dict[str, Json], found: CaptureResults, version: str) -> Json:
    """Return the device of a capture; captures of one camera and calibration share it."""
    made = device(found, version)
    return devices.setdefault(made["id"], made)


def _entry(resource: Json) -> dict[str, Any]:
    return {
        "fullUrl": f"urn:uuid:{resource['id']}",
        "resource": resource,
        "request": {"method": "PUT", "url": f"{resource['resourceType']}/{resource['id']}"},
    }
