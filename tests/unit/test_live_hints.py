"""What the clinician is told about where the patient stands."""

import numpy as np
import pytest

from adibas.pipeline.hints import (
    FEET_CUT_OFF,
    HEAD_CUT_OFF,
    NOBODY,
    TOO_FAR,
    TOO_NEAR,
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


def test_nobody_is_told_from_somebody_too_near():
    depth_m, _ = standing((40, 440), distance_m=0.6)
    assert stance_hints(depth_m, None, UP) == (TOO_NEAR,)
    depth_m[:] = 3.0
    assert stance_hints(depth_m, None, UP) == (NOBODY,)
    depth_m[:] = np.nan
    assert stance_hints(depth_m, None, UP) == (NOBODY,)
