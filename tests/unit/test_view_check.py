"""When a declared view is doubted, by the way that names show somebody to face."""

import math

import numpy as np
import pytest

from adibas.data.joints import JOINT_NAMES
from adibas.data.views import VIEWS
from adibas.pipeline.view_check import LOOKS_ASIDE, LOOKS_OTHERWISE, doubt_by_heading
from adibas.skeleton.labelling import Labelling
from adibas.skeleton.starts import HEADINGS_RAD


def labelling(heading_deg, confidence=1.0):
    """Return the naming of all joints of somebody who faces that way."""
    n = len(JOINT_NAMES)
    masses = np.eye(n, n + 1)
    heading_rad = math.radians(heading_deg)
    return Labelling(JOINT_NAMES, JOINT_NAMES, np.full(n, confidence), heading_rad, masses)


@pytest.mark.parametrize("view", VIEWS)
@pytest.mark.parametrize(
    ("off_deg", "doubt"),
    [(0, None), (45, None), (-55, None), (75, LOOKS_ASIDE), (-110, LOOKS_ASIDE)]
    + [(off_deg, LOOKS_OTHERWISE) for off_deg in (130, -130, 180)],
)
def test_a_view_is_doubted_by_how_far_somebody_is_turned_from_it(view, off_deg, doubt):
    heading_deg = math.degrees(HEADINGS_RAD[view]) + off_deg
    assert doubt_by_heading(labelling(heading_deg), view) == doubt


def test_no_view_is_doubted_by_names_that_are_not_sure_and_none_that_nobody_declared():
    assert doubt_by_heading(labelling(180, confidence=0.7), "anterior") is None
    assert doubt_by_heading(labelling(math.nan), "anterior") is None
    assert doubt_by_heading(labelling(180), "") is None
