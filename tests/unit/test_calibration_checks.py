"""Wand, drift, vertical, and the fit of depth and colour."""

import cv2
import numpy as np
import pytest
from scipy import stats
from scipy.io import loadmat

from adibas.calibration.drift import fit_drift
from adibas.calibration.registration_check import RegistrationResult, check_registration
from adibas.calibration.registration_check_kernels import rough_scores
from adibas.calibration.vertical import vertical_from_accelerometer, vertical_from_floor
from adibas.calibration.wand import WandParams, WandResult, check_wand
from adibas.data.calibration import CameraCalibration, RgbdCalibration
from adibas.data.frames import depth_in_metres
from adibas.data.sentence import Sentence
from adibas.geometry.pinhole import Intrinsics
from adibas.geometry.planes import Plane
from adibas.geometry.rigid import RigidTransform
from adibas.texts import message, speaking

RNG = np.random.default_rng
MILLIMETRE = 0.001


def wand(measured_m, sd_m, length_m=0.5, params=None):
    ends_m = np.array([[0.0, 0.0, 2.0], [measured_m, 0.0, 2.0]])
    return check_wand(ends_m, np.eye(6) * sd_m**2 / 2, length_m, params)


def test_the_rough_score_of_a_shift_is_that_of_straight_lines_between_samples():
    rng = np.random.default_rng(8)
    shifts, growths = np.linspace(-6.0, 6.0, 7), np.linspace(-2.0, 2.0, 3)
    normals, sums = rng.normal(0.0, 0.7, (4, 2)), rng.normal(0.0, 1.0, (4, 21))
    scores = np.empty((7, 7, 3))
    rough_scores((shifts, growths), normals, sums, 2.0, scores)
    u, v, growth = np.meshgrid(shifts, shifts, growths, indexing="ij")
    expected = sum(
        np.interp(10.0 + 2.0 * (u * x + v * y + growth), np.arange(21), row, left=0.0, right=0.0)
        for (x, y), row in zip(normals, sums, strict=True)
    )
    np.testing.assert_allclose(scores, expected, atol=1e-12)


def test_a_wand_of_the_right_length_passes():
    check = wand(0.503, 0.001)
    assert check.result is WandResult.PASSED
    half_m = 1.96 * 0.001
    np.testing.assert_allclose(check.interval_m, [0.503 - half_m, 0.503 + half_m], atol=2e-5)
    assert "500.0 mm measures 503.0 mm (501.0 to 505.0 mm)" in check.sentence.text


def test_a_wand_is_wrong_where_interval_and_tolerance_do_not_reach_its_length():
    assert wand(0.5069, 0.001).result is WandResult.PASSED
    check = wand(0.5071, 0.001)
    assert check.result is WandResult.FAILED
    assert "more than 5.0 mm away" in check.sentence.text
    assert wand(0.4929, 0.001).result is WandResult.FAILED
    assert wand(0.5071, 0.001, params=WandParams(tolerance_m=0.006)).result is WandResult.PASSED


def test_a_wand_that_is_measured_badly_says_nothing():
    check = wand(0.503, 0.004)
    assert check.result is WandResult.UNSURE
    assert "nearer" in check.sentence.text
    assert wand(0.6, 0.004).result is WandResult.FAILED


def test_a_wand_needs_a_length_and_two_ends():
    with pytest.raises(ValueError, match="positive length"):
        wand(0.5, 0.001, length_m=0.0)
    with pytest.raises(ValueError, match="two measured ends"):
        wand(np.nan, 0.001)
    with pytest.raises(ValueError, match="tolerance_m"):
        WandParams(0.0)


def test_sentences_follow_the_language():
    sentence = Sentence(message("No"), {})
    assert Sentence(message("{a} {b} {c}"), {"a": 1.25, "b": 3, "c": message("depth")}).text == (
        "1.2 3 depth"
    )
    with speaking("es"):
        assert Sentence(message("{a}"), {"a": 1.25}, decimals=2).text == "1,25"
        assert sentence.text
    assert Sentence(message("{a}"), {"a": message("depth")}).text == "depth"


def test_a_drift_is_the_slope_of_the_errors():
    times_s = np.array([0.0, 10.0, 30.0, 60.0, 100.0])
    drift = fit_drift(times_s, 0.01 - 2e-5 * times_s, np.ones(5))
    assert drift.rate_per_m_s == pytest.approx(-2e-5)
    assert drift.rate_m_s(2.0) == pytest.approx(8e-5)
    assert drift.span_s == 100.0
    text = drift.notice().text
    assert "4.8 mm a minute at 2.0 m (4.8 to 4.8 mm)" in text


def test_interval_of_a_drift_is_that_of_a_regression():
    rng = RNG(0)
    times_s = np.linspace(0.0, 60.0, 12)
    errors = rng.normal(0.0, 1e-4, 12) + 1e-6 * times_s
    drift = fit_drift(times_s, errors, np.full(12, 7.0))
    referee = stats.linregress(times_s, errors)
    half = stats.t.ppf(0.975, 10) * referee.stderr
    assert drift.rate_per_m_s == pytest.approx(referee.slope)
    np.testing.assert_allclose(
        drift.interval_per_m_s, [referee.slope - half, referee.slope + half], rtol=1e-9
    )


def test_no_drift_is_no_notice():
    rng = RNG(1)
    times_s = np.linspace(0.0, 60.0, 12)
    assert fit_drift(times_s, rng.normal(0.0, 1e-3, 12), np.ones(12)).notice() is None
    assert fit_drift(times_s, 1e-7 * times_s, np.ones(12)).notice() is None


def test_few_moments_have_no_drift():
    times_s, errors = np.arange(5.0), np.array([0.0, np.nan, 1.0, np.nan, 2.0])
    assert fit_drift(times_s, errors, np.ones(5)) is None
    assert fit_drift(np.zeros(5), np.arange(5.0), np.ones(5)) is None


def floor_blocks(rng, up, height_m, sd_per_m, n=200):
    """Return blocks of a floor, with noise in 1/z as the sensor has it."""
    rays = np.column_stack([rng.uniform(-0.5, 0.5, n), rng.uniform(0.15, 0.4, n), np.ones(n)])
    inverse_m = -(rays @ up) / height_m + rng.normal(0.0, 1.0, n) * sd_per_m
    return rays / inverse_m[:, None]


UP = np.array([0.05, -0.95, -0.2]) / np.linalg.norm([0.05, -0.95, -0.2])


def test_the_vertical_of_an_exact_floor_is_its_normal():
    blocks_m = floor_blocks(RNG(2), UP, 1.1, 0.0)
    found = vertical_from_floor(blocks_m, Plane(np.array([0.0, -1.0, 0.0]), 1.0))
    np.testing.assert_allclose(found.gravity, -UP, atol=1e-9)
    assert found.floor.offset_m == pytest.approx(1.1)
    assert found.flatness_m == pytest.approx(0.0, abs=1e-9)
    assert found.sd_rad == pytest.approx(0.0, abs=1e-8)


def test_uncertainty_of_the_vertical_is_its_scatter():
    floor = Plane(UP, 1.1)
    turns, sds = [], []
    for seed in range(200):
        found = vertical_from_floor(floor_blocks(RNG(seed), UP, 1.1, 0.0005), floor)
        turns.append(np.cross(found.gravity, -UP))
        sds.append(found.sd_rad)
    scatter = np.linalg.eigvalsh(np.cov(np.array(turns).T))[-1]
    assert np.mean(sds) == pytest.approx(np.sqrt(scatter), rel=0.15)


def test_things_on_the_floor_do_not_turn_the_vertical():
    rng = RNG(3)
    blocks_m = floor_blocks(rng, UP, 1.1, 0.0002)
    blocks_m[:20] += 0.15 * UP
    found = vertical_from_floor(blocks_m, Plane(UP, 1.1))
    assert np.arccos(-found.gravity @ UP) < 0.002
    assert found.flatness_m < 0.002


def test_a_floor_without_extent_has_no_vertical():
    blocks_m = floor_blocks(RNG(4), UP, 1.1, 0.0)
    assert vertical_from_floor(blocks_m[:5], Plane(UP, 1.1)) is None
    line_m = np.linspace(blocks_m[0], blocks_m[1], 20)
    assert vertical_from_floor(line_m, Plane(UP, 1.1)) is None


def test_an_accelerometer_at_rest_shows_up():
    rng = RNG(5)
    up = np.array([0.0, -1.0, 0.0])
    samples = 9.81 * up + rng.normal(0.0, 0.05, (400, 3))
    found = vertical_from_accelerometer(samples)
    np.testing.assert_allclose(found.gravity, -up, atol=0.001)
    assert found.sd_rad == pytest.approx(0.05 / 9.81 / 20, rel=0.2)
    turn = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
    turned = vertical_from_accelerometer(samples, turn)
    np.testing.assert_allclose(turned.gravity, turn @ found.gravity)
    assert turned.disagreement_rad(found) == pytest.approx(np.pi / 2, abs=0.002)


def test_an_accelerometer_that_is_shaken_or_silent_shows_nothing():
    rng = RNG(6)
    assert vertical_from_accelerometer(rng.normal(0.0, 5.0, (100, 3))) is None
    assert vertical_from_accelerometer(np.full((5, 3), 9.8)) is None


COLOR = CameraCalibration(640, 512, Intrinsics(525.0, 525.0, 320.0, 256.0), (0.05, -0.1, 0.0, 0.0))
DEPTH = CameraCalibration(320, 240, Intrinsics(290.0, 290.0, 160.0, 120.0))
CALIBRATION = RgbdCalibration(
    color=COLOR,
    depth=DEPTH,
    color_from_depth=RigidTransform(np.eye(3), np.array([-0.025, 0.0, 0.0])),
)


def seen_by(camera, from_depth, radius_m):
    """Return 1/z of two discs, 1.2 m away before a wall at 2.2 m."""
    v, u = np.mgrid[0 : camera.height, 0 : camera.width].astype(float)
    k = camera.intrinsics
    points = np.stack([u, v], axis=-1).reshape(-1, 1, 2)
    lens = np.array(camera.distortion or (0.0,) * 4)
    rays = cv2.undistortPoints(points, k.matrix(), lens).reshape(camera.height, camera.width, 2)
    inverse_m = np.full(u.shape, 1 / 2.2)
    for x, y in ((-0.25, 0.1), (0.3, -0.15)):
        centre_x, centre_y, z = from_depth.apply(np.array([x, y, 1.2]))
        far = np.hypot(rays[..., 0] * z - centre_x, rays[..., 1] * z - centre_y)
        inverse_m[far < radius_m] = 1 / z
    return inverse_m


def edges(moved_px=(0.0, 0.0), grown_m=0.0):
    """Return a colour image and the depth of the same discs."""
    rng = RNG(7)
    depth_m = (1.0 / seen_by(DEPTH, RigidTransform(np.eye(3), np.zeros(3)), 0.18 + grown_m)).astype(
        np.float32
    )
    near = seen_by(COLOR, CALIBRATION.color_from_depth, 0.18) > 1 / 2.0
    gray = np.where(near, 90.0, 170.0)
    move = np.array([[1.0, 0.0, moved_px[0]], [0.0, 1.0, moved_px[1]]])
    gray = cv2.warpAffine(gray, move, gray.shape[::-1], borderMode=cv2.BORDER_REPLICATE)
    gray = cv2.GaussianBlur(gray, (0, 0), 1.0) + rng.normal(0.0, 3.0, gray.shape)
    return np.clip(gray, 0, 255).astype(np.uint8), depth_m


def test_depth_and_colour_of_one_scene_fit():
    check = check_registration(*edges(), CALIBRATION)
    assert check.result is RegistrationResult.FITS
    np.testing.assert_allclose(check.shift_px, 0.0, atol=0.35)
    assert (check.standard_error_px < 0.4).all()
    assert "Depth and colour fit" in check.sentence.text


@pytest.mark.parametrize("moved_px", [(4.0, -3.0), (-25.0, 18.0)])
def test_a_shift_of_the_colour_is_found(moved_px):
    check = check_registration(*edges(moved_px), CALIBRATION)
    assert check.result is RegistrationResult.SHIFTED
    np.testing.assert_allclose(check.shift_px, moved_px, atol=0.5)
    assert "do not fit" in check.sentence.text


def test_outlines_that_are_drawn_too_large_are_no_shift():
    check = check_registration(*edges(grown_m=0.006), CALIBRATION)
    assert check.result is RegistrationResult.FITS
    assert check.growth_px == pytest.approx(-0.006 * 525 / 1.2, abs=0.8)


def test_nothing_is_said_without_edges():
    gray, depth_m = edges()
    flat = np.full_like(depth_m, 2.0)
    assert check_registration(gray, flat, CALIBRATION).result is RegistrationResult.UNSURE
    noise = RNG(8).integers(0, 256, gray.shape).astype(np.uint8)
    check = check_registration(noise, depth_m, CALIBRATION)
    assert check.result is RegistrationResult.UNSURE
    assert np.isnan(check.shift_px).all()
    assert "cannot be told" in check.sentence.text


def test_the_check_needs_both_cameras():
    gray, depth_m = edges()
    with pytest.raises(ValueError, match="both cameras"):
        check_registration(gray, depth_m, RgbdCalibration(color=COLOR))


def test_a_real_room_shows_by_how_much_its_calibrations_differ(real_data):
    # The colour's principal point is set to the middle: the stored one is off by tens of pixels.
    folder = real_data / "calibration" / "kinect1"
    gray = cv2.imread(str(folder / "left_scene.png"), cv2.IMREAD_GRAYSCALE)
    raw = cv2.imread(str(folder / "left_depth_scene.png"), cv2.IMREAD_UNCHANGED)
    depth_m = depth_in_metres(raw, MILLIMETRE)
    depth = CameraCalibration(640, 480, Intrinsics(576.2, 573.8, 324.4, 235.8))
    stored = loadmat(folder / "Kinect_Parameters.mat")
    shift = RigidTransform(stored["R"], stored["T"].ravel())

    def checked(cx, cy):
        color = CameraCalibration(640, 480, Intrinsics(530.9, 533.6, cx, cy))
        calibration = RgbdCalibration(color=color, depth=depth, color_from_depth=shift)
        return check_registration(gray, depth_m, calibration)

    first = checked(319.5, 239.5)
    assert first.result is RegistrationResult.SHIFTED
    again = checked(319.5 + first.shift_px[0], 239.5 + first.shift_px[1])
    assert again.result is RegistrationResult.FITS
    far = checked(319.5 + first.shift_px[0] - 8.0, 239.5 + first.shift_px[1] + 6.0)
    np.testing.assert_allclose(far.shift_px - again.shift_px, (8.0, -6.0), atol=0.7)
