"""Which side is seen at first, as the names of markers tell in a movement."""

import math

import numpy as np
import pytest

from adibas.data.joints import JOINT_NAMES
from adibas.data.views import VIEWS
from adibas.pipeline.skeleton_labelling import shipped_namer
from adibas.pipeline.skeleton_simulator import simulate_shapes
from adibas.skeleton.first_view import first_view
from adibas.skeleton.labelling import Labelling
from adibas.skeleton.starts import HEADINGS_RAD, turn_back
from adibas.skeleton.tracking import MovingPoints

STEP_S = 0.1
NAMED = ("head", "torso", "left_hip", "right_hip", "left_knee")
MIDDLES = ("head", "neck", "torso", None, None)


class Teller:
    """Names each frame and tells a heading as the test wants; stands where a namer does."""

    names = JOINT_NAMES

    def __init__(self, headings_rad, names=NAMED):
        self._headings_rad, self._names = iter(headings_rad), names
        self.confidences = np.ones(len(names))

    def label(self, points_m, **_given):
        masses = np.full((len(points_m), len(JOINT_NAMES) + 1), 1.0 / (len(JOINT_NAMES) + 1))
        heading_rad = next(self._headings_rad)
        return Labelling(self._names, self._names, self.confidences, heading_rad, masses)


def frames_of(headings_rad):
    """Return five points that are turned to each heading."""
    place_m = np.random.default_rng(3).normal(scale=(0.25, 0.5, 0.25), size=(len(NAMED), 3))
    return [
        MovingPoints(place_m @ turn_back(heading) + [0.0, 0.0, 2.0], number * STEP_S)
        for number, heading in enumerate(headings_rad)
    ]


@pytest.mark.parametrize("view", VIEWS)
def test_most_frames_tell_the_view(view):
    told = np.full(20, HEADINGS_RAD[view])
    told[7] += math.pi
    found = first_view(Teller(told), frames_of(told[:1].repeat(20)))
    assert (found.view, found.n_telling) == (view, 19)


@pytest.mark.parametrize("way", [-1.0, 1.0])
def test_of_who_turns_the_first_view_is_told_by_all_frames(way):
    """Half a turn in two seconds: the headings that frames tell are of all sides."""
    headings = way * math.pi * np.arange(20) / 20
    found = first_view(Teller(headings), frames_of(headings))
    assert (found.view, found.n_telling) == ("anterior", 20)


def test_frames_that_contradict_each_other_tell_nothing():
    told = np.where(np.arange(20) % 5 == 0, math.pi, 0.0)
    assert first_view(Teller(told), frames_of(np.zeros(20))) is None


def test_two_frames_are_too_few():
    assert first_view(Teller([0.0] * 2), frames_of([0.0] * 2)) is None
    assert first_view(Teller([0.0] * 3), frames_of([0.0] * 3)).n_telling == 3


def test_names_without_a_side_and_headings_that_are_not_known_tell_nothing():
    assert first_view(Teller([0.0] * 20, MIDDLES), frames_of([0.0] * 20)) is None
    one_sided = (*MIDDLES[:3], "left_hip", None)
    assert first_view(Teller([0.0] * 20, one_sided), frames_of([0.0] * 20)) is None
    assert first_view(Teller([math.nan] * 20), frames_of([0.0] * 20)) is None


def test_frames_of_which_one_name_is_not_sure_tell_nothing():
    teller = Teller([0.0] * 20)
    teller.confidences = np.array([1.0, 1.0, 0.79, 1.0, 1.0])
    assert first_view(teller, frames_of([0.0] * 20)) is None


def test_no_frames_tell_nothing():
    assert first_view(Teller([]), []) is None


@pytest.mark.parametrize("view", VIEWS)
def test_the_shipped_model_tells_it_of_people_who_bend_their_knees_and_elbows(view):
    people = simulate_shapes(8, 4, 6210, lambda _done, _all: None)
    moving_m = people.shapes_m[np.isin(people.kinds, ("gesture", "moving"))]
    rng = np.random.default_rng(2)
    found = []
    for shape_m in moving_m[:5]:
        turned_m = shape_m @ turn_back(HEADINGS_RAD[view])
        frames = [
            MovingPoints(rng.permutation(turned_m) + rng.normal(scale=0.005, size=(15, 3)), t)
            for t in np.arange(8) * STEP_S
        ]
        found.append(first_view(shipped_namer(), frames))
    assert {one.view for one in found if one is not None} == {view}
    assert sum(one is not None for one in found) >= 3
