"""Markers are found in colour by contrast with their surroundings, and centred to parts of a pixel.

Pictures are painted here with discs of known place (16 x 16 samples a pixel) on plain skin.
"""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from adibas.markers.blobs import Blob
from adibas.markers.burst import BurstParams, BurstTracker
from adibas.markers.color_model import ColorModel
from adibas.markers.detection import DetectionParams, find_color_markers, spots_with_features
from adibas.markers.faint import FaintParams
from adibas.markers.lab import rgb_to_lab
from adibas.markers.led import LedParams, find_led_markers

SIZE = (160, 200)
SKIN = np.array([200, 150, 125.0])
GREEN = np.array([40, 150, 70.0])
SHIRT = np.array([60, 60, 120.0])
FOCAL_PX = 1050.0
BODY = np.ones(SIZE, bool)
DEPTH_M = np.full(SIZE, 2.0, np.float32)
MODEL = ColorModel(rgb_to_lab(GREEN.astype(np.uint8)[None, None])[0].astype(float), 14.0)
SAMPLES = 16


def disc(u, v, radius, ratio=1.0):
    """Share of every pixel that an ellipse of long half axis `radius` covers."""
    steps = (np.arange(SAMPLES) + 0.5) / SAMPLES - 0.5
    rows = np.arange(SIZE[0])[:, None] + steps
    columns = np.arange(SIZE[1])[:, None] + steps
    inside = ((columns.ravel() - u) / (radius * ratio)) ** 2 + (
        (rows.ravel()[:, None] - v) / radius
    ) ** 2 <= 1
    return inside.reshape(SIZE[0], SAMPLES, SIZE[1], SAMPLES).mean(axis=(1, 3))


def painted(discs, background=SKIN, colour=GREEN, light=1.0, noise=0.0, seed=0):
    """A picture with lens blur, light, and noise of `noise` grey levels."""
    picture = np.broadcast_to(background, (*SIZE, 3)).astype(float)
    for share in discs:
        picture = picture + share[..., None] * (colour - picture)
    picture = cv2.GaussianBlur(picture, (0, 0), 0.7) * light
    picture += np.random.default_rng(seed).normal(size=picture.shape) * noise
    return np.clip(np.rint(picture), 0, 255).astype(np.uint8)


def find(picture, body=BODY, depth_m=DEPTH_M, model=MODEL):
    return find_color_markers(picture, body, depth_m, FOCAL_PX, model, DetectionParams())


def test_the_centre_of_a_sticker_of_four_pixels_is_right_to_a_fifteenth_of_a_pixel():
    rng = np.random.default_rng(1)
    for _ in range(10):
        u, v = rng.uniform(60, 100, 2)
        (blob,) = find(painted([disc(u, v, 2.1)])).blobs
        assert np.hypot(blob.u - u, blob.v - v) < 1 / 15


def test_noise_moves_the_centre_no_more_than_its_covariance_says():
    u, v = 80.3, 70.6
    errors, variances = [], []
    for seed in range(60):
        (blob,) = find(painted([disc(u, v, 2.1)], noise=4.0, seed=seed)).blobs
        tracker = BurstTracker(BurstParams())
        tracker.add([blob])
        (marker,) = tracker.markers()
        errors.append([marker.u - u, marker.v - v])
        variances.append(np.diag(marker.covariance_px2))
    inside = np.abs(errors) < 1.96 * np.sqrt(variances)
    assert inside.mean() > 0.92


@pytest.mark.parametrize("radius", [1.8, 2.4, 5.0])
def test_what_no_number_of_frames_takes_out_of_a_centre_is_in_its_covariance(radius):
    """In a shade that falls off, seen at a slant, beside the border of a shirt."""
    rng = np.random.default_rng(round(10 * radius))
    shade = np.linspace(1.0, 0.6, SIZE[1])[None, :, None]
    ratios = []
    for seed in range(40):
        u, v = rng.uniform(60, 100, 2)
        background = np.broadcast_to(SKIN, (*SIZE, 3)).copy()
        background[round(v + radius + rng.uniform(1, 6)) :] = SHIRT
        share = disc(u, v, radius, ratio=rng.uniform(0.6, 1.0))
        tracker = BurstTracker(BurstParams())
        for frame in range(6):
            picture = painted([share], background, light=shade, noise=3.0, seed=10 * seed + frame)
            tracker.add(find(picture).blobs)
        nearest = min(tracker.markers(), key=lambda one: np.hypot(one.u - u, one.v - v))
        ratios += (
            [nearest.u - u, nearest.v - v] / np.sqrt(np.diag(nearest.covariance_px2))
        ).tolist()
    assert np.mean(np.abs(ratios) < 1.96) > 0.92
    assert np.median(np.abs(ratios)) > 0.1, "nor is it much better than it says"


@pytest.mark.parametrize("light", [0.75, np.array([1.0, 0.9, 0.7]), np.array([0.8, 0.9, 1.0])])
def test_markers_are_found_in_shadow_and_changed_light(light):
    assert len(find(painted([disc(60, 70, 2.1), disc(120, 50, 2.1)], light=light)).blobs) == 2


def test_nothing_is_found_where_there_is_nothing():
    assert find(painted([], noise=4.0)).blobs == ()
    assert find(painted([disc(60, 70, 2.1)]), body=np.zeros(SIZE, bool)).blobs == ()


def test_a_marker_outside_the_body_is_none():
    body = np.ones(SIZE, bool)
    body[:, 100:] = False
    found = find(painted([disc(60, 70, 2.1), disc(140, 70, 2.1)]), body=body).blobs
    assert [round(blob.u) for blob in found] == [60]


def test_the_border_of_two_garments_is_no_marker():
    background = np.broadcast_to(SKIN, (*SIZE, 3)).copy()
    background[80:] = SHIRT
    background[:, 120:] = (90, 120, 90)
    assert find(painted([], background=background, noise=2.0)).blobs == ()


def test_large_and_small_markers_are_found_side_by_side():
    found = find(painted([disc(60, 80, 14.0), disc(140, 80, 2.1)])).blobs
    assert sorted(round(blob.u) for blob in found) == [60, 140]
    large = max(found, key=lambda blob: blob.radius_px)
    assert large.radius_px == pytest.approx(14.0, rel=0.1)


def test_what_has_a_form_that_no_marker_has_holds_no_faint_marker():
    """However little is asked of the odds."""
    every = DetectionParams(faint=FaintParams(least_rise=1.5, least_log_odds=-np.inf))
    depth_m = np.full(SIZE, 1.2, np.float32)
    picture = painted([disc(100, 80, 24.0, ratio=0.12), disc(40, 80, 1.2)], noise=2.0)
    spots = spots_with_features(picture, BODY, depth_m, FOCAL_PX, MODEL, every)
    places = [(blob.u, blob.v) for blob, _ in spots if blob is not None]
    assert not any(abs(u - 100) < 3.0 and abs(v - 80) < 24.0 for u, v in places)
    assert any(np.hypot(u - 40, v - 80) < 1.0 for u, v in places)


@pytest.mark.parametrize(
    ("shape", "distance_m", "words"),
    [
        (disc(100, 80, 18.0), 4.0, "too large"),
        (disc(100, 80, 3.0), 0.5, "too small"),
        (disc(100, 80, 24.0, ratio=0.12), 1.2, "too long"),
    ],
)
def test_what_cannot_be_a_marker_at_its_depth_is_refused_with_the_reason(shape, distance_m, words):
    found = find(painted([shape]), depth_m=np.full(SIZE, distance_m, np.float32))
    assert found.blobs == ()
    assert any(words in blob.reason for blob in found.rejected)


def test_the_share_of_the_body_that_fits_the_model_is_told():
    skin_model = ColorModel(rgb_to_lab(SKIN.astype(np.uint8)[None, None])[0].astype(float), 14.0)
    assert find(painted([]), model=skin_model).matched_share > 0.99
    assert find(painted([disc(60, 70, 2.1)])).matched_share < 0.01


def led_picture(places, brightness=1.0):
    picture = np.full((*SIZE, 3), 12.0)
    for u, v in places:
        picture += 900.0 * brightness * disc(u, v, 1.5)[..., None]
    return np.clip(cv2.GaussianBlur(picture, (0, 0), 1.2), 0, 255).astype(np.uint8)


def test_leds_are_found_in_a_dark_picture_though_they_are_saturated():
    places = [(60.3, 70.7), (120.6, 40.2)]
    found = find_led_markers(led_picture(places), BODY, DEPTH_M, FOCAL_PX, LedParams()).blobs
    assert len(found) == 2
    for u, v in places:
        assert min(np.hypot(blob.u - u, blob.v - v) for blob in found) < 0.15


def leds(peaks, background=12.0):
    """A picture with an LED of each peak, grey levels over its background, 40 pixels apart."""
    picture = np.broadcast_to(np.float64(background), SIZE).copy()
    for number, peak in enumerate(peaks):
        light = cv2.GaussianBlur(disc(40.3 + 40 * number, 80.7, 2.0), (0, 0), 1.5)
        picture += peak * light / light.max()
    return np.repeat(np.clip(np.rint(picture), 0, 255).astype(np.uint8)[..., None], 3, axis=2)


@pytest.mark.parametrize(
    ("least", "n_found"), [(20.0, 4), (40.0, 3), (60.0, 2), (150.0, 1), (255.0, 0)]
)
def test_the_least_brightness_decides_which_leds_count_beside_brighter_ones(least, n_found):
    picture = leds([900.0, 80.0, 50.0, 30.0])
    params = LedParams(least_brightness=least)
    found = find_led_markers(picture, BODY, DEPTH_M, FOCAL_PX, params).blobs
    assert len(found) == n_found
    for blob in found:
        assert abs(blob.v - 80.7) < 0.1
        assert abs((blob.u - 0.3 + 20) % 40 - 20) < 0.1


def test_an_led_is_as_large_as_a_brighter_one_of_its_size():
    (bright,) = find_led_markers(leds([200.0]), BODY, DEPTH_M, FOCAL_PX, LedParams()).blobs
    both = find_led_markers(leds([200.0, 70.0]), BODY, DEPTH_M, FOCAL_PX, LedParams()).blobs
    for blob in both:
        assert blob.radius_px == pytest.approx(bright.radius_px, rel=0.02)
        assert blob.n_pixels == pytest.approx(bright.n_pixels, abs=6)


def test_an_led_is_compared_with_the_cloth_about_it():
    background = np.full(SIZE, 12.0)
    background[:, 100:] = 30.0
    picture = leds([80.0, 0.0, 50.0], background)
    wanted = [(60.0, 1), (40.0, 2)]
    for least, n_found in wanted:
        params = LedParams(least_brightness=least)
        found = find_led_markers(picture, BODY, DEPTH_M, FOCAL_PX, params).blobs
        assert len(found) == n_found, least


def test_an_led_that_touches_the_glow_of_a_brighter_one_is_another_blob():
    picture = leds([200.0, 0.0])[..., 0] + np.roll(leds([130.0])[..., 0], 11, axis=1) - 12
    picture = np.repeat(picture[..., None].astype(np.uint8), 3, axis=2)
    found = find_led_markers(picture, BODY, DEPTH_M, FOCAL_PX, LedParams()).blobs
    assert sorted(round(blob.u) for blob in found) == [40, 51]


def test_leds_are_found_on_somebody_so_far_away_that_their_glow_is_much_of_the_body():
    places = [(35.0 + 20 * column, 35.0 + 20 * row) for row in range(4) for column in range(4)]
    body = np.zeros(SIZE, bool)
    body[30:100, 30:100] = True
    depth_m = np.full(SIZE, 3.5, np.float32)
    picture = led_picture(places)
    assert (picture[body].max(axis=1) > 100).mean() > LedParams().greatest_share
    assert len(find_led_markers(picture, body, depth_m, FOCAL_PX, LedParams()).blobs) == 16


def test_a_dark_picture_without_leds_has_none():
    dark = led_picture([], 0.0)
    assert find_led_markers(dark, BODY, DEPTH_M, FOCAL_PX, LedParams()).blobs == ()


def test_a_bright_picture_is_told_by_its_share():
    bright = painted([disc(100, 80, 40.0)], colour=np.array([255.0, 255, 255]), background=SHIRT)
    found = find_led_markers(bright, BODY, DEPTH_M, FOCAL_PX, LedParams())
    assert found.matched_share > LedParams().greatest_share
    assert found.blobs == ()


def sighting(u, v, radius_px=2.0):
    (blob,) = find(painted([disc(60, 70, 2.1)], noise=4.0)).blobs
    values = {name: getattr(blob, name) for name in Blob.__slots__}
    return Blob(**values | {"u": u, "v": v, "radius_px": radius_px})


def test_a_burst_keeps_what_half_of_its_frames_show():
    tracker = BurstTracker(BurstParams())
    for index in range(10):
        flicker = [sighting(150.0, 20.0)] if index % 3 == 0 else []
        tracker.add([sighting(60.0 + 0.1 * index, 70.0), *flicker])
    (marker,) = tracker.markers()
    assert marker.u == pytest.approx(60.45)
    assert marker.n_sightings == 10


@pytest.mark.parametrize(("n_faint", "is_faint"), [(0, False), (5, False), (6, True), (10, True)])
def test_a_burst_marker_is_faint_where_most_of_its_sightings_are(n_faint, is_faint):
    tracker, seen = BurstTracker(BurstParams()), sighting(60.0, 70.0)
    for index in range(10):
        tracker.add([replace(seen, is_faint=index < n_faint)])
    of_mean = replace(sighting(90.0, 70.0), is_faint=is_faint)
    assert [one.is_faint for one in tracker.markers([of_mean])] == [is_faint] * 2


def test_two_markers_that_sway_are_not_mixed_up():
    tracker = BurstTracker(BurstParams())
    for index in range(12):
        shift = 3.0 * np.sin(index)
        blobs = [sighting(60.0 + shift, 70.0), sighting(67.0 + shift, 70.0)]
        tracker.add(blobs if index % 2 else blobs[::-1])
    left, right = sorted(tracker.markers(), key=lambda marker: marker.u)
    assert right.u - left.u == pytest.approx(7.0, abs=1e-9)


def test_an_outlier_does_not_move_the_mean_and_more_frames_are_surer():
    tracker = BurstTracker(BurstParams())
    for index in range(9):
        tracker.add([sighting(60.0 if index != 4 else 64.0, 70.0)])
    (marker,) = tracker.markers()
    assert marker.u == pytest.approx(60.0)
    alone = BurstTracker(BurstParams())
    alone.add([sighting(60.0, 70.0)])
    assert marker.covariance_px2[0, 0] < alone.markers()[0].covariance_px2[0, 0]


def test_markers_come_from_top_to_bottom_and_an_empty_burst_has_none():
    tracker = BurstTracker(BurstParams())
    assert tracker.markers() == ()
    tracker.add([sighting(60.0, 90.0), sighting(60.0, 20.0)])
    tracker.add([])
    assert [marker.v for marker in tracker.markers()] == [20.0, 90.0]
