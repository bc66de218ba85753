"""How long a disk lasts."""

import math
import shutil
from types import SimpleNamespace

import pytest

from adibas.errors import FileError
from adibas.pipeline.disk_forecast import (
    RESERVED_BYTES,
    expected_bytes_per_s,
    free_bytes,
    minutes_left,
)
from adibas.recordings import create_recording
from adibas.simulation.scenes import open_scene


def test_minutes_are_what_is_free_over_what_comes():
    assert minutes_left(RESERVED_BYTES + 600_000_000, 1_000_000) == pytest.approx(10.0)


@pytest.mark.parametrize("free", [0, 1, RESERVED_BYTES])
def test_the_last_part_of_the_disk_is_left_alone(free):
    assert minutes_left(free, 1e6) == 0.0


def test_a_disk_lasts_for_ever_where_nothing_comes():
    assert minutes_left(10**12, 0.0) == math.inf


def test_a_recording_is_hardly_larger_than_expected(tmp_path):
    scene = open_scene("posterior", seed=3, color_size=(480, 640))
    with create_recording(tmp_path / "a.mcap", scene.info) as writer:
        for index in range(3):
            writer.write(scene.frame(index).sensor_frame)
    measured = (tmp_path / "a.mcap").stat().st_size / 3
    expected = expected_bytes_per_s((640, 480), (640, 480), 1.0)
    assert 0.6 * expected < measured < 1.1 * expected


def test_a_folder_that_is_not_made_yet_lies_on_the_disk_of_its_parent(tmp_path):
    free = free_bytes(tmp_path / "not" / "yet")
    assert 0 < free <= shutil.disk_usage(tmp_path).total


def test_a_disk_that_does_not_answer_is_told(tmp_path, monkeypatch):
    def fail(_):
        raise OSError(5, "Input/output error")

    monkeypatch.setattr("adibas.pipeline.disk_forecast.shutil", SimpleNamespace(disk_usage=fail))
    with pytest.raises(FileError, match="Input/output error"):
        free_bytes(tmp_path)
