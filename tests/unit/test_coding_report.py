"""A coding as a report of its own, and codings of other programs on a recording's clock."""

import csv
from dataclasses import replace

import pytest
from openpyxl import load_workbook

from adibas.data.coding import Section
from adibas.errors import BehaviourError
from adibas.pipeline.coding_files import for_file, read_for, shifted
from adibas.reports.coding_report import write_coding_report
from adibas.reports.codings import write_codings
from tests.unit.coding_samples import coding

DONE = coding(
    ("seated", 1, 4, "child"), ("nods", 2, 2, "child"), sections=(Section("game", 0, 30_000),)
)


def test_a_workbook_holds_what_is_counted(tmp_path):
    write_coding_report([DONE], 10_000, tmp_path / "a.xlsx", "en")
    workbook = load_workbook(tmp_path / "a.xlsx")
    assert workbook.sheetnames == [
        *("Behaviour", "Behaviour in time", "Events", "Transitions", "Ethogram")
    ]


def test_a_table_holds_the_totals_of_each_condition(tmp_path):
    write_coding_report([DONE], 10_000, tmp_path / "a.csv", "es")
    with (tmp_path / "a.csv").open(newline="", encoding="utf-8") as file:
        title, *rows = csv.reader(file)
    assert title[0] == "Observador"
    seated = [row for row in rows if row[2:4] == ["child", "seated"]]
    column = 7
    assert [float(row[column]) for row in seated] == [3.0, 3.0, 0.0]


def test_a_carriage_return_in_a_name_does_not_cut_the_table_of_totals(tmp_path):
    odd = replace(DONE, observer="A\rB")
    write_coding_report([odd], 10_000, tmp_path / "a.csv", "en")
    with (tmp_path / "a.csv").open(newline="", encoding="utf-8") as file:
        title, *rows = csv.reader(file)
    assert {row[0] for row in rows} == {"A\rB"}
    assert {len(row) for row in rows} == {len(title)}


def test_another_ending_is_a_mistake_of_the_caller(tmp_path):
    with pytest.raises(ValueError, match="pdf"):
        write_coding_report([DONE], 10_000, tmp_path / "a.pdf", "en")


@pytest.mark.parametrize("ending", ["boris", "eaf", "csv", "xlsx"])
@pytest.mark.parametrize("begin_ms", [0, 5000, 1_700_000_000_000])
def test_a_coding_keeps_its_place_in_the_recording(tmp_path, ending, begin_ms):
    placed = shifted(DONE, begin_ms)
    path = tmp_path / f"a.{ending}"
    write_codings(path, [for_file(placed, path)], "en")
    found = read_for(path, "session 1", (placed.begin_ms, placed.end_ms))
    spans = [(one.behaviour, one.begin_ms) for one in found.occurrences]
    assert spans == [("seated", begin_ms + 1000), ("nods", begin_ms + 2000)]


def test_a_table_that_counts_from_the_videos_begin_is_told_by_its_times(tmp_path):
    write_codings(tmp_path / "a.csv", [DONE], "en")
    found = read_for(tmp_path / "a.csv", "other", (100_000, 160_000))
    assert (found.begin_ms, found.end_ms) == (100_000, 160_000)
    assert found.occurrences[0].begin_ms == 101_000
    assert found.sections == (Section("game", 100_000, 130_000),)


def test_events_beyond_the_recording_are_told(tmp_path):
    write_codings(tmp_path / "a.csv", [DONE], "en")
    with pytest.raises(BehaviourError, match="outside the session"):
        read_for(tmp_path / "a.csv", "session 1", (0, 1500))


def test_a_file_without_a_session_is_told(tmp_path):
    (tmp_path / "a.csv").write_text("recording,label,begin_s,end_s\n")
    with pytest.raises(BehaviourError, match="no session"):
        read_for(tmp_path / "a.csv", "a", (0, 1))
