"""Excel, CSV and JSON show the same numbers, and text can never run as a formula."""

import csv
import json

import numpy as np
import openpyxl
import pytest

from adibas.pipeline.session_report import report_of_analysis
from adibas.reports import write_report
from adibas.reports.cells import neutralised
from adibas.reports.json_report import posture_to_json
from adibas.reports.pictures import (
    WITH_POSITION_RGB,
    WITHOUT_POSITION_RGB,
    draw_markers,
    picture_of,
)


@pytest.fixture
def workbook(analysis, tmp_path):
    path = tmp_path / "report.xlsx"
    write_report(report_of_analysis(analysis, "en"), path)
    return openpyxl.load_workbook(path)


def table(sheet):
    header, *rows = sheet.iter_rows(values_only=True)
    return [dict(zip(header, row, strict=True)) for row in rows]


def test_the_workbook_has_the_sheets_of_the_contract(workbook):
    assert workbook.sheetnames == ["Summary", "Markers", "Distances", "Angles", "Provenance"]


def test_distances_and_angles_are_real_numbers_in_clinical_units(workbook):
    distances = table(workbook["Distances"])
    assert [row["Distance [mm]"] for row in distances] == pytest.approx([300.0, 400.0, 500.0])
    assert distances[0]["95 % from [mm], instrument only"] == pytest.approx(299.0)
    angles = table(workbook["Angles"])
    assert angles[0]["Angle [deg]"] == pytest.approx(90.0)
    assert angles[0]["95 % to [deg], instrument only"] == pytest.approx(np.degrees(1.58))
    assert workbook["Angles"]["D2"].number_format == "0.0"


def test_a_marker_without_position_has_empty_cells_and_a_remark(workbook):
    row = table(workbook["Markers"])[-1]
    assert row["x [mm]"] is None
    assert row["sd z [mm]"] is None
    assert row["Remark"]
    assert table(workbook["Markers"])[0]["sd z [mm]"] == pytest.approx(2.0)


def test_no_cell_holds_a_formula_and_hostile_text_is_neutralised(workbook):
    cells = [cell for sheet in workbook for row in sheet.iter_rows() for cell in row]
    assert not [cell.coordinate for cell in cells if cell.data_type == "f"]
    texts = [cell.value for cell in cells if isinstance(cell.value, str)]
    assert not [text for text in texts if text.startswith(("=", "+", "-", "@"))]
    assert "'@m03" in texts


def test_tables_can_be_filtered_and_fit_the_page(workbook):
    sheet = workbook["Angles"]
    assert sheet.freeze_panes == "A2"
    assert sheet.auto_filter.ref == "A1:G4"
    assert sheet.print_title_rows == "$1:$1"
    for sheet in workbook:
        assert sheet.sheet_properties.pageSetUpPr.fitToPage
        assert (sheet.page_setup.fitToWidth, sheet.page_setup.fitToHeight) == (1, 0)


def test_the_summary_names_intended_use_version_and_notices(workbook):
    pairs = {row[0]: row[1] for row in workbook["Summary"].iter_rows(min_row=3, values_only=True)}
    assert "Not for diagnosis" in pairs["Intended use"]
    assert pairs["Software version"] == "0.1.0"
    assert pairs["Markers found"] == 4
    assert pairs["Markers with a position"] == 3
    assert "cut" in pairs["Notice"]
    assert len(workbook["Summary"]._images) == 1


def test_every_parameter_is_in_the_provenance(workbook):
    pairs = dict(row[:2] for row in workbook["Provenance"].iter_rows(min_row=3, values_only=True))
    assert pairs["detection.threshold"] == 12.5
    assert pairs["detection.name"] == "'-x"


def test_csv_and_json_show_the_numbers_of_the_workbook(analysis, workbook, tmp_path):
    path = tmp_path / "report.csv"
    write_report(report_of_analysis(analysis, "en"), path)
    with path.open(newline="") as file:
        rows = list(csv.DictReader(file))
    document = posture_to_json(analysis)
    from_excel = [row["Angle [deg]"] for row in table(workbook["Angles"])]
    from_csv = [float(row["value"]) for row in rows if row["quantity"] == "angle"]
    from_json = [angle["deg"] for angle in document["angles"]]
    assert from_excel == from_csv == from_json
    assert [row["value"] for row in rows if row["quantity"] == "x"][-1] == ""
    assert {row["a"][0] for row in rows if row["a"]} <= {"m", "'"}


def test_the_json_document_is_the_contract_s(analysis):
    document = json.loads(json.dumps(posture_to_json(analysis), allow_nan=False))
    assert document["measures"] == []
    assert document["markers"][3]["position_m"] is None
    assert document["markers"][0]["covariance_m2"][2][2] == 4e-6
    assert document["distances"][2] == {
        "a": "m02",
        "b": "@m03",
        "mm": 500.0,
        "ci95_mm": [499.0, 501.0],
    }
    assert set(document["provenance"]) >= {
        "recording_sha256",
        "calibration",
        "version",
        "parameters",
    }


def test_markers_are_drawn_where_they_lie_and_tell_whether_they_were_measured(analysis):
    picture = draw_markers(picture_of(analysis), 240).astype(int)

    def distance_to(rgb, u, v):
        ring = picture[round(v * 2) - 16 : round(v * 2) + 17, round(u * 2) - 16 : round(u * 2) + 17]
        return np.abs(ring - rgb).sum(axis=2).min()

    assert distance_to(WITH_POSITION_RGB, 30.5, 20.25) < 40
    assert distance_to(WITHOUT_POSITION_RGB, 120.5, 20.25) < 40
    assert (picture[200:] == 90).all()


@pytest.mark.parametrize("start", ["=", "+", "-", "@", "\t", "\r"])
def test_formula_starts_are_made_text(start):
    assert neutralised(f"{start}1+1") == f"'{start}1+1"
    assert neutralised("1+1") == "1+1"


def test_a_report_of_unknown_format_is_a_programming_error(analysis, tmp_path):
    with pytest.raises(ValueError, match="docx"):
        write_report(report_of_analysis(analysis, "en"), tmp_path / "report.docx")
