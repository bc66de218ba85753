"""The simulated colour camera keeps colours and adds the noise that it claims."""

import numpy as np
import pytest

from adibas.data.calibration import CameraCalibration
from adibas.geometry.pinhole import Intrinsics
from adibas.simulation.color_noise import EXACT_COLOR, PAPER, ColorNoise, ColorSensor
from adibas.simulation.light import Illumination, black_body_rgb
from adibas.simulation.looks import linear_from_srgb

CAMERA = CameraCalibration(640, 480, Intrinsics(525.0, 525.0, 320.0, 240.0))
PLAIN = Illumination(temperature_k=6500.0)


def uniform(red, green, blue):
    return np.full((480, 640, 3), (red, green, blue), np.float32)


def taken(linear, noise=None, light=PLAIN, moment=0, seed=1):
    sensor = ColorSensor(CAMERA, noise or ColorNoise(), light, seed)
    return linear_from_srgb(sensor.take(linear, moment).astype(float))


def test_red_green_and_blue_stay_in_their_channels():
    for channel in range(3):
        color = np.full(3, 0.1)
        color[channel] = 0.6
        seen = taken(uniform(*color))[200:280, 280:360].mean(axis=(0, 1))
        balance = np.sqrt(black_body_rgb(6500.0))
        np.testing.assert_allclose(seen, PAPER * color * balance, rtol=0.03)


def test_noise_is_shot_and_read_noise_of_the_electrons():
    noise = ColorNoise(blur_px=0.0, corner_loss=0.0)
    level = 0.5
    sensor = ColorSensor(CAMERA, noise, PLAIN, seed=2)
    pictures = np.stack([sensor.take(uniform(level, level, level), m) for m in range(12)])
    # Green of even rows and odd columns is measured; the mosaic's other places are interpolated.
    green = linear_from_srgb(pictures[:, 0::2, 1::2, 1].astype(float))
    electrons = noise.full_well * PAPER * level
    expected = np.sqrt(electrons + noise.read_noise**2) / noise.full_well
    assert green.std(axis=0).mean() == pytest.approx(expected, rel=0.08)


def test_tungsten_light_looks_warm_and_daylight_neutral():
    warm, cool = (
        taken(uniform(0.5, 0.5, 0.5), EXACT_COLOR, Illumination(temperature_k=kelvin))[240, 320]
        for kelvin in (2900.0, 6500.0)
    )
    assert warm[0] > 1.2 * warm[2]
    assert cool[0] == pytest.approx(cool[2], rel=0.08)


def test_corners_are_darker_by_the_loss_that_is_set():
    noise = ColorNoise(corner_loss=0.4)
    seen = taken(uniform(0.5, 0.5, 0.5), noise)
    ratio = seen[:4, :4].mean() / seen[236:244, 316:324].mean()
    assert ratio == pytest.approx(0.6, abs=0.03)


def test_what_is_too_bright_is_white():
    assert taken(uniform(5.0, 5.0, 5.0), light=Illumination(temperature_k=3000.0)).min() == 1.0


def test_a_picture_is_the_same_for_the_same_moment_only():
    linear = uniform(0.3, 0.4, 0.5)
    np.testing.assert_array_equal(taken(linear, moment=3), taken(linear, moment=3))
    assert (taken(linear, moment=3) != taken(linear, moment=4)).any()
    assert (taken(linear, seed=1) != taken(linear, seed=2)).any()
