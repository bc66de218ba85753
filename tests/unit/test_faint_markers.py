"""Markers that differ little from what is about them are found, and spots of other things are not.

Stickers far away are painted here with discs of known place: of two to four pixels, each of which
is a mixture once the lens and the mosaic of the colour filter have been there.
"""

import itertools
from dataclasses import replace

import cv2
import numpy as np
import pytest
from scipy import ndimage

from adibas.markers.blobs import Looks, connected_groups, look_at, measure_blobs
from adibas.markers.color_model import ColorModel
from adibas.markers.detection import DetectionParams, find_color_markers, spots_with_features
from adibas.markers.faint import (
    FaintParams,
    find_spots,
    in_other_light,
    likely_groups,
    look_features,
    ways_to_marker,
)
from adibas.markers.lab import rgb_to_lab
from adibas.markers.spot_odds import crowd_size

SIZE = (120, 160)
SKIN, DARK_SKIN = np.array([200.0, 150, 125]), np.array([85.0, 50, 35])
GREEN, WHITE = np.array([40.0, 150, 70]), np.array([215.0, 215, 210])
WALL, TROUSERS = np.array([170.0, 180, 140]), np.array([50.0, 35, 30])
FOCAL_PX, FAR_M = 1050.0, 3.5
SAMPLES = 12
PLACES = [(30.3, 30.6), (80.7, 30.2), (130.1, 30.9), (30.5, 80.4), (80.2, 80.8), (130.6, 80.1)]
BODY = np.ones(SIZE, np.bool_)
DEPTH_M = np.full(SIZE, FAR_M, np.float32)


def lab_of(color):
    return rgb_to_lab(np.rint(color).astype(np.uint8)[None, None])[0, 0].astype(float)


MODEL = ColorModel(lab_of(GREEN)[None], 12.0)


def share_of(is_inside):
    """Return the share of every pixel where a function of (rows, columns) is true."""
    steps = (np.arange(SAMPLES) + 0.5) / SAMPLES - 0.5
    rows = (np.arange(SIZE[0])[:, None] + steps).ravel()[:, None]
    columns = (np.arange(SIZE[1])[:, None] + steps).ravel()
    fine = is_inside(rows, columns)
    return fine.reshape(SIZE[0], SAMPLES, SIZE[1], SAMPLES).mean(axis=(1, 3))[..., None]


def discs(radius_px, places=PLACES):
    return share_of(
        lambda rows, columns: np.any(
            [(columns - u) ** 2 + (rows - v) ** 2 <= radius_px**2 for u, v in places], axis=0
        )
    )


def seen(picture, seed=0, noise=2.0):
    """Return the picture as a colour camera has it: lens, noise, one colour in each pixel."""
    blurred = cv2.GaussianBlur(picture, (0, 0), 0.7)
    blurred += np.random.default_rng(seed).normal(0, noise, blurred.shape)
    blurred = np.clip(np.rint(blurred), 0, 255).astype(np.uint8)
    mosaic = blurred[..., 1].copy()
    mosaic[::2, ::2], mosaic[1::2, 1::2] = blurred[::2, ::2, 0], blurred[1::2, 1::2, 2]
    return cv2.cvtColor(mosaic, cv2.COLOR_BayerRGGB2RGB)


def on(background, radius_px, color=GREEN, light=1.0):
    share = discs(radius_px)
    return seen((share * color + (1 - share) * background) * light)


def find(picture, params=None):
    return find_color_markers(picture, BODY, DEPTH_M, FOCAL_PX, MODEL, params or DetectionParams())


def n_right(blobs, places=PLACES, gate_px=1.0):
    return sum(any(np.hypot(b.u - u, b.v - v) < gate_px for b in blobs) for u, v in places)


@pytest.mark.parametrize("background", [SKIN, WHITE, DARK_SKIN], ids=["skin", "white", "dark"])
@pytest.mark.parametrize("radius_px", [1.5, 1.8, 2.1])
def test_stickers_of_three_pixels_are_all_found_and_nothing_else(background, radius_px):
    picture = on(background, radius_px)
    blobs = find(picture).blobs
    assert n_right(blobs) == len(blobs) == len(PLACES)


@pytest.mark.parametrize("light", [0.7, 1.25, np.array([1.1, 1.0, 0.8])])
def test_they_are_found_in_other_light_than_the_one_they_were_learned_in(light):
    blobs = find(on(SKIN, 1.5, light=light)).blobs
    assert n_right(blobs) == len(blobs) == len(PLACES)


@pytest.mark.parametrize("background", [SKIN, WHITE, DARK_SKIN], ids=["skin", "white", "dark"])
def test_stickers_of_two_pixels_are_found_in_a_mean_picture(background):
    share = discs(0.95)
    picture = seen(share * GREEN + (1 - share) * background, noise=0.3)
    of_mean = FaintParams(least_rise=1.5, least_log_odds=0.0)
    blobs = find(picture, DetectionParams(faint=of_mean)).blobs
    assert n_right(blobs) == len(blobs) == len(PLACES)


def test_a_large_sticker_on_cloth_not_unlike_it_is_found():
    cloth = 0.7 * GREEN + 0.3 * np.array([90.0, 90, 90])
    blobs = find(on(cloth, 4.0)).blobs
    assert n_right(blobs) == len(blobs) == len(PLACES)


@pytest.mark.parametrize("color", [(190, 190, 60), (60, 160, 190), (200, 60, 50), (90, 80, 190)])
def test_spots_of_another_colour_are_no_markers(color):
    for background in (SKIN, DARK_SKIN, WHITE):
        assert find(on(background, 1.5, np.array(color, float))).blobs == ()


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("background", [SKIN, WHITE, DARK_SKIN], ids=["skin", "white", "dark"])
def test_the_noise_of_a_dark_picture_is_no_marker(background, seed):
    picture = seen(np.broadcast_to(background, (*SIZE, 3)).astype(float), seed, noise=8.0)
    assert find(picture).blobs == ()


@pytest.mark.parametrize("half_width_px", [1.2, 1.7])
@pytest.mark.parametrize("number", range(6))
def test_the_tips_of_a_wall_seen_between_legs_are_no_markers(number, half_width_px):
    tips = [(30.3 + 0.37 * number, 40.2), (80.1, 50.6 + 0.3 * number), (130.7, 44.4)]
    gaps = share_of(
        lambda rows, columns: np.any(
            [
                (np.abs(columns - u) < half_width_px + 0.03 * (rows - v)) & (rows > v)
                for u, v in tips
            ],
            axis=0,
        )
    )
    assert find(seen(gaps * WALL + (1 - gaps) * TROUSERS, number)).blobs == ()


@pytest.mark.parametrize("red", [(160, 25, 35), (190, 40, 50)])
def test_a_wall_seen_through_a_hole_in_red_trousers_is_no_marker(red):
    """Grey is as far from red as green is, on nearly the same way."""
    picture = on(np.array(red, float), 2.0, np.array([90.0, 120, 110]))
    assert find(picture).blobs == ()


@pytest.mark.parametrize("radius_px", [1.5, 2.0])
def test_stickers_on_the_border_of_two_colours_are_found(radius_px):
    """The mean of the surroundings says nothing of either side; a closing does."""
    share = discs(radius_px, [(80.2, 20.0), (80.4, 50.3), (79.8, 80.7), (81.5, 105.1)])
    border = np.where(np.arange(SIZE[1])[:, None] < 80, SKIN, TROUSERS)[None]
    picture = seen(share * GREEN + (1 - share) * border)
    blobs = find(picture).blobs
    assert len(blobs) == 4
    assert n_right(blobs, [(80.2, 20.0), (80.4, 50.3), (79.8, 80.7), (81.5, 105.1)]) == 4


def measured(picture, places):
    """Return the blobs of 5x5 pixels about places."""
    lab = rgb_to_lab(picture)
    distance = np.linalg.norm(lab - MODEL.centroids_lab[0], axis=2).astype(np.float32)
    seeds = np.zeros(SIZE, np.bool_)
    for u, v in places:
        seeds[round(v) - 2 : round(v) + 3, round(u) - 2 : round(u) + 3] = True
    groups = connected_groups(seeds, np.zeros(SIZE, np.bool_))
    return groups, distance, measure_blobs(lab, distance, groups)


def on_the_way(picture, params=None):
    """Say of the spot at the first place whether it can be a marker, if its form is right."""
    params = params or FaintParams()
    groups, distance, _ = measured(picture, PLACES[:1])
    colors_lab = in_other_light(MODEL.centroids_lab, params.light_range)
    looks = look_at(rgb_to_lab(picture), distance, groups, 0.15)
    likely = likely_groups(groups, looks, colors_lab, 0.15, params)
    assert len(likely.looks) == len(likely.groups[2]) - 1
    return len(likely.looks) > 0


@pytest.mark.parametrize(
    ("limit", "value"),
    [
        ("least_direction", 1.001),
        ("least_share", 1.3),
        ("greatest_aside", -1.0),
        ("least_log_odds", 500.0),
    ],
)
def test_each_limit_alone_refuses_a_spot(limit, value):
    assert on_the_way(on(SKIN, 1.8))
    assert not on_the_way(on(SKIN, 1.8), FaintParams(**{limit: value}))


def features_of(picture, lightness_weight):
    """Return the blob at the first place, how it looks, and the features of that."""
    groups, distance, (blob,) = measured(picture, PLACES[:1])
    colors_lab = in_other_light(MODEL.centroids_lab, 1.5)
    looks = look_at(rgb_to_lab(picture), distance, groups, lightness_weight)
    return blob, looks, look_features(looks, ways_to_marker(looks, colors_lab, lightness_weight))[0]


def test_what_the_odds_go_by_is_what_the_spot_is():
    blob, looks, features = features_of(on(SKIN, 1.8), 1.0)
    unexplained, aside, log_separation, log_contrast, middle, against, log_share = features
    way = blob.core - blob.surround
    assert unexplained == blob.unexplained
    assert (middle, against**2) == pytest.approx((looks.middle[0], looks.against[0]))
    assert np.exp(log_separation) == pytest.approx(blob.separation)
    assert np.exp(log_contrast) == pytest.approx(np.linalg.norm(way))
    colors_lab = in_other_light(MODEL.centroids_lab, 1.5)
    off = np.cross(way, colors_lab - blob.surround)
    lengths = np.linalg.norm(colors_lab - blob.surround, axis=1)
    beside = np.linalg.norm(off, axis=1) / lengths
    assert aside == pytest.approx(beside.min(), rel=1e-3)
    along = ((colors_lab - blob.surround) @ way / lengths**2)[beside.argmin()]
    assert np.exp(log_share) == pytest.approx(along, rel=1e-3)


def test_a_surround_without_noise_makes_no_spot_clearer_than_those_learned_from():
    one = np.ones(1)
    colors = np.zeros((1, 3)), np.array([[0.0, -9.0, 3.0]])
    looks = [Looks(one * apart, one, one, one, *colors) for apart in (20.0, 60.0, 1e3)]
    rows = [look_features(one, ways_to_marker(one, MODEL.centroids_lab, 0.15))[0] for one in looks]
    assert rows[0][2] == pytest.approx(np.log(20.0))
    np.testing.assert_array_equal(rows[1], rows[2])


def test_a_middle_that_is_nothing_but_noise_counts_no_more_than_a_clear_one():
    one = np.ones(1)
    colors = np.zeros((1, 3)), np.array([[0.0, -9.0, 3.0]])
    looks = [Looks(one, one, one * middle, one, *colors) for middle in (-9.0, -1.0, 2.5, 9.0)]
    rows = [look_features(one, ways_to_marker(one, MODEL.centroids_lab, 0.15))[0] for one in looks]
    np.testing.assert_array_equal(rows[0], rows[1])
    np.testing.assert_array_equal(rows[2], rows[3])


@pytest.mark.parametrize("noise", [2.0, 8.0])
def test_faint_markers_are_the_likely_ones_of_the_spots_that_are_learned_from(noise):
    share = discs(1.1)
    picture = seen(share * GREEN + (1 - share) * SKIN, noise=noise)
    faint = FaintParams(least_rise=1.5)
    every = DetectionParams(faint=replace(faint, least_log_odds=-np.inf))
    none = DetectionParams(faint=replace(faint, least_log_odds=np.inf))
    spots = spots_with_features(picture, BODY, DEPTH_M, FOCAL_PX, MODEL, every)
    odds, rows = faint.odds, np.array([row for _, row in spots])
    n_crowd = crowd_size(odds.alone_in_best_form(rows[:, :-1]))
    assert (n_crowd > 0) == (noise > 2.0)
    likely = odds.among(odds.alone(rows), n_crowd) >= faint.least_log_odds
    chosen = [blob for (blob, _), is_one in zip(spots, likely, strict=True) if is_one]
    found = find(picture, DetectionParams(faint=faint)).blobs
    assert find(picture, none).blobs == ()
    assert {(blob.u, blob.v) for blob in chosen if blob is not None} == {
        (one.u, one.v) for one in found
    }
    assert len(found) >= 3
    assert all(one.is_faint for one in found)
    assert all(row[-1] == blob.axis_ratio for blob, row in spots if blob is not None)


def test_a_marker_of_few_pixels_is_told_by_the_odds_alone():
    """Nine pixels of its colour may as well be of a seam; the odds see what is about them."""
    no_spots = DetectionParams(faint=FaintParams(least_log_odds=np.inf))
    picture = np.broadcast_to(SKIN, (*SIZE, 3)).astype(np.uint8).copy()
    picture[40:43, 40:43] = picture[80:84, 80:84] = GREEN
    (large,) = find(picture, no_spots).blobs
    assert not large.is_faint
    assert (large.u, large.v) == pytest.approx((81.5, 81.5), abs=0.3)
    assert n_right(find(picture).blobs, [(41.0, 41.0), (81.5, 81.5)]) == 2


def test_where_nobody_is_there_is_no_spot():
    every = DetectionParams(faint=FaintParams(least_log_odds=-np.inf))
    assert spots_with_features(on(SKIN, 1.1), ~BODY, DEPTH_M, FOCAL_PX, MODEL, every) == ()


def test_of_a_disc_the_middle_is_full_and_nothing_about_it_goes_the_other_way():
    _, looks, _ = features_of(on(SKIN, 3.0), 0.15)
    assert looks.middle[0] == pytest.approx(1.0, abs=0.1)
    assert looks.against[0] < 0.12  # noise
    seam = on(SKIN, 3.0)
    seam[36:38, 28:33] = np.clip(SKIN + 0.8 * (SKIN - GREEN), 0, 255)
    assert features_of(seam, 0.15)[1].against[0] > 0.25


def test_the_way_is_to_the_colour_nearest_in_direction():
    nothing = np.zeros(2)
    cores = np.array([[9.0, 2.0, 0.5], [0.0, -3.0, 4.0]])
    looks = Looks(nothing, nothing, nothing, nothing, np.zeros((2, 3)), cores)
    way = ways_to_marker(looks, np.array([[0.0, 8.0, 0.0], [0.0, 0.0, 5.0]]), 0.0)
    np.testing.assert_allclose(way.direction, [2.0 / np.hypot(2.0, 0.5), 0.8])
    np.testing.assert_allclose(way.share, [0.25, 0.8])
    np.testing.assert_allclose(way.contrast, [np.hypot(2.0, 0.5), 5.0])
    np.testing.assert_allclose(way.aside, [0.5, 3.0])


def test_a_colour_is_on_the_way_from_its_surround_to_the_markers_and_not_beyond_or_beside():
    ways = {0.3: True, 0.6: True, -0.3: False}
    for share, wanted in ways.items():
        mixed = SKIN + share * (GREEN - SKIN)
        picture = on(SKIN, 3.0, np.clip(mixed, 0, 255))
        assert on_the_way(picture, FaintParams(least_log_odds=-1e9)) is wanted


def spots_by_brute_force(distance, free, params):
    """Return the sets of pixels of the spots, highest first."""
    square = np.ones((params.spot_px, params.spot_px))
    closed = ndimage.grey_closing(distance, footprint=square, mode="nearest")
    rise = closed - distance
    is_high = (rise > params.least_rise) & (rise > params.least_rise_share * closed)
    is_peak = (rise == ndimage.maximum_filter(rise, 3)) & free & is_high
    is_peak[[0, -1]] = is_peak[:, [0, -1]] = False
    left, found = free.copy(), []
    for row, column in sorted(np.argwhere(is_peak), key=lambda at: -rise[tuple(at)]):
        if not left[row, column]:
            continue
        window = np.zeros_like(free)
        reach = params.spot_px // 2
        window[
            max(row - reach, 0) : row + reach + 1, max(column - reach, 0) : column + reach + 1
        ] = True
        within = window & left & (rise > params.group_share * rise[row, column])
        labels, _ = ndimage.label(within, np.ones((3, 3)))
        own = labels == labels[row, column]
        left &= ~own
        found.append({tuple(at) for at in np.argwhere(own).tolist()})
    return found


def as_sets(groups):
    rows, columns, starts = groups
    pixels = list(zip(rows.tolist(), columns.tolist(), strict=True))
    return [set(pixels[a:b]) for a, b in itertools.pairwise(starts)]


@pytest.mark.parametrize("seed", range(5))
def test_spots_are_the_peaks_of_what_a_closing_fills_and_what_hangs_on_them(seed):
    rng = np.random.default_rng(seed)
    distance = ndimage.gaussian_filter(rng.uniform(0.0, 200.0, (40, 50)), 1.0).astype(np.float32)
    free = rng.uniform(size=distance.shape) < 0.9
    params = FaintParams(spot_px=9, least_rise=20.0, least_rise_share=0.3, group_share=0.6)
    wanted = spots_by_brute_force(distance, free, params)
    assert as_sets(find_spots(distance, free, params)) == wanted
    assert len(wanted) > 10
    assert max(map(len, wanted)) > 5


def test_of_two_equal_neighbours_one_is_a_peak():
    distance = np.full((30, 30), 50.0, np.float32)
    distance[10, 10:12] = distance[20:22, 20] = 30.0
    free = np.ones((30, 30), np.bool_)
    found = as_sets(find_spots(distance, free, FaintParams()))
    assert found == [{(10, 10), (10, 11)}, {(20, 20), (21, 20)}]


def test_a_picture_without_a_spot_has_none():
    free = np.ones((30, 30), np.bool_)
    assert as_sets(find_spots(np.full((30, 30), 50.0, np.float32), free, FaintParams())) == []
