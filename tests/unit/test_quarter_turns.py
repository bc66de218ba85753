"""A turned picture holds the same pixels, and each still looks along its own ray."""

import numpy as np
import pytest

from adibas.geometry.distortion import pixel_rays
from adibas.geometry.picture_edges import cut_px, seen_box
from adibas.geometry.pinhole import Intrinsics
from adibas.geometry.planes import Plane
from adibas.geometry.quarter_turns import QuarterTurn

SIZE = (30, 40)
CAMERA = Intrinsics(35.0, 36.5, 18.7, 14.1)
LENS = (0.1, -0.05, 0.003, -0.004, 0.02, 0.01, 0.005, -0.01, 0.002, -0.001, -0.003, 0.0015)
TURNS = [QuarterTurn(n_quarters) for n_quarters in range(4)]


def test_a_quarter_is_clockwise():
    picture = np.array([[1, 2], [3, 4], [5, 6]])
    assert TURNS[1].picture(picture).tolist() == [[5, 3, 1], [6, 4, 2]]
    assert TURNS[0].picture(picture) is picture


@pytest.mark.parametrize("turn", TURNS)
@pytest.mark.parametrize("n_coefficients", [0, 4, 5, 8, 12])
def test_every_pixel_looks_along_the_ray_that_it_looked_along_before(turn, n_coefficients):
    lens = LENS[:n_coefficients]
    rays = np.ones((*SIZE, 3))
    rays[..., :2] = pixel_rays(SIZE, CAMERA, lens)
    turned = pixel_rays(turn.size(SIZE), turn.intrinsics(CAMERA, SIZE), turn.distortion(lens))
    expected = turn.points(turn.picture(rays))[..., :2]
    np.testing.assert_allclose(turned, expected, rtol=0, atol=1e-12)


@pytest.mark.parametrize("turn", TURNS)
def test_what_is_turned_back_is_the_same_to_the_last_bit(turn):
    rng = np.random.default_rng(5)
    depth_m = rng.uniform(1.0, 3.0, SIZE).astype(np.float32)
    points_m = rng.normal(size=(15, 3))
    points_m[3] = np.nan
    back = turn.inverse()
    np.testing.assert_array_equal(back.picture(turn.picture(depth_m)), depth_m)
    np.testing.assert_array_equal(back.points(turn.points(points_m)), points_m)
    assert back.size(turn.size(SIZE)) == SIZE
    assert back.distortion(turn.distortion(LENS)) == LENS


@pytest.mark.parametrize("turn", TURNS)
def test_heights_over_the_floor_stay(turn):
    rng = np.random.default_rng(6)
    points_m = rng.normal(size=(20, 3))
    normal = rng.normal(size=3)
    floor = Plane(normal / np.linalg.norm(normal), 0.9)
    np.testing.assert_allclose(
        turn.plane(floor).signed_distance_m(turn.points(points_m)),
        floor.signed_distance_m(points_m),
        atol=1e-12,
    )


@pytest.mark.parametrize("turn", TURNS)
def test_an_edge_that_cuts_somebody_off_turns_with_the_picture(turn):
    measured = np.ones((80, 100), np.bool_)
    measured[:2] = measured[:, -1] = False
    person = np.zeros_like(measured)
    person[1:50, 10:30] = True
    box = turn.box(seen_box(measured), measured.shape)
    assert box == seen_box(turn.picture(measured))
    expected = turn.edges(tuple(cut_px(person, seen_box(measured)).tolist()))
    assert tuple(cut_px(turn.picture(person), box).tolist()) == expected
    assert sorted(expected) == [0, 0, 0, 20]


def test_more_than_three_quarters_are_refused():
    with pytest.raises(ValueError, match="n_quarters"):
        QuarterTurn(4)
