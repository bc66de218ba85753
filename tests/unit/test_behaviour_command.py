"""Behaviour from joints and from observers, end to end through the command line."""

import dataclasses
import json
from types import SimpleNamespace

import numpy as np
import pytest
from openpyxl import load_workbook

from adibas.behaviour.activity import ActivityParams
from adibas.cli.command_line import main
from adibas.data.coding import LONGEST_MS
from adibas.data.events import TimedEvent
from adibas.data.joints import JOINT_NAMES
from adibas.data.skeleton_track import track_of
from adibas.geometry.quarter_turns import QuarterTurn
from adibas.gestures.descriptor import DescriptorParams
from adibas.gestures.model_file import write_model
from adibas.gestures.training import TrainingParams, train
from adibas.pipeline.behaviour import BehaviourRequest, analyse_behaviour, gesture_occurrences
from adibas.pipeline.behaviour_agreement import icc_of
from adibas.pipeline.gesture_examples import examples_of
from adibas.pipeline.joined_access import joined_name
from adibas.recordings.boris_writing import write_boris
from adibas.recordings.coding_csv import coding_csv_text, write_coding_csv
from adibas.recordings.codings import read_codings
from adibas.recordings.joints_csv import write_joints_csv
from adibas.resources import resource_path
from tests.unit.coding_samples import coding
from tests.unit.gesture_examples import recording, streams
from tests.unit.test_activity import FOOT, HAND, circling, still


@pytest.fixture
def joints(tmp_path):
    """Two people for 60 s: the first circles a hand for 20 s and shifts; the second comes late."""
    times_s, first_m = still(900, 15.0, 0.005, begin_s=0.0)
    first_m[:300] = circling(first_m[:300], HAND, 0.1, 1.0, 15.0)
    first_m[600:, :, 0] += 0.3
    _times, second_m = still(900, 15.0, 0.005, seed=1)
    second_m[:300] = np.nan
    path = tmp_path / "play.joints.csv"
    write_joints_csv(path, [track_of(times_s, first_m), track_of(times_s, second_m, 2)])
    return path


def told(capsys, *argv):
    code = main([*map(str, argv), "--json"])
    document = capsys.readouterr().out
    return code, json.loads(document) if document else None


def test_a_table_of_joints_becomes_a_timeline(joints, tmp_path, capsys):
    report = tmp_path / "report.xlsx"
    code, document = told(
        capsys, "behaviour", joints, "--section", "game=0:20", "--section", "task=20:50",
        "--bin", "20", "--out", report,
    )  # fmt: skip
    assert code == 0
    first, second = document["people"]
    conditions = {name: one[HAND] for name, one in first["conditions"].items()}
    assert conditions["game"]["active_s"] > 19
    assert conditions["task"]["active_s"] < 1.5
    assert sum(one["observed_s"] for one in conditions.values()) == pytest.approx(
        first["joints"][HAND]["observed_s"]
    )
    (detected,) = document["codings"]
    totals = {(one["subject"], one["behaviour"]): one for one in detected["totals"]}
    assert totals["person 1", "posture change"]["count"] == 1
    assert totals["person 2", "out of view"]["total_s"] == pytest.approx(20.0, abs=0.1)
    for whose, one in totals.items():
        bins = [
            part
            for some in detected["bins"]
            for part in some["totals"]
            if (part["subject"], part["behaviour"]) == whose
        ]
        assert sum(part["count"] for part in bins) == one["count"]
    assert second["joints"][HAND]["seen_s"] == pytest.approx(40.0, abs=0.2)
    assert any(notice.startswith("Person 2 is out of view") for notice in document["notices"])
    book = load_workbook(report)
    assert book.sheetnames[:4] == ["Summary", "Activity", "Activity in time", "Behaviour"]
    rows = list(book["Activity"].iter_rows(values_only=True))
    whole = next(row for row in rows if row[:3] == ("whole session", "Person 1", "Left hand"))
    assert whole[7] == pytest.approx(first["joints"][HAND]["path_m"])
    bins = list(book["Activity in time"].iter_rows(min_row=2, values_only=True))
    column = [cell.value for cell in book["Activity in time"][1]].index("Left hand [m]")
    mine = [row[column] or 0.0 for row in bins if row[2] == "Person 1"]
    assert sum(mine) == pytest.approx(whole[7])
    book.close()


@pytest.mark.parametrize(
    ("still_s", "words"),
    [
        ("25:35", []),
        ("5:15", ["person 2 ", ": head, neck, "]),
        ("40:50", ["person 1 ", ": left hand."]),
    ],
)
def test_joints_of_which_a_still_time_tells_no_noise_are_named(tmp_path, capsys, still_s, words):
    times_s, first_m = still(900, 15.0, 0.005, begin_s=0.0)
    first_m[600:745, HAND] = np.nan  # seven steps of the last still time are left
    _times, second_m = still(900, 15.0, 0.005, seed=1)
    second_m[:300] = np.nan
    second_m[:, FOOT] = np.nan  # whoever never appears has no noise
    path = tmp_path / "a.csv"
    write_joints_csv(path, [track_of(times_s, first_m), track_of(times_s, second_m, 2)])
    code, document = told(
        capsys, "behaviour", path, "--still", still_s, "--out", tmp_path / "r.xlsx"
    )
    assert code == 0
    said = [notice for notice in document["notices"] if "in the still time" in notice]
    assert len(said) == bool(words)
    assert all(word in notice for notice in said for word in words)
    assert all("right foot" not in notice for notice in said)


def test_who_has_no_neck_does_no_gesture(tmp_path):
    times_s, joints_m = still(100, 15.0)
    joints_m[:, JOINT_NAMES.index("neck")] = np.nan
    write_joints_csv(tmp_path / "a.csv", [track_of(times_s, joints_m)])
    request = BehaviourRequest(tmp_path / "a.csv", (resource_path("models", "gestures.json"),))
    found = analyse_behaviour(request, lambda _done, _total: None)
    assert any("neck of person 1 never appears" in notice.text for notice in found.notices)


def test_the_side_that_people_show_is_told_to_who_finds_their_joints(tmp_path, monkeypatch, capsys):
    asked = []

    def posed(request, _progress, _clock):
        asked.append(request.pose.view)
        times_s, joints_m = still(60, 15.0, 0.005, begin_s=0.0)
        tracks = (track_of(times_s, joints_m),)
        return SimpleNamespace(tracks=tracks, notices=(), turn=QuarterTurn(0))

    monkeypatch.setattr("adibas.pipeline.found_joints.pose_recording", posed)
    (tmp_path / "a.mcap").write_bytes(b"recording")
    words = ["behaviour", tmp_path / "a.mcap", "--out", tmp_path / "r.csv"]
    code, document = told(capsys, *words, "--view", "posterior")
    assert code == 0
    assert told(capsys, *words)[0] == 0
    assert asked == ["posterior", ""]
    assert document["provenance"]["parameters"]["view"] == "posterior"


def test_no_side_is_told_of_a_table_of_joints(joints, tmp_path, capsys):
    with pytest.raises(SystemExit) as ended:
        main(["behaviour", str(joints), "--view", "anterior", "--out", str(tmp_path / "r.csv")])
    assert ended.value.code == 2
    assert "--view is of a recording" in capsys.readouterr().err


def test_joints_of_a_recording_are_found_without_markers(tmp_path, monkeypatch):
    """The chain of its own is tested elsewhere; here its people arrive in the timeline."""
    track = track_of(*still(100, 15.0))
    monkeypatch.setattr(
        "adibas.pipeline.found_joints.pose_recording",
        lambda *_told: SimpleNamespace(tracks=(track,), notices=(), turn=QuarterTurn()),
    )
    (tmp_path / "a.mcap").write_bytes(b"recording")
    found = analyse_behaviour(BehaviourRequest(tmp_path / "a.mcap"), lambda _done, _total: None)
    assert found.recording == "a"
    assert "estimated without markers" in found.notices[0].text
    assert "--still" in found.notices[0].text
    still_time = ActivityParams(still_s=(5.0, 10.0))
    request = BehaviourRequest(tmp_path / "a.mcap", activity=still_time, joints=found.joints)
    again = analyse_behaviour(request, lambda _done, _total: None)
    assert "estimated without markers" in again.notices[0].text
    assert not any("--still" in notice.text for notice in again.notices)


def test_an_observer_stands_beside_the_joints(joints, tmp_path, capsys):
    write_coding_csv(tmp_path / "ab.csv", [coding(("fidgets", 1, 19, "child"), end_ms=59_000)])
    code, document = told(
        capsys, "behaviour", joints, "--coding", tmp_path / "ab.csv", "--out", tmp_path / "r.xlsx",
        "--out", tmp_path / "found.csv", "--language", "es",
    )  # fmt: skip
    assert code == 0
    assert [one["observer"] for one in document["codings"]] == ["AB", "ADiBAS"]
    (found,) = read_codings(tmp_path / "found.csv")
    assert len(found.occurrences) == len(document["codings"][1]["events"])


def test_gestures_that_overlap_with_themselves_follow_each_other():
    events = [TimedEvent("r", "wave", 0.0, 2.0), TimedEvent("r", "wave", 1.5, 3.0),
              TimedEvent("r", "clap", 1.0, 2.0), TimedEvent("r", "wave", 1.6, 2.5)]  # fmt: skip
    found = gesture_occurrences(events, "person 1")
    assert [(one.behaviour, one.begin_ms, one.end_ms) for one in found] == [
        ("wave", 0, 2000),
        ("clap", 1000, 2000),
        ("wave", 2000, 3000),
    ]


@pytest.mark.parametrize(("bin_s", "bin_ms"), [(0.0001, 1), (1e306, LONGEST_MS)])
def test_a_bin_lasts_a_millisecond_at_least_and_no_longer_than_anything(joints, bin_s, bin_ms):
    request = BehaviourRequest(joints, bin_s=bin_s)
    assert analyse_behaviour(request, lambda _done, _total: None).bin_ms == bin_ms


def test_gestures_are_seen_by_a_sensor_on_its_side_whose_rotation_is_told(tmp_path, capsys):
    tracks, events = streams(2, ("wave", "bend", "wave"))
    descriptor = DescriptorParams()
    examples = examples_of(tracks, events, descriptor)[0]
    model = tmp_path / "model.json"
    write_model(model, train(examples, descriptor, TrainingParams(method="dtw")))
    track, done = recording(9, ("wave", "bend"))
    lying = dataclasses.replace(track, joints_m=QuarterTurn(1).points(track.joints_m))
    write_joints_csv(tmp_path / "upright.csv", [track])
    write_joints_csv(tmp_path / "lying.csv", [lying])

    def seen(name, *options):
        argv = ["behaviour", tmp_path / name, "--model", model, *options]
        code, document = told(capsys, *argv, "--out", tmp_path / "r.xlsx")
        assert code == 0
        found = document["codings"][0]["events"]
        return [one for one in found if one["behaviour"] in ("wave", "bend")]

    upright = seen("upright.csv")
    assert [one["behaviour"] for one in upright] == [label for label, *_span in done]
    assert seen("lying.csv", "--rotation", "270") == upright


def test_gestures_of_a_model_are_in_the_timeline(joints):
    model = resource_path("models", "gestures.json")
    found = analyse_behaviour(BehaviourRequest(joints, (model,)), lambda _done, _total: None)
    names = {one.name for one in found.detected.ethogram.behaviours}
    assert {"clap", "jump", "posture change", "out of view"} <= names


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--section", "a=0:20", "--section", "b=10:30"], "overlaps with another one"),
        (["--section", "a=0:200"], "outside the recording"),
        (["--still", "50:70"], "still time from 50.0 to 70.0 s lies outside the recording (0.0 to"),
        (["--still", "0:1e306"], "lies outside the recording"),
        (["--section", "a=0:1e306"], "outside the recording"),
        (["--coding", "none.csv"], "none.csv cannot be read"),
        (["--model", "none.json"], "none.json cannot be read"),
    ],
)
def test_what_the_world_lacks_is_told(joints, tmp_path, capsys, options, words):
    code = main(["behaviour", str(joints), *options, "--out", str(tmp_path / "r.xlsx")])
    assert code == 1
    assert words in capsys.readouterr().err
    assert not (tmp_path / "r.xlsx").exists()


@pytest.mark.parametrize(
    "options", [["--section", "a=x:3"], ["--section", "=1:3"], ["--still", "5:1"], ["--bin", "0"]]
)
def test_wrong_usage_is_told(joints, tmp_path, options):
    with pytest.raises(SystemExit) as stopped:
        main(["behaviour", str(joints), *options, "--out", str(tmp_path / "r.xlsx")])
    assert stopped.value.code == 2


@pytest.fixture
def observers(tmp_path):
    one = coding(("seated", 0, 30, "child"), ("nods", 31, 31, "child"), ("nods", 50, 50, "child"))
    other = coding(
        ("seated", 2, 30, "child"), ("nods", 31.4, 31.4, "child"), observer="CD",
    )  # fmt: skip
    write_coding_csv(tmp_path / "one.csv", [one])
    write_boris(tmp_path / "other.boris", [other])
    return tmp_path / "one.csv", tmp_path / "other.boris"


def test_observers_are_compared_across_formats(observers, tmp_path, capsys):
    report = tmp_path / "agreement.xlsx"
    code, document = told(capsys, "coding", "agreement", *observers, "--out", report)
    assert code == 0
    (session,) = document["sessions"]
    assert session["observers"] == ["AB", "CD"]
    values = {(one["method"], one["subject"], one["behaviour"]): one for one in session["figures"]}
    assert values["time-unit-kappa", "child", "seated"]["observed"] == pytest.approx(58 / 60)
    assert values["total-count", "child", "nods"]["value"] == 0.5
    assert values["icc-duration", "child", "seated"]["value"] > 0.9
    assert values["icc-count", "child", "up"]["value"] is None
    assert "same value" in values["icc-count", "child", "up"]["reason"]
    assert session["disagreements"] == [
        {"subject": "child", "behaviour": "seated", "begin_s": 0.0, "end_s": 2.0, "seen_by": 1}
    ]
    assert {"first": "nods", "second": None, "begin_s": 50.0} in session["events"]
    book = load_workbook(report)
    assert book.sheetnames == ["Summary", "Agreement", "Who called it what", "Disagreements"]
    rows = list(book["Agreement"].iter_rows(min_row=2, values_only=True))
    assert len(rows) == len(session["figures"])
    assert all(row[4] is not None or row[8] for row in rows)
    book.close()


def test_one_method_is_printed_for_a_reader(observers, capsys):
    assert main(["coding", "agreement", *map(str, observers), "--method", "event-kappa"]) == 0
    printed = capsys.readouterr().out
    assert "Kappa by events" in printed
    assert "PABAK" not in printed
    assert "events not agreed on, and 2.0 s" in printed


def test_sessions_are_paired_by_name(tmp_path, capsys):

    one = coding(("nods", 1, 1))
    two = dataclasses.replace(one, name="session 2")
    write_coding_csv(tmp_path / "a.csv", [one, two])
    write_coding_csv(tmp_path / "b.csv", [two, dataclasses.replace(one, name="session 3")])
    code, document = told(capsys, "coding", "agreement", tmp_path / "a.csv", tmp_path / "b.csv")
    assert code == 0
    assert [one["session"] for one in document["sessions"]] == ["session 2"]
    assert "session 1, session 3" in document["notices"][0]
    write_coding_csv(tmp_path / "c.csv", [dataclasses.replace(one, name="x"), one])
    write_coding_csv(tmp_path / "d.csv", [dataclasses.replace(one, name="y"), two])
    assert main(["coding", "agreement", str(tmp_path / "c.csv"), str(tmp_path / "d.csv")]) == 1
    assert "No session is in all files" in capsys.readouterr().err


def test_all_observers_of_a_file_are_compared_with_those_of_the_others(tmp_path, capsys):
    ann, bob, cy = (
        coding(("seated", begin, end, "child"), observer=name)
        for name, begin, end in (("ann", 0, 20), ("bob", 30, 60), ("cy", 0, 20))
    )
    other = coding(("nods", 1, 1), observer="ann")
    other = dataclasses.replace(other, name="session 2")
    _head, *rows = coding_csv_text([bob]).splitlines(keepends=True)
    (tmp_path / "two.csv").write_text(coding_csv_text([ann]) + "".join(rows))
    (tmp_path / "more.csv").write_text(coding_csv_text([ann, other]) + "".join(rows))
    write_coding_csv(tmp_path / "cy.csv", [cy])
    for files, observers in (
        (("two",), ["ann", "bob"]),
        (("two", "cy"), ["ann", "bob", "cy"]),
        (("cy", "more"), ["cy", "ann", "bob"]),
    ):
        paths = [tmp_path / f"{name}.csv" for name in files]
        code, document = told(capsys, "coding", "agreement", *paths)
        assert code == 0
        (session,) = document["sessions"]
        assert session["observers"] == observers
        first_two = f"first two, {observers[0]} and {observers[1]}"
        assert any(first_two in one for one in session["notices"]) == (len(observers) > 2)
        (fleiss,) = [one for one in session["figures"] if one["method"] == "fleiss-kappa"]
        assert fleiss["n"] == 60


def test_a_coding_goes_through_every_format(observers, tmp_path, capsys):
    at = observers[0]
    for name in ("c.xlsx", "c.boris", "c.eaf", "back.csv"):
        assert main(["coding", "convert", str(at), str(tmp_path / name)]) == 0
        at = tmp_path / name
    assert read_codings(at) == read_codings(observers[0])
    assert main(["coding", "convert", str(at), str(tmp_path / "c.doc")]) == 1
    assert "must end in one of" in capsys.readouterr().err


@pytest.mark.parametrize(
    "command",
    [
        ["count", "--bin"],
        ["sample", "--interval"],
        ["agreement", "--tolerance"],
        ["agreement", "--interval"],
        ["agreement", "--unit"],
    ],
)
@pytest.mark.parametrize("seconds", ["1e-9", "1e306"])
def test_a_time_that_nothing_lasts_is_as_good_as_any_other(observers, command, seconds):
    action, option = command
    codings = observers[: 2 if action == "agreement" else 1]
    assert main(["coding", action, *map(str, codings), option, seconds]) == 0


def test_several_sessions_are_several_files_of_elan(tmp_path, capsys):

    one = coding(("nods", 1, 1))
    write_coding_csv(tmp_path / "a.csv", [one, dataclasses.replace(one, name="two")])
    code, document = told(capsys, "coding", "convert", tmp_path / "a.csv", tmp_path / "a.eaf")
    assert code == 0
    assert document["sessions"] == 2
    assert (tmp_path / "a-2.eaf").exists()


def test_a_coding_is_sampled_and_counted(observers, capsys):
    code, document = told(
        capsys, "coding", "sample", observers[0], "--method", "momentary", "--interval", "20"
    )
    assert code == 0
    seated = next(
        one
        for one in document["samples"]
        if (one["behaviour"], one["subject"]) == ("seated", "child")
    )
    assert seated["scores"] == [True, False, False]
    code, document = told(capsys, "coding", "count", observers[0], "--bin", "30")
    (session,) = document["sessions"]
    assert len(session["bins"]) == 2
    total = next(one for one in session["totals"] if one["behaviour"] == "seated" and one["count"])
    assert total["total_s"] == 30.0


def test_readers_get_lines(observers, tmp_path, capsys):
    assert main(["coding", "sample", str(observers[0])]) == 0
    assert "50.0 % of intervals" in capsys.readouterr().out
    assert main(["coding", "count", str(observers[0])]) == 0
    assert "1 times, 30.000 s (50.0 %): child, seated" in capsys.readouterr().out
    assert main(["coding", "ethogram", "--out", str(tmp_path / "e.json")]) == 0
    assert "holds an ethogram" in capsys.readouterr().out
    assert main(["coding", "count", str(observers[0]), "--ethogram", str(tmp_path / "e.json")]) == 1
    assert "nods is not in the ethogram" in capsys.readouterr().err


def test_what_is_counted_is_written(observers, tmp_path, capsys):
    report = tmp_path / "counts.xlsx"
    code, _document = told(capsys, "coding", "count", observers[0], "--out", report)
    assert code == 0
    assert "Behaviour" in load_workbook(report).sheetnames
    assert main(["coding", "count", str(observers[0]), "--out", str(tmp_path / "a.pdf")]) != 0


def test_too_few_intervals_have_a_reason():
    assert "takes 5 intervals" in icc_of("icc-count", np.zeros((4, 2))).reason.text


@pytest.fixture
def recordings(tmp_path, monkeypatch):
    """Recordings of one camera, whose joints arrive without the chain that is tested elsewhere."""
    track = track_of(*still(100, 15.0))
    monkeypatch.setattr(
        "adibas.pipeline.found_joints.pose_recording",
        lambda *_told: SimpleNamespace(tracks=(track,), notices=(), turn=QuarterTurn()),
    )
    paths = [tmp_path / name for name in ("morning.mcap", "noon.mcap", "evening.mcap")]
    for path in paths:
        path.write_bytes(path.name.encode())
    return paths


def test_recordings_that_are_watched_as_one_are_told_by_all_their_names(
    recordings, tmp_path, capsys
):
    report, found = tmp_path / "r.xlsx", tmp_path / "found.csv"
    code, document = told(capsys, "behaviour", *recordings, "--out", report, "--out", found)
    assert code == 0
    assert document["recordings"] == ["morning", "noon", "evening"]
    (coded,) = read_codings(found)
    assert coded.name == document["recording"] == joined_name(document["recordings"])
    book = load_workbook(report)
    summary = dict(book["Summary"].iter_rows(max_col=2, values_only=True))
    assert summary["Recordings"] == "morning, noon, evening"
    book.close()


def test_reports_in_a_folder_are_named_after_what_was_watched_and_none_is_replaced(
    recordings, tmp_path, capsys
):
    folder = tmp_path / "reports"
    folder.mkdir()
    runs = (recordings[:1], recordings[:2], [recordings[0], recordings[2]], recordings[:2])
    written = []
    for some in runs:
        code, document = told(capsys, "behaviour", *some, "--out", folder)
        assert code == 0
        written += document["out"]
    assert sorted(written) == sorted(str(path) for path in folder.iterdir())
    assert len(written) == len(runs)
    assert written[0] == str(folder / "morning-behaviour.xlsx")
    assert all("morning+1-" in path for path in written[1:])
