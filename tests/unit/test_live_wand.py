"""A wand before the live sensor: its ends are found, compared, kept; nothing goes to the disk."""

from dataclasses import replace
from datetime import UTC, datetime, timedelta

import numpy as np
import pytest

from adibas.calibration.wand import WandResult
from adibas.errors import CalibrationError, MarkerError
from adibas.markers.color_model import LearningParams, grow_region, learn_colors
from adibas.markers.lab import rgb_to_lab
from adibas.pipeline.live import LiveView
from adibas.pipeline.wand_check import (
    compare_ends,
    is_fresh,
    see_wand,
    wand_from_document,
    wand_to_document,
)
from adibas.simulation.patient import MarkerSettings
from adibas.simulation.scenes import open_scene
from adibas.texts import speaking
from tests.unit.live_rig import DrivenCamera, Sources, Told, numbered

N_FRAMES = 3
NOW = datetime(2026, 5, 4, 9, 30, tzinfo=UTC)


@pytest.fixture(scope="module")
def scene():
    markers = MarkerSettings(("left_asis", "right_asis"), diameter_m=0.015)
    return open_scene("anterior", seed=7, markers=markers)


@pytest.fixture(scope="module")
def frames(scene):
    return [scene.frame(index) for index in range(2)]


@pytest.fixture(scope="module")
def target(frames):
    lab = rgb_to_lab(frames[0].sensor_frame.color)
    markers = frames[0].truth.markers
    taken = sum(grow_region(lab, (one.u, one.v), 20.0) for one in markers) > 0
    return learn_colors(lab[taken].astype(float), np.random.default_rng(0), LearningParams(), {})


def given(frames):
    return numbered([frames[i % 2].sensor_frame for i in range(12)], 0)


@pytest.fixture
def live(frames, scene):
    camera, told = DrivenCamera(given(frames), is_live=False, info=scene.info), Told()
    view = LiveView(told, opener=Sources(camera))
    view.open("any")
    told.wait_for(lambda: told.frames)
    yield view, camera
    camera.push(*[None] * 3)
    view.close()


def seen_by(live, frames, target):
    view, camera = live
    steps = []

    def progress(*numbers):
        steps.append(numbers)
        camera.push(*numbered([frames[i % 2].sensor_frame for i in range(2)], 20 + 2 * len(steps)))

    return see_wand(view, target, progress, N_FRAMES), steps


def test_a_live_wand_has_its_length(live, frames, target):
    seen, steps = seen_by(live, frames, target)
    assert len(seen.markers) == 2
    assert seen.picture_rgb.shape == (1024, 1280, 3)
    assert steps[-1] == (2 * N_FRAMES, 2 * N_FRAMES)
    ends_m = [marker.position_m for marker in frames[0].truth.markers]
    length_m = float(np.linalg.norm(ends_m[0] - ends_m[1]))
    check = compare_ends(*seen.markers, length_m)
    assert check.measured_m == pytest.approx(length_m, abs=0.006)
    assert check.result is not WandResult.FAILED
    assert compare_ends(*seen.markers, length_m + 0.04).result is WandResult.FAILED


def test_without_two_markers_it_is_said_how_to_hold_the_wand(live, frames):
    blue = learn_colors(
        np.tile([[50.0, 40.0, -70.0]], (50, 1)),
        np.random.default_rng(0),
        LearningParams(),
        {},
    )
    with pytest.raises(MarkerError, match="in colour and depth: 0, and a wand"):
        seen_by(live, frames, blue)


def test_a_source_without_calibration_measures_no_wand(frames, target, scene):
    info = replace(scene.info, calibration=None)
    camera, told = DrivenCamera(given(frames), is_live=False, info=info), Told()
    view = LiveView(told, opener=Sources(camera))
    view.open("any")
    told.wait_for(lambda: told.frames)
    try:
        with pytest.raises(CalibrationError, match="no calibration"):
            see_wand(view, target, lambda *_: None, N_FRAMES)
    finally:
        camera.push(*[None] * 3)
        view.close()


def test_a_check_that_was_kept_says_the_same(live, frames, target):
    seen, _ = seen_by(live, frames, target)
    check = compare_ends(*seen.markers, 0.25)
    document = wand_to_document(check, NOW)
    again, checked_utc = wand_from_document(document)
    assert (again, checked_utc) == (check, NOW)
    with speaking("en"):
        assert again.sentence.text == check.sentence.text
    assert document["result"] == check.result.value


def test_a_check_serves_a_day():
    document = {
        "format": "adibas-wand",
        "checked_utc": NOW.isoformat(),
        "length_m": 0.5,
        "measured_m": 0.501,
        "interval_m": [0.499, 0.503],
        "tolerance_m": 0.005,
        "result": "passed",
    }
    assert is_fresh(document, NOW + timedelta(hours=9))
    assert not is_fresh(document, NOW + timedelta(hours=13))
    assert not is_fresh(document, NOW - timedelta(minutes=1))
    with pytest.raises(ValueError, match="interval_m"):
        wand_from_document(document | {"interval_m": 3})
