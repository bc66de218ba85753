"""A marker's place in space comes from the skin around it, with an honest covariance."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from adibas.data.calibration import CameraCalibration, DepthBias, RgbdCalibration
from adibas.data.markers import Marker
from adibas.data.surface import BurstDisparity
from adibas.geometry.distortion import project_distorted
from adibas.geometry.pinhole import Intrinsics
from adibas.geometry.rigid import RigidTransform
from adibas.markers.disparity import DisparitySum, fuse_depth
from adibas.markers.position import (
    LEAST_NOISE,
    DisparityNoise,
    PositionFinder,
    PositionParams,
    _patch,
)
from adibas.markers.position_kernels import radius_at_m

HEIGHT, WIDTH = 240, 320
TURN = cv2.Rodrigues(np.array([0.004, -0.003, 0.005]))[0]
CALIBRATION = RgbdCalibration(
    color=CameraCalibration(640, 480, Intrinsics(530.0, 531.0, 322.0, 238.0), (0.05, -0.1, 0, 0)),
    depth=CameraCalibration(WIDTH, HEIGHT, Intrinsics(580.0, 580.0, 160.5, 119.5)),
    color_from_depth=RigidTransform(TURN, np.array([-0.025, 0.001, 0.0])),
)
NO_NOISE = DisparityNoise(frame_sd_per_m=1e-5, quantum_per_m=1e-5, static_sd_per_m=0.0)
PIXEL_SD2 = np.eye(2) * 0.05**2


def rays():
    k = CALIBRATION.depth.intrinsics
    v, u = np.mgrid[:HEIGHT, :WIDTH]
    return np.stack([(u - k.cx) / k.fx, (v - k.cy) / k.fy, np.ones_like(u)], axis=-1)


def plane_depth_m(normal, distance_m):
    """Depth of the plane normal . p = distance."""
    return distance_m / (rays() @ np.asarray(normal, float))


def cylinder_depth_m(axis_z_m, radius_m):
    """Depth of an upright limb's front: (x, z - axis)^2 = radius^2, NaN beside it."""
    x = rays()[..., 0]
    a, b, c = x**2 + 1, -2 * axis_z_m, axis_z_m**2 - radius_m**2
    root = b**2 - 4 * a * c
    return np.where(root > 0, (-b - np.sqrt(np.maximum(root, 0))) / (2 * a), np.nan)


def point_of_pixel(depth_m, u, v):
    return rays()[v, u] * depth_m[v, u]


def locate(depth_m, point_m, noise=NO_NOISE, **params):
    burst = fuse_depth([depth_m.astype(np.float32)], DepthBias())
    finder = PositionFinder(burst, CALIBRATION, PositionParams(noise=noise, **params))
    truth_m = CALIBRATION.color_from_depth.apply(point_m)
    color = CALIBRATION.color
    pixel = project_distorted(truth_m, color.intrinsics, color.distortion)
    return finder.locate(pixel, PIXEL_SD2), truth_m


@pytest.mark.parametrize("normal", [(0, 0, 1), (0.6, 0.1, 0.8), (-0.3, 0.8, 0.7)])
def test_a_point_on_a_plane_is_found_where_it_is(normal):
    depth_m = plane_depth_m(normal, 1.4)
    found, truth_m = locate(depth_m, point_of_pixel(depth_m, 150, 110))
    np.testing.assert_allclose(found.position_m, truth_m, atol=1e-5)


def test_a_point_on_a_thin_limb_is_found_to_half_a_millimetre():
    depth_m = cylinder_depth_m(2.0, 0.04)
    found, truth_m = locate(depth_m, point_of_pixel(depth_m, 163, 120))
    np.testing.assert_allclose(found.position_m, truth_m, atol=5e-4)


def test_a_marker_without_depth_of_its_own_is_measured_by_what_surrounds_it():
    depth_m = plane_depth_m((0.3, 0.1, 0.95), 1.5)
    point_m = point_of_pixel(depth_m, 150, 110)
    depth_m[108:113, 148:153] = np.nan
    found, truth_m = locate(depth_m, point_m)
    np.testing.assert_allclose(found.position_m, truth_m, atol=1e-5)


def test_the_surface_behind_takes_no_part():
    depth_m = plane_depth_m((0, 0, 1), 2.0)
    near_m = plane_depth_m((0.2, 0, 1), 1.5)
    depth_m[:, :160] = near_m[:, :160]
    point_m = point_of_pixel(depth_m, 154, 110)
    found, truth_m = locate(depth_m, point_m)
    np.testing.assert_allclose(found.position_m, truth_m, atol=1e-4)


def test_flying_pixels_do_not_move_it():
    depth_m = plane_depth_m((0.2, 0, 1), 1.5)
    point_m = point_of_pixel(depth_m, 154, 110)
    depth_m[104:116:3, 150:160:3] += 0.025
    found, truth_m = locate(depth_m, point_m)
    np.testing.assert_allclose(found.position_m, truth_m, atol=1e-4)


@pytest.mark.parametrize(
    "spoil",
    [
        lambda depth_m: depth_m.fill(np.nan),
        lambda depth_m: depth_m[:, 151:].fill(np.nan),
        lambda depth_m: depth_m[90:131, 130:171].fill(np.nan),
    ],
)
def test_no_position_is_better_than_a_wrong_one(spoil):
    depth_m = plane_depth_m((0, 0, 1), 1.5)
    point_m = point_of_pixel(depth_m, 150, 110)
    spoil(depth_m)
    assert locate(depth_m, point_m)[0] is None


def placed(depth_m, point_m):
    """Return the marker that is seen where a point of the depth camera is, and the true point."""
    truth_m = CALIBRATION.color_from_depth.apply(point_m)
    u, v = project_distorted(truth_m, CALIBRATION.color.intrinsics, CALIBRATION.color.distortion)
    burst = fuse_depth([depth_m.astype(np.float32)], DepthBias())
    finder = PositionFinder(burst, CALIBRATION, PositionParams(noise=NO_NOISE))
    marker = finder.placed(Marker("m01", float(u), float(v), 2.0, PIXEL_SD2))
    return marker, truth_m, finder.is_between_surfaces(np.array([u, v]))


@pytest.mark.parametrize("normal", [(0, 0, 1), (0, 0.4, 0.9)])
@pytest.mark.parametrize(
    ("spoil", "is_between"),
    [
        (lambda depth_m: depth_m[:, 151:].fill(2.5), True),
        (lambda depth_m: depth_m[:, 151:].fill(1.65), True),
        (lambda depth_m: depth_m[:, 151:].fill(np.nan), False),
    ],
)
def test_at_an_outline_the_depth_is_rough_and_may_be_of_two_surfaces(spoil, is_between, normal):
    depth_m = plane_depth_m(normal, 1.5 * normal[2])
    point_m = point_of_pixel(depth_m, 150, 110)
    spoil(depth_m)
    marker, truth_m, between = placed(depth_m, point_m)
    assert marker.position_m is None
    assert marker.rough_depth_m == pytest.approx(truth_m[2], abs=0.02)
    assert between == is_between


def test_a_marker_with_a_position_has_no_rough_depth_and_far_from_all_depth_there_is_none():
    depth_m = plane_depth_m((0.5, 0.5, 0.7), 1.0)
    point_m = point_of_pixel(depth_m, 150, 110)
    marker, truth_m, is_between = placed(depth_m, point_m)
    np.testing.assert_allclose(marker.position_m, truth_m, atol=1e-5)
    assert marker.rough_depth_m is None
    assert not is_between
    depth_m[70:151, 110:191] = np.nan
    marker, _truth_m, is_between = placed(depth_m, point_m)
    assert marker.rough_depth_m is None
    assert not is_between


def test_a_rough_depth_beside_a_position_is_refused():
    with pytest.raises(ValueError, match="rough"):
        Marker("m01", 0.0, 0.0, 2.0, np.eye(2), np.zeros(3), np.eye(3), rough_depth_m=2.0)


def test_a_marker_outside_the_depth_camera_s_picture_has_no_position():
    depth_m = plane_depth_m((0, 0, 1), 1.5)
    assert locate(depth_m, np.array([0.6, 0.0, 1.5]))[0] is None
    just_outside_m = 1.5 * np.array([(-1.0 - 160.5) / 580.0, -0.02, 1.0])
    assert locate(depth_m, just_outside_m)[0] is None


def test_noise_beyond_the_limit_is_no_position():
    depth_m = plane_depth_m((0, 0, 1), 1.5)
    point_m = point_of_pixel(depth_m, 150, 110)
    assert locate(depth_m, point_m, noise=DisparityNoise(frame_sd_per_m=0.05))[0] is None


PUBLISHED = DisparityNoise()


def noisy_frames(depth_m, rng, n_frames, noise=PUBLISHED):
    """Frames with the published noise: correlated over 9 x 7 pixels, and rounded."""
    for _ in range(n_frames):
        white = rng.standard_normal(depth_m.shape)
        correlated = cv2.blur(white, (9, 7), borderType=cv2.BORDER_REFLECT) * np.sqrt(63)
        disparity = 1 / depth_m + noise.frame_sd_per_m * correlated
        yield (1 / (np.round(disparity / noise.quantum_per_m) * noise.quantum_per_m)).astype(
            np.float32
        )


@pytest.mark.parametrize("n_frames", [1, 8])
def test_the_interval_holds_the_truth_in_95_percent_of_cases(n_frames):
    rng = np.random.default_rng(11)
    depth_m = plane_depth_m((0.3, 0.1, 0.95), 2.0)
    noise = DisparityNoise(static_sd_per_m=0.0, frames_per_sample=1.0)
    misses, cases = 0, 0
    for _ in range(12):
        burst = fuse_depth(noisy_frames(depth_m, rng, n_frames), DepthBias())
        finder = PositionFinder(burst, CALIBRATION, PositionParams(noise=noise))
        for u in range(30, 300, 30):
            for v in range(30, 220, 30):
                truth_m = CALIBRATION.color_from_depth.apply(point_of_pixel(depth_m, u, v))
                color = CALIBRATION.color
                pixel = project_distorted(truth_m, color.intrinsics, color.distortion)
                found = finder.locate(pixel, np.eye(2) * 1e-6)
                error_m = found.position_m - truth_m
                sd_m = np.sqrt(found.covariance_m2[2, 2])
                misses += abs(error_m[2]) > 1.96 * sd_m
                cases += 1
    assert cases > 500
    assert 0.92 < 1 - misses / cases < 0.98


@pytest.mark.parametrize("relief_m", [0.0, PositionParams().relief_m])
@pytest.mark.parametrize("factor", [0.8, 1.0, 2.0])
def test_a_sensor_of_other_noise_than_assumed_still_gets_intervals_that_hold(factor, relief_m):
    rng = np.random.default_rng(12)
    depth_m = plane_depth_m((0.3, 0.1, 0.95), 2.0)
    assumed = DisparityNoise(static_sd_per_m=0.0, frames_per_sample=1.0)
    real = replace(
        assumed,
        frame_sd_per_m=factor * assumed.frame_sd_per_m,
        quantum_per_m=factor * assumed.quantum_per_m,
    )
    camera = CALIBRATION.color
    points_px = [(u, v) for u in range(30, 300, 30) for v in range(30, 220, 30)]
    truths_m = [
        CALIBRATION.color_from_depth.apply(point_of_pixel(depth_m, *one)) for one in points_px
    ]
    seen_px = np.array(
        [project_distorted(truth_m, camera.intrinsics, camera.distortion) for truth_m in truths_m]
    )
    errors, shares = [], []
    for _ in range(12):
        burst = fuse_depth(noisy_frames(depth_m, rng, 4, real), DepthBias())
        params = PositionParams(noise=assumed, relief_m=relief_m)
        finder = PositionFinder(burst, CALIBRATION, params, seen_px[::5])
        shares.append(finder.noise_share)
        for pixel, truth_m in zip(seen_px, truths_m, strict=True):
            found = finder.locate(pixel, np.eye(2) * 1e-6)
            sd_m = np.sqrt(found.covariance_m2[2, 2])
            errors.append((found.position_m - truth_m)[2] / sd_m)
    if not relief_m:  # as of the plane; else some of the noise is taken for relief
        assert np.mean(shares) == pytest.approx(factor**2, rel=0.15)  # far-off pixels are left out
    assert 0.92 < np.mean(np.abs(errors) <= 1.96) < 0.98


def drawn_relief_m(rng, width_px, per_px_m, sd_m, length_m):
    """Draw a square of Matern's process of order 3/2 (Rasmussen & Williams 2006, eq. 4.17)."""
    v, u = np.mgrid[:width_px, :width_px] * per_px_m
    apart = np.sqrt(3) * np.hypot(u.ravel()[:, None] - u.ravel(), v.ravel()[:, None] - v.ravel())
    covariance = sd_m**2 * (1 + apart / length_m) * np.exp(-apart / length_m)
    root = np.linalg.cholesky(covariance + 1e-12 * np.eye(len(covariance)))
    return (root @ rng.standard_normal((len(root), 150))).T.reshape(-1, width_px, width_px)


def test_skin_that_is_no_quadratic_is_measured_as_well_as_stated_and_better_than_by_one():
    rng, distance_m, half = np.random.default_rng(3), 1.2, 13
    plane_m = plane_depth_m((0, 0, 1), distance_m)
    reliefs_m = drawn_relief_m(rng, 2 * half + 1, distance_m / 580.0, 0.002, 0.02)
    errors_m, deviations, smooth_errors_m, smooth = [], [], [], []
    for relief in reliefs_m:
        depth_m = plane_m.copy()
        depth_m[110 - half : 111 + half, 150 - half : 151 + half] += relief
        point_m = point_of_pixel(depth_m, 150, 110)
        depth_m[106:115, 146:155] = np.nan  # as where an LED shines
        found, truth_m = locate(depth_m, point_m)
        errors_m.append(found.position_m[2] - truth_m[2])
        deviations.append(errors_m[-1] / np.sqrt(found.covariance_m2[2, 2]))
        flat, _ = locate(depth_m, point_m, relief_m=0.0)
        smooth_errors_m.append(flat.position_m[2] - truth_m[2])
        smooth.append(smooth_errors_m[-1] / np.sqrt(flat.covariance_m2[2, 2]))
    assert 0.92 < np.mean(np.abs(deviations) < 1.96) < 0.985
    assert np.mean(np.abs(smooth) < 1.96) < 0.5
    assert np.std(errors_m) < 0.8 * np.std(smooth_errors_m)


def test_the_patch_has_as_many_pixels_wherever_it_is_until_it_is_as_large_as_limbs_are_thick():
    params = PositionParams()
    patch = _patch(params)
    assert 580.0 / 0.8 * radius_at_m(1 / 0.8, patch) == pytest.approx(580.0 * 0.02)
    assert 580.0 / 2.9 * radius_at_m(1 / 2.9, patch) == pytest.approx(580.0 * 0.02)
    assert radius_at_m(1 / 4.5, patch) == params.greatest_radius_m


def test_a_fold_about_one_marker_does_not_make_the_sensor_s_noise_larger():
    rng = np.random.default_rng(8)
    depth_m = plane_depth_m((0, 0, 1), 1.5)
    folded_m = depth_m.copy()
    folded_m[95:125, 100:130] += 0.01 * np.sin(np.arange(30))
    seen_px = [
        project_distorted(
            CALIBRATION.color_from_depth.apply(point_of_pixel(depth_m, u, 110)),
            CALIBRATION.color.intrinsics,
            CALIBRATION.color.distortion,
        )
        for u in (55, 115, 175, 235, 285)
    ]
    noises = [list(noisy_frames(one, rng, 4)) for one in (depth_m, folded_m)]
    shares = [
        PositionFinder(
            fuse_depth(frames, DepthBias()), CALIBRATION, PositionParams(), np.array(seen_px)
        ).noise_share
        for frames in noises
    ]
    assert shares[1] == pytest.approx(shares[0], rel=0.15)


def test_a_depth_without_any_noise_is_not_believed_to_have_none():
    depth_m = plane_depth_m((0, 0, 1), 1.5)
    burst = fuse_depth([depth_m.astype(np.float32)], DepthBias())
    seen_px = np.array([(u, v) for u in range(60, 260, 20) for v in range(60, 200, 20)], float)
    finder = PositionFinder(burst, CALIBRATION, PositionParams(), seen_px)
    assert finder.noise_share == LEAST_NOISE


def test_without_markers_the_noise_is_as_assumed():
    burst = fuse_depth([plane_depth_m((0, 0, 1), 1.5).astype(np.float32)], DepthBias())
    finder = PositionFinder(burst, CALIBRATION, PositionParams(), np.empty((0, 2)))
    assert finder.noise_share == 1.0


def test_an_unsure_pixel_is_unsure_within_the_skin_not_across_it():
    normal = np.array([0.6, 0.0, 0.8])
    depth_m = plane_depth_m(normal, 1.4)
    burst = fuse_depth([depth_m.astype(np.float32)], DepthBias())
    finder = PositionFinder(burst, CALIBRATION, PositionParams(noise=NO_NOISE, relief_m=0.0))
    truth_m = CALIBRATION.color_from_depth.apply(point_of_pixel(depth_m, 150, 110))
    color = CALIBRATION.color
    pixel = project_distorted(truth_m, color.intrinsics, color.distortion)
    moved = [
        finder.locate(pixel + np.array(step), PIXEL_SD2).position_m
        for step in ((1, 0), (-1, 0), (0, 1), (0, -1))
    ]
    jacobian = np.stack([moved[0] - moved[1], moved[2] - moved[3]], axis=1) / 2
    covariance_m2 = finder.locate(pixel, PIXEL_SD2).covariance_m2
    np.testing.assert_allclose(
        covariance_m2, jacobian @ PIXEL_SD2 @ jacobian.T, rtol=0.05, atol=2e-10
    )


def test_a_burst_is_the_mean_of_what_was_measured():
    frames = np.full((4, 2, 2), 2.0, np.float32)
    frames[1, 0, 0] = np.nan
    frames[:3, 0, 1] = np.nan
    frames[2, 1, 0] = 4.0
    frames[:, 1, 1] = [1.0, 3.0, 1.0, 3.0]
    burst = fuse_depth(frames, DepthBias(), least_share=0.5, greatest_sd_per_m=0.2)
    assert burst.n_frames == 4
    np.testing.assert_array_equal(burst.n_readings, [[3, 1], [4, 4]])
    np.testing.assert_allclose(burst.mean_per_m, [[0.5, np.nan], [0.4375, np.nan]], rtol=1e-6)


def test_the_device_s_bias_is_taken_out_before_the_mean():
    burst = fuse_depth([np.full((1, 1), 2.0, np.float32)], DepthBias(a=0.1, b=1.2))
    np.testing.assert_allclose(burst.mean_per_m, 1 / 2.5, rtol=1e-6)


def test_what_cannot_be_is_a_programming_error():
    with pytest.raises(ValueError, match="one frame"):
        DisparitySum(DepthBias()).result(0.3, 0.1)
    burst = BurstDisparity(np.ones((2, 2), np.float32), np.ones((2, 2), np.int64), 1)
    with pytest.raises(ValueError, match="both cameras"):
        PositionFinder(burst, RgbdCalibration(depth=CALIBRATION.depth), PositionParams())
