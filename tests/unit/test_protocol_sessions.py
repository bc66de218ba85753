"""A protocol through store, reports and command line: the same numbers everywhere, or a reason."""

import csv
import json
from dataclasses import replace
from datetime import UTC, datetime, timedelta

import numpy as np
import openpyxl
import pytest
from pypdf import PdfReader

from adibas.cli import main
from adibas.data.calibration import CameraCalibration, RgbdCalibration
from adibas.data.patients import Identity
from adibas.data.posture import PostureAnalysis, Provenance
from adibas.data.protocol_measures import INSTRUMENT_ONLY
from adibas.data.report import PictureChoice
from adibas.data.sentence import Sentence
from adibas.data.sessions import Session, SessionSetup
from adibas.errors import FileError, MarkerError, ProtocolError, ReportError
from adibas.geometry.pinhole import Intrinsics
from adibas.measures.protocol_store import find_protocol
from adibas.pipeline.labels import read_labels, with_labels
from adibas.pipeline.protocol_measuring import (
    LOST_PROTOCOL,
    ProtocolWish,
    check_view,
    with_measures,
)
from adibas.pipeline.session_comparison import compare_by_protocol
from adibas.pipeline.session_report import report_of_analysis
from adibas.pipeline.stored_report import ReportWish, stored_report
from adibas.reports import pictures, write_report
from adibas.reports.comparison_pictures import EARLIER_RGB, picture_pairs
from adibas.sessions import NewCapture
from tests.unit.standing_points import seen_from, standing
from tests.unit.store_samples import PASSPHRASE, add_patient, open_sample

SAPO = ProtocolWish(find_protocol("sapo-1"))
LEVEL_CAMERA = RgbdCalibration(
    color=CameraCalibration(160, 120, Intrinsics(100.0, 100.0, 80.0, 60.0)),
    gravity=np.array([0.0, 1.0, 0.0]),
    gravity_sd_rad=0.002,
)
PROVENANCE = Provenance("ab" * 32, "sha256:" + "cd" * 32, "0.1.0", "2026-11-21T10:00:00", {})


def raised(height_m):
    """A patient whose left acromion stands higher by so much over 36 cm."""
    places = standing()
    places["left_acromion"] = places["left_acromion"] + (0, height_m, 0)
    return places


@pytest.fixture
def analysis():
    return PostureAnalysis(
        patient="P1",
        view="anterior",
        n_frames=30,
        first_frame=0,
        markers=tuple(
            marker for marker in seen_from("anterior", raised(0.02)) if "tragus" not in marker.label
        ),
        rejected=(),
        distances=(),
        angles=(),
        picture_rgb=np.full((120, 160, 3), 90, np.uint8),
        calibration=LEVEL_CAMERA,
        provenance=PROVENANCE,
    )


ACROMIA_DEG = np.degrees(np.arctan2(0.02, 0.36))


def test_the_same_measures_stand_in_excel_csv_and_json(analysis, tmp_path):
    report = report_of_analysis(with_measures(analysis, SAPO, {"left_asis"}), "en")
    for ending in ("xlsx", "csv", "json", "pdf"):
        write_report(report, tmp_path / f"report.{ending}")
    workbook = openpyxl.load_workbook(tmp_path / "report.xlsx")
    assert workbook.sheetnames[:3] == ["Summary", "Measures", "Markers"]
    header, *rows = workbook["Measures"].iter_rows(values_only=True)
    table = {row[0]: dict(zip(header, row, strict=True)) for row in rows}
    document = json.loads((tmp_path / "report.json").read_text(encoding="utf-8"))["captures"][0]
    from_json = {one["id"]: one for one in document["measures"]}
    with (tmp_path / "report.csv").open(newline="", encoding="utf-8") as file:
        from_csv = {row["a"]: row for row in csv.DictReader(file) if row["quantity"] == "measure"}
    assert set(table) == set(from_json) == set(from_csv)
    assert table["ANT.ACR.H"]["Value"] == pytest.approx(ACROMIA_DEG)
    assert table["ANT.ACR.H"]["Positive means"] == "left acromion higher"
    assert "SAPO 0.68" in table["ANT.ACR.H"]["Values of others, with their source"]
    assert table["ANT.ASIS.H"]["Remark"] == "placed by hand: ASIS, left"
    for name, row in table.items():
        value = from_json[name]["value"]
        assert from_csv[name]["value"] == ("" if value is None else str(value))
        # The workbook keeps 16 digits.
        assert row["Value"] == (
            None if value is None else pytest.approx(value, rel=1e-14, abs=1e-14)
        )
    head = from_json["ANT.HEAD.H"]
    assert (head["value"], head["ci95"]) == (None, None)
    assert head["remark"] == "not marked: Tragus, right; Tragus, left"
    low, high = from_json["ANT.ACR.H"]["ci95"]
    assert low < ACROMIA_DEG < high
    assert document["protocol"]["plane"] == "sensor"
    assert document["protocol"]["intervals"] == INSTRUMENT_ONLY
    assert document["provenance"]["parameters"]["protocol"]["id"] == "sapo-1"
    text = "".join(page.extract_text() for page in PdfReader(tmp_path / "report.pdf").pages)
    assert "Measures of SAPO-1" in text
    assert "2-3 deg and 3-6 mm" in text
    assert "no normal value" in " ".join(text.split())


def test_the_csv_table_tells_protocol_plane_and_notices_and_whose_intervals(analysis, tmp_path):
    measured = with_measures(replace(analysis, notices=()), SAPO)
    told = replace(measured.measures, notices=(Sentence("Stood on a slope."),))
    report = report_of_analysis(replace(measured, measures=told), "en")
    write_report(report, tmp_path / "report.csv")
    with (tmp_path / "report.csv").open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    by_quantity = {row["quantity"]: row for row in rows if row["a"] in ("ANT.ACR.H", "")}
    in_plane = by_quantity["measure_plane"]
    assert [in_plane[key] for key in ("view", "protocol", "plane")] == [
        "anterior",
        "sapo-1",
        "sensor",
    ]
    assert in_plane["revision"] == SAPO.protocol.revision
    assert by_quantity["measure"]["plane"] == "sensor"
    assert by_quantity["measure_space"]["plane"] == ""
    low, high = (float(in_plane[f"ci95_{end}_instrument_only"]) for end in ("low", "high"))
    assert low < float(in_plane["value"]) < high
    assert by_quantity["notice"]["remark"] == "Stood on a slope."
    head = next(row for row in rows if row["a"] == "ANT.HEAD.H")
    assert (head["value"], head["remark"]) == ("", "not marked: Tragus, right; Tragus, left")


def test_a_report_speaks_the_language_of_the_protocol_s_reader(analysis, tmp_path):
    write_report(report_of_analysis(with_measures(analysis, SAPO), "ca"), tmp_path / "report.xlsx")
    sheet = openpyxl.load_workbook(tmp_path / "report.xlsx").worksheets[1]
    names = [row[1] for row in sheet.iter_rows(min_row=2, values_only=True)]
    assert "Alineació horitzontal dels acròmions" in names


def test_a_protocol_needs_a_view_that_it_knows():
    with pytest.raises(ProtocolError, match="which side is seen"):
        check_view(SAPO, "")
    upper = ProtocolWish(find_protocol("upper-quadrant"))
    with pytest.raises(ProtocolError, match="measures nothing in the view posterior"):
        check_view(upper, "posterior")
    check_view(SAPO, "posterior")


def test_a_capture_of_an_untold_view_says_so(analysis):
    found = with_measures(replace(analysis, view=""), SAPO)
    assert found.measures is None
    assert "was not told" in found.notices[-1]


def labels_file(tmp_path, text):
    path = tmp_path / "labels.csv"
    path.write_text(text, encoding="utf-8")
    return path


def spread():
    """Three markers, 100 pixels apart."""
    markers = seen_from("anterior", {name: np.zeros(3) for name in ("m01", "m02", "m03")})
    return tuple(replace(one, u=100.0 * n, v=50.0) for n, one in enumerate(markers))


@pytest.mark.parametrize(
    "text",
    ["marker,label\nm02,c7\n", "point,label,x\nm02,c7,3\nm01,,4\n", "u,v,label\n104,53,c7\n"],
)
def test_markers_get_their_names_by_name_or_by_pixel(tmp_path, text):
    labels = read_labels(labels_file(tmp_path, text))
    assert [one.label for one in with_labels(spread(), labels)] == ["m01", "c7", "m03"]


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("marker,label\nm09,c7\n", "Line 2 of the labels, c7, means no marker"),
        ("u,v,label\n100,50,a\n101,50,b\n", "Line 3 of the labels, b, means no marker"),
        ("marker,label\n\nm01,a\n\nm09,c7\n", "Line 5 of the labels, c7, means no marker"),
        ("u,v,label\n150,50,a\n", "means no marker"),
        ("marker,label\nm01,a\nm02,a\n", "same name"),
        ("marker,label\nm01,m02\n", "same name"),
    ],
)
def test_labels_that_mean_no_marker_or_two_are_refused(tmp_path, text, told):
    with pytest.raises(MarkerError, match=told):
        with_labels(spread(), read_labels(labels_file(tmp_path, text)))


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("a,b\n", "names no markers"),
        ("u,label\n1,a\n", "names no markers"),
        ("u,v,label\nx,2,a\n", "line 2: this is no marker"),
        ("marker,label\n,a\n", "line 2: this is no marker"),
        (f"marker,label\nm01,{'x' * 41}\n", "line 2: this is no marker"),
    ],
)
def test_files_of_labels_that_make_no_sense_are_refused(tmp_path, text, told):
    with pytest.raises(FileError, match=told):
        read_labels(labels_file(tmp_path, text))
    (tmp_path / "labels.csv").write_bytes(b"marker,label\nm01,\xff\n")
    with pytest.raises(FileError, match="UTF-8"):
        read_labels(tmp_path / "labels.csv")
    with pytest.raises(FileError, match="cannot be read"):
        read_labels(tmp_path / "gone.csv")


def add_visit(store, patient, heights_m, *, protocol="sapo-1"):
    """Add a session with one capture from the front for each height of the left acromion."""
    session = store.sessions.start(patient, SessionSetup(protocol=protocol))
    picture_rgb = np.full((12, 16, 3), 90, np.uint8)
    for height_m in heights_m:
        new = NewCapture(
            view="anterior",
            recording_id="",
            first_frame=0,
            n_frames=1,
            calibration=LEVEL_CAMERA,
            detected=tuple(seen_from("anterior", raised(height_m))),
            rejected=(),
            provenance=PROVENANCE,
        )
        store.captures.add(session.session_id, new, picture_rgb)
    return session.session_id


def call_repeat(store, session_id):
    """Say that a session repeats the one before it."""
    setup = replace(store.sessions.get(session_id).setup, is_repeat=True)
    store.sessions.change(session_id, setup=setup)


@pytest.fixture
def clinic(tmp_path, monkeypatch):
    """Ten patients with a visit and its repeat, and one who comes again after a month."""
    monkeypatch.setenv("ADIBAS_PASSPHRASE", PASSPHRASE)
    rng = np.random.default_rng(2)
    now = [datetime(2026, 11, 2, 9, 0, tzinfo=UTC)]

    def clock():
        now[0] += timedelta(seconds=30)
        return now[0]

    with open_sample(tmp_path / "store", clock=clock) as store:
        first = None
        for number in range(10):
            patient = add_patient(store, Identity(f"Somebody {number}")).pseudonym
            first = first or patient
            slope = 0.004 * number
            add_visit(store, patient, [slope + rng.normal(0, 0.001)])
            call_repeat(store, add_visit(store, patient, [slope + rng.normal(0, 0.001)]))
        early = store.sessions.of_patient(first)[0].session_id
        now[0] += timedelta(days=30)
        late = add_visit(store, first, [0.03])
        yield store, early, late


def first_of(store):
    """Return the first session of the first patient of the clinic."""
    patient = store.patients.search("Somebody 0")[0].pseudonym
    return min(store.sessions.of_patient(patient), key=lambda one: one.started_utc).session_id


def test_the_report_of_a_session_follows_its_protocol_and_tells_what_changed(clinic, tmp_path):
    store, early, late = clinic
    report = stored_report(store, late, ReportWish("en", protocol=SAPO, compared_with=early))
    found = report.comparison.comparison
    acromia = next(one for one in found.changes if one.measure_id == "ANT.ACR.H")
    assert acromia.verdict.value == "beyond"
    assert found.n_beyond >= 1
    assert found.expected_by_chance == pytest.approx(0.05 * found.n_judged)
    for ending in ("xlsx", "json", "pdf"):
        write_report(report, tmp_path / f"report.{ending}")
    workbook = openpyxl.load_workbook(tmp_path / "report.xlsx")
    told = {row[1]: row for row in workbook["Changes"].iter_rows(values_only=True)}
    assert told["ANT.ACR.H"][-1] == "beyond MDC95"
    assert len(workbook["Comparison"]._images) == 3, (
        "the view before and now, overlaid, and the plots"
    )
    trend = [row for row in workbook["Trends"].values if row[1] == "ANT.ACR.H"]
    assert len(trend) == 3, "two visits on one day, and the reported one"
    assert (trend[0][8], trend[0][10], trend[2][10]) == (None, None, "beyond MDC95")
    document = json.loads((tmp_path / "report.json").read_text(encoding="utf-8"))["comparison"]
    line = next(one for one in document["trends"] if one["id"] == "ANT.ACR.H")
    assert [one["value"] for one in line["points"]] == pytest.approx([row[5] for row in trend])
    changes = {one["id"]: one for one in document["changes"]}
    assert changes["ANT.ACR.H"]["difference"] == pytest.approx(told["ANT.ACR.H"][6])
    text = "".join(page.extract_text() for page in PdfReader(tmp_path / "report.pdf").pages)
    assert "if nothing had changed" in " ".join(text.split())
    assert "anterior, before (2026-11-02)" in " ".join(text.split())
    assert "anterior, overlaid" in " ".join(text.split())
    assert "Measures over the sessions" in text
    old = stored_report(
        store, early, ReportWish("en", protocol=SAPO, compared_with=first_of(store))
    )
    times = {point.taken_utc for one in old.comparison.trends for point in one.points}
    assert max(times) == store.sessions.get(early).started_utc, "nothing of what came later"


def test_the_overlaid_picture_shows_the_markers_of_the_earlier_session(clinic):
    store, early, late = clinic
    report = stored_report(store, late, ReportWish("en", protocol=SAPO, compared_with=early))
    (pair,) = picture_pairs(report, 240)
    colors = set(map(tuple, pair.both_rgb.reshape(-1, 3).tolist()))
    assert pair.both_rgb.shape[0] == 240
    assert EARLIER_RGB in colors


def test_the_overlaid_picture_shows_no_more_than_is_wished(clinic, monkeypatch):
    store, early, late = clinic
    wish = ReportWish("en", PictureChoice.BLURRED, SAPO, early)
    report = stored_report(store, late, wish)
    monkeypatch.setattr(pictures, "blurred", lambda one, _deg: np.zeros_like(one.picture_rgb))
    (pair,) = picture_pairs(report, 240)
    assert np.median(pair.both_rgb) == 0
    assert np.median(report.captures[0].analysis.picture_rgb) > 0


def test_sessions_of_other_patients_or_protocols_are_not_compared(clinic):
    store, early, late = clinic
    patient = store.sessions.get(early).patient
    others = [row.pseudonym for row in store.patients.search("") if row.pseudonym != patient]
    other = store.sessions.of_patient(others[0])[0].session_id
    wish = ReportWish("en", protocol=SAPO, compared_with=other)
    with pytest.raises(ReportError, match="different patients"):
        stored_report(store, late, wish)
    free = add_visit(store, patient, [0.0], protocol="")
    with pytest.raises(ReportError, match="none is told"):
        stored_report(store, free, ReportWish("en", compared_with=early))
    joints = add_visit(store, patient, [0.0], protocol="joints-15")
    with pytest.raises(ReportError, match="different protocols"):
        stored_report(store, joints, ReportWish("en", compared_with=early))


def test_a_session_is_compared_with_an_earlier_one_alone(clinic):
    store, early, late = clinic
    for before, now, told in (
        (late, late, "with itself"),
        (late, early, "not earlier than session"),
    ):
        with pytest.raises(ReportError, match=told):
            stored_report(store, now, ReportWish("en", protocol=SAPO, compared_with=before))
        with pytest.raises(ReportError, match=told):
            compare_by_protocol(
                store, store.sessions.get(before), store.sessions.get(now), SAPO, {}
            )


def test_a_session_names_its_protocol_or_that_it_is_lost(clinic):
    store, early, _late = clinic
    patient = store.sessions.get(early).patient
    measures = stored_report(store, early, ReportWish("en")).captures[0].analysis.measures
    assert measures.protocol.protocol_id == "sapo-1"
    lost = add_visit(store, patient, [0.0], protocol="gone")
    analysis = stored_report(store, lost, ReportWish("en")).captures[0].analysis
    assert analysis.measures is None
    assert LOST_PROTOCOL in analysis.notices


def test_the_command_line_tells_how_measures_repeat(clinic, tmp_path, capsys):
    store, _early, _late = clinic
    folder = tmp_path / "store"
    store.close()
    options = ["--store", str(folder), "--protocol", "sapo-1"]
    assert main(["sessions", "reliability", *options, "--operator", "op", "--json"]) == 0
    captured = capsys.readouterr()
    found = {one["id"]: one for one in json.loads(captured.out)["measures"]}
    one = found["ANT.ACR.H"]
    assert one["n_patients"] == 10
    assert one["mdc95"] == pytest.approx(2.228 * 2**0.5 * one["sem"], rel=1e-3)  # t of 10
    assert one["icc_2_1"]["ci95"][0] < one["icc_2_1"]["value"] < 1
    # 1 mm of height over 360 mm, twice a patient.
    assert one["sem_ci95"][0] < np.degrees(0.001 / 0.36) < one["sem_ci95"][1]
    assert found["ANT.ASIS.H"]["sem"] == 0.0
    plotted = one["bland_altman"]
    assert len(plotted["means"]) == len(plotted["differences"]) == 10
    assert plotted["limits"][0] < plotted["bias"] < plotted["limits"][1]
    assert "do not differ" in captured.err
    assert (one["unit"], found["ANT.LLD"]["unit"]) == ("deg", "cm")
    assert main(["sessions", "reliability", *options, "--operator", "op"]) == 0
    (line,) = (row for row in capsys.readouterr().out.splitlines() if " ANT.ACR.H " in row)
    assert f"SEM {one['sem']:.2f} deg  MDC95 {one['mdc95']:.2f} deg" in line
    assert main(["sessions", "reliability", *options, "--operator", "nobody"]) == 0
    told = capsys.readouterr().err
    assert "No session of nobody has a measure of this protocol" in told
    assert "has sessions of: op." in told
    assert main(["sessions", "reliability", "--store", str(folder)]) == 1
    assert "--protocol" in capsys.readouterr().err


def test_captures_of_one_session_are_repeats_with_the_same_markers(tmp_path):
    from adibas.pipeline.clinic_repeats import reliability_in_clinic

    with open_sample(tmp_path / "store") as store:
        patient = add_patient(store, Identity("Somebody")).pseudonym
        add_visit(store, patient, [0.001, 0.003])
        found = reliability_in_clinic(store, SAPO, "op").by_measure["anterior", "ANT.ACR.H"]
    assert found.sem == pytest.approx(np.degrees(0.002 / 0.36) / np.sqrt(2), rel=1e-3)
    assert found.mdc95 is None
    assert "placed anew" in found.reasons[0].text


def test_markers_placed_anew_count_more_than_many_captures_of_one_placing(tmp_path, monkeypatch):
    from adibas.pipeline.clinic_repeats import reliability_in_clinic

    monkeypatch.setenv("ADIBAS_PASSPHRASE", PASSPHRASE)
    days = [datetime(2026, 11, day, 9, 0, tzinfo=UTC) for day in (2, 3)]
    now = [days[0]]
    with open_sample(tmp_path / "store", clock=lambda: now[0]) as store:
        patient = add_patient(store, Identity("Somebody")).pseudonym
        add_visit(store, patient, [0.001])
        now[0] += timedelta(hours=1)
        call_repeat(store, add_visit(store, patient, [0.003]))
        now[0] = days[1]
        add_visit(store, patient, [0.001, 0.0011, 0.0012])
        found = reliability_in_clinic(store, SAPO, "op").by_measure["anterior", "ANT.ACR.H"]
    assert found.n_values == 2
    assert found.sem == pytest.approx(np.degrees(0.002 / 0.36) / np.sqrt(2), rel=1e-3)
    assert found.mdc95 is not None


@pytest.mark.usefixtures("three_hours_behind_utc")
@pytest.mark.parametrize(
    ("first", "second", "is_same_day"),
    [
        ("2026-11-02 20:45", "2026-11-02 21:15", True),
        ("2026-11-02 21:15", "2026-11-03 10:45", False),
        ("2026-11-02 23:59", "2026-11-03 00:01", False),
    ],
)
def test_a_repeat_is_of_the_day_that_the_clinics_clock_shows(first, second, is_same_day):
    from adibas.pipeline.clinic_repeats import is_repeat_of

    before, repeat = (
        Session(name, "P-1", datetime.fromisoformat(f"{begun}-03:00").astimezone(UTC), "op", setup)
        for name, begun, setup in (
            ("before", first, SessionSetup()),
            ("again", second, SessionSetup(is_repeat=True)),
        )
    )
    assert is_repeat_of(repeat, before) == is_same_day


def test_two_sessions_of_a_day_are_repeats_only_where_somebody_says_so(tmp_path, monkeypatch):
    from adibas.pipeline.clinic_repeats import reliability_in_clinic

    def found(store):
        return reliability_in_clinic(store, SAPO, "op").by_measure["anterior", "ANT.ACR.H"]

    monkeypatch.setenv("ADIBAS_PASSPHRASE", PASSPHRASE)
    folder = tmp_path / "store"
    with open_sample(folder) as store:
        patient = add_patient(store, Identity("Somebody")).pseudonym
        add_visit(store, patient, [0.001])
        treated = add_visit(store, patient, [0.030])
        again = add_visit(store, patient, [0.032])
        assert found(store).mdc95 is None, "one may lie before and one after a treatment"
        assert found(store).n_patients == 0
    assert main(["sessions", "repeat", again, "--store", str(folder)]) == 0
    with open_sample(folder) as store:
        sem = np.degrees(0.002 / 0.36) / np.sqrt(2)
        assert found(store).mdc95 == pytest.approx(12.706 * np.sqrt(2) * sem, rel=1e-2)
    for session in (again, treated):
        assert main(["sessions", "repeat", session, "--no", "--store", str(folder)]) == 0
    with open_sample(folder) as store:
        assert found(store).mdc95 is None
        assert not store.sessions.get(again).setup.is_repeat


def test_the_command_line_lists_shows_and_checks_protocols(tmp_path, capsys):
    assert main(["protocols", "list", "--json"]) == 0
    listed = json.loads(capsys.readouterr().out)["protocols"]
    assert {"joints-15", "sapo-1", "upper-quadrant"} <= {one["name"] for one in listed}
    assert main(["protocols", "show", "sapo-1"]) == 0
    assert "left acromion higher" in capsys.readouterr().out
    assert main(["protocols", "show", "joints-15", "--json"]) == 0
    assert len(json.loads(capsys.readouterr().out)["views"][0]["measures"]) == 1470
    broken = tmp_path / "broken.json"
    broken.write_text('{"format": "adibas-protocol",\n "version": 1}', encoding="utf-8")
    assert main(["protocols", "check", str(broken), "--json"]) == 1
    captured = capsys.readouterr()
    assert "broken.json, line 1: title is missing. Add it." in captured.err
    assert not json.loads(captured.out)["is_valid"]
    assert main(["protocols", "show", "nothing"]) == 1
    assert "No protocol is named nothing" in capsys.readouterr().err
