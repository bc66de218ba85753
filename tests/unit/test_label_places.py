"""Names beside markers: which side they stand on."""

import itertools

from hypothesis import assume, given
from hypothesis import strategies as st

from ui.widgets.label_places import Named, leader, place_labels

WINDOW = (800.0, 600.0)
spots = st.tuples(st.integers(100, 700), st.integers(100, 500))


def do_overlap(one, other):
    """Compare two boxes side by side, another way round than the code does."""
    across = min(one[2], other[2]) - max(one[0], other[0])
    down = min(one[3], other[3]) - max(one[1], other[1])
    return across > 0 and down > 0


def about(thing):
    return (
        thing.x - thing.radius,
        thing.y - thing.radius,
        thing.x + thing.radius,
        thing.y + thing.radius,
    )


def test_a_name_alone_stands_at_the_right_above():
    (box,) = place_labels([Named(100.0, 100.0, 6.0, 30.0, 10.0)], WINDOW)
    assert box == (109.0, 86.0, 139.0, 96.0)


def test_a_name_at_the_right_edge_stands_at_the_left():
    (box,) = place_labels([Named(790.0, 100.0, 6.0, 30.0, 10.0)], WINDOW)
    assert box[2] < 790.0 - 6.0


@given(st.lists(spots, min_size=2, max_size=6, unique=True))
def test_names_of_markers_that_are_apart_hide_neither_name_nor_marker(places):
    things = [Named(float(x), float(y), 6.0, 30.0, 10.0) for x, y in places]
    assume(
        all(
            abs(one.x - other.x) > 100 or abs(one.y - other.y) > 50
            for one, other in itertools.combinations(things, 2)
        )
    )
    boxes = place_labels(things, WINDOW)
    markers = [about(thing) for thing in things]
    assert not any(do_overlap(*pair) for pair in itertools.combinations(boxes, 2))
    assert not any(do_overlap(box, marker) for box in boxes for marker in markers)


def test_the_markers_of_two_knees_keep_their_names_apart():
    knees = [(100, 100), (130, 100), (100, 114), (130, 114)]
    things = [Named(float(x), float(y), 6.0, 30.0, 10.0) for x, y in knees]
    boxes = place_labels(things, WINDOW)
    assert not any(do_overlap(*pair) for pair in itertools.combinations(boxes, 2))
    assert not any(do_overlap(box, about(thing)) for box in boxes for thing in things)


def test_what_is_taken_already_stays_free():
    taken = (105.0, 80.0, 150.0, 120.0)
    (box,) = place_labels([Named(100.0, 100.0, 6.0, 30.0, 10.0)], WINDOW, [taken])
    assert not do_overlap(box, taken)


def test_where_no_side_is_free_the_name_hides_as_little_as_it_can():
    everything, corner = (0.0, 0.0, 800.0, 600.0), (105.0, 80.0, 150.0, 95.0)
    (box,) = place_labels([Named(100.0, 100.0, 6.0, 30.0, 10.0)], WINDOW, [everything, corner])
    assert not do_overlap(box, corner)


BODY = [(0, -70), (0, -50), (-15, -47), (20, -47), (-20, -20), (20, -20), (-10, -5), (10, -5)]
BODY += [(-10, 35), (10, 35), (-10, 45), (10, 45)]
"""Where markers of a body lie in a small picture, from its middle."""


def names_of_a_body(width, height):
    middle = (109.0, 100.0)
    return [Named(middle[0] + x, middle[1] + y, 6.0, width, height) for x, y in BODY]


@given(st.integers(20, 70), st.integers(8, 24))
def test_in_a_small_picture_no_name_lies_upon_another_one_or_is_cut(width, height):
    window = (218.0, 340.0)
    boxes = [box for box in place_labels(names_of_a_body(width, height), window) if box]
    assert not any(do_overlap(*pair) for pair in itertools.combinations(boxes, 2))
    assert all(box[0] >= 0 and box[1] >= 0 for box in boxes)
    assert all(box[2] <= window[0] and box[3] <= window[1] for box in boxes)


def test_large_letters_in_a_small_picture_leave_all_twelve_names_to_be_read():
    things = names_of_a_body(60.0, 20.0)
    boxes = place_labels(things, (218.0, 340.0))
    assert None not in boxes
    led = [leader(thing, box) for thing, box in zip(things, boxes, strict=True)]
    assert any(led)
    assert not all(led)


def test_a_name_that_would_hide_another_one_is_left_out():
    things = [Named(20.0, 10.0, 2.0, 36.0, 18.0), Named(22.0, 10.0, 2.0, 36.0, 18.0)]
    first, second = place_labels(things, (62.0, 21.0))
    assert first is not None
    assert second is None


def test_what_is_not_seen_has_no_name():
    assert place_labels([Named(-5.0, 100.0, 6.0, 30.0, 10.0)], WINDOW) == (None,)


def test_a_line_leads_to_a_name_that_stands_apart():
    thing = Named(100.0, 100.0, 6.0, 30.0, 10.0)
    assert leader(thing, (109.0, 86.0, 139.0, 96.0)) is None
    assert leader(thing, (130.0, 60.0, 160.0, 70.0)) == (130.0, 70.0)
