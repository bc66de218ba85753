"""What is being coded outlives a crash, beside its recording."""

import csv
import io
from dataclasses import replace

import pytest

from adibas.behaviour.editing import Draft, pressed, removed
from adibas.data.coding import Coding, Occurrence
from adibas.data.ethogram import Behaviour, Ethogram
from adibas.errors import BehaviourError, FileError, RecordingError
from adibas.pipeline.coding_drafts import BesideRecording, new_draft, read_draft, write_draft
from adibas.recordings.coding_csv import codings_of_csv
from tests.unit.coding_samples import ETHOGRAM, coding


@pytest.fixture
def place(tmp_path):
    return BesideRecording(tmp_path / "child.mcap")


def test_nothing_is_kept_before_anything_is_coded(place):
    assert read_draft(place) is None


def test_a_draft_comes_back_as_it_was(place):
    draft = Draft(coding(("seated", 1, 4, "child"), ("nods", 2, 2)))
    write_draft(place, draft, 9000)
    assert read_draft(place) == draft
    assert place.path("coding").name == "child.coding.csv"


def test_a_state_that_lasts_is_kept_up_to_now(place):
    write_draft(place, pressed(Draft(coding()), "seated", "child", 1000), 9000)
    assert read_draft(place).coding.occurrences == (Occurrence("seated", 1000, 9000, "child"),)


def test_what_was_detected_and_not_decided_comes_back(place):
    seen = Ethogram("program", (Behaviour("waves"),))
    found = Coding("child", seen, 0, 60_000, (Occurrence("waves", 1, 2),), "program")
    draft = Draft(coding(), (), found)
    write_draft(place, draft, 0)
    assert read_draft(place) == draft
    write_draft(place, removed(draft, found.occurrences[0]), 0)
    assert read_draft(place).proposed == ()


WITH_RETURN = Draft(
    replace(
        coding(("seated", 1, 4, "child")),
        occurrences=(
            Occurrence("seated", 1000, 4000, "child", (), "sits\rthen leans", "up\r"),
            Occurrence("nods", 5000, 5000, "child", (), "\r", "two\r\nlines"),
        ),
    )
)


def test_a_carriage_return_in_a_comment_comes_back(place):
    write_draft(place, WITH_RETURN, 9000)
    assert read_draft(place) == WITH_RETURN


def test_a_draft_that_was_kept_with_a_bare_carriage_return_opens_again(place):
    write_draft(place, WITH_RETURN, 9000)
    table = io.StringIO(newline="")
    rows = csv.reader(io.StringIO(place.read("coding"), newline=""))
    csv.writer(table, lineterminator="\n").writerows(rows)
    damaged = table.getvalue()
    for cell in ("sits\rthen leans", "up\r", "'\r"):  # a later Python would quote them
        damaged = damaged.replace(f'"{cell}"', cell)
    assert ",sits\rthen leans,up\r," in damaged
    place.write("coding", damaged)
    assert read_draft(place) == WITH_RETURN


def test_a_table_whose_lines_end_in_carriage_returns_alone_is_read(place):
    write_draft(place, Draft(coding(("seated", 1, 4, "child"), ("nods", 2, 2))), 0)
    text = place.read("coding").replace("\r\n", "\r")
    assert codings_of_csv(text, "coding") == (coding(("seated", 1, 4, "child"), ("nods", 2, 2)),)


def test_a_second_observer_has_files_of_his_own(tmp_path):
    second = BesideRecording(tmp_path / "child.joints.csv", "M. P/2")
    assert second.path("coding").name == "child.coding-M_P_2.csv"


def test_a_new_draft_holds_nothing():
    draft = new_draft("child", (5, 10), ETHOGRAM, "MP")
    assert (draft.coding.begin_ms, draft.coding.end_ms, draft.coding.occurrences) == (5, 10, ())
    assert new_draft("", (0, 1), ETHOGRAM, "").coding.name


@pytest.mark.parametrize("broken", [b"nonsense", b"recording,label,begin_s,end_s\nx,y,z,0\n"])
def test_a_broken_draft_is_told(place, broken):
    place.path("coding").write_bytes(broken)
    with pytest.raises(BehaviourError):
        read_draft(place)


def test_bytes_that_are_no_text_are_told(place):
    place.path("coding").write_bytes(b"\xff\xfe\xff")
    with pytest.raises(RecordingError, match=r"child.coding.csv"):
        read_draft(place)


def test_an_empty_table_is_no_draft(place):
    place.path("coding").write_text("recording,label,begin_s,end_s\n")
    assert read_draft(place) is None


def test_what_cannot_be_written_is_told_and_the_draft_before_is_unharmed(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(FileError):
        write_draft(BesideRecording(tmp_path / "file" / "child.mcap"), Draft(coding()), 0)


def test_what_no_spreadsheet_runs_stays_text(place):
    draft = Draft(replace(coding(), name="=1+1"))
    write_draft(place, draft, 0)
    assert read_draft(place) == draft
