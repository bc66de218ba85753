"""What of a session is handed over: its report, whose it is, and the numbers in it."""

import hashlib
import json
from collections import Counter
from collections.abc import Iterator
from dataclasses import asdict, dataclass, replace
from datetime import datetime
from typing import Any

from adibas.arrays import FloatArray
from adibas.data.landmark_texts import landmark_text
from adibas.data.patients import Identity, Patient
from adibas.data.posture import PostureAnalysis
from adibas.data.protocol_measures import INSTRUMENT_ONLY, PLANE_TEXTS, VERTICAL_TEXTS
from adibas.data.protocols import id_of_all
from adibas.data.report import CaptureReport, SessionReport
from adibas.exchange.orders import Order
from adibas.reports.facts import view_name
from adibas.reports.rows import (
    MeasureRow,
    NumberRow,
    distance_rows,
    free_remark,
    free_rows,
    measure_rows,
    names_line,
)
from adibas.texts import speaking
from adibas.texts import translate as _


@dataclass(frozen=True, slots=True, repr=False)
class Subject:
    """Whose session it is: a pseudonym, and the person only where that was asked for.

    Attributes
    ----------
    pseudonym : str
        Of the patient.
    identity : Identity or None
        None: who it is stays in the clinic.
    sex : str
        Of `SEXES`; empty without an identity, because it helps to find out.
    """

    pseudonym: str
    identity: Identity | None = None
    sex: str = ""

    def __repr__(self) -> str:
        return f"Subject({self.pseudonym}, hidden)"


@dataclass(frozen=True, slots=True)
class Result:
    """One number of a capture.

    Attributes
    ----------
    code, name : str
        Such as ``ANT.ACR.H``, and what it is called.
    unit : str
        ``deg``, ``mm``, ``cm`` or ``%``: what UCUM calls them, too.
    number : NumberRow or None
        The value with its 95 % interval; None where it could not be measured.
    in_plane, in_space : NumberRow or None
        Both values of a protocol's measure.
    remarks : tuple of str
        What the reader must know: why it is missing, what a positive value means, values of
        others.
    reason : str
        Why it is missing, or what of it was placed by hand.
    """

    code: str
    name: str
    unit: str
    number: NumberRow | None
    in_plane: NumberRow | None = None
    in_space: NumberRow | None = None
    remarks: tuple[str, ...] = ()
    reason: str = ""


@dataclass(frozen=True, slots=True, eq=False)
class CaptureResults:
    """The numbers of one capture.

    Attributes
    ----------
    key : str
        Stays the same for the same capture of a session: its view, numbered.
    view : str
        Its name for a reader.
    capture : CaptureReport
        That they come from.
    protocol : tuple of str
        Id and revision of the protocol; empty strings where none was followed.
    method : str
        How it was measured.
    results : tuple of Result
        In the report's order.
    """

    key: str
    view: str
    capture: CaptureReport
    protocol: tuple[str, str]
    method: str
    results: tuple[Result, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Handover:
    """One session as it leaves the clinic; made by `hand_over`.

    Attributes
    ----------
    session_id : str
        Random, without meaning.
    subject : Subject
        Whose it is.
    report : SessionReport
        What was measured; without the clinician's free notes where the person is not told.
    started_utc : datetime
        When the session began.
    captures : tuple of CaptureResults
        The numbers of every capture.
    revision : str
        A digest of all that is told: another one after every correction.
    order : Order or None
        That DICOM files answer.
    """

    session_id: str
    subject: Subject
    report: SessionReport
    started_utc: datetime
    captures: tuple[CaptureResults, ...]
    revision: str
    order: Order | None = None

    @property
    def tells_who(self) -> bool:
        """Return whether the person goes along."""
        return self.subject.identity is not None or self.order is not None


def hand_over(
    session_id: str,
    report: SessionReport,
    person: Patient | None = None,
    order: Order | None = None,
) -> Handover:
    """Return a session as it may leave the clinic.

    Parameters
    ----------
    session_id : str
        Of the store.
    report : SessionReport
        Of that session.
    person : Patient, optional
        Whose session it is: then name, birth date, record number, sex and the clinician's free
        notes go along. Without it nothing does that tells who it is.
    order : Order, optional
        Of a work list: DICOM files then belong to its study and its patient.
    """
    started_utc = report.started_utc
    if started_utc is None:
        raise ValueError("only a session of the store is handed over")
    if person is None:
        subject = Subject(report.patient)
        report = replace(report, notes="")  # people are named in free notes
    else:
        subject = Subject(person.pseudonym, person.identity, person.sex)
    captures = capture_results(report)
    revision = _revision(subject, report, captures, order)
    return Handover(session_id, subject, report, started_utc, captures, revision, order)


def capture_results(report: SessionReport) -> tuple[CaptureResults, ...]:
    """Return the numbers of every capture, in the report's language.

    They are the protocol's measures and those that were asked for by hand; where there are
    neither, the distances of all pairs.
    """
    counts: Counter[str] = Counter()
    found = []
    with speaking(report.language):
        for capture in report.captures:
            analysis = capture.analysis
            counts[analysis.view] += 1
            found.append(
                CaptureResults(
                    f"{analysis.view or 'view'}-{counts[analysis.view]}",
                    view_name(analysis.view),
                    capture,
                    _protocol(analysis),
                    _method(analysis),
                    tuple(_results(capture)),
                )
            )
    return tuple(found)


def _results(capture: CaptureReport) -> Iterator[Result]:
    rows = [_of_protocol(row) for row in measure_rows(capture.analysis)]
    rows += _free_results(capture)
    yield from rows or _all_distances(capture.analysis)


def _of_protocol(row: MeasureRow) -> Result:
    positive = _("positive: {meaning}").format(meaning=row.positive) if row.positive else ""
    remarks = (row.remark, positive, row.reference)
    return Result(
        row.measure_id,
        row.name,
        row.unit,
        row.main,
        row.projected,
        row.spatial,
        tuple(remark for remark in remarks if remark),
        row.remark,
    )


def _free_results(capture: CaptureReport) -> Iterator[Result]:
    for row in free_rows(capture):
        points = (row.a, row.vertex, row.c) if row.vertex else (row.a, row.c)
        kind = "angle" if row.vertex else "distance"
        if row.value is None or row.low is None or row.high is None:
            reason = free_remark(row) or ""
            yield Result(
                id_of_all(kind, points),
                _name(points),
                row.unit,
                None,
                None,
                None,
                (reason,),
                reason,
            )
        else:
            number = NumberRow(row.value, row.low, row.high)
            yield Result(id_of_all(kind, points), _name(points), row.unit, number)


def _all_distances(analysis: PostureAnalysis) -> Iterator[Result]:
    for row in distance_rows(analysis.distances):
        points = (row.a, row.b)
        number = NumberRow(row.mm, row.low_mm, row.high_mm)
        yield Result(id_of_all("distance", points), _name(points), "mm", number)


def _name(points: tuple[str, ...]) -> str:
    return " \N{EN DASH} ".join(landmark_text(point) for point in points)


def _protocol(analysis: PostureAnalysis) -> tuple[str, str]:
    if analysis.measures is None:
        return "", ""
    protocol = analysis.measures.protocol
    return protocol.protocol_id, protocol.revision


def _method(analysis: PostureAnalysis) -> str:
    """Return on what the numbers rest, in one line."""
    parts = [_("Markers seen by a depth camera"), view_name(analysis.view)]
    measures = analysis.measures
    if measures is not None:
        protocol = measures.protocol
        parts[:0] = [f"{protocol.title.text} ({protocol.protocol_id}, {protocol.revision})"]
        parts += [_(PLANE_TEXTS[measures.plane])]
        parts += [_("vertical: {origin}").format(origin=_(VERTICAL_TEXTS[measures.vertical]))]
    return "; ".join(part for part in (*parts, names_line(analysis)) if part)


def interval_text() -> str:
    """Return what the intervals hold, in the language in use."""
    return _(INSTRUMENT_ONLY)


def _revision(
    subject: Subject,
    report: SessionReport,
    captures: tuple[CaptureResults, ...],
    order: Order | None,
) -> str:
    """Return a digest of all that pictures, tables and headers are made of."""
    told = {
        "person": _person(subject),
        "order": None if order is None else asdict(order),
        "session": [report.operator, report.protocol, report.notes, report.version],
        "shown": [report.language, report.pictures.value, report.rotation_deg],
        "captures": [_told(found) for found in captures],
    }
    return hashlib.sha256(json.dumps(told, sort_keys=True).encode()).hexdigest()


def _person(subject: Subject) -> list[str]:
    identity = subject.identity
    if identity is None:
        return [subject.pseudonym]
    born = "" if identity.birth_date is None else identity.birth_date.isoformat()
    return [subject.pseudonym, identity.name, born, identity.record_number, subject.sex]


def _told(found: CaptureResults) -> list[Any]:
    analysis = found.capture.analysis
    return [
        found.key,
        found.method,
        [asdict(result) for result in found.results],
        [[one.label, one.u, one.v, _listed(one.position_m)] for one in analysis.markers],
        sorted(found.capture.placed_by_hand),
        hashlib.sha256(analysis.picture_rgb.tobytes()).hexdigest(),
        [analysis.provenance.recording_sha256, analysis.provenance.calibration],
        list(analysis.notices),
    ]


def _listed(position_m: FloatArray | None) -> list[float] | None:
    return None if position_m is None else [float(value) for value in position_m]
