"""Tracks of joints and events: what they refuse, and files that keep them."""

import numpy as np
import pytest

from adibas.data.events import TimedEvent
from adibas.data.skeleton_track import SkeletonTrack, track_of
from adibas.errors import RecordingError
from adibas.recordings.events_csv import read_events_csv, write_events_csv
from adibas.recordings.joints_csv import read_joints_csv, recording_name, write_joints_csv


def small_track(n_frames=4, person=1):
    rng = np.random.default_rng(person)
    joints_m = rng.normal(0, 1, (n_frames, 15, 3))
    joints_m[1, 4] = np.nan
    return track_of(np.arange(n_frames) / 30, joints_m, person)


def test_a_track_knows_what_was_seen_and_cuts_by_time():
    track = small_track()
    assert len(track) == 4
    assert not track.seen[1, 4]
    assert track.seen.sum() == 59
    cut = track.between(1 / 30, 2 / 30)
    np.testing.assert_allclose(cut.times_s, [1 / 30, 2 / 30], atol=1e-9)
    assert not track.joints_m.flags.writeable


def test_a_track_refuses_times_that_do_not_increase_and_other_skeletons():
    with pytest.raises(ValueError, match="must increase"):
        track_of(np.array([0.0, 0.0]), np.zeros((2, 15, 3)))
    with pytest.raises(ValueError, match="joints_m must have shape"):
        SkeletonTrack(np.zeros(1, np.int64), np.zeros((1, 20, 3)), np.zeros((1, 15)))


def test_an_event_has_its_times_in_order_and_a_known_kind():
    with pytest.raises(ValueError, match="ends before"):
        TimedEvent("a", "clap", 2.0, 1.0)
    with pytest.raises(ValueError, match="finite"):
        TimedEvent("a", "clap", float("nan"), 1.0)
    with pytest.raises(ValueError, match="kind"):
        TimedEvent("a", "clap", 0.0, 1.0, kind="thing")
    assert TimedEvent("a", "clap", 0.0, 1.0).who == "a"
    assert TimedEvent("a", "clap", 0.0, 1.0, subject="s").who == "s"


def test_overlap_is_intersection_over_union():
    first = TimedEvent("a", "clap", 0.0, 2.0)
    assert first.overlap(TimedEvent("a", "clap", 1.0, 3.0)) == pytest.approx(1 / 3)
    assert first.overlap(TimedEvent("a", "clap", 5.0, 6.0)) == 0.0
    point = TimedEvent("a", "clap", 1.0, 1.0)
    assert point.overlap(point) == 1.0


def test_joints_come_back_from_a_file_as_they_were(tmp_path):
    path = tmp_path / "two people.joints.csv"
    tracks = (small_track(), small_track(6, person=2))
    write_joints_csv(path, tracks)
    again = read_joints_csv(path)
    assert again.notices == ()
    assert recording_name(path) == "two people"
    assert recording_name(tmp_path / "other.csv") == "other"
    for track, found in zip(tracks, again.tracks, strict=True):
        assert found.person == track.person
        np.testing.assert_array_equal(found.timestamps_ns, track.timestamps_ns)
        np.testing.assert_allclose(found.joints_m, track.joints_m, atol=1e-5)
        np.testing.assert_array_equal(found.confidence, track.confidence)


def write_rows(path, times, cell="1.0"):
    lines = ["timestamp_s,head_x_m,head_y_m,head_z_m", *(f"{t},{cell},0,2" for t in times)]
    path.write_text("\n".join(lines) + "\n")


def test_repeated_and_backward_times_are_left_out_and_said(tmp_path):
    path = tmp_path / "a.joints.csv"
    write_rows(path, ["0", "0.1", "0.1", "0.05", "0.2"])
    found = read_joints_csv(path)
    np.testing.assert_allclose(found.tracks[0].times_s, [0, 0.1, 0.2])
    texts = [notice.text for notice in found.notices]
    assert "repeat the time of the frame before are left out: 1." in texts[0]
    assert "go back in time are left out: 1," in texts[1]
    assert "0.050 s" in texts[1]


@pytest.mark.parametrize(
    "rows", [["1,0", "1,0.1", "1,1700000000"], ["1,0", "2,1700000000", "1,0.1", "2,1700000000.1"]]
)
def test_joints_more_than_a_day_after_all_others_are_refused_and_the_times_told(tmp_path, rows):
    path = tmp_path / "a.joints.csv"
    path.write_text("\n".join(["person,timestamp_s,head_x_m", *(f"{row},1" for row in rows)]))
    with pytest.raises(RecordingError) as refused:
        read_joints_csv(path)
    said = str(refused.value)
    assert "a.joints.csv: the frame after the one at 0.1 s is at 1700000000.0 s" in said


def test_a_long_pause_is_no_jump_and_neither_is_one_person_who_comes_late(tmp_path):
    path = tmp_path / "a.joints.csv"
    hours = "\n".join(f"1,{3600 * hour},1" for hour in (0, 20, 40, 60))
    path.write_text(f"person,timestamp_s,head_x_m\n{hours}\n2,{3600 * 60},1\n")
    found = read_joints_csv(path)
    assert [len(track) for track in found.tracks] == [4, 1]
    assert found.notices == ()


def test_joints_without_a_column_were_never_seen(tmp_path):
    path = tmp_path / "a.joints.csv"
    write_rows(path, ["0", "0.1"])
    track = read_joints_csv(path).tracks[0]
    assert track.seen[:, 0].all()
    assert not track.seen[:, 1:].any()


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ("a,b\n1,2\n", "no table of joints"),
        ("timestamp_s,head_x_m\n", "no frames"),
        ("timestamp_s,head_x_m\n1,2\n2,x\n", "line 3"),
        ("timestamp_s,head_x_m\n1,2\n2\n", "line 3"),
        ("timestamp_s,head_x_m\n\n1,2\n\n2,x\n", "line 5"),
        ("timestamp_s,head_x_m\n,2\n", "without a time"),
        ("timestamp_s,head_x_m\n1,inf\n", "infinite"),
        ("timestamp_s,head_x_m\n1700000000000,1\n", "is in seconds, not in milliseconds"),
        ("", "no table of joints"),
    ],
)
def test_a_broken_table_of_joints_is_refused_in_words(tmp_path, content, words):
    path = tmp_path / "bad.csv"
    path.write_text(content)
    with pytest.raises(RecordingError, match=words):
        read_joints_csv(path)


def test_files_that_are_not_there_are_named(tmp_path):
    with pytest.raises(RecordingError, match=r"gone\.csv cannot be read"):
        read_joints_csv(tmp_path / "gone.csv")
    with pytest.raises(RecordingError, match=r"gone\.csv cannot be read"):
        read_events_csv(tmp_path / "gone.csv")


def test_half_a_character_becomes_a_box_in_a_table_of_events(tmp_path):
    write_events_csv(tmp_path / "e.csv", [TimedEvent("r\udce9", "l\ud800", 1.0, 2.0, "s\udfff")])
    (read,) = read_events_csv(tmp_path / "e.csv")
    assert (read.recording, read.label, read.subject) == ("r\u25a1", "l\u25a1", "s\u25a1")


def test_events_come_back_from_a_file_as_they_were(tmp_path):
    events = (
        TimedEvent("walk", "clap", 0.5, 1.25, "s01", 2, "state", 0.75),
        TimedEvent("walk, again", "jump", 3.0, 3.0, kind="point"),
        TimedEvent("walk", "a\rb", 4.0, 5.0, "s\r1"),
    )
    path = tmp_path / "events.csv"
    write_events_csv(path, events)
    assert read_events_csv(path) == events


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ("recording,label\n", "no table of events"),
        ("recording,label,begin_s,end_s\na,clap,2,1\n", "line 2"),
        ("recording,label,begin_s,end_s\na,,1,2\n", "line 2"),
        ("recording,label,begin_s,end_s\na,clap,x,2\n", "line 2"),
    ],
)
def test_a_broken_table_of_events_is_refused_in_words(tmp_path, content, words):
    path = tmp_path / "events.csv"
    path.write_text(content)
    with pytest.raises(RecordingError, match=words):
        read_events_csv(path)


UP = np.array([0.6, -0.8, 0.0])


def test_the_vertical_and_the_origin_of_a_table_come_back(tmp_path):
    path = tmp_path / "a.joints.csv"
    track = track_of(np.arange(3) / 30, np.ones((3, 15, 3)))
    write_joints_csv(path, [track], "markerless", UP)
    found = read_joints_csv(path)
    np.testing.assert_allclose(found.up, UP, atol=1e-6)
    assert found.origin == "markerless"
    assert path.read_text().splitlines()[0].endswith("up_x,up_y,up_z,origin")
    write_joints_csv(path, [track], "markerless")
    assert read_joints_csv(path).up is None


@pytest.mark.parametrize(
    ("first", "second"),
    [
        ("0,-1,0", "0,0,-1"),  # a camera that was turned
        ("0,-1,0", ",,"),
        ("0,-2,0", "0,-2,0"),
        ("0,0,0", "0,0,0"),
        ("0,-1,inf", "0,-1,inf"),
    ],
)
def test_a_vertical_that_rows_do_not_agree_on_is_not_known(tmp_path, first, second):
    path = tmp_path / "a.joints.csv"
    rows = "\n".join(["timestamp_s,head_x_m,up_x,up_y,up_z", f"0,1,{first}", f"1,1,{second}"])
    path.write_text(rows)
    assert read_joints_csv(path).up is None


def test_a_vertical_that_is_no_number_is_refused_with_its_line(tmp_path):
    path = tmp_path / "a.joints.csv"
    path.write_text("timestamp_s,head_x_m,up_x,up_y,up_z\n0,1,0,-1,0\n1,1,0,down,0\n")
    with pytest.raises(RecordingError, match="line 3"):
        read_joints_csv(path)
