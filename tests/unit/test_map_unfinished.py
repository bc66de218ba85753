"""A map that was interrupted goes on where it stood, and comes to the same files."""

import contextlib
import os
import signal
import subprocess
import sys

import pytest

from adibas.cli.command_line import main
from adibas.pipeline.map_state import FOREIGN, FileKeeper, MapMemory, Unfinished, unfinished_path
from adibas.pipeline.mapping import MapRequest, map_recording
from tests.unit.room_recordings import room_frames, written

YAWS_DEG = (0.0, 2.5, 5.0, 7.5, 10.0, 12.5, 11.0, 8.0)
"""So slow that the step before tells where the next frame lies."""
KILLED_AT = 5
VICTIM = f"""
import os, signal, sys
from pathlib import Path
from adibas.pipeline import map_state
from adibas.pipeline.mapping import MapRequest, map_recording

map_state.EVERY_S = 0.0

def progress(done, _total):
    if done == {KILLED_AT}:
        os.kill(os.getpid(), signal.SIGKILL)

map_recording(MapRequest(Path(sys.argv[1]), out=Path(sys.argv[2])), progress)
"""


class StoppedError(Exception):
    """Somebody stopped the work."""


@pytest.fixture(scope="module")
def taken(tmp_path_factory):
    return written(tmp_path_factory.mktemp("map") / "room.mcap", room_frames(yaws_deg=YAWS_DEG)[0])


@pytest.fixture(scope="module")
def whole(taken, tmp_path_factory):
    return mapped(taken, tmp_path_factory.mktemp("whole"))


def mapped(taken, folder):
    """Run the command and return the bytes of both files."""
    out, trajectory = folder / "map.ply", folder / "trajectory.txt"
    assert main(["map", str(taken), "--out", str(out), "--trajectory", str(trajectory)]) == 0
    assert not unfinished_path(out).exists()
    return out.read_bytes(), trajectory.read_bytes()


def stopped(taken, out, at=KILLED_AT):
    """Map until so many frames are done, as by a click on Stop."""

    def progress(done, _total):
        if done == at:
            raise StoppedError

    with pytest.raises(StoppedError):
        map_recording(MapRequest(taken, out=out), progress)


@pytest.mark.skipif(os.name == "nt", reason="there is no SIGKILL")
def test_after_kill_9_the_same_command_goes_on_to_the_same_files(taken, whole, tmp_path, capsys):
    out = tmp_path / "map.ply"
    victim = [sys.executable, "-c", VICTIM, str(taken), str(out)]
    assert subprocess.run(victim, check=False).returncode == -signal.SIGKILL
    assert unfinished_path(out).exists()
    assert not out.exists()
    assert mapped(taken, tmp_path) == whole
    assert f"interrupted after {KILLED_AT} of {len(YAWS_DEG)} frames" in capsys.readouterr().err


def test_ctrl_c_says_where_the_map_is_kept(taken, tmp_path, monkeypatch, capsys):
    def bar(_console, _text):
        return contextlib.nullcontext(press)

    def press(done, _total):
        if done == KILLED_AT:
            raise KeyboardInterrupt

    monkeypatch.setattr("adibas.cli.console.Console.progress", bar)
    out = tmp_path / "map.ply"
    assert main(["map", str(taken), "--out", str(out)]) == 1
    assert "lies in map.ply.unfinished; the same command" in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["map.ply.unfinished"]


@pytest.mark.parametrize("at", [1, 4, len(YAWS_DEG), len(YAWS_DEG) + 3])
def test_a_map_that_was_stopped_anywhere_goes_on_to_the_same_files(taken, whole, tmp_path, at):
    out = tmp_path / "map.ply"
    stopped(taken, out, at)
    assert unfinished_path(out).exists()
    assert mapped(taken, tmp_path) == whole


def test_frames_that_were_looked_at_are_not_looked_at_again(taken, tmp_path):
    out, seen = tmp_path / "map.ply", []
    stopped(taken, out)
    map_recording(MapRequest(taken, out=out), lambda done, _total: seen.append(done))
    assert min(seen) == KILLED_AT + 1


@pytest.mark.parametrize("at", [1, KILLED_AT, len(YAWS_DEG) + 3])
def test_a_map_that_is_held_in_memory_goes_on_to_the_same_surface(taken, at):
    memory, seen = MapMemory(), []
    whole = map_recording(MapRequest(taken), lambda _done, _total: None)

    def progress(done, _total):
        if done == at:
            raise StoppedError

    before = {path.name for path in taken.parent.iterdir()}
    with pytest.raises(StoppedError):
        map_recording(MapRequest(taken, memory=memory), progress)
    for _time in range(2):  # what it goes on from stays as it was
        again = map_recording(
            MapRequest(taken, memory=memory), lambda done, _total: seen.append(done)
        )
        assert (again.surface.points_m == whole.surface.points_m).all()
        assert (again.world_from_camera[-1].translation_m
                == whole.world_from_camera[-1].translation_m).all()  # fmt: skip
    assert min(seen) == min(at, len(YAWS_DEG)) + 1
    assert {path.name for path in taken.parent.iterdir()} == before
    other = map_recording(
        MapRequest(taken, frames=(0, 4), memory=memory), lambda _done, _total: None
    )
    assert FOREIGN in [one.message for one in other.notices]


@pytest.mark.parametrize("spoil", ["cut", "changed", "text", "empty"])
def test_a_damaged_state_is_told_and_not_used(taken, whole, tmp_path, capsys, spoil):
    out = tmp_path / "map.ply"
    stopped(taken, out)
    state = unfinished_path(out)
    kept = state.read_bytes()
    middle = len(kept) // 2
    state.write_bytes(
        {
            "cut": kept[:middle],
            "changed": kept[:middle] + bytes([kept[middle] ^ 255]) + kept[middle + 1 :],
            "text": b"no archive",
            "empty": b"",
        }[spoil]
    )
    assert mapped(taken, tmp_path) == whole
    assert "is damaged and was not used" in capsys.readouterr().err


def test_the_state_of_another_recording_or_other_settings_is_told_and_not_used(
    taken, whole, tmp_path, capsys
):
    other = written(tmp_path / "other.mcap", room_frames()[0][:-1])
    stopped(other, tmp_path / "map.ply")
    assert mapped(taken, tmp_path) == whole
    assert "of another recording or other settings" in capsys.readouterr().err
    stopped(taken, tmp_path / "map.ply")
    arguments = ["map", str(taken), "--out", str(tmp_path / "map.ply"), "--frames", "0:6"]
    assert main(arguments) == 0
    assert "of another recording or other settings" in capsys.readouterr().err


def test_the_state_is_kept_at_times_and_not_at_every_frame(tmp_path):
    now_s = [0.0]
    keeper = FileKeeper(tmp_path / "map.ply.unfinished", {}, clock=lambda: now_s[0])
    made = []
    for now_s[0] in (1.0, 4.0, 6.0, 7.0, 10.0, 11.5):
        keeper.keep_at_times(lambda: made.append(now_s[0]) or Unfinished())
    assert made == [6.0, 11.5]


def test_where_nothing_fits_nothing_is_left_behind(taken, tmp_path):
    out = tmp_path / "map.ply"
    assert main(["map", str(taken), "--out", str(out), "--frames", "0:1"]) == 1
    assert not list(tmp_path.glob("*unfinished*"))
