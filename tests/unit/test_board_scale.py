"""A wrong size of the squares shows in the depth; a right one and a biased sensor do not."""

from dataclasses import replace

import numpy as np
import pytest

from adibas.calibration.board_scale import ScaleParams, check_scale
from adibas.calibration.extrinsics import DepthStart, fit_depth
from adibas.calibration.extrinsics_pose import find_pose
from adibas.calibration.shots import BoardShot
from adibas.data.calibration import DepthBias
from adibas.data.calibration_verdict import Grade
from adibas.pipeline.calibrating_depth_checks import verdict_of
from adibas.pipeline.calibrating_depth_types import DepthCalibratingParams
from tests.unit.depth_shots import BOARD, COLOR, COLOR_FROM_DEPTH, DEPTH, board_view

SMALL_BIAS = DepthBias(0.003, 0.995, 0.002)


def shots(said_share, seed=1, n=8, bias=SMALL_BIAS):
    """Return boards whose squares were said to be `said_share` times as large as they are."""
    rng = np.random.default_rng(seed)
    said = replace(BOARD, square_m=said_share * BOARD.square_m)
    found = []
    for number in range(n):
        corners, cells = board_view(rng, 0.1, 0.0004, bias)
        found.append(BoardShot(f"b{number}", find_pose(corners, said, COLOR), cells))
    return found, said


def test_a_right_size_is_not_blamed_on_a_biased_sensor():
    for seed in range(5):
        found, said = shots(1.0, seed)
        scale = check_scale(found, said, COLOR_FROM_DEPTH)
        low, high = scale.interval
        assert low < 1.0 < high
        assert not scale.is_wrong


@pytest.mark.parametrize("said_share", [0.94, 1.05])
def test_a_wrong_size_is_named_with_the_true_one(said_share):
    found, said = shots(said_share)
    scale = check_scale(found, said, COLOR_FROM_DEPTH)
    low, high = scale.interval
    assert low < 1.0 / said_share < high
    assert scale.is_wrong
    assert "Measure one with a ruler" in scale.sentence.text


def test_a_wrong_size_is_never_good():
    found, said = shots(1.05)
    fit = fit_depth(DepthStart(DEPTH), found, start=COLOR_FROM_DEPTH)
    scale = check_scale(found, said, fit.color_from_depth)
    params = DepthCalibratingParams()
    verdict = verdict_of(fit, fit.covariance, (scale, None, None), params)
    assert verdict.grade is Grade.REPEAT
    assert verdict.findings[0].text == scale.sentence.text
    assert scale.sentence in [finding.sentence for finding in verdict.findings]


def test_few_boards_are_to_be_repeated_and_some_are_usable():
    found, _ = shots(1.0, n=6)
    params = DepthCalibratingParams()
    few = fit_depth(DepthStart(DEPTH), found[:3], start=COLOR_FROM_DEPTH)
    some = fit_depth(DepthStart(DEPTH), found, start=COLOR_FROM_DEPTH)
    for fit, grade in ((few, Grade.REPEAT), (some, Grade.USABLE)):
        verdict = verdict_of(fit, fit.covariance, (None, None, None), params)
        assert verdict.grade is grade
        assert any("boards could be used" in finding.text for finding in verdict.findings)


def test_a_sensor_known_better_tells_the_size_better():
    found, said = shots(1.0)
    wide = check_scale(found, said, COLOR_FROM_DEPTH).interval
    known = ScaleParams(offset_sd_m=1e-4, factor_sd=1e-4, square_sd_per_m=1e-4)
    exact, _ = shots(1.0, bias=DepthBias())
    narrow = check_scale(exact, said, COLOR_FROM_DEPTH, known).interval
    assert np.ptp(narrow) < 0.1 * np.ptp(wide)
    assert narrow[0] == pytest.approx(1.0, abs=2e-3)


def test_without_a_board_there_is_no_size():
    assert check_scale([], BOARD, COLOR_FROM_DEPTH) is None
