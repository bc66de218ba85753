"""Blobs are measured in compiled loops: held against NumPy, SciPy and closed forms."""

import math
from dataclasses import replace

import cv2
import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy import ndimage
from scipy.sparse.csgraph import connected_components

from adibas.markers.blob_kernels import _widened
from adibas.markers.blobs import (
    BLUR_PX2,
    LEAST_TOLD_PX,
    SPECK_REACH_PX,
    Blob,
    BlobParams,
    connected_groups,
    depth_near,
    joined_specks,
    judge,
    long_radius_px,
    look_at,
    measure_blobs,
    pixels_of,
)
from adibas.markers.quantile_kernels import quantile

SIZE = 48
SKIN_LAB, STICKER_LAB = np.array([65.0, 15.0, 20.0]), np.array([50.0, -40.0, 30.0])
masks = arrays(np.bool_, (9, 12))


def disc_picture(u, v, radius_px, noise=0.0):
    """Return Lab of a sticker on skin with a soft rim, its distance to the model, its pixels."""
    rows, columns = np.mgrid[:SIZE, :SIZE]
    share = np.clip(radius_px + 0.5 - np.hypot(columns - u, rows - v), 0, 1)[..., None]
    lab = share * STICKER_LAB + (1 - share) * SKIN_LAB
    lab += np.random.default_rng(1).normal(0, 1, lab.shape) * noise
    distance = np.linalg.norm(lab - STICKER_LAB, axis=2)
    return lab.astype(np.float32), distance.astype(np.float32), distance < 20


def measured(lab, distance, seeds):
    groups = connected_groups(seeds, np.zeros(seeds.shape, bool))
    return measure_blobs(lab, distance, groups)


@pytest.mark.parametrize("radius_px", [1, 3, 9])
def test_middle_and_ring_are_those_of_a_weighted_least_squares(radius_px):
    rng = np.random.default_rng(radius_px)
    lab, distance, _ = disc_picture(24, 23, radius_px)
    lab += rng.normal(0, 8, lab.shape).astype(np.float32)
    seeds = np.zeros((SIZE, SIZE), bool)
    seeds[23 - radius_px : 24 + radius_px, 24 - radius_px : 25 + radius_px] = True
    groups = connected_groups(seeds, np.zeros(seeds.shape, bool))
    weights = np.array([0.15, 1.0, 1.0])
    looks = look_at(lab, distance, groups, 0.15)
    way = np.sqrt(weights) * (looks.core[0] - looks.surround[0])
    off = np.sqrt(weights) * (lab - looks.surround[0])
    shares = np.linalg.lstsq(way[:, None], off.reshape(-1, 3).T, rcond=None)[0].reshape(SIZE, SIZE)
    near = ndimage.binary_dilation(seeds, np.ones((5, 5)))
    reach = max(3, round(0.8 * math.sqrt(seeds.sum())))
    ring = ndimage.binary_dilation(near, np.ones((2 * reach + 1, 2 * reach + 1))) & ~near
    assert looks.middle[0] == pytest.approx(shares[22:25, 23:26].mean(), rel=1e-4)
    assert looks.against[0] == pytest.approx(-shares[ring].min(), rel=1e-4)
    np.testing.assert_allclose(looks.surround[0], np.median(lab[ring], axis=0), rtol=1e-6)


def test_a_spot_is_explained_by_whatever_is_like_it_in_its_ring():
    """As are the dots that the mosaic leaves along a seam."""
    lab, distance, seeds = disc_picture(24, 23, 2.0)
    assert measured(lab, distance, seeds)[0].unexplained > 0.9
    lab[29, 24] = 0.2 * SKIN_LAB + 0.8 * STICKER_LAB
    distance[29, 24] = np.linalg.norm(lab[29, 24] - STICKER_LAB)
    assert measured(lab, distance, seeds)[0].unexplained < 0.3


@given(masks, masks)
def test_groups_are_scipys_components_without_those_that_touch_a_taken_pixel(seeds, taken):
    groups = connected_groups(seeds, taken)
    found = {
        frozenset(zip(*(axis.tolist() for axis in pixels_of(groups, index)), strict=True))
        for index in range(len(groups[2]) - 1)
    }
    labels, n_labels = ndimage.label(seeds, np.ones((3, 3)))
    wanted = {
        frozenset(map(tuple, np.argwhere(labels == label).tolist()))
        for label in range(1, n_labels + 1)
        if not (taken & (labels == label)).any()
    }
    assert found == wanted


def pixel_sets(groups):
    return [
        frozenset(zip(*(axis.tolist() for axis in pixels_of(groups, index)), strict=True))
        for index in range(len(groups[2]) - 1)
    ]


OUT_OF_ORDER = np.zeros((9, 12), bool)
OUT_OF_ORDER[[3, 7, 6], [0, 0, 2]] = True
"""OpenCV numbers the last of these specks after the one below it."""


@given(masks)
@example(OUT_OF_ORDER)
def test_specks_near_to_one_another_are_one_group_and_larger_groups_stay(seeds):
    apart = connected_groups(seeds, np.zeros(seeds.shape, bool))
    specks = [group for group in pixel_sets(apart) if len(group) < LEAST_TOLD_PX]
    away = [
        [min(max(abs(a - c), abs(b - d)) for a, b in one for c, d in other) for other in specks]
        for one in specks
    ]
    are_near = np.array(away).reshape(len(specks), len(specks)) <= SPECK_REACH_PX
    n_joined, label = connected_components(are_near, directed=False)
    wanted = {
        frozenset().union(*(specks[i] for i in np.flatnonzero(label == one)))
        for one in range(n_joined)
    }
    wanted |= set(pixel_sets(apart)) - set(specks)
    joined = pixel_sets(joined_specks(apart))
    assert set(joined) == wanted
    assert len(joined) == len(wanted)


@given(masks, st.integers(1, 6))
def test_widening_is_dilation_by_a_square(mask, reach):
    square = np.ones((2 * reach + 1, 2 * reach + 1), np.uint8)
    image = mask.astype(np.uint8)
    np.testing.assert_array_equal(_widened(image, reach), cv2.dilate(image, square))


@given(
    arrays(np.float64, st.integers(1, 40), elements=st.floats(-1e3, 1e3)),
    st.sampled_from([0.0, 0.2, 0.5, 1.0]),
)
def test_quantiles_are_numpys(values, share):
    wanted = np.quantile(values, share)
    assert quantile(values.copy(), share) == pytest.approx(wanted, abs=1e-9)


def test_the_quantile_of_nothing_is_unknown():
    assert math.isnan(quantile(np.empty(0), 0.5))


@pytest.mark.parametrize("centre", [(20.0, 22.0), (20.3, 22.4), (23.5, 19.5)])
@pytest.mark.parametrize("radius_px", [1.5, 3.2, 6.0])
def test_a_disc_is_measured_where_and_as_large_as_it_is(centre, radius_px):
    (blob,) = measured(*disc_picture(*centre, radius_px))
    assert (blob.u, blob.v) == pytest.approx(centre, abs=0.06)
    assert blob.radius_px == pytest.approx(radius_px, rel=0.06)
    assert blob.axis_ratio > 0.95


def test_an_ellipse_is_as_long_as_it_is():
    rows, columns = np.mgrid[: 8 * SIZE, : 8 * SIZE] / 8.0
    along, across = (columns + rows - 46) / math.sqrt(2), (columns - rows) / math.sqrt(2)
    fine = (along / 9.0) ** 2 + (across / 4.5) ** 2 < 1
    share = fine.reshape(SIZE, 8, SIZE, 8).mean(axis=(1, 3))[..., None]
    lab = (share * STICKER_LAB + (1 - share) * SKIN_LAB).astype(np.float32)
    distance = np.linalg.norm(lab - STICKER_LAB, axis=2).astype(np.float32)
    (blob,) = measured(lab, distance, distance < 50)
    weights = np.where(share > 0.12, share, 0).ravel()
    pixels = np.indices((SIZE, SIZE)).reshape(2, -1)
    spread = np.cov(pixels, aweights=weights, ddof=0) + np.eye(2) / 12
    short, long = np.sqrt(np.linalg.eigvalsh(spread))
    assert blob.axis_ratio == pytest.approx(short / long, rel=1e-4)
    assert blob.axis_ratio == pytest.approx(0.5, rel=0.05)
    assert blob.radius_px == pytest.approx(math.sqrt(9.0 * 4.5), rel=0.05)


@pytest.mark.parametrize("slant_deg", [0.0, 30.0, 50.0, 65.0])
@pytest.mark.parametrize("radius_px", [2.5, 4.0, 8.0])
def test_a_blurred_sticker_is_as_large_however_slantingly_it_is_seen(radius_px, slant_deg):
    fine = 8
    rows, columns = (np.mgrid[: fine * SIZE, : fine * SIZE] + 0.5) / fine
    across = (columns - 24.3) / math.cos(math.radians(slant_deg))
    sharp = ((rows - 23.8) ** 2 + across**2 < radius_px**2).astype(np.float32)
    # The program adds a pixel's own variance, 1/12, and the mean over each pixel as much.
    blurred = cv2.GaussianBlur(sharp, (0, 0), fine * math.sqrt(BLUR_PX2 - 2.0 / 12.0))
    share = blurred.reshape(SIZE, fine, SIZE, fine).mean(axis=(1, 3))[..., None]
    lab = (share * STICKER_LAB + (1 - share) * SKIN_LAB).astype(np.float32)
    distance = np.linalg.norm(lab - STICKER_LAB, axis=2).astype(np.float32)
    (blob,) = measured(lab, distance, share[..., 0] > 0.3)
    found_px = long_radius_px(blob.radius_px, blob.axis_ratio)
    assert found_px == pytest.approx(radius_px, abs=0.35)


@given(st.floats(0.5, 20.0), st.floats(0.2, 1.0))
def test_the_long_axis_is_that_of_the_ellipse_with_such_an_area_and_blurred_ratio(long_px, ratio):
    short_px = ratio * long_px
    blurred = [axis**2 / 4.0 + BLUR_PX2 for axis in (short_px, long_px)]
    radius_px = math.sqrt(long_px * short_px)
    found_px = long_radius_px(radius_px, math.sqrt(blurred[0] / blurred[1]))
    assert found_px == pytest.approx(long_px, rel=1e-9)


def test_the_centres_covariance_is_that_of_many_noisy_pictures():
    noise = 2.0
    lab, distance, seeds = disc_picture(20.0, 22.0, 4.0, noise)
    (blob,) = measured(lab, distance, seeds)
    contrast = np.linalg.norm(STICKER_LAB - SKIN_LAB)
    assert blob.separation == pytest.approx(contrast / noise, rel=0.25)
    area = math.pi * 4.0**2
    variance = (noise / contrast) ** 2 * (area * 4.0**2 / 4) / area**2
    np.testing.assert_allclose(np.diag(blob.covariance_px2), variance, rtol=0.8)


def test_a_group_like_its_surround_stays_where_it_is_and_is_no_marker():
    lab, distance, _ = disc_picture(20.0, 22.0, 0.0)
    seeds = np.zeros(distance.shape, bool)
    seeds[21:24, 19:22] = True
    (blob,) = measured(lab, distance, seeds)
    assert (blob.u, blob.v) == (20.0, 22.0)
    depth_m = np.full((SIZE, SIZE), 2.0, np.float32)
    assert not isinstance(judge(blob, np.zeros(2), depth_m, 1050.0, BlobParams()), Blob)


def test_the_border_of_the_picture_is_no_trouble():
    lab, distance, seeds = disc_picture(0.0, 0.0, 4.0)
    (blob,) = measured(lab, distance, seeds)
    assert 0 < blob.u < 4
    assert 0 < blob.v < 4


def test_only_refusals_that_a_user_would_ask_about_are_told():
    depth_m = np.full((SIZE, SIZE), 2.0, np.float32)
    told = {}
    for radius_px in (0.6, 1.8, 9.0):
        (blob,) = measured(*disc_picture(22.0, 22.0, radius_px))
        focal_px = 1050.0 if radius_px < 9.0 else 400.0
        told[radius_px] = judge(blob, np.zeros(2), depth_m, focal_px, BlobParams())
    assert told[0.6] is None
    assert isinstance(told[1.8], Blob)
    assert told[9.0].reason == "too large for a marker at that distance"


@pytest.mark.parametrize(
    ("n_pixels", "is_marker"), [(LEAST_TOLD_PX - 1, False), (LEAST_TOLD_PX, True)]
)
def test_a_speck_that_colours_beside_it_explain_is_no_marker_and_told_to_nobody(
    n_pixels, is_marker
):
    depth_m = np.full((SIZE, SIZE), 2.0, np.float32)
    (blob,) = measured(*disc_picture(22.0, 22.0, 1.8))
    mixed = replace(blob, n_pixels=n_pixels, unexplained=0.4)
    judged = judge(mixed, np.zeros(2), depth_m, 1050.0, BlobParams())
    assert isinstance(judged, Blob) is is_marker
    assert is_marker or judged is None


def test_a_blob_of_too_few_pixels_is_too_faint_and_not_too_small():
    """Of a disc that is wide enough little may have the full colour: its size is not the reason."""
    depth_m = np.full((SIZE, SIZE), 2.0, np.float32)
    (blob,) = measured(*disc_picture(22.0, 22.0, 1.8))
    params = BlobParams(least_pixels=LEAST_TOLD_PX + 2)
    judged = [
        judge(replace(blob, n_pixels=n_pixels), np.zeros(2), depth_m, 1050.0, params)
        for n_pixels in (LEAST_TOLD_PX + 1, LEAST_TOLD_PX + 2)
    ]
    assert judged[0].reason == "too faint against its surroundings"
    assert isinstance(judged[1], Blob)


def test_depth_near_a_marker_is_the_median_of_what_is_known():
    depth_m = np.full((20, 20), np.nan, np.float32)
    assert depth_near(depth_m, 9.0, 9.0, 3.0) is None
    depth_m[8:11, 8:11] = [[2.0, 2.1, 2.2], [2.3, 2.4, 2.5], [2.6, 2.7, np.nan]]
    assert depth_near(depth_m, 9.0, 9.0, 3.0) == pytest.approx(2.35)
    assert depth_near(depth_m, 0.0, 0.0, 3.0) is None
