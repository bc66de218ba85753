"""What fails in the world about the program, a few of each.

`adibas benchmark reliability` does all.

Disks that fill up and shares that vanish are mounted in a namespace of their own, which needs no
rights but user namespaces.
"""

import json
import shutil
from contextlib import suppress
from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

from adibas.data.frames import SourceInfo
from adibas.errors import AdibasError
from adibas.recordings import RecordingOptions, create_recording, open_recording
from benchmarks import reliability_clock, reliability_hours
from benchmarks.hours_picture import draw_hours
from benchmarks.long_run import Run
from benchmarks.own_disk import can_mount, on_own_disks
from benchmarks.reliability_hours import Sample
from benchmarks.store_work import Notes, make_store, problems_in, work
from benchmarks.two_programs import one_round
from tests.unit.recorded_frames import assert_same_frame, make_frames

needs_mounts = pytest.mark.skipif(
    not can_mount(), reason="user namespaces are not allowed here, so that no disk can be mounted"
)
needs_bindfs = pytest.mark.skipif(
    shutil.which("bindfs") is None, reason="bindfs is not installed, so that no share can vanish"
)


@needs_mounts
@pytest.mark.parametrize("n_pages", [0, 60])
def test_on_a_full_disk_all_is_whole_or_refused_in_a_sentence(tmp_path, n_pages):
    with on_own_disks("benchmarks.full_disk_child", str(tmp_path), str(n_pages), "1") as lines:
        (told,) = map(json.loads, lines)
    assert told["problems"] == []
    assert any("disk is full" in sentence for sentence in told["told"])


@needs_mounts
def test_a_disk_with_room_refuses_nothing(tmp_path):
    with on_own_disks("benchmarks.full_disk_child", str(tmp_path), "1000", "1") as lines:
        (told,) = map(json.loads, lines)
    assert told == {"n_pages": 1000, "told": [], "problems": []}


@needs_mounts
@needs_bindfs
def test_a_share_that_vanishes_is_told_and_takes_nothing_that_was_saved(tmp_path):
    with on_own_disks("benchmarks.share_child", str(tmp_path), "0", "3") as lines:
        told = list(map(json.loads, lines))
    assert [one["problems"] for one in told] == [[], [], []]
    assert all(one["told"].endswith(".") and one["seconds"] < 10 for one in told)


@pytest.mark.parametrize("seed", [1, 2])
def test_a_clock_that_jumps_back_and_ahead_confuses_nothing(seed):
    n_back, problems = reliability_clock.trial(seed)
    assert problems == []
    assert n_back > 3


def test_a_sensor_clock_that_jumps_back_loses_no_frame(tmp_path):
    frames = make_frames(6)
    set_back = [
        replace(frame, timestamp_ns=frame.timestamp_ns - (i > 2) * 3600 * 10**9)
        for i, frame in enumerate(frames)
    ]
    for name in ("a.mcap", "a.oni", "a"):
        with suppress(AdibasError):  # a format may refuse such times, but then in a sentence
            with create_recording(tmp_path / name, SourceInfo(), RecordingOptions()) as writer:
                for frame in set_back:
                    writer.write(frame)
            with open_recording(tmp_path / name) as reader:
                assert len(reader) == len(set_back)
                for got, want in zip(reader, set_back, strict=True):
                    assert_same_frame(got, want)


def test_of_two_programs_on_one_store_one_writes_and_the_other_takes_over(tmp_path):
    store = tmp_path / "store"
    acknowledged = make_store(store)
    for seed in range(2):
        told = one_round(store, seed, acknowledged)
        assert told.problems == []
        assert told.n_saved > 0


def test_a_trial_sees_what_is_missing(tmp_path):
    notes = Notes()
    assert work(tmp_path / "store", 1, notes) is None
    assert problems_in(tmp_path / "store", notes.acknowledged) == []
    notes.send_bytes(b'["session", "5e55"]')
    assert len(problems_in(tmp_path / "store", notes.acknowledged)) == 1


def sample(elapsed_s, memory_mb, n_frames):
    return Sample(elapsed_s, memory_mb, n_frames, n_frames, -0.01, 7, 5)


def test_hours_of_the_simulator_tell_growth_and_missing_frames(tmp_path, monkeypatch):
    samples = [(sample(900.0 * k, 500 + 5.0 * k, 27_000 * k), k) for k in range(1, 33)]
    monkeypatch.setattr(reliability_hours, "_samples", lambda _seconds: iter(samples))
    run = Run(is_quick=False, amount=8.0, progress=lambda _n, _all: None, folder=tmp_path)
    told = {row.name: row for row in reliability_hours.rows(run)}
    assert told["hours of 8"].ours == 8.0
    assert told["its growth, line through the settled part"].ours == pytest.approx(20.0)
    frames = next(row for name, row in told.items() if name.startswith("frames that came"))
    assert (frames.ours, frames.reference) == (27_000 * 32, 864_001)
    with Image.open(tmp_path / "hours.png") as picture:
        assert np.asarray(picture.convert("L")).std() > 5
    assert len((tmp_path / "hours.jsonl").read_text().splitlines()) == 32


def test_seconds_of_the_live_view_come_at_thirty_frames_a_second(tmp_path):
    run = Run(is_quick=True, amount=None, progress=lambda _n, _all: None, folder=tmp_path)
    told = {row.name: row.ours for row in reliability_hours.rows(run)}
    assert told["looked at, the newest each time"] > 10
    assert told[f"bursts of {reliability_hours.BURST_FRAMES} frames written meanwhile"] == 1


def test_an_interrupted_benchmark_goes_on_where_it_was(tmp_path):
    run = Run(is_quick=False, amount=25.0, progress=lambda _n, _all: None, folder=tmp_path)
    done = run.kept("kills", {"n_kills": 0, "problems": []})
    done["n_kills"] += 40
    done.keep()
    assert run.kept("kills", {"n_kills": 0, "saved": 0}) == {
        "n_kills": 40,
        "problems": [],
        "saved": 0,
    }
    assert replace(run, is_quick=True).kept("kills", {"n_kills": 0}) == {"n_kills": 0}
    assert [one.name for one in tmp_path.iterdir()] == ["kills.json"]
    assert [run.n_to_do(100, done, 3) for done in (40, 90, 100)] == [25, 10, 0]
    assert replace(run, amount=None).n_to_do(100, 40, 3) == 60
    assert replace(run, is_quick=True).n_to_do(100, 40, 3) == 3


def test_a_picture_is_drawn_of_any_number_of_samples(tmp_path):
    draw_hours(tmp_path / "one.png", [sample(5.0, 400.0, 150)])
    assert (tmp_path / "one.png").stat().st_size > 1000
