"""Coverage, tilts, the table of the board and its Q, and what the verdict says of mistakes."""

from dataclasses import replace

import numpy as np
import pytest

from adibas.calibration.camera_fitting import FittingParams, fit_camera
from adibas.calibration.finder import BoardProblem, BoardSearch
from adibas.calibration.lens_models import BROWN_4
from adibas.calibration.quality import (
    board_errors,
    computed_on_board,
    map_residuals,
    mean_board_error_m,
    tilt_directions_rad,
    tilts_rad,
)
from adibas.calibration.sharpness import blur_px
from adibas.calibration.verdict import Evidence, ScaleCheck, judge
from adibas.data.board import BoardCorners
from adibas.data.calibration_verdict import SENTENCES, Finding, Grade, Reason, Verdict
from adibas.geometry.rigid import RigidTransform, rotation_from_vector
from tests.unit.calibration_views import BOARD, as_corners, drawn_pixels, drawn_poses

PARAMS = FittingParams(model=BROWN_4)


@pytest.fixture(scope="module")
def corners():
    return as_corners(drawn_pixels(np.random.default_rng(1), 16))


@pytest.fixture(scope="module")
def fit(corners):
    return fit_camera(BOARD, corners, PARAMS)


def evidence(corners, fit, **changes):
    searches = [BoardSearch(one) for one in corners]
    return replace(Evidence(BOARD, searches, fit, [1.0] * len(searches)), **changes)


def reasons(verdict):
    return [finding.reason for finding in verdict.findings]


def test_every_corner_is_in_one_cell(fit):
    found = map_residuals(fit)
    assert found.counts.sum() == sum(view.is_used.sum() for view in fit.used_views)
    assert found.covered_share == (found.counts > 0).mean()
    total = np.nansum(found.rms_px**2 * found.counts)
    assert np.sqrt(total / found.counts.sum()) == pytest.approx(fit.rms_px)
    assert np.isnan(found.rms_px[found.counts == 0]).all()


def test_tilts_are_those_of_the_boards():
    poses = drawn_poses(np.random.default_rng(1), 16)
    fit = fit_camera(BOARD, as_corners(drawn_pixels(np.random.default_rng(1), 16)), PARAMS)
    normals = np.array([rotation_from_vector(vector)[:, 2] for vector, _ in poses])
    np.testing.assert_allclose(tilts_rad(fit), np.arccos(normals[:, 2]), atol=0.02)
    is_tilted = tilts_rad(fit) > 0.2
    expected = np.arctan2(normals[:, 1], normals[:, 0])[is_tilted]
    turn = np.angle(np.exp(1j * (tilt_directions_rad(fit)[is_tilted] - expected)))
    assert np.abs(turn).max() < 0.1


def test_exact_pixels_meet_the_board_at_its_corners(fit):
    pose = RigidTransform(rotation_from_vector(np.array([0.3, -0.4, 0.1])), np.array([0, 0, 0.6]))
    from adibas.geometry.distortion import project_distorted

    camera = fit.camera
    pixels = project_distorted(pose.apply(BOARD.points_m()), camera.intrinsics, camera.distortion)
    np.testing.assert_allclose(
        computed_on_board(pixels, camera, pose), BOARD.points_m()[:, :2], atol=1e-12
    )


def test_q_is_the_mean_error_of_corners_that_had_no_part_in_the_pose(fit):
    errors = board_errors(fit)
    assert len(errors) == 16
    first = errors[0]
    assert len(first.rows) == BOARD.n_corners // 2
    assert first.q_m == pytest.approx(np.mean([np.hypot(*row.error_m) for row in first.rows]))
    # 0.1 px at 0.5 m and 1050 px: 0.06 mm as a mean length.
    assert 2e-5 < mean_board_error_m(errors) < 2e-4
    judged = {(round(row.x_m / 0.025), round(row.y_m / 0.025)) for row in first.rows}
    assert all((column + row) % 2 == 1 for column, row in judged)
    assert np.isnan(mean_board_error_m([]))


def test_a_careful_set_is_good(corners, fit):
    verdict = judge(evidence(corners, fit))
    assert verdict.grade is Grade.GOOD
    assert verdict.sentences() == ("Good: the calibration can be used for measuring.",)


def test_three_boards_are_too_few(corners):
    verdict = judge(evidence(corners[:3], fit_camera(BOARD, corners[:3])))
    assert verdict.grade is Grade.REPEAT
    assert reasons(verdict) == [Reason.TOO_FEW]
    assert "images show the board: 3" in verdict.sentences()[1]


def test_eight_boards_are_few(corners):
    verdict = judge(evidence(corners[:8], fit_camera(BOARD, corners[:8], PARAMS)))
    assert verdict.grade is Grade.USABLE
    assert Reason.FEW in reasons(verdict)


@pytest.mark.parametrize("tilt_rad", [0.02, 0.002])
def test_frontal_boards_are_said_to_be_frontal(tilt_rad):
    frontal = as_corners(drawn_pixels(np.random.default_rng(2), 12, tilt_rad=tilt_rad))
    verdict = judge(evidence(frontal, fit_camera(BOARD, frontal)))
    assert verdict.grade is Grade.REPEAT
    assert Reason.FRONTAL in reasons(verdict)


def test_blurred_images_are_said_to_be_blurred(corners, fit):
    verdict = judge(evidence(corners, fit, blurs_px=[4.0] * 16))
    assert (verdict.grade, reasons(verdict)) == (Grade.REPEAT, [Reason.BLURRED])
    some = judge(evidence(corners, fit, blurs_px=[4.0] * 5 + [1.0] * 11))
    assert (some.grade, reasons(some)) == (Grade.USABLE, [Reason.BLURRED])


def test_boards_half_outside_are_said_to_be(corners):
    problems = [BoardSearch(None, BoardProblem.PARTLY_SEEN, {"columns": 5, "rows": 6})] * 14
    searches = [*(BoardSearch(one) for one in corners[:2]), *problems]
    verdict = judge(Evidence(BOARD, searches, fit_camera(BOARD, corners[:2])))
    assert reasons(verdict)[0] is Reason.CUT_OFF


def test_hidden_corners_count_as_cut_off(corners, fit):
    cut = []
    for one in corners:
        pixels, sigma_px = one.pixels.copy(), one.sigma_px.copy()
        pixels[:20], sigma_px[:20] = np.nan, np.nan
        cut.append(replace(one, pixels=pixels, sigma_px=sigma_px))
    assert reasons(judge(evidence(cut, fit))) == [Reason.CUT_OFF]


def test_another_size_is_told_with_both_sizes():
    fields = {"columns": 8, "rows": 6, "wanted_columns": 9, "wanted_rows": 6}
    searches = [BoardSearch(None, BoardProblem.ANOTHER_SIZE, fields)] * 12
    verdict = judge(Evidence(BOARD, searches, None))
    assert reasons(verdict) == [Reason.OTHER_SIZE]
    assert "8 x 6" in verdict.findings[0].text
    assert "9 x 6" in verdict.findings[0].text


@pytest.mark.parametrize(
    ("problem", "reason"),
    [(BoardProblem.TWO_BOARDS, Reason.TWO_BOARDS), (BoardProblem.NO_BOARD, Reason.NO_BOARD)],
)
def test_images_without_corners_are_told_by_their_reason(corners, fit, problem, reason):
    verdict = judge(Evidence(BOARD, [BoardSearch(None, problem)] * 12, None))
    assert (verdict.grade, reasons(verdict)) == (Grade.REPEAT, [reason])
    mixed = [*(BoardSearch(one) for one in corners), BoardSearch(None, problem)]
    some = judge(Evidence(BOARD, mixed, fit, [1.0] * 16))
    assert (some.grade, reasons(some)) == (Grade.USABLE, [reason])


def test_mirrored_images_are_never_good(corners, fit):
    mirrored = [replace(one, is_mirrored=True) for one in corners]
    verdict = judge(evidence(mirrored, fit))
    assert (verdict.grade, reasons(verdict)) == (Grade.REPEAT, [Reason.MIRRORED])


def test_depth_shows_a_wrong_size_of_the_squares(corners, fit):
    wrong = tuple(ScaleCheck(1.2 * z, z, 0.02) for z in (0.8, 1.0, 1.2))
    verdict = judge(evidence(corners, fit, scale_checks=wrong))
    assert (verdict.grade, reasons(verdict)) == (Grade.REPEAT, [Reason.SCALE])
    assert "30.00 mm, not 25.00 mm" in verdict.findings[0].text
    right = tuple(ScaleCheck(1.02 * z, z, 0.02) for z in (0.8, 1.0, 1.2))
    assert judge(evidence(corners, fit, scale_checks=right)).grade is Grade.GOOD


def test_contradicting_images_are_named(corners):
    spoiled = [replace(corners[0], pixels=np.roll(corners[0].pixels, 1, axis=0)), *corners[1:]]
    verdict = judge(evidence(spoiled, fit_camera(BOARD, spoiled, PARAMS)))
    assert Reason.OUTLIERS in reasons(verdict)
    assert any("view01" in finding.text for finding in verdict.findings)


def test_large_errors_and_contradictions_are_told(corners, fit):
    noisy = as_corners(drawn_pixels(np.random.default_rng(3), 16, 0.8))
    verdict = judge(evidence(noisy, fit_camera(BOARD, noisy, PARAMS)))
    assert Reason.LARGE_ERROR in reasons(verdict)
    assert Reason.UNCERTAIN in reasons(verdict)
    assert reasons(judge(evidence(corners, replace(fit, birge_ratio=25.0)))) == [Reason.NOT_FLAT]


def test_boards_in_one_place_leave_the_image_uncovered():
    pixels = np.stack([drawn_pixels(np.random.default_rng(4), 1)[0]] * 12)
    same = as_corners(pixels + np.random.default_rng(5).normal(0, 0.1, pixels.shape))
    verdict = judge(evidence(same, fit_camera(BOARD, same, PARAMS)))
    assert verdict.grade is Grade.REPEAT
    assert {Reason.UNCOVERED, Reason.UNSETTLED, Reason.FRONTAL} & set(reasons(verdict))


def test_a_fit_that_did_not_settle_is_never_good(corners, fit):
    verdict = judge(evidence(corners, replace(fit, is_settled=False)))
    assert (verdict.grade, reasons(verdict)) == (Grade.REPEAT, [Reason.UNSETTLED])


def test_every_reason_has_its_own_sentence():
    assert set(SENTENCES) == set(Reason)
    assert len(set(SENTENCES.values())) == len(Reason)
    assert Verdict((Finding(Reason.MIRRORED, Grade.REPEAT),)).grade is Grade.REPEAT


@pytest.mark.parametrize("sigma_px", [1.0, 2.5, 4.0])
def test_blur_is_measured(sigma_px):
    from scipy.ndimage import gaussian_filter

    side, rows, columns = 40, BOARD.rows + 1, BOARD.columns + 1
    squares = np.indices((rows, columns)).sum(axis=0) % 2 * 200.0 + 20.0
    image = np.pad(np.kron(squares, np.ones((side, side))), side, constant_values=220.0)
    gray = np.round(gaussian_filter(image, sigma_px)).astype(np.uint8)
    row, column = np.divmod(np.arange(BOARD.n_corners), BOARD.columns)
    pixels = np.stack([column, row], axis=-1) * side + 2.0 * side - 0.5
    found = BoardCorners("x", *gray.shape[::-1], pixels, np.full(len(pixels), 0.1))
    assert blur_px(gray, BOARD, found) == pytest.approx(sigma_px, rel=0.15)
    flat = np.full_like(gray, 128)
    assert np.isnan(blur_px(flat, BOARD, found))
    hidden = BoardCorners(
        "x", *gray.shape[::-1], np.full_like(pixels, np.nan), np.full(len(pixels), np.nan)
    )
    assert np.isnan(blur_px(gray, BOARD, hidden))
