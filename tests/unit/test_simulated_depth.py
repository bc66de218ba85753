"""The simulated depth camera errs as published, and repeats itself exactly."""

import math
from dataclasses import replace

import numpy as np
import pytest

from adibas.data.calibration import DepthBias
from adibas.simulation.depth_noise import EXACT, DepthNoise, DepthSensor
from adibas.simulation.device import DeviceSpread, draw_device

SIZE = (480, 640)
WINDOW = (slice(100, 380), slice(100, 540))


def unbiased_device(seed=4):
    device = draw_device(seed)
    return replace(device, calibration=replace(device.calibration, depth_bias=DepthBias()))


def plane(depth_m):
    return np.full(SIZE, 1 / depth_m, np.float32), np.full(SIZE, 0.6, np.float32)


def measured(noise, depth_m, moments, seed=1, device=None):
    sensor = DepthSensor(device or unbiased_device(), noise, seed)
    frames = np.stack([sensor.measure(*plane(depth_m), moment) for moment in moments])
    return np.where(frames == 0, np.nan, frames / 1000.0)


@pytest.mark.parametrize("depth_m", [0.8, 1.5, 2.0, 3.0])
def test_scatter_lies_between_the_published_curves_and_their_sum_with_rounding(depth_m):
    scatter_m = np.nanstd(measured(DepthNoise(), depth_m, [0])[0])
    khoshelham_m = 1.425e-5 * (100 * depth_m) ** 2 / 100
    # Khoshelham's 0.5 raw units; rounding to whole units and the fixed pattern come on top.
    disparity_m = khoshelham_m / 0.5 * math.sqrt(0.5**2 + 1 / 12 + 0.15**2)
    expected_m = math.hypot(disparity_m, 0.001 / math.sqrt(12))
    assert khoshelham_m < scatter_m
    assert scatter_m == pytest.approx(expected_m, rel=0.08)


def test_steps_of_disparity_are_11_mm_at_2_m():
    values_m = np.unique(measured(DepthNoise(), 2.0, [0])[0])
    values_m = values_m[np.isfinite(values_m)]
    steps_m = np.diff(values_m[np.abs(values_m - 2.0) < 0.04])
    assert steps_m.mean() == pytest.approx(2.0**2 / (8 * 0.075 * 580), rel=0.03)


def test_neighbours_within_the_window_of_correlation_err_together():
    noise = DepthNoise(static_sd=0.0, temporal_weights=(1.0,))
    disparity = 1 / measured(noise, 1.0, [0])[0][WINDOW]
    error = disparity - np.nanmean(disparity)

    def correlation(down, across):
        a = error[: error.shape[0] - down, : error.shape[1] - across]
        b = error[down:, across:]
        return np.nanmean(a * b) / np.nanmean(error**2)

    # Noise of 0.25 raw units squared carries 1/12 of rounding, which is not correlated.
    share = 0.25 / (0.25 + 1 / 12)
    assert correlation(0, 3) == pytest.approx(share * (1 - 3 / 9), abs=0.06)
    assert correlation(3, 0) == pytest.approx(share * (1 - 3 / 7), abs=0.06)
    assert abs(correlation(0, 12)) < 0.05
    assert abs(correlation(12, 0)) < 0.05


def test_one_frame_resembles_the_next_and_not_those_after():
    noise = DepthNoise(static_sd=0.0)
    frames = 1 / measured(noise, 1.0, range(6))[(slice(None), *WINDOW)]
    errors = frames - np.nanmean(frames, axis=(1, 2), keepdims=True)

    def correlation(lag):
        return np.nanmean(errors[:-lag] * errors[lag:]) / np.nanmean(errors**2)

    share = 0.25 / (0.25 + 1 / 12)
    assert correlation(1) == pytest.approx(share * 0.30, abs=0.04)
    assert abs(correlation(4)) < 0.04


def test_fixed_pattern_belongs_to_the_device():
    # Fine steps of disparity come only near; there the pattern shows in the mean of many frames.
    quiet = DepthNoise(disparity_sd=0.0, static_sd=3.0)
    first = measured(quiet, 0.8, [0], seed=1)[0][WINDOW]
    again = measured(quiet, 0.8, [5], seed=2)[0][WINDOW]
    other = measured(quiet, 0.8, [0], seed=1, device=unbiased_device(5))[0][WINDOW]
    both = np.isfinite(first) & np.isfinite(again) & np.isfinite(other)
    assert np.corrcoef(first[both], again[both])[0, 1] > 0.999
    assert abs(np.corrcoef(first[both], other[both])[0, 1]) < 0.1


def test_a_frame_is_the_same_whatever_was_asked_before():
    device, noise = draw_device(3), DepthNoise()
    forward = DepthSensor(device, noise, 7)
    in_order = [forward.measure(*plane(2.0), moment) for moment in range(4)]
    alone = DepthSensor(device, noise, 7).measure(*plane(2.0), 3)
    np.testing.assert_array_equal(in_order[3], alone)
    assert (in_order[2] != in_order[3]).any()


def test_the_image_term_handed_out_brings_depth_back_to_the_truth():
    device = draw_device(11, spread=DeviceSpread(bias_of_border_m=0.01))
    assert len(device.calibration.depth_bias.image_term) == 5
    raw_m = measured(EXACT, 2.0, [0], device=device)[0]
    spread_m = np.nanmax(raw_m) - np.nanmin(raw_m)
    corrected_m = device.calibration.corrected_depth(raw_m.astype(np.float32))
    step_m = 2.0**2 / (8 * 0.075 * 575)
    assert spread_m > 3 * step_m
    # Up to half a step of disparity.
    assert np.nanmax(np.abs(corrected_m - 2.0)) < 0.5 * step_m + 0.001
    plain = draw_device(11)
    assert plain.calibration.depth_bias.image_term == ()
    assert plain.disparity_offset == device.disparity_offset


def test_the_bias_handed_out_brings_depth_back_to_the_truth():
    device = draw_device(11)
    for depth_m, low_m, high_m in ((2.0, 0.006, 0.022), (3.0, 0.012, 0.032)):
        raw_m = np.nanmean(measured(EXACT, depth_m, [0], device=device)[0])
        assert low_m < abs(raw_m - depth_m) < high_m
        corrected_m = device.calibration.depth_bias.correct(np.array([raw_m]))[0]
        # Up to half a step of disparity.
        assert abs(corrected_m - depth_m) < 0.5 * depth_m**2 / (8 * 0.075 * 575) + 0.001


def test_shadow_lies_to_the_left_of_what_stands_before():
    inverse_depth = np.full(SIZE, 1 / 3.0, np.float32)
    inverse_depth[:, 300:400] = 1 / 1.5
    device = unbiased_device()
    lost = DepthSensor(device, EXACT, 0).measure(inverse_depth, np.ones(SIZE, np.float32), 0) == 0
    row = lost[240]
    # The pattern moves by f b (1/z1 - 1/z2) between the two.
    width_px = device.depth.intrinsics.fx * 0.075 * (1 / 1.5 - 1 / 3.0)
    assert row[300 - int(width_px) + 2 : 299].all()
    assert not row[100 : 300 - int(width_px) - 3].any()
    assert not row[402:600].any()


def test_a_thin_thing_shades_only_a_strip_of_its_own_width():
    inverse_depth = np.full(SIZE, 1 / 3.0, np.float32)
    inverse_depth[:, 300:305] = 1 / 1.0
    device = unbiased_device()
    lost = DepthSensor(device, EXACT, 0).measure(inverse_depth, np.ones(SIZE, np.float32), 0) == 0
    shift_px = round(device.depth.intrinsics.fx * 0.075 * (1 / 1.0 - 1 / 3.0))
    row = lost[240]
    assert row[302 - shift_px]
    assert not row[310 - shift_px : 298].any()


def test_dark_and_grazing_surfaces_and_all_out_of_range_are_lost():
    device, noise = unbiased_device(), DepthNoise()
    sensor = DepthSensor(device, noise, 0)

    def lost(depth_m, reflectance):
        image = sensor.measure(plane(depth_m)[0], np.full(SIZE, reflectance, np.float32), 0)
        return (image[WINDOW] == 0).mean()

    assert lost(2.0, 0.55) < 0.01
    assert lost(2.0, 0.02) > 0.5
    assert lost(3.5, 0.05) > lost(2.0, 0.05)
    assert lost(0.4, 0.55) == 1.0
    assert lost(4.8, 0.55) == 1.0
    k = device.depth.intrinsics
    slopes = np.tan(np.radians([60.0, 85.0]))
    u = (np.arange(640) - k.cx) / k.fx
    # A wall through (0, 2 m) that is turned away by the angle: z = 2 + slope x.
    shares = []
    for slope in slopes:
        inverse_depth = np.tile(((1 - slope * u) / 2.0).astype(np.float32), (480, 1))
        image = sensor.measure(inverse_depth, np.full(SIZE, 0.55, np.float32), 0)
        shares.append((image[WINDOW[0], 318:323] == 0).mean())
    assert shares[0] < 0.05
    assert shares[1] > 0.9


def test_a_hole_is_round_and_where_it_should_be():
    sensor = DepthSensor(unbiased_device(), EXACT, 0)
    image = sensor.measure(*plane(2.0), 0, np.array([[200.3, 150.7, 4.0]]))
    v, u = np.nonzero(image[:, 100:] == 0)
    assert (np.hypot(u + 100 - 200.3, v - 150.7) <= 4.0).all()
    assert len(v) == pytest.approx(math.pi * 16, abs=6)


def test_flying_pixels_appear_only_when_asked_for():
    inverse_depth = np.full(SIZE, 1 / 3.0, np.float32)
    inverse_depth[100:300, 300:400] = 1 / 1.5
    for share, expected in ((0.0, False), (0.5, True)):
        noise = replace(EXACT, edge_jitter_px=0.8, flying_share=share)
        sensor = DepthSensor(unbiased_device(), noise, 0)
        image = sensor.measure(inverse_depth, np.ones(SIZE, np.float32), 0)
        assert ((image > 1600) & (image < 2800)).any() == expected
