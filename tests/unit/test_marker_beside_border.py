"""A sticker beside the border of a garment: its centre stays where the sticker is."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import lsq_linear, nnls

from adibas.markers.blobs import connected_groups, measure_blobs
from adibas.markers.border_kernels import shares_beside_two, two_sides, unexplained
from adibas.markers.lab import rgb_to_lab

SIZE, SAMPLES = 40, 12
RADIUS_PX = 2.2
"""Of an 8 mm sticker at 2 m."""
STICKER = (30, 150, 60)
SKIN = (205, 150, 125)
CLOTHS = {
    "dark blue": (35, 40, 85),
    "white": (235, 235, 230),
    "red": (160, 40, 45),
    "black": (25, 25, 25),
    "grey": (110, 112, 115),
}
ANGLES_RAD = np.arange(8) * math.pi / 4 + 0.2
OFFSETS_PX = (-3.5, -2.5, -1.5, -0.5, 0.5, 1.5, 2.5, 3.5)
NO_BORDER = (0.0, 1e3)
STICKER_LAB = rgb_to_lab(np.full((1, 1, 3), STICKER, np.uint8))[0, 0].astype(float)


def linear(color):
    return (np.array(color) / 255.0) ** 2.2


def rendered(centre, border, cloth, noise=0.0):
    """Return the picture of a disc on a border, mixed in light, and its distance to the sticker.

    `border` is (angle, offset): the cloth begins at this distance from the disc's centre.
    """
    steps = (np.arange(SIZE * SAMPLES) + 0.5) / SAMPLES - 0.5
    u, v = np.meshgrid(steps - centre[0], steps - centre[1])
    angle_rad, offset_px = border
    is_cloth = u * math.cos(angle_rad) + v * math.sin(angle_rad) > offset_px
    light = np.where(is_cloth[..., None], linear(cloth), linear(SKIN))
    light[np.hypot(u, v) < RADIUS_PX] = linear(STICKER)
    light = light.reshape(SIZE, SAMPLES, SIZE, SAMPLES, 3).mean(axis=(1, 3))
    rng = np.random.default_rng(3)
    rgb = 255.0 * light ** (1 / 2.2) + rng.normal(0.0, 1.0, light.shape) * noise
    lab = rgb_to_lab(np.clip(np.round(rgb), 0, 255).astype(np.uint8))
    distance = np.linalg.norm((lab - STICKER_LAB) * (0.4, 1.0, 1.0), axis=2)
    return lab, distance.astype(np.float32)


def centre_error_px(centre, border, cloth, noise=0.0):
    lab, distance = rendered(centre, border, cloth, noise)
    groups = connected_groups(distance < 22.0, np.zeros(distance.shape, np.bool_))
    blobs = measure_blobs(lab, distance, groups)
    return min(math.hypot(blob.u - centre[0], blob.v - centre[1]) for blob in blobs)


@pytest.mark.parametrize("cloth", CLOTHS.values(), ids=CLOTHS)
def test_the_centre_beside_a_border_is_right_to_a_quarter_of_a_pixel(cloth):
    errors_px = [
        centre_error_px((19.3, 20.4), (angle_rad, offset_px), cloth, noise=2.0)
        for angle_rad in ANGLES_RAD
        for offset_px in OFFSETS_PX
    ]
    assert max(errors_px) < 0.25
    assert np.mean(errors_px) < 0.12


@pytest.mark.parametrize("noise", [0.0, 3.0])
def test_beside_no_border_the_centre_is_right_to_a_twentieth_of_a_pixel(noise):
    assert centre_error_px((19.3, 20.4), NO_BORDER, SKIN, noise) < 0.05


def ring_of(picture_lab):
    """Return the colours between 5 and 8 pixels from the middle, and their median."""
    rows, columns = np.indices(picture_lab.shape[:2]) - SIZE // 2
    distance_px = np.hypot(rows, columns)
    ring = picture_lab[(distance_px > 5) & (distance_px < 8)].astype(float).T.copy()
    return ring, median_of(ring)


def median_of(ring):
    return np.median(ring, axis=1)


@pytest.mark.parametrize("offset_px", [-4.0, 0.0, 4.0])
def test_the_colours_on_both_sides_are_found(offset_px):
    lab, _ = rendered((19.3, 20.4), (0.7, offset_px), CLOTHS["red"], noise=2.0)
    sides_lab, are_two = two_sides(*ring_of(lab), STICKER_LAB)
    assert are_two
    wanted = rgb_to_lab(np.array([[SKIN, CLOTHS["red"]]], np.uint8))[0]
    by_redness = sides_lab[np.argsort(sides_lab[:, 1])]
    np.testing.assert_allclose(by_redness, wanted, atol=2.0)


def test_noise_and_shading_have_no_two_sides():
    rng = np.random.default_rng(5)
    skin_lab = rgb_to_lab(np.full((SIZE, SIZE, 3), SKIN, np.uint8))
    shading = np.linspace(-6.0, 6.0, SIZE)[:, None, None] * (1.0, 0.2, 0.2)
    for picture_lab in (skin_lab, skin_lab + shading):
        noisy_lab = picture_lab + rng.normal(0.0, 2.0, picture_lab.shape)
        assert not two_sides(*ring_of(noisy_lab), STICKER_LAB)[1]


def test_a_few_other_pixels_are_no_side():
    ring = np.tile(np.array([[60.0], [20.0], [20.0]]), 100)
    ring[:, :10] = np.array([[30.0], [0.0], [-20.0]])
    assert not two_sides(ring, median_of(ring), STICKER_LAB)[1]


def test_a_marker_whose_colour_both_sides_can_mix_is_not_told_by_them():
    ring = np.repeat(np.array([[20.0, 90.0], [0.0, 5.0], [0.0, 5.0]]), 50, axis=1)
    surround = median_of(ring)
    assert two_sides(ring, surround, STICKER_LAB)[1]
    assert not two_sides(ring, surround, np.array([55.0, 4.0, 1.0]))[1]
    assert not two_sides(ring[:1].copy(), surround[:1], STICKER_LAB[:1])[1]


@given(st.integers(0, 2**32 - 1), st.sampled_from([0.0, 4.0]))
def test_shares_are_those_of_scipys_non_negative_least_squares(seed, noise):
    rng = np.random.default_rng(seed)
    sides_lab = np.array([[66.0, 18.0, 21.0], [20.0, 6.0, -25.0]])
    corners = np.vstack([STICKER_LAB, sides_lab])
    parts = rng.dirichlet((0.7, 0.7, 0.7), (4, 5))
    lab = parts @ corners + rng.normal(0.0, 1.0, (4, 5, 3)) * noise
    shares = shares_beside_two(lab.astype(np.float32), sides_lab, STICKER_LAB)
    sum_counts = 1e4
    system = np.vstack([corners.T, np.full(3, sum_counts)])
    wanted = np.array([nnls(system, [*pixel, sum_counts])[0][0] for pixel in lab.reshape(-1, 3)])
    is_inside = (shares.ravel() > 0.0) & (shares.ravel() < 1.0)
    np.testing.assert_allclose(shares.ravel()[is_inside], wanted[is_inside], atol=1e-3)
    if noise == 0.0:
        np.testing.assert_allclose(shares, parts[..., 0], atol=1e-4)


colors_lab = st.lists(
    st.tuples(*(st.floats(-60, 60) for _ in range(3))), min_size=1, max_size=8
).map(lambda colors: np.array(colors).T)


@given(colors_lab, colors_lab)
def test_what_no_colour_beside_a_spot_explains_is_scipys_least_squares(ring, others):
    surround, core = others[:, 0], others[:, -1] + 7.0
    left = [
        lsq_linear((color - surround)[:, None], core - surround, bounds=(0.0, 1.0)).cost
        for color in ring.T
        if np.linalg.norm(color - surround) > 1e-3
    ]
    contrast = np.linalg.norm(core - surround)
    wanted = min([math.sqrt(2 * cost) / contrast for cost in left], default=1.0)
    assert unexplained(ring, surround, core) == pytest.approx(wanted, abs=1e-4)


def test_of_brightness_alone_nothing_is_explained():
    assert unexplained(np.array([[1.0, 2.0, 3.0]]), np.array([1.0]), np.array([2.0])) == 1.0


def test_a_spot_that_is_its_surround_is_explained_by_nothing():
    ring = np.ones((3, 4))
    assert unexplained(ring, ring[:, 0], ring[:, 0]) == 1.0
