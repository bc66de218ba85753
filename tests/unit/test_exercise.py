"""Exercises beside the therapist's: repetitions that were planted, with known range and tempo."""

import dataclasses
import json

import numpy as np
import pytest
from openpyxl import load_workbook

from adibas.cli.command_line import main
from adibas.data.skeleton_track import track_of
from adibas.errors import GestureError
from adibas.geometry.quarter_turns import QuarterTurn
from adibas.gestures.exercise import (
    AngleTrack,
    ExerciseParams,
    exercise_model,
    repetitions,
)
from adibas.recordings.joints_csv import read_joints_csv, write_joints_csv
from tests.unit.test_joint_angles import RIGHT, standing, turned

RATE_HZ = 15.0
NAMES = ("left_elbow_flexion", "right_elbow_flexion", "trunk_flexion")


def once(n_frames, left=120.0, right=120.0, held=0):
    """Return one repetition (n + held, 3): out along a cosine, held, and back."""
    out = (1 - np.cos(np.linspace(0, np.pi, n_frames // 2))) / 2
    share = np.concatenate([out, np.ones(held), out[::-1]])
    return np.column_stack([left * share, right * share, np.zeros(len(share))])


def series(*parts, rest=20, noise=0.0, seed=0):
    pieces = [np.zeros((rest, 3))]
    for part in parts:
        pieces += [part, np.zeros((rest, 3))]
    deg = np.concatenate(pieces)
    return AngleTrack(
        0.0, RATE_HZ, NAMES, deg + np.random.default_rng(seed).normal(0, noise, deg.shape)
    )


THERAPIST = exercise_model(series(once(40, held=10)))


def test_the_model_is_the_movement_alone():
    assert THERAPIST.angles.names == NAMES[:2]
    assert THERAPIST.duration_s == pytest.approx(50 / RATE_HZ, abs=0.6)
    assert THERAPIST.angles.begin_s == pytest.approx(20 / RATE_HZ, abs=0.4)
    first, last = THERAPIST.hold
    assert last - first >= 10


@pytest.mark.parametrize("noise", [0.0, 3.0])
def test_repetitions_are_counted_and_timed(noise):
    done = series(once(40, held=10), once(24, held=4), once(80, held=20), noise=noise)
    found = repetitions(THERAPIST, done)
    assert len(found) == 3
    tempos = [one.duration_s / THERAPIST.duration_s for one in found]
    assert tempos == pytest.approx([1.0, 28 / 50, 2.0], abs=0.25)
    assert all(one.cost < 0.2 for one in found)
    assert found[0].begin_s == pytest.approx(20 / RATE_HZ, abs=0.5)
    held = [one.phases_s[1] * RATE_HZ for one in found]
    assert held == pytest.approx([18, 9, 36], abs=5)
    assert all(sum(one.phases_s) == pytest.approx(one.duration_s) for one in found)


def test_a_smaller_range_is_a_repetition_and_told():
    (found,) = repetitions(THERAPIST, series(once(40, 60.0, 120.0, held=10)))
    assert found.range_deg == pytest.approx([60.0, 120.0], abs=1.0)
    # Half of the left one is missing where it is greatest.
    assert np.nanmin(found.deviation_deg[:, 0]) == pytest.approx(-60.0, abs=2.0)
    assert np.nanmax(np.abs(found.deviation_deg[:, 1])) < 12.0
    assert 0.1 < found.cost < 0.5


def test_who_stands_still_has_no_repetition():
    assert repetitions(THERAPIST, series(noise=5.0, rest=300)) == ()
    assert repetitions(THERAPIST, series(once(40, 20.0, 20.0))) == ()


def test_gaps_are_bridged_and_hidden_angles_told():
    done = series(once(40, held=10))
    deg = done.deg.copy()
    deg[30:34] = np.nan
    (found,) = repetitions(THERAPIST, dataclasses.replace(done, deg=deg))
    assert found.range_deg[0] == pytest.approx(120.0, abs=1.0)
    deg[:, 0] = np.nan
    with pytest.raises(GestureError, match="left elbow flexion"):
        repetitions(THERAPIST, dataclasses.replace(done, deg=deg))


def test_a_therapist_who_does_not_move_is_told():
    with pytest.raises(GestureError, match="moves no joint by 15"):
        exercise_model(series(once(40, 5.0, 5.0)))
    short = AngleTrack(0.0, RATE_HZ, NAMES, np.array([[0.0, 0, 0], [90.0, 0, 0]]))
    with pytest.raises(GestureError, match="too short"):
        exercise_model(short)
    with pytest.raises(ValueError, match="above zero"):
        ExerciseParams(rate_hz=0.0)
    with pytest.raises(ValueError, match="edge_share"):
        ExerciseParams(edge_share=0.95)


def joints_file(path, deg, origin="unknown"):
    joints_m = np.stack(
        [
            turned(turned(standing(), ["left_hand"], "left_elbow", RIGHT, left),
                   ["right_hand"], "right_elbow", RIGHT, right)
            for left, right, _ in deg
        ]
    )  # fmt: skip
    write_joints_csv(path, [track_of(3.0 + np.arange(len(deg)) / 30.0, joints_m)], origin)


@pytest.fixture
def files(tmp_path):
    joints_file(tmp_path / "therapist.csv", series(once(60, held=20)).deg, "markers")
    done = series(once(60, 110.0, 80.0, held=20), once(90, 70.0, 70.0, held=10), rest=40)
    joints_file(tmp_path / "patient.csv", done.deg, "markerless")
    return tmp_path


def test_an_exercise_is_checked_from_the_command_line(files, capsys):
    report = files / "r.xlsx"
    arguments = ["gestures", "check", files / "patient.csv", "--therapist", files / "therapist.csv"]
    assert main([*map(str, arguments), "--out", str(report), "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert set(document["angles"]) == set(NAMES[:2])
    first, second = document["repetitions"]
    shares = {row["angle"]: row["share"] for row in first["ranges"]}
    assert shares["left_elbow_flexion"] == pytest.approx(110 / 120, abs=0.03)
    assert shares["right_elbow_flexion"] == pytest.approx(80 / 120, abs=0.03)
    assert first["symmetry"][0]["index_percent"] == pytest.approx(-100 * 30 / 95, abs=2)
    assert second["symmetry"][0]["index_percent"] == pytest.approx(0.0, abs=2)
    assert second["tempo"] > first["tempo"]
    book = load_workbook(report)
    assert book.sheetnames == ["Summary", "Repetitions", "Ranges", "Symmetry", "Deviation"]
    assert len(list(book["Repetitions"].iter_rows(min_row=2))) == 3
    facts = {row[0]: row[1] for row in book["Summary"].iter_rows(values_only=True)}
    assert (document["origin"], document["therapist"]["origin"]) == ("markerless", "markers")
    assert facts["Joints from"].startswith("markerless:")
    assert facts["Joints of the therapist from"].startswith("markers on the skin:")
    book.close()


def test_an_exercise_before_a_camera_on_its_side_is_the_same_where_its_rotation_is_told(
    files, tmp_path, capsys
):
    def checked(folder, *options):
        patient, therapist = (str(folder / f"{who}.csv") for who in ("patient", "therapist"))
        argv = ["gestures", "check", patient, "--therapist", therapist, "--json", *options]
        assert main(argv) == 0
        document = json.loads(capsys.readouterr().out)
        return document["angles"], document["repetitions"]

    lying = tmp_path / "lying"
    lying.mkdir()
    rng = np.random.default_rng(1)
    for who in ("patient", "therapist"):
        (track,) = read_joints_csv(files / f"{who}.csv").tracks
        noisy_m = track.joints_m + rng.normal(0.0, 0.002, track.joints_m.shape)
        write_joints_csv(files / f"{who}.csv", [track_of(track.times_s, noisy_m)])
        turned_m = QuarterTurn(1).points(noisy_m)
        write_joints_csv(lying / f"{who}.csv", [track_of(track.times_s, turned_m)])
    angles, done = checked(files)
    assert set(angles) == set(NAMES[:2])
    angles_lying, done_lying = checked(lying, "--rotation", "270")
    assert angles_lying == angles
    for one, other in zip(done_lying, done, strict=True):
        assert one["tempo"] == pytest.approx(other["tempo"], abs=0.02)


def test_readers_get_lines_and_mistakes_are_told(files, capsys):
    arguments = [
        "gestures",
        "check",
        str(files / "patient.csv"),
        "--therapist",
        str(files / "therapist.csv"),
    ]
    assert main(arguments) == 0
    assert "2 repetitions found" in capsys.readouterr().out
    assert main([*arguments, "--repetition", "0:60"]) == 1
    assert "ends at" in capsys.readouterr().err
    assert main([*arguments, "--out", str(files / "r.doc")]) == 1
    assert "ends in one of: .xlsx" in capsys.readouterr().err
    joints_file(files / "still.csv", np.zeros((200, 3)))
    arguments[2] = str(files / "still.csv")
    assert main(arguments) == 0
    assert "No repetition was found" in capsys.readouterr().err
