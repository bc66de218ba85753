"""Discs are drawn as geometry says: against closed forms and a drawing pixel by pixel."""

import numpy as np
import pytest

from adibas.data.discs import Discs
from adibas.geometry import disc_kernels
from adibas.geometry.disc_kernels import INSIDE, LIGHT, draw_discs

SHAPE = (60, 80)
TOWARDS_VIEWER = (0.0, 0.0, -1.0)
LOOPS = ("draw_discs", "_covered", "_bring_near", "_blend", "_hit", "_tilt", "_blended")


def drawn(places, normals, radii, colors=None, shape=SHAPE):
    n = len(places)
    colors = np.full((n, 3), 200) if colors is None else np.array(colors)
    return draw_discs(
        np.array(places, np.float32),
        np.array(normals, np.float32),
        np.array(radii, np.float32),
        colors.astype(np.uint8),
        shape,
    )


def ball(n, radius_px, middle):
    """Return evenly spread places on a sphere, their normals, and radii that leave no gap."""
    turn, height = np.arange(n) * np.pi * (3 - np.sqrt(5)), np.linspace(-1, 1, n)
    around = np.sqrt(1 - height**2)
    normals = np.column_stack([around * np.cos(turn), height, around * np.sin(turn)])
    spacing = radius_px * np.sqrt(4 * np.pi / n)
    return normals * radius_px + middle, normals, np.full(n, spacing)


def test_a_ball_of_discs_has_its_outline_and_its_depth():
    radius, middle = 24.0, np.array([41.3, 29.8, 100.0])
    _picture, is_drawn, nearest = drawn(*ball(3000, radius, middle))
    rows, columns = np.mgrid[: SHAPE[0], : SHAPE[1]] + 0.5
    off = np.hypot(columns - middle[0], rows - middle[1])
    assert is_drawn[off < radius - 1].all()
    assert not is_drawn[off > radius + 1].any()
    inner = off < 0.9 * radius
    true_px = middle[2] - np.sqrt(radius**2 - off[inner] ** 2)
    assert np.abs(nearest[inner] - true_px).max() < 0.5
    assert np.isinf(nearest[~is_drawn]).all()


@pytest.mark.parametrize("seed", range(20))
def test_a_slanted_disc_covers_the_pixels_that_it_covers_in_space(seed):
    rng = np.random.default_rng(seed)
    normal = rng.normal(size=3)
    normal[2] = -abs(normal[2]) - 0.5
    normal /= np.linalg.norm(normal)
    place, radius = np.array([*rng.uniform(0, 60, 2), 50.0]), rng.uniform(3, 20)
    _picture, is_drawn, nearest = drawn([place], [normal], [radius])
    for row in range(SHAPE[0]):
        for column in range(SHAPE[1]):
            # Where the line of sight of the pixel goes through the disc's plane.
            pixel = np.array([column + 0.5, row + 0.5, 0.0])
            away = (place - pixel) @ normal / normal[2]
            off = np.linalg.norm(pixel + np.array([0, 0, away]) - place)
            if abs(off - radius) > 1e-3:
                assert is_drawn[row, column] == (off < radius)
            if off < radius - 1e-3:
                assert nearest[row, column] == pytest.approx(away, abs=1e-3)


def test_what_is_nearer_hides_what_is_behind_in_either_order():
    places, colors = [(40, 30, 10), (40, 30, 30)], [(255, 0, 0), (0, 255, 0)]
    for order in ([0, 1], [1, 0]):
        picture, _is_drawn, nearest = drawn(
            [places[k] for k in order],
            [TOWARDS_VIEWER] * 2,
            [5, 9],
            [colors[k] for k in order],
        )
        red, green, _blue = picture[30, 40]
        assert red > 100
        assert green == 0
        assert nearest[30, 40] == 10


def test_colours_of_discs_that_lie_in_one_surface_run_into_each_other():
    picture, _is_drawn, _nearest = drawn(
        [(30, 30, 10), (40, 30, 10)],
        [TOWARDS_VIEWER] * 2,
        [9, 9],
        [(200, 0, 0), (0, 0, 200)],
    )
    reds, blues = picture[30, 22:48, 0].astype(int), picture[30, 22:48, 2].astype(int)
    assert (np.diff(reds) <= 0).all()
    assert (np.diff(blues) >= 0).all()
    assert reds[12] == pytest.approx(blues[12], abs=25)


def test_a_surface_is_brightest_towards_the_lamp_and_dim_inside():
    lamp = np.array(LIGHT) / np.linalg.norm(LIGHT)

    def brightness(normal):
        picture, _is_drawn, _nearest = drawn([(40, 30, 0)], [normal], [6])
        return int(picture[30, 40, 0])

    assert brightness(lamp) == pytest.approx(200, abs=1)
    assert brightness(lamp) > brightness(TOWARDS_VIEWER) > brightness((0.8, 0.0, -0.6))
    assert brightness(-lamp) == pytest.approx(200 * INSIDE, abs=1)
    assert brightness((np.nan, np.nan, np.nan)) == 200


def test_a_disc_smaller_than_a_pixel_is_seen_and_one_beside_the_picture_is_not():
    _picture, is_drawn, _nearest = drawn(
        [(10.2, 5.7, 0), (-30, 5, 0), (10, 90, 0)], [TOWARDS_VIEWER] * 3, [0.01, 4, 4]
    )
    assert is_drawn[5, 10]
    assert is_drawn.sum() <= 2


def test_the_compiled_loops_are_the_written_ones(monkeypatch):
    rng = np.random.default_rng(6)
    places = np.column_stack([rng.uniform(-9, [49, 39], (60, 2)), rng.uniform(0, 9, 60)])
    normals = rng.normal(size=(60, 3))
    normals[::7, 2] *= 0.01
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    normals[::11] = np.nan
    colors = rng.integers(0, 256, (60, 3))
    scene = (places, normals, rng.uniform(0.1, 9.0, 60), colors, (30, 40))
    compiled = drawn(*scene)
    for name in LOOPS:
        monkeypatch.setattr(disc_kernels, name, getattr(disc_kernels, name).py_func)
    monkeypatch.setattr("tests.unit.test_disc_drawing.draw_discs", disc_kernels.draw_discs)
    picture, is_drawn, nearest = drawn(*scene)
    # Rounding of single precision decides at borders.
    assert (is_drawn != compiled[1]).mean() < 0.002
    both = is_drawn & compiled[1]
    assert np.median(np.abs(nearest[both] - compiled[2][both])) < 1e-5
    assert (np.abs(picture[both].astype(int) - compiled[0][both]) > 1).mean() < 0.01


def test_fewer_discs_cover_as_much():
    places, normals, radii = ball(5000, 1.0, np.zeros(3))
    whole = Discs(
        places.astype(np.float32),
        normals.astype(np.float32),
        radii.astype(np.float32),
        np.zeros((5000, 3), np.uint8),
    )
    for most in (5000, 4999, 1200, 3):
        fewer = whole.at_most(most)
        assert len(fewer) <= most
        assert (fewer.radii_m**2).sum() == pytest.approx((radii**2).sum(), rel=0.01 + 1 / most)
    assert whole.at_most(5000) is whole
