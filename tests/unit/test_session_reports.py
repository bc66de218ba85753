"""A report of several views: every format shows the same numbers and what a hand changed."""

import csv
import json
import re
from dataclasses import replace
from datetime import UTC, datetime

import numpy as np
import openpyxl
import pytest
from pypdf import PdfReader

from adibas.data.corrections import (
    CorrectionHistory,
    FreeMeasure,
    MarkerCorrection,
    MeasureCorrection,
)
from adibas.data.markers import AutomaticName, Marker
from adibas.data.report import CaptureReport, PictureChoice, SessionReport
from adibas.data.sessions import Capture, Session, SessionSetup
from adibas.errors import ReportError
from adibas.measures.geometry_tables import all_distances
from adibas.pipeline.session_report import capture_report, report_of_analysis, report_of_session
from adibas.reports import batch, pdf, sheets, write_report
from adibas.reports.batch import PICTURES, report_stem, write_session_reports
from adibas.reports.facts import capture_facts

DASH = "\N{EN DASH}"
BEGUN = datetime(2026, 11, 21, 9, 30, tzinfo=UTC)
NAMES = ("espatlla_esquerra·l·l", "ombligo\N{BONE}ñ", "<b>&amp;", "Ωμέγα")


@pytest.fixture(autouse=True)
def small_pictures(monkeypatch):
    """Draw less, for speed."""
    monkeypatch.setattr(pdf, "PICTURE_HEIGHT_PX", 200)
    monkeypatch.setattr(batch, "PICTURE_HEIGHT_PX", 200)


@pytest.fixture
def report(analysis):
    """Two captures of one view and one of another; names of several scripts, corrections."""
    calibration = replace(analysis.calibration, created_utc="2026-11-01T09:30:00+00:00")
    markers = tuple(
        replace(marker, label=name) for marker, name in zip(analysis.markers, NAMES, strict=True)
    )
    names = dict(zip(("m01", "m02", "@m03"), NAMES, strict=False))
    named = replace(
        analysis,
        patient="P-7",
        calibration=calibration,
        markers=markers,
        distances=tuple(replace(d, a=names[d.a], b=names[d.b]) for d in analysis.distances),
        angles=tuple(
            replace(g, a=names[g.a], vertex=names[g.vertex], c=names[g.c]) for g in analysis.angles
        ),
    )
    plain = replace(analysis, patient="P-7", calibration=calibration)
    return SessionReport(
        patient="P-7",
        captures=(
            CaptureReport(plain),
            CaptureReport(
                replace(named, view="left_lateral"),
                frozenset({NAMES[0], NAMES[3]}),
                (
                    FreeMeasure((NAMES[1], NAMES[0])),
                    FreeMeasure((NAMES[2], NAMES[0], NAMES[1])),
                    FreeMeasure((NAMES[0], NAMES[3])),
                ),
            ),
            CaptureReport(replace(plain, picture_rgb=plain.picture_rgb - np.uint8(20))),
        ),
        version="9.9",
        started_utc=BEGUN,
        operator="O. Perator",
        protocol="four views",
        notes="first visit",
    )


def written(report, kind, tmp_path):
    path = tmp_path / f"report{kind}"
    write_report(report, path)
    return path


def table(sheet):
    header, *rows = sheet.iter_rows(values_only=True)
    return [dict(zip(header, row, strict=True)) for row in rows]


def pdf_text(path):
    return "\n".join(page.extract_text() for page in PdfReader(path).pages)


def test_tables_of_several_captures_name_the_view_of_every_row(report, tmp_path):
    workbook = openpyxl.load_workbook(written(report, ".xlsx", tmp_path))
    assert workbook.sheetnames == [
        "Summary",
        "Markers",
        "Distances",
        "Angles",
        "Free measures",
        "Provenance",
    ]
    views = [row["View"] for row in table(workbook["Distances"])]
    assert views == ["anterior"] * 3 + ["left lateral"] * 3 + ["anterior (2)"] * 3
    assert len(workbook["Summary"]._images) == 3
    assert len(workbook["Summary"].row_breaks.brk) == 2


def test_pictures_stand_below_their_facts_and_before_the_next_view(report, tmp_path):
    sheet = openpyxl.load_workbook(written(report, ".xlsx", tmp_path))["Summary"]
    anchors = [image.anchor._from.row + 1 for image in sheet._images]
    for anchor in anchors:
        n_rows = -(-720 // sheets.ROW_PX)
        covered = sheet.iter_rows(min_row=anchor, max_row=anchor + n_rows - 1, values_only=True)
        assert not [row for row in covered if any(row)]
        assert any(sheet.cell(row, 1).value for row in (anchor - 1, anchor - 2))


def test_markers_placed_by_hand_are_marked_in_excel_pdf_and_json(report, tmp_path):
    rows = table(openpyxl.load_workbook(written(report, ".xlsx", tmp_path))["Markers"])
    remarks = {(row["View"], row["Marker"]): row["Remark"] for row in rows}
    assert remarks["left lateral", NAMES[0]] == "corrected by hand"
    assert remarks["left lateral", NAMES[1]] is None
    assert remarks["left lateral", NAMES[3]].startswith("corrected by hand; the depth")
    assert remarks["anterior", "m04"] == "the depth gives no position here"
    assert "* corrected by hand" in pdf_text(written(report, ".pdf", tmp_path))
    document = json.loads(written(report, ".json", tmp_path).read_text(encoding="utf-8"))
    assert document["captures"][1]["placed_by_hand"] == sorted([NAMES[0], NAMES[3]])


def test_free_measures_have_the_numbers_of_the_tables_in_every_format(report, tmp_path):
    workbook = openpyxl.load_workbook(written(report, ".xlsx", tmp_path))
    free = table(workbook["Free measures"])
    assert [row["Value"] for row in free] == pytest.approx([300.0, 90.0, None])
    assert free[2]["Remark"] == "not measured: a marker has no position"
    with written(report, ".csv", tmp_path).open(encoding="utf-8", newline="") as file:
        rows = [row for row in csv.DictReader(file) if row["quantity"].startswith("free")]
    assert [float(row["value"] or 0) for row in rows] == [row["Value"] or 0 for row in free]
    document = json.loads(written(report, ".json", tmp_path).read_text(encoding="utf-8"))
    measures = document["captures"][1]["free_measures"]
    assert [one["value"] for one in measures] == [row["Value"] for row in free]
    assert measures[2]["ci95"] is None
    text = pdf_text(written(report, ".pdf", tmp_path))
    assert "300.0 mm" in text
    assert "90.0 deg" in text


def csv_rows(path):
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def test_the_csv_table_has_the_same_columns_for_one_capture_and_for_many(report, tmp_path):
    rows = csv_rows(written(report, ".csv", tmp_path))
    seen = list(dict.fromkeys((row["capture"], row["view"]) for row in rows))
    assert seen == [("1", "anterior"), ("2", "left_lateral"), ("3", "anterior")]
    single = csv_rows(written(replace(report, captures=report.captures[:1]), ".csv", tmp_path))
    assert single == [row for row in rows if row["capture"] == "1"]


def test_the_csv_table_says_why_a_value_is_missing_and_what_must_be_known(report, tmp_path):
    rows = csv_rows(written(report, ".csv", tmp_path))
    nowhere = [row for row in rows if row["quantity"] in "xyz" and not row["value"]]
    assert nowhere
    assert all("the depth gives no position here" in row["remark"] for row in nowhere)
    missing = [row for row in rows if row["quantity"] == "free_distance" and not row["value"]]
    assert [row["remark"] for row in missing] == ["not measured: a marker has no position"]
    notices = [row["remark"] for row in rows if row["quantity"] == "notice"]
    assert len(notices) == len(report.captures)
    assert "cut" in notices[0]


def test_every_format_tells_who_named_a_marker(analysis, tmp_path):
    by_model, by_user, *numbered = analysis.markers
    by_model = replace(by_model, label="neck", named_by=AutomaticName("model of May", 0.93))
    markers = (by_model, replace(by_user, label="head"), replace(numbered[0], label="m03"))
    single = report_of_analysis(
        replace(analysis, markers=markers, distances=(), angles=()), language="en"
    )
    rows = table(openpyxl.load_workbook(written(single, ".xlsx", tmp_path))["Markers"])
    found = [(row["Named by"], row["Confidence of the name"]) for row in rows]
    assert found == [("model of May", 0.93), ("a person", None), (None, None)]
    document = json.loads(written(single, ".json", tmp_path).read_text(encoding="utf-8"))
    markers = document["captures"][0]["markers"]
    found = [(one["named_by"], one["name_confidence"]) for one in markers]
    assert found == [("model of May", 0.93), ("user", None), (None, None)]
    rows = [row for row in csv_rows(written(single, ".csv", tmp_path)) if row["quantity"] == "u"]
    found = [(row["named_by"], row["name_confidence"]) for row in rows]
    assert found == [("model of May", "0.93"), ("user", ""), ("", "")]
    line = "Names of markers: 1 automatic (least sure: Neck, 93 %), 1 by a person"
    assert line in " ".join(pdf_text(written(single, ".pdf", tmp_path)).split())


def test_every_distance_of_the_pdf_is_the_workbook_s_to_a_tenth(report, tmp_path):
    single = replace(report, captures=report.captures[:1])
    text = pdf_text(written(single, ".pdf", tmp_path))
    rows = table(openpyxl.load_workbook(written(single, ".xlsx", tmp_path))["Distances"])
    for row in rows:
        low, high = row["95 % from [mm], instrument only"], row["95 % to [mm], instrument only"]
        a, b = (row[side].removeprefix("'") for side in "AB")
        cells = [f"{a} {DASH} {b}", f"{row['Distance [mm]']:.1f}", f"{low:.1f} {DASH} {high:.1f}"]
        assert re.search(r"\s+".join(map(re.escape, cells)), text)
    with written(single, ".csv", tmp_path).open(encoding="utf-8", newline="") as file:
        reader = csv.DictReader(file)
        numbers = [float(row["value"]) for row in reader if row["quantity"] == "distance"]
    assert numbers == [row["Distance [mm]"] for row in rows]
    assert "3 angles of all triplets" in text


def test_a_spanish_pdf_writes_its_numbers_with_a_comma(report, tmp_path):
    english = pdf_text(written(report, ".pdf", tmp_path))
    spanish = pdf_text(written(replace(report, language="es"), ".pdf", tmp_path))
    interval = rf"(\d+)[.,](\d) {DASH} (\d+)[.,](\d)"
    assert len(re.findall(interval, english)) > 5
    assert re.findall(interval, spanish) == re.findall(interval, english)
    assert not re.findall(interval.replace("[.,]", r"\."), spanish)
    assert not re.findall(interval.replace("[.,]", ","), english)


def test_the_pdf_has_a_page_a_view_and_a_footer_on_each(report, tmp_path):
    reader = PdfReader(written(report, ".pdf", tmp_path))
    pages = [page.extract_text() for page in reader.pages]
    assert len(pages) == 4
    for number, page in enumerate(pages, 1):
        assert f"Page {number} of 4" in page
        assert "Not for diagnosis" in page
        assert "ADiBAS 9.9" in page
        assert "S1, 2026-11-01T09:30:00+00:00" in page
        assert "20 days" in page
    assert [len(page.images) for page in reader.pages] == [3, 2, 2, 2]  # a picture and a plot
    for fact in ("P-7", "O. Perator", "four views", "first visit", "2026-11-21T09:30:00+00:00"):
        assert fact in pages[0]
    assert "The recording was cut" in pages[0]


def test_nobody_s_identity_nor_pseudonym_is_in_the_metadata(report, tmp_path):
    reader = PdfReader(written(report, ".pdf", tmp_path))
    told = " ".join(str(value) for value in reader.metadata.values())
    assert "P-7" not in told
    assert "Perator" not in told
    assert reader.metadata.title == "Posture report"


def test_names_of_any_script_reach_the_pdf_and_mark_up_is_text(report, tmp_path):
    text = pdf_text(written(report, ".pdf", tmp_path))
    for name in (NAMES[0], NAMES[2], NAMES[3]):
        assert name in text


@pytest.mark.parametrize("separator", [" ", "\n"])
def test_notes_longer_than_a_page_go_on_on_the_next(report, tmp_path, separator):
    notes = separator.join(f"word{number}" for number in range(3000))
    write_report(replace(report, notes=notes), tmp_path / "r.pdf")
    words = set(pdf_text(tmp_path / "r.pdf").split())
    assert words >= {f"word{number}" for number in range(3000)}


def test_characters_that_no_file_holds_stop_no_report(report, tmp_path):
    hostile = Marker("bell\x07\x00\ud800", 5.0, 5.0, 4.0, np.eye(2))
    capture = report.captures[0]
    analysis = replace(capture.analysis, markers=(*capture.analysis.markers, hostile))
    broken = replace(report, captures=(CaptureReport(analysis),), notes="a\x0bb <i>&")
    for kind in (".xlsx", ".pdf", ".csv", ".json"):
        assert written(broken, kind, tmp_path).stat().st_size > 500
    sheet = openpyxl.load_workbook(tmp_path / "report.xlsx")["Markers"]
    assert "bell\N{WHITE SQUARE}" in sheet.cell(6, 1).value


def test_a_name_like_an_error_value_is_text(report, tmp_path):
    strange = Marker("#N/A", 5.0, 5.0, 4.0, np.eye(2))
    analysis = replace(
        report.captures[0].analysis, markers=(strange, *report.captures[0].analysis.markers)
    )
    path = written(replace(report, captures=(CaptureReport(analysis),)), ".xlsx", tmp_path)
    sheet = openpyxl.load_workbook(path)["Markers"]
    assert (sheet["A2"].value, sheet["A2"].data_type) == ("#N/A", "s")
    assert (sheet["A3"].value, sheet["A3"].data_type) == ("m01", "s")


def test_many_markers_with_long_names_fit_the_page(report, tmp_path):
    rng = np.random.default_rng(0)
    markers = tuple(
        Marker(
            f"a_very_long_name_of_a_landmark_number_{n:02d}",
            *rng.uniform(5, 110, 2),
            4.0,
            np.eye(2),
            rng.uniform(-1, 1, 3),
            np.eye(3) * 1e-6,
        )
        for n in range(32)
    )
    analysis = replace(
        report.captures[0].analysis, markers=markers, distances=all_distances(markers), angles=()
    )
    path = written(replace(report, captures=(CaptureReport(analysis),)), ".pdf", tmp_path)
    text = pdf_text(path)
    assert "The first 435 of 496 distances" in text
    assert "a_very_long_name_of_a_landmark_number_31" in text


def test_a_capture_of_one_marker_says_that_there_is_no_distance(report, tmp_path):
    analysis = replace(
        report.captures[0].analysis,
        markers=report.captures[0].analysis.markers[:1],
        distances=(),
        angles=(),
    )
    text = pdf_text(written(replace(report, captures=(CaptureReport(analysis),)), ".pdf", tmp_path))
    assert "No two markers have a position" in text


def test_calibrations_that_differ_or_are_of_unknown_age_are_told(report, tmp_path):
    known = report.captures[0].analysis
    unknown = replace(known, calibration=replace(known.calibration, created_utc="long ago"))
    mixed = replace(report, captures=(report.captures[0], CaptureReport(unknown)))
    assert "several calibrations" in pdf_text(written(mixed, ".pdf", tmp_path))
    alone = replace(report, captures=(CaptureReport(unknown),))
    assert "age not known" in pdf_text(written(alone, ".pdf", tmp_path))


@pytest.mark.parametrize(
    ("language", "expected"), [("es", "Informe de postura"), ("ca", "Informe de postura")]
)
def test_a_report_speaks_its_own_language(report, tmp_path, language, expected):
    spoken = replace(report, language=language)
    assert expected in pdf_text(written(spoken, ".pdf", tmp_path))
    reader = PdfReader(tmp_path / "report.pdf")
    assert reader.trailer["/Root"]["/Lang"] == language
    workbook = openpyxl.load_workbook(written(spoken, ".xlsx", tmp_path))
    assert "Summary" not in workbook.sheetnames
    assert isinstance(workbook.worksheets[2].cell(2, 4).value, int | float)


def test_the_moment_of_the_analysis_is_told_to_the_second(report):
    (capture, *_others) = report.captures
    made = replace(capture.analysis.provenance, created_utc="2026-03-27T16:05:09+00:00")
    told = capture_facts(
        report, replace(capture, analysis=replace(capture.analysis, provenance=made))
    )
    assert ("Analysed (UTC)", "2026-03-27 16:05:09") in told


def test_rows_beyond_what_a_sheet_holds_go_on_in_another(report, tmp_path, monkeypatch):
    monkeypatch.setattr(sheets, "MOST_ROWS", 4)
    workbook = openpyxl.load_workbook(written(report, ".xlsx", tmp_path))
    names = [name for name in workbook.sheetnames if name.startswith("Distances")]
    assert names == ["Distances", "Distances (2)", "Distances (3)"]
    assert sum(len(table(workbook[name])) for name in names) == 9


def test_a_face_that_cannot_be_hidden_stops_the_report_and_leaves_no_file(report, tmp_path):
    for kind in (".xlsx", ".pdf"):
        with pytest.raises(ReportError):
            written(replace(report, pictures=PictureChoice.BLURRED), kind, tmp_path)
    assert not list(tmp_path.iterdir())


def test_a_batch_replaces_nothing_and_tells_how_far_it_is(report, tmp_path):
    told = []
    reports = [report, replace(report, patient="../../etc/p:8")]
    for _round in range(2):
        paths = write_session_reports(
            reports, tmp_path / "out", (".csv", PICTURES), lambda *done: told.append(done)
        )
    assert told[:4] == [(1, 4), (2, 4), (3, 4), (4, 4)]
    assert len(set(paths)) == len(paths) == 8
    assert {path.parent for path in paths} == {tmp_path / "out"}
    names = sorted(path.name for path in (tmp_path / "out").iterdir())
    assert len(names) == 16
    assert "P-7_2026-11-21.csv" in names
    assert "P-7_2026-11-21_2.csv" in names
    assert "P-7_2026-11-21_left-lateral.png" in names
    assert "etc-p-8_2026-11-21.csv" in names


def test_a_report_without_patient_and_date_has_a_name_too(report):
    assert report_stem(replace(report, patient="", started_utc=None)) == "report"
    assert report_stem(replace(report, patient="...", started_utc=None)) == "report"


@pytest.mark.usefixtures("three_hours_behind_utc")
def test_a_file_has_the_day_of_the_clinics_clock(report):
    late = datetime(2026, 3, 6, 1, 30, tzinfo=UTC)
    assert report_stem(replace(report, patient="P-7F3KQ2", started_utc=late)).endswith("2026-03-05")


def test_a_session_of_the_store_becomes_a_report_of_its_corrected_markers(report):
    analysis = report.captures[0].analysis
    m01, m02, _m03, m04 = analysis.markers
    moved = replace(m01, u=m01.u + 1, position_m=np.array([0.0, 0.1, 2.0]))
    history = CorrectionHistory()
    for correction in (
        MarkerCorrection(m01, moved),
        MarkerCorrection(m04, None),
        MeasureCorrection(None, FreeMeasure(("m01", "m02"))),
    ):
        history = history.after(correction)
    capture = Capture(
        "c1",
        "s1",
        "posterior",
        BEGUN,
        "r1",
        5,
        30,
        analysis.calibration,
        analysis.markers,
        (),
        analysis.provenance,
        history,
    )
    surface = np.full((4, 4), 0.5, np.float32)
    shown = capture_report(capture, analysis.picture_rgb, surface)
    session = Session("s1", "P-9", BEGUN, "op", SessionSetup(rotation_deg=90, protocol="p"))
    whole = report_of_session(session, (shown,), "ca", PictureChoice.DEPTH)
    found = whole.captures[0]
    assert found.placed_by_hand == {"m01"}
    assert [marker.label for marker in found.analysis.markers] == ["m01", "m02", "@m03"]
    assert found.analysis.distances[0].value_m == pytest.approx(np.hypot(0.3, 0.1))
    assert found.analysis.patient == whole.patient == "P-9"
    assert (whole.rotation_deg, whole.protocol, whole.operator) == (90, "p", "op")
    assert (whole.language, whole.pictures) == ("ca", PictureChoice.DEPTH)
    assert m02 in found.analysis.markers
