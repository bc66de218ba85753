"""FHIR: the numbers of the report, in a bundle that others' models accept, and nobody's name."""

import base64
import io
import json
from dataclasses import replace

import pytest
from fhir.resources.bundle import Bundle
from pypdf import PdfReader

from adibas.cli import main
from adibas.data.patients import Patient
from adibas.data.report import PictureChoice
from adibas.exchange.content import capture_results, hand_over
from adibas.exchange.fhir_bundle import fhir_bundle, write_fhir
from adibas.exchange.identifiers import stable_uid, stable_uuid
from adibas.pipeline.stored_report import ReportWish, stored_report
from adibas.reports import pdf
from adibas.reports.rows import measure_rows
from tests.unit.exchange_samples import NOTES, add_clinic_session, hostile, secrets_in
from tests.unit.store_samples import IDENTITY, NAME, START, open_sample


@pytest.fixture(autouse=True)
def small_pictures(monkeypatch):
    """Draw less, for speed."""
    monkeypatch.setattr(pdf, "PICTURE_HEIGHT_PX", 200)


@pytest.fixture(scope="module")
def report(tmp_path_factory):
    """Return the report of a session in a store of its own, measured once."""
    with open_sample(tmp_path_factory.mktemp("exchange") / "store") as store:
        session = add_clinic_session(store)
        return stored_report(store, session.session_id, ReportWish("en"))


@pytest.fixture
def session(folder):
    with open_sample(folder) as store:
        return add_clinic_session(store)


def person():
    return Patient("P-7F3KQ2", IDENTITY, "female", "", START)


def resources(bundle, kind):
    every = (entry["resource"] for entry in bundle["entry"])
    return [one for one in every if one["resourceType"] == kind]


def by_code(bundle):
    return {
        one["code"]["coding"][0]["code"]: one
        for one in resources(bundle, "Observation")
        if one["component"][0]["valueCodeableConcept"]["text"] == "anterior"
    }


def run(folder, session, out, *options):
    command = ["export", "fhir", session.session_id, "--store", str(folder), "--out", str(out)]
    return main([*command, "--pictures", "as-is", *options])


def test_every_measure_stands_there_with_unit_interval_and_method(report):
    bundle = fhir_bundle(hand_over("ab12", report))
    read = Bundle.model_validate_json(json.dumps(bundle))
    assert read.type == "transaction"
    assert read.get_resource_type() == "Bundle"
    found = by_code(bundle)
    rows = {row.measure_id: row for row in measure_rows(report.captures[0].analysis)}
    assert set(rows) <= set(found)
    for code, row in rows.items():
        told = found[code]
        assert told["code"]["text"] == row.name
        assert "SAPO-1" in told["method"]["text"]
        n_markers = len(report.captures[0].analysis.markers)
        assert f"Names of markers: {n_markers} by a person" in told["method"]["text"]
        if row.main is None:
            assert "valueQuantity" not in told
            assert told["dataAbsentReason"]["text"] == row.remark
            continue
        assert told["valueQuantity"]["value"] == pytest.approx(row.main.value, abs=1e-4)
        assert told["valueQuantity"]["system"] == "http://unitsofmeasure.org"
        assert told["valueQuantity"]["code"] == row.unit
        interval = told["component"][1]["valueRange"]
        assert interval["low"]["value"] == pytest.approx(row.main.low, abs=1e-4)
        assert interval["high"]["value"] == pytest.approx(row.main.high, abs=1e-4)
        assert "instrument only" in told["note"][-1]["text"]
    assert any(row.main is None for row in rows.values())


def test_the_report_names_all_observations_and_carries_the_pdf(report):
    bundle = fhir_bundle(hand_over("ab12", report))
    (told,) = resources(bundle, "DiagnosticReport")
    names = {f"urn:uuid:{one['id']}" for one in resources(bundle, "Observation")}
    assert {one["reference"] for one in told["result"]} == names
    attached = told["presentedForm"][0]
    data = base64.b64decode(attached["data"])
    assert attached["size"] == len(data)
    assert "Posture report" in PdfReader(io.BytesIO(data)).pages[0].extract_text()
    urls = {entry["fullUrl"] for entry in bundle["entry"]}
    pointed_at = {told["subject"]["reference"]} | {
        one[field]["reference"]
        for one in resources(bundle, "Observation")
        for field in ("subject", "device")
    }
    assert pointed_at <= urls
    assert len(urls) == len(bundle["entry"])
    (device,) = resources(bundle, "Device")
    assert device["version"] == [{"value": report.version}]


def test_the_same_session_has_the_same_names_in_the_world(report):
    first, again = (fhir_bundle(hand_over("ab12", report)) for _ in range(2))
    other = fhir_bundle(hand_over("ab13", report))
    assert [one["fullUrl"] for one in first["entry"]] == [one["fullUrl"] for one in again["entry"]]
    differing = {one["fullUrl"] for one in first["entry"]} & {
        one["fullUrl"] for one in other["entry"]
    }
    shared = [*resources(first, "Patient"), *resources(first, "Device")]
    assert differing == {f"urn:uuid:{one['id']}" for one in shared}


def test_names_for_the_world_follow_their_standards():
    assert stable_uuid("a", "bc") != stable_uuid("ab", "c")
    uid = stable_uid("series", "ab12")
    assert uid == stable_uid("series", "ab12")
    assert uid.startswith("2.25.")
    assert len(uid) <= 64


def test_a_bundle_speaks_the_language_of_the_report(report):
    bundle = fhir_bundle(hand_over("ab12", replace(report, language="ca")))
    names = {one["code"]["text"] for one in resources(bundle, "Observation")}
    assert "Alineació horitzontal dels acròmions" in names


def test_without_a_protocol_all_distances_are_handed_over(folder):
    with open_sample(folder) as store:
        session = add_clinic_session(store, protocol="")
        report = stored_report(store, session.session_id, ReportWish("en"))
    results = capture_results(report)[0].results
    assert len(results) == len(report.captures[0].analysis.distances) > 0
    assert {one.unit for one in results} == {"mm"}
    assert results[0].code.startswith("D.")


def test_names_of_any_script_are_a_bundle(report, tmp_path):
    path = tmp_path / "bundle.json"
    assert write_fhir(hand_over("ab12", hostile(report)), path) == 15
    bundle = json.loads(path.read_text("utf-8"))
    assert len({entry["fullUrl"] for entry in bundle["entry"]}) == len(bundle["entry"])
    Bundle.model_validate(bundle)


def test_nothing_tells_who_it_is_unless_that_was_asked_for(folder, session, tmp_path, capsys):
    out = tmp_path / "out.json"
    assert run(folder, session, out) == 0
    captured = capsys.readouterr()
    bundle = json.loads(out.read_text("utf-8"))
    pdf_bytes = base64.b64decode(
        resources(bundle, "DiagnosticReport")[0]["presentedForm"][0]["data"]
    )
    for told in (out.read_bytes(), pdf_bytes, captured.out.encode(), captured.err.encode()):
        assert not secrets_in(told)
    text = "".join(page.extract_text() for page in PdfReader(io.BytesIO(pdf_bytes)).pages)
    assert not secrets_in(text.encode())
    (patient,) = resources(bundle, "Patient")
    assert patient["identifier"][0]["value"] == session.patient
    assert patient["meta"]["security"][0]["code"] == "PSEUDED"
    assert {"name", "birthDate", "gender"}.isdisjoint(patient)


def test_who_it_is_goes_along_when_asked_for_and_is_noted(folder, session, tmp_path):
    out = tmp_path / "out.json"
    assert run(folder, session, out, "--with-identity", "--json") == 0
    bundle = json.loads(out.read_text("utf-8"))
    (patient,) = resources(bundle, "Patient")
    assert patient["name"][0]["text"] == NAME
    assert patient["birthDate"] == "2014-03-27"
    assert patient["gender"] == "female"
    assert [one["value"] for one in patient["identifier"]] == ["HC-004711", session.patient]
    Bundle.model_validate(bundle)
    with open_sample(folder) as store:
        (entry,) = [one for one in store.audit.entries() if one.action == "export"]
    assert entry.detail["kind"] == "fhir, with identity"
    assert entry.subject == session.session_id


def test_the_notes_stay_unless_the_person_goes_along(report):
    assert report.notes == NOTES
    assert hand_over("ab12", report).report.notes == ""
    assert hand_over("ab12", report, person()).report.notes == NOTES
    assert NAME not in repr(hand_over("ab12", report, person()).subject)


def test_a_correction_makes_another_revision_and_the_same_content_the_same(report):
    first = hand_over("ab12", report).revision
    assert first == hand_over("ab12", report).revision
    others = (
        hand_over("ab12", report, person()),
        hand_over("ab12", replace(report, pictures=PictureChoice.DEPTH)),
        hand_over("ab12", replace(report, captures=report.captures[:1])),
    )
    assert len({first, *(one.revision for one in others)}) == 4


def test_a_head_that_cannot_be_hidden_is_one_sentence_and_no_file(
    folder, session, tmp_path, capsys
):
    out = tmp_path / "out.json"
    command = ["export", "fhir", session.session_id, "--store", str(folder), "--out", str(out)]
    assert main(command) == 1
    assert "No depth was kept" in capsys.readouterr().err
    assert not list(tmp_path.glob("*out*"))


def test_a_bundle_has_the_ending_of_one(folder, session, tmp_path, capsys):
    assert run(folder, session, tmp_path / "out.pdf") == 1
    assert ".json" in capsys.readouterr().err
