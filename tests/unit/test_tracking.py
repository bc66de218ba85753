"""Points of a movement keep their names: by where they are, what they are called, and bodies."""

import math

import numpy as np
import pytest

from adibas.data.joints import JOINT_NAMES
from adibas.pipeline.skeleton_labelling import shipped_namer
from adibas.pipeline.skeleton_simulator import simulate_shapes
from adibas.skeleton.labelling import Labelling
from adibas.skeleton.starts import turn_back
from adibas.skeleton.tracking import MovingPoints, NamesSoFar, name_movement

NAMES = ("head", "neck", "torso")
RATE_HZ = 15.0
SURE = 0.97


class Teller:
    """Says of each frame what the test tells it to; stands where a namer does."""

    names = NAMES

    def __init__(self, said, headings_rad=()):
        self._said = iter(said)
        self._headings_rad = iter(headings_rad)
        self.views, self.bodies = [], []

    def who_sees(self, body_odds):
        self.bodies.append(body_odds)
        return self

    def label(self, points_m, view="", **_given):
        self.views.append(view)
        masses = np.array(next(self._said), float).reshape(len(points_m), len(NAMES) + 1)
        masses /= masses.sum(axis=1, keepdims=True)
        names = tuple(JOINT_NAMES[: len(points_m)])
        heading_rad = next(self._headings_rad, math.nan)
        return Labelling(names, names, masses.max(axis=1), heading_rad, masses)


def sure(*names):
    """Return masses of points that are called so, an empty name: of nothing known."""
    rows = []
    for name in names:
        row = np.full(len(NAMES) + 1, (1.0 - SURE) / len(NAMES))
        if name:
            row[NAMES.index(name)] = SURE
        else:
            row[:] = 1.0 / len(row)
        rows.append(row)
    return np.array(rows)


def frames_of(places_m):
    """Return a frame for each list of heights along a line, metres."""
    return [
        MovingPoints(np.array([[0.0, y_m, 2.0] for y_m in ys_m]).reshape(-1, 3), number / RATE_HZ)
        for number, ys_m in enumerate(places_m)
    ]


def test_one_frame_that_exchanges_two_names_is_overruled():
    said = [sure("head", "neck")] * 11
    said[5] = sure("neck", "head")
    tracked = name_movement(Teller(said), frames_of([[0.0, 0.15]] * 11))
    assert [one.names for one in tracked] == [("head", "neck")] * 11


def test_a_point_that_appears_where_another_hid_does_not_take_its_name():
    """The head is hidden and the neck appears 8 cm beside: both are called what they are."""
    places_m = [[0.0]] * 12 + [[0.08]] * 3
    said = [sure("head")] * 12 + [sure("neck")] * 3
    tracked = name_movement(Teller(said), frames_of(places_m))
    assert [one.names for one in tracked] == [("head",)] * 12 + [("neck",)] * 3


def test_a_point_of_which_nothing_is_said_takes_the_name_from_near_not_from_far():
    near = name_movement(Teller([sure("head"), sure("")]), frames_of([[0.0], [0.02]]))
    far = name_movement(Teller([sure("head"), sure("")]), frames_of([[0.0], [0.17]]))
    assert near[1].names == ("head",)
    assert far[1].names == (None,)


def test_two_points_that_pass_each_other_keep_their_names():
    """They meet in the middle, where nothing is said of them for three frames."""
    numbers = np.arange(15)
    places_m = [[0.01 * (n - 7), 0.02 - 0.01 * (n - 7)] for n in numbers]
    said = [sure("", "") if abs(n - 8) <= 1 else sure("head", "neck") for n in numbers]
    tracked = name_movement(Teller(said), frames_of(places_m))
    assert {one.names for one in tracked} == {("head", "neck")}


def test_a_frame_in_which_nobody_is_found_says_nothing_against_names():
    """Every second frame finds no person; counted as words, no name would be left."""
    nobody = np.full((2, len(NAMES) + 1), (1.0 - SURE) / len(NAMES))
    nobody[:, -1] = SURE
    said = [nobody if n % 2 else sure("head", "neck") for n in range(12)]
    tracked = name_movement(Teller(said), frames_of([[0.0, 0.15]] * 12))
    assert [one.names for one in tracked] == [("head", "neck")] * 12
    alone = name_movement(Teller([nobody] * 3), frames_of([[0.0, 0.15]] * 3))
    assert [one.guesses for one in alone] == [(None, None)] * 3


UNSURE = np.array([[0.6, 0.38, 0.01, 0.01], [0.38, 0.6, 0.01, 0.01]])


def heard(said, places_m, sure_from=0.9):
    """Return the names so far in each frame; a frame alone names from `sure_from` on."""
    so_far, named = NamesSoFar(NAMES), []
    for masses, frame in zip(said, frames_of(places_m), strict=True):
        names = tuple(
            (*NAMES, None)[int(row.argmax())] if row.max() >= sure_from else None for row in masses
        )
        alone = Labelling(names, names, masses.max(axis=1), math.nan, masses)
        named.append(so_far.hear(frame.points_m, frame.time_s, alone).names)
    return named


def test_many_frames_that_are_not_sure_do_not_make_a_name():
    """Who holds still says the same in all of them; as a recording they would name it."""
    assert heard([UNSURE] * 30, [[0.0, 0.15]] * 30) == [(None, None)] * 30
    as_recorded = name_movement(Teller([UNSURE] * 30), frames_of([[0.0, 0.15]] * 30))
    assert as_recorded[15].names == ("head", "neck")


def test_a_name_that_was_sure_is_carried_on_for_two_seconds():
    said = [sure("head", "neck")] * 3 + [UNSURE] * 40
    named = heard(said, [[0.0, 0.15]] * 43)
    assert named[:33] == [("head", "neck")] * 33
    assert named[-1] == (None, None)


def test_a_point_does_not_carry_on_what_only_another_one_was_called():
    """The neck is hidden; somewhere else a point appears that is perhaps the neck."""
    head, perhaps = sure("head")[0], np.array([0.05, 0.75, 0.1, 0.1])
    said = [sure("head", "neck")] * 3 + [np.stack([head, perhaps])] * 10
    named = heard(said, [[0.0, 0.6]] * 3 + [[0.0, 1.5]] * 10)
    assert named[2] == ("head", "neck")
    assert named[3:] == [("head", None)] * 10


def test_a_point_that_was_hidden_goes_on_with_its_name():
    said = [sure("head", "neck")] * 3 + [sure("head")] * 5 + [UNSURE]
    named = heard(said, [[0.0, 0.15]] * 3 + [[0.0]] * 5 + [[0.0, 0.15]])
    assert named[-1] == ("head", "neck")


def test_a_frame_that_exchanges_two_names_does_not_exchange_what_is_shown():
    said = [sure("head", "neck")] * 6 + [sure("neck", "head")] + [sure("head", "neck")] * 6
    assert heard(said, [[0.0, 0.15]] * 13) == [("head", "neck")] * 13


def test_a_body_is_asked_for_what_is_seen_of_it_and_told_to_the_namer():
    asked = []

    def body(view):
        asked.append(view)
        return None if len(asked) == 2 else "odds"

    frames = [
        MovingPoints(one.points_m, one.time_s, body=body) for one in frames_of([[0.0, 0.2]] * 3)
    ]
    teller = Teller([sure("head", "neck")] * 3)
    name_movement(teller, frames, "right_lateral")
    assert asked == ["right_lateral"] * 3
    assert teller.bodies == ["odds", "odds"]
    assert teller.views == ["right_lateral"] * 3


@pytest.mark.parametrize("view", ["", "anterior"])
def test_no_body_is_asked_for_where_no_view_is_known_or_no_point_is_seen(view):
    def body(_view):
        raise AssertionError("asked")

    frames = [MovingPoints(np.empty((0, 3)), 0.0, body=body)] if view else []
    frames += [] if view else [MovingPoints(np.zeros((2, 3)), 0.0, body=body)]
    said = [np.empty((0, 4))] if view else [sure("head", "neck")]
    assert len(name_movement(Teller(said), frames, view)) == 1


def turning(n_frames, *, jumps_m=0.0):
    """Return frames of eight points that turn by 90 degrees a second, away from the camera."""
    rng = np.random.default_rng(5)
    place_m = rng.normal(scale=(0.25, 0.5, 0.2), size=(8, 3))
    for number in range(n_frames):
        turned_m = place_m @ turn_back(0.5 * math.pi * number / RATE_HZ)
        away_m = np.array([jumps_m * (number % 2), 0.0, 2.0])
        yield MovingPoints(turned_m + away_m, number / RATE_HZ)


def test_the_view_follows_points_that_turn_whatever_they_are_called():
    teller = Teller([np.ones((8, 4))] * 34)
    name_movement(teller, turning(34), "anterior")
    assert list(dict.fromkeys(teller.views)) == ["anterior", "left_lateral", "posterior"]


def test_the_view_follows_what_names_tell_of_points_that_are_new_in_each_frame():
    headings = [0.5 * math.pi * number / RATE_HZ for number in range(34)]
    teller = Teller([np.ones((8, 4))] * 34, headings)
    name_movement(teller, turning(34, jumps_m=3.0), "anterior")
    assert list(dict.fromkeys(teller.views)) == ["anterior", "left_lateral", "posterior"]


def test_in_a_plane_the_declared_view_stays():
    frames = [MovingPoints(np.array([[0.0, 0.0], [0.0, 0.2]]), float(t)) for t in range(6)]
    teller = Teller([sure("head", "neck")] * 6)
    name_movement(teller, frames, "posterior")
    assert teller.views == ["posterior"] * 6


def test_who_turns_round_keeps_left_and_right():
    """Until the view was followed, a patient who stands was named as a front from behind."""
    people = simulate_shapes(6, 4, 6200, lambda _done, _all: None)
    standing_m = people.shapes_m[np.array(people.kinds) == "standing"]
    rng = np.random.default_rng(1)
    assert len(standing_m) >= 4
    for shape_m in standing_m[:4]:
        frames, truth = [], []
        for number in range(41):
            turned_m = shape_m @ turn_back(2.0 * math.pi * number / 40)
            order = rng.permutation(len(JOINT_NAMES))
            points_m = turned_m[order] + rng.normal(scale=0.005, size=(len(order), 3))
            frames.append(MovingPoints(points_m, number / 10.0))
            truth.append(tuple(JOINT_NAMES[i] for i in order))
        tracked = name_movement(shipped_namer(), frames, "anterior")
        assert [one.names for one in tracked] == truth
