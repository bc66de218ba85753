"""Names beside markers: none is cut, hides anything, or can be read as the name of another."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from ui.widgets.label_places import (
    CLEARER_HEIGHTS,
    GAP_PX,
    LEAST_LEADER_PX,
    Named,
    Ring,
    place_labels,
)

WINDOW = (640, 480)
NEAR_PX = 0.05

KINDS = st.sampled_from(["marker", "marker", "marker", "value"])
RINGS = st.builds(
    Ring,
    x=st.floats(-20, WINDOW[0] + 20),
    y=st.floats(-20, WINDOW[1] + 20),
    radius=st.floats(4, 14),
    owner=st.sampled_from(["", "", "", "knee"]),
    kind=KINDS,
)
THINGS = st.builds(Named, RINGS, width=st.floats(8, 260), height=st.floats(9, 40))
SCENES = st.tuples(
    st.lists(THINGS, min_size=1, max_size=14).map(tuple), st.lists(RINGS, max_size=6).map(tuple)
)
CLOSE = st.tuples(st.floats(-45, 45), st.floats(-60, 60))
CROWDS = st.tuples(
    st.lists(
        st.builds(
            lambda at, kind, *size: Named(Ring(320 + at[0], 240 + at[1], 8.0, "", kind), *size),
            CLOSE,
            KINDS,
            st.floats(20, 200),
            st.floats(12, 32),
        ),
        min_size=2,
        max_size=12,
    ).map(tuple),
    st.just(()),
)
ANY = st.one_of(SCENES, CROWDS)


def distance(ring, box):
    """Return how far a box is from a circle's edge, by its corners and sides."""
    dx = max(box[0] - ring.x, 0.0, ring.x - box[2])
    dy = max(box[1] - ring.y, 0.0, ring.y - box[3])
    return math.hypot(dx, dy) - ring.radius


def do_overlap(one, other):
    """Compare two boxes side by side, another way round than the code does."""
    across = min(one[2], other[2]) - max(one[0], other[0])
    down = min(one[3], other[3]) - max(one[1], other[1])
    return across > 0 and down > 0


def points_of(line):
    """Return many points of a line, its ends left out."""
    shares = np.linspace(0.0, 1.0, 402)[1:-1, None]
    return (1 - shares) * line[:2] + shares * line[2:]


def do_cross(one, other):
    """Say whether two lines have a point in common, solving for it."""
    one, other = np.array(one), np.array(other)
    ways = np.column_stack([one[2:] - one[:2], other[:2] - other[2:]])
    if abs(np.linalg.det(ways)) < 1e-6:
        return False
    shares = np.linalg.solve(ways, other[:2] - one[:2])
    return bool(np.all((shares > 1e-6) & (shares < 1 - 1e-6)))


def is_kept_free(thing, ring):
    return ring.kind == "marker" or thing.ring.kind == "value"


def is_same_marker(thing, ring):
    return thing.ring is ring or (ring.owner != "" and ring.owner == thing.ring.owner)


def is_passed(thing, ring):
    """Say whether a line may not touch a ring; a value's line can begin within a marker's ring."""
    apart = math.dist((thing.ring.x, thing.ring.y), (ring.x, ring.y))
    is_about = ring.kind != thing.ring.kind and apart < thing.ring.radius + ring.radius
    return is_kept_free(thing, ring) and not is_same_marker(thing, ring) and not is_about


def rivals(thing, rings):
    """Return the rings for whose name a reader could take the name of a thing."""
    alike = (ring for ring in rings if ring.kind == thing.ring.kind)
    return [ring for ring in alike if not is_same_marker(thing, ring)]


def placed(scene):
    """Return all rings, and things with their labels as far as they have one."""
    things, others = scene
    labels = place_labels(things, WINDOW, others)
    pairs = [pair for pair in zip(things, labels, strict=True) if pair[1] is not None]
    return [*(thing.ring for thing in things), *others], pairs


@given(ANY)
def test_every_name_is_of_its_size_and_within_the_window(scene):
    _rings, pairs = placed(scene)
    for thing, label in pairs:
        left, top, right, bottom = label.box
        assert (right - left, bottom - top) == pytest.approx((thing.width, thing.height))
        assert left >= 0
        assert top >= 0
        assert right <= WINDOW[0]
        assert bottom <= WINDOW[1]


@given(ANY)
def test_no_name_touches_a_ring(scene):
    rings, pairs = placed(scene)
    for thing, label in pairs:
        kept_free = [ring for ring in rings if is_kept_free(thing, ring)]
        assert all(distance(ring, label.box) > GAP_PX - NEAR_PX for ring in kept_free)


@given(ANY)
def test_no_name_lies_upon_another_one(scene):
    _rings, pairs = placed(scene)
    boxes = [label.box for _thing, label in pairs]
    assert not any(do_overlap(*pair) for pair in itertools.combinations(boxes, 2))


@given(ANY)
def test_a_name_without_a_line_is_clearly_nearest_to_its_own_ring(scene):
    rings, pairs = placed(scene)
    for thing, label in pairs:
        if label.leader is None:
            own = distance(thing.ring, label.box)
            assert own < thing.ring.radius + 2 * GAP_PX
            clear = own + CLEARER_HEIGHTS * thing.height - NEAR_PX
            assert all(distance(ring, label.box) > clear for ring in rivals(thing, rings))


@given(ANY)
def test_a_line_leads_from_the_own_ring_to_the_name(scene):
    _rings, pairs = placed(scene)
    for thing, label in pairs:
        if label.leader is not None:
            start, end = label.leader[:2], label.leader[2:]
            center = thing.ring.x, thing.ring.y
            assert math.dist(start, center) == pytest.approx(thing.ring.radius)
            assert math.dist(start, end) > LEAST_LEADER_PX - NEAR_PX
            assert distance(Ring(*end, 0.0), label.box) == pytest.approx(0.0, abs=NEAR_PX)


@given(ANY)
def test_a_line_passes_every_other_ring_name_and_line(scene):
    rings, pairs = placed(scene)
    led = [(thing, label) for thing, label in pairs if label.leader is not None]
    for thing, label in led:
        points = points_of(np.array(label.leader))
        for ring in rings:
            if is_passed(thing, ring):
                away = np.hypot(points[:, 0] - ring.x, points[:, 1] - ring.y)
                assert away.min() > ring.radius
        for other in (other for _thing, other in pairs if other is not label):
            left, top, right, bottom = other.box
            inside = (points > (left, top)) & (points < (right, bottom))
            assert not inside.all(axis=1).any()
    lines = [label.leader for _thing, label in led]
    assert not any(do_cross(*pair) for pair in itertools.combinations(lines, 2))


@given(ANY)
def test_the_same_markers_have_their_names_at_the_same_places(scene):
    things, others = scene
    first = place_labels(things, WINDOW, others)
    place_labels.cache_clear()
    assert place_labels(things, WINDOW, others) == first


@given(st.floats(9, 280), st.integers(-400, 400), st.floats(20, 200))
def test_names_of_two_markers_stand_at_their_outer_sides(apart, down, width):
    window = (1000, 1000)
    assume(apart > 18 or abs(down) > 60)
    left = Named(Ring(500.0 - apart, 500.0, 8.0), width, 14.0)
    right = Named(Ring(500.0 + apart, 500.0 + down, 8.0), width, 14.0)
    at_left, at_right = place_labels((left, right), window)
    assert at_left.box[2] < left.ring.x
    assert at_right.box[0] > right.ring.x
    assert at_left.leader is None
    assert at_right.leader is None


def test_a_name_alone_stands_level_with_its_marker_at_the_right():
    (label,) = place_labels((Named(Ring(100.0, 100.0, 6.0), 30.0, 10.0),), WINDOW)
    assert label.box == (109.0, 95.0, 139.0, 105.0)
    assert label.leader is None


def test_a_name_at_the_right_edge_stands_at_the_left():
    (label,) = place_labels((Named(Ring(630.0, 100.0, 6.0), 30.0, 10.0),), WINDOW)
    assert label.box[2] < 630.0 - 6.0


def test_a_name_that_fits_to_no_side_stands_above():
    (label,) = place_labels((Named(Ring(100.0, 100.0, 6.0), 150.0, 10.0),), (200, 200))
    assert label.box[3] < 100.0 - 6.0


BODY = [(0, -150), (0, -93), (-38, -83), (37, -84), (-52, -24), (51, -25), (-25, 5), (25, 5)]
BODY += [(-29, 108), (26, 108), (-29, 122), (27, 123)]
"""Where markers from the brow to both knees lie in a picture of 555 x 596, from its middle."""
LETTERS = (8, 13, 16, 15, 24, 23, 11, 10, 14, 13, 23, 22)
"""How long their names are."""
STILL = ((0.0, 0.0),) * len(BODY)
SHIFTS = st.lists(
    st.tuples(st.floats(-1, 1), st.floats(-1, 1)), min_size=len(BODY), max_size=len(BODY)
)


def body(window, scale, letter_px, height, radius=10.0, shifts=STILL):
    """Return a body's markers in the middle of a picture, each with its name."""
    places = [
        (window[0] / 2 + scale * x + dx, window[1] / 2 + scale * y + dy)
        for (x, y), (dx, dy) in zip(BODY, shifts, strict=True)
    ]
    return tuple(
        Named(Ring(x, y, radius), letter_px * n, height)
        for (x, y), n in zip(places, LETTERS, strict=True)
    )


@given(SHIFTS)
def test_each_marker_of_a_body_has_its_name_beside_it_and_at_the_outer_side(shifts):
    things = body((555, 596), 1.0, 6.7, 16.0, shifts=shifts)
    labels = place_labels(things, (555, 596))
    assert all(label.leader is None for label in labels)
    for (x, _y), thing, label in zip(BODY, things, labels, strict=True):
        if x < 0:
            assert label.box[2] < thing.ring.x
        if x > 0:
            assert label.box[0] > thing.ring.x


@given(SHIFTS)
def test_names_of_a_body_stay_near_where_they_were_when_it_moves_by_a_pixel(shifts):
    still = place_labels(body((555, 596), 1.0, 6.7, 16.0), (555, 596))
    moved = place_labels(body((555, 596), 1.0, 6.7, 16.0, shifts=shifts), (555, 596))
    for one, other in zip(still, moved, strict=True):
        assert math.dist(one.box, other.box) < 25.0  # of a name that steps up, two coordinates


def test_letters_of_twice_the_size_leave_a_small_picture_all_short_names():
    things = body((331, 540), 0.65, 4.5, 26.0, radius=8.0)
    things = tuple(Named(thing.ring, 62.0, thing.height) for thing in things)
    assert None not in place_labels(things, (331, 540))


def test_letters_of_twice_the_size_leave_most_long_names_to_be_read():
    labels = place_labels(body((505, 290), 0.66, 13.5, 29.0, radius=8.0), (505, 290))
    assert sum(label is not None for label in labels) >= 8


def test_two_rings_of_one_marker_do_not_bar_it_from_its_name():
    before, now = Ring(100.0, 100.0, 8.0, "knee"), Ring(103.0, 101.0, 8.0, "knee")
    (label,) = place_labels((Named(now, 40.0, 12.0),), WINDOW, (before,))
    assert label is not None
    assert distance(before, label.box) > GAP_PX - NEAR_PX


def among_six(x, y):
    """Return a marker whose name finds no room beside it, and the rings about it."""
    turns = np.arange(6) * math.tau / 6
    rings = [Ring(x + 24.0 * math.cos(turn), y + 24.0 * math.sin(turn), 8.0) for turn in turns]
    return Named(Ring(x, y, 8.0), 60.0, 14.0), tuple(rings)


def test_a_name_that_another_ring_is_nearer_to_has_a_line():
    thing, about = among_six(100.0, 100.0)
    (label,) = place_labels((thing,), WINDOW, about)
    assert label is not None
    assert label.leader is not None


@given(st.floats(0, 1), st.floats(-50, 20), st.floats(-15, 15))
def test_a_value_does_not_stand_upon_the_line_of_a_name(share, dx, dy):
    thing, about = among_six(300.0, 200.0)
    x1, y1, x2, y2 = place_labels((thing,), WINDOW, about)[0].leader
    at = x1 + share * (x2 - x1) + dx, y1 + share * (y2 - y1) + dy
    value = Named(Ring(*at, 4.0, kind="value"), 30.0, 12.0)
    name, label = place_labels((thing, value), WINDOW, about)
    if label is not None:
        points = points_of(np.array(name.leader))
        inside = (points > label.box[:2]) & (points < label.box[2:])
        assert not inside.all(axis=1).any()


def test_a_marker_walled_in_by_others_has_no_name():
    wall = tuple(
        Ring(100.0 + 16.0 * math.cos(turn), 100.0 + 16.0 * math.sin(turn), 8.0)
        for turn in np.arange(12) * math.tau / 12
    )
    assert place_labels((Named(Ring(100.0, 100.0, 8.0), 60.0, 14.0),), WINDOW, wall) == (None,)


def test_names_of_markers_stand_before_values():
    marker = Named(Ring(30.0, 10.0, 5.0), 50.0, 14.0)
    value = Named(Ring(30.0, 10.0, 5.0, kind="value"), 50.0, 14.0)
    at_value, at_marker = place_labels((value, marker), (90, 21))
    assert at_value is None
    assert at_marker is not None


@pytest.mark.parametrize("way", [(1.0, 0.0), (0.0, 1.0)])
def test_a_value_does_not_stand_upon_its_level_or_upright_line(way):
    value = Named(Ring(300.0, 200.0, 6.5, kind="value"), 50.0, 15.0)
    (label,) = place_labels((value,), WINDOW)
    points = (300.0, 200.0) + np.linspace(-100.0, 100.0, 401)[:, None] * way
    inside = (points > label.box[:2]) & (points < label.box[2:])
    assert not inside.all(axis=1).any()


def test_a_value_stands_beside_its_line_though_a_marker_is_there():
    value = Named(Ring(300.0, 200.0, 5.0, kind="value"), 50.0, 14.0)
    marker = Ring(302.0, 201.0, 8.0)
    (label,) = place_labels((value,), WINDOW, (marker,))
    assert label is not None
    assert distance(marker, label.box) > GAP_PX - NEAR_PX


def test_what_is_out_of_sight_has_no_name():
    assert place_labels((Named(Ring(-5.0, 100.0, 6.0), 30.0, 10.0),), WINDOW) == (None,)


def test_where_nothing_has_a_name_nothing_is_placed():
    assert place_labels((), WINDOW, (Ring(100.0, 100.0, 8.0),)) == ()
