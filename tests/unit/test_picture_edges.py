"""Where a picture ends, and what it cuts off there."""

import numpy as np
import pytest

from adibas.geometry.picture_edges import cut_px, seen_box

SHAPE = (100, 200)


def measured(rows=slice(None), columns=slice(None)):
    picture = np.zeros(SHAPE, bool)
    picture[rows, columns] = True
    return picture


def test_a_whole_picture_is_seen_to_its_edges():
    assert seen_box(measured()) == (0, 100, 0, 200)


def test_few_columns_without_depth_are_where_the_picture_ends():
    assert seen_box(measured(slice(2, 98), slice(5, 197))) == (2, 98, 5, 197)


def test_a_wide_margin_is_something_far_away_and_no_end_of_the_picture():
    assert seen_box(measured(slice(3, None), slice(6, None))) == (0, 100, 0, 200)


def test_a_line_that_shows_a_little_is_the_end_of_a_thing():
    picture = measured(slice(2, 98))
    picture[2, 60:] = False  # 30 %
    picture[97, 59:] = False
    assert seen_box(picture)[:2] == (2, 100)


def test_a_picture_without_any_depth_has_all_of_its_lines():
    assert seen_box(np.zeros(SHAPE, bool)) == (0, 100, 0, 200)


@pytest.mark.parametrize("edge", range(4))
def test_a_mask_is_cut_where_it_touches_the_end_of_what_is_seen(edge):
    box = (2, 98, 5, 197)
    touching = [
        (slice(3, 20), slice(50, 57)),
        (slice(80, 97), slice(50, 57)),
        (slice(40, 47), slice(6, 30)),
        (slice(40, 47), slice(150, 196)),
    ]
    wanted = np.zeros(4, int)
    wanted[edge] = 7
    np.testing.assert_array_equal(cut_px(measured(*touching[edge]), box), wanted)
    assert not cut_px(measured(slice(20, 80), slice(50, 150)), box).any()
