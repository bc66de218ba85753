"""When a declared view is doubted, by the way that names show somebody to face."""

import math
from dataclasses import replace

import numpy as np
import pytest

from adibas.data.joints import JOINT_NAMES, mirror_order
from adibas.data.views import VIEWS
from adibas.pipeline.view_check import LOOKS_ASIDE, LOOKS_OTHERWISE, doubt_by_heading
from adibas.skeleton.labelling import Labelling
from adibas.skeleton.starts import HEADINGS_RAD

MIRROR = mirror_order(JOINT_NAMES)
N = len(JOINT_NAMES)


def labelling(heading_deg, confidence=1.0, other_side=0.0):
    """Return the naming of all joints of somebody who faces that way.

    So sure each name is, and the one of the other side; nothing else is likely but no name.
    """
    masses = np.zeros((N, N + 1))
    own = np.arange(N)
    np.add.at(masses, (own, own), confidence)
    np.add.at(masses, (own, MIRROR), other_side)
    masses[:, -1] = 1.0 - masses.sum(axis=1)
    heading_rad = math.radians(heading_deg)
    return Labelling(JOINT_NAMES, JOINT_NAMES, masses[own, own], heading_rad, masses)


@pytest.mark.parametrize("view", VIEWS)
@pytest.mark.parametrize(
    ("off_deg", "doubt"),
    [(0, None), (45, None), (-55, None), (75, LOOKS_ASIDE), (-110, LOOKS_ASIDE)]
    + [(off_deg, LOOKS_OTHERWISE) for off_deg in (130, -130, 180)],
)
def test_a_view_is_doubted_by_how_far_somebody_is_turned_from_it(view, off_deg, doubt):
    heading_deg = math.degrees(HEADINGS_RAD[view]) + off_deg
    assert doubt_by_heading(labelling(heading_deg), view) == doubt


def test_whose_front_and_back_look_alike_is_still_known_not_to_be_seen_aside():
    """A patient who stands upright, as flat as a picture: left and right are not sure."""
    alike = labelling(0, confidence=0.5, other_side=0.45)
    assert doubt_by_heading(alike, "right_lateral") == LOOKS_ASIDE
    assert doubt_by_heading(alike, "anterior") is None
    assert doubt_by_heading(alike, "posterior") is None
    unsure = labelling(0, confidence=0.4, other_side=0.3)
    assert doubt_by_heading(unsure, "right_lateral") is None


@pytest.mark.parametrize(("n_unsure", "doubt"), [(1, LOOKS_ASIDE), (2, None)])
def test_an_axis_is_sure_if_no_more_than_one_point_is_in_doubt(n_unsure, doubt):
    alike = labelling(0, confidence=0.5, other_side=0.45)
    masses = alike.masses.copy()
    masses[:n_unsure] = 1.0 / masses.shape[1]
    assert doubt_by_heading(replace(alike, masses=masses), "right_lateral") == doubt


def test_no_points_doubt_no_view():
    nothing = Labelling((), (), np.zeros(0), math.nan, np.zeros((0, N + 1)))
    assert doubt_by_heading(nothing, "anterior") is None


def test_no_view_is_doubted_by_names_that_are_not_sure_and_none_that_nobody_declared():
    assert doubt_by_heading(labelling(180, confidence=0.7), "anterior") is None
    assert doubt_by_heading(labelling(math.nan), "anterior") is None
    assert doubt_by_heading(labelling(180), "") is None
