"""Names beside markers: which side they stand on."""

import itertools

from hypothesis import assume, given
from hypothesis import strategies as st

from ui.widgets.label_places import Named, place_labels

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
