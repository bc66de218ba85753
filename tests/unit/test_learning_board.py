"""Clicks on one picture: regions come, follow the sensitivity, go, and make the colours."""

import numpy as np
import pytest

from adibas.errors import MarkerError
from adibas.markers.color_model import LearningParams
from adibas.markers.lab import lab_to_rgb, rgb_to_lab
from adibas.pipeline.learning_board import MOST_PIXELS, LearningBoard

WALL, GREEN, RED = (150, 140, 120), (60, 170, 80), (200, 40, 50)


def picture(n_shades=0):
    """Two discs, a green and a red one, on a wall; with a rim of so many shades about the green."""
    v, u = np.mgrid[:120, :160]
    color = np.full((120, 160, 3), WALL, np.uint8)
    from_green = np.hypot(u - 40, v - 60)
    for shade in range(n_shades, -1, -1):
        share = shade / (n_shades + 1)
        mixed = [
            round(share * wall + (1 - share) * own) for wall, own in zip(WALL, GREEN, strict=True)
        ]
        color[from_green < 10 + 3 * shade] = mixed
    color[np.hypot(u - 110, v - 60) < 8] = RED
    return color


@pytest.fixture
def board():
    return LearningBoard(picture(n_shades=4), LearningParams())


def test_a_click_takes_the_disc_and_its_colour(board):
    region = board.click(110, 60)
    v, u = np.mgrid[:120, :160]
    np.testing.assert_array_equal(region.pixels, np.hypot(u - 110, v - 60) < 8)
    assert region.n_pixels == region.pixels.sum()
    assert tuple(region.mean_rgb) == RED
    np.testing.assert_array_equal(board.taken(), region.pixels)


def test_the_last_region_follows_the_sensitivity_and_the_others_stay(board):
    first = board.click(110, 60)
    board.click(40, 60)
    sizes = []
    for sensitivity in (5.0, 15.0, 25.0, 35.0):
        board.set_sensitivity(sensitivity)
        assert board.regions[0] is first
        sizes.append(board.regions[1].n_pixels)
    assert sizes == sorted(set(sizes)), "each step takes more of the rim"
    board.set_sensitivity(5.0)
    assert board.regions[1].n_pixels == sizes[0]
    assert board.click(41, 60).sensitivity == 5.0, "and those to come have it, too"


def test_a_discarded_region_takes_its_pixels_along(board):
    green, red = board.click(40, 60), board.click(110, 60)
    board.discard(0)
    assert board.regions == (red,)
    assert not (board.taken() & green.pixels).any()
    board.discard(0)
    assert not board.taken().any()
    assert board.model() is None


def test_the_colours_are_those_of_the_stickers():
    board = LearningBoard(picture(), LearningParams())
    board.click(40, 60)
    board.click(110, 60)
    board.set_clusters(2)
    model = board.model()
    distances = np.abs(lab_to_rgb(model.centroids_lab).astype(int)[:, None] - [GREEN, RED]).max(2)
    assert sorted(distances.argmin(axis=1)) == [0, 1]
    assert distances.min(axis=1).max() <= 3
    assert model.source["n_pixels"] == board.taken().sum()
    assert len(model.source["seeds"]) == 2
    wall_lab = rgb_to_lab(np.array([[WALL]], np.uint8))[0, 0]
    assert np.linalg.norm(model.surround_lab[1] - wall_lab) < 1.0


def test_regions_that_grew_otherwise_are_said_so(board):
    board.click(40, 60)
    assert board.model().source["sensitivity"] == 20.0
    board.set_sensitivity(10.0)
    board.click(110, 60)
    board.set_sensitivity(30.0)
    assert board.model().source["sensitivity"] == [10.0, 30.0]


def test_the_same_clicks_give_the_same_colours_also_of_a_large_region():
    models = []
    for _ in range(2):
        board = LearningBoard(picture(), LearningParams())
        assert board.click(0, 0).n_pixels > MOST_PIXELS
        models.append(board.model())
    np.testing.assert_array_equal(models[0].centroids_lab, models[1].centroids_lab)
    assert np.abs(lab_to_rgb(models[0].centroids_lab).astype(int) - WALL).max() <= 1


def test_a_board_without_regions_is_for_the_same_picture_and_leaves_the_old_one(board):
    board.click(40, 60)
    board.set_sensitivity(44.0)
    empty = board.without_regions()
    assert (empty.regions, empty.params) == ((), LearningParams())
    assert empty.lab is board.lab
    assert len(board.regions) == 1
    board.set_sensitivity(3.0)
    empty.set_sensitivity(9.0)
    assert empty.params.sensitivity == 9.0
    assert empty.regions == ()


def test_a_click_beside_the_picture_is_told_and_adds_nothing(board):
    with pytest.raises(MarkerError, match="outside the picture"):
        board.click(160, 3)
    assert board.regions == ()
