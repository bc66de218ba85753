"""What the clinician is told about where the patient stands."""

from typing import get_args

import numpy as np
import pytest

from adibas.body.absence import Absence
from adibas.pipeline.hints import (
    FEET_CUT_OFF,
    HEAD_CUT_OFF,
    HOLES,
    NOBODY,
    SIDE_CUT_OFF,
    TOO_FAR,
    TOO_NEAR,
    absence_hint,
    stance_hints,
)

UP = np.array([0.0, -1.0, 0.0])
SHAPE = (480, 640)


def standing(rows, distance_m=2.0, columns=(280, 360)):
    depth_m = np.full(SHAPE, 3.5, np.float32)
    body = np.zeros(SHAPE, np.bool_)
    body[slice(*rows), slice(*columns)] = True
    depth_m[body] = distance_m
    return depth_m, body


@pytest.mark.parametrize(
    ("rows", "distance_m", "expected"),
    [
        ((40, 440), 2.0, ()),
        ((40, 440), 0.7, (TOO_NEAR,)),
        ((40, 440), 4.2, (TOO_FAR,)),
        ((40, 475), 2.0, (FEET_CUT_OFF,)),
        ((3, 440), 2.0, (HEAD_CUT_OFF,)),
        ((0, 480), 0.7, (TOO_NEAR, HEAD_CUT_OFF, FEET_CUT_OFF)),
    ],
)
def test_a_patient_is_told_where_to_stand(rows, distance_m, expected):
    assert stance_hints(*standing(rows, distance_m), UP) == expected


@pytest.mark.parametrize(
    ("up", "at_upper_side"),
    [((0, -1, 0), "top"), ((0, 1, 0), "bottom"), ((-1, 0, 0), "left"), ((1, 0, 0), "right")],
)
def test_the_head_is_where_up_is(up, at_upper_side):
    depth_m, body = standing((200, 280), columns=(280, 360))
    edges = {
        "top": np.s_[0:200, 300:340],
        "bottom": np.s_[280:480, 300:340],
        "left": np.s_[220:260, 0:280],
        "right": np.s_[220:260, 360:640],
    }
    body[edges[at_upper_side]] = True
    assert stance_hints(depth_m, body, np.array(up, float)) == (HEAD_CUT_OFF,)


def test_a_side_that_is_cut_off_is_told_and_a_hand_is_not():
    assert stance_hints(*standing((40, 440), columns=(0, 80)), UP) == (SIDE_CUT_OFF,)
    assert stance_hints(*standing((40, 440), columns=(560, 640)), UP) == (SIDE_CUT_OFF,)
    depth_m, body = standing((40, 440))
    body[200:230, 360:640] = True
    assert stance_hints(depth_m, body, UP) == ()


def test_a_patient_full_of_holes_is_told():
    depth_m, body = standing((40, 440))
    depth_m[::2, ::2] = np.nan
    assert stance_hints(depth_m, body, UP) == ()
    depth_m[::2] = np.nan
    assert stance_hints(depth_m, body, UP) == (HOLES,)


@pytest.mark.parametrize("absence", get_args(Absence))
def test_each_reason_why_nobody_is_seen_has_its_own_word(absence):
    told = absence_hint(absence)
    others = {absence_hint(other) for other in get_args(Absence) if other != absence}
    assert told not in others
    assert (told == TOO_NEAR) == (absence == "near")
    assert (told == NOBODY) == (absence == "nobody")
