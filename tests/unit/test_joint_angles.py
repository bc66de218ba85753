"""Joint angles beside a body that is bent by known angles."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from adibas.data.joints import JOINT_NAMES
from adibas.movement.joint_angles import ANGLES, INDEX, joint_angles

UP = np.array([0.0, -1.0, 0.0])
RIGHT, AHEAD = np.array([-1.0, 0.0, 0.0]), np.array([0.0, 0.0, -1.0])
"""Of a patient who faces the camera."""

STANDING = {
    "head": (0, 1.65, 0),
    "neck": (0, 1.45, 0),
    "left_shoulder": (-0.2, 1.4, 0),
    "right_shoulder": (0.2, 1.4, 0),
    "left_elbow": (-0.2, 1.1, 0),
    "right_elbow": (0.2, 1.1, 0),
    "left_hand": (-0.2, 0.85, 0),
    "right_hand": (0.2, 0.85, 0),
    "torso": (0, 1.2, 0),
    "left_hip": (-0.1, 0.95, 0),
    "right_hip": (0.1, 0.95, 0),
    "left_knee": (-0.1, 0.5, 0),
    "right_knee": (0.1, 0.5, 0),
    "left_foot": (-0.1, 0.05, 0),
    "right_foot": (0.1, 0.05, 0),
}
"""Right, up and ahead of the patient, metres."""

PELVIS = ("left_hip", "right_hip")
LEGS = (*PELVIS, "left_knee", "right_knee", "left_foot", "right_foot")
UPPER_BODY = tuple(name for name in JOINT_NAMES if name not in LEGS)


def standing():
    places = np.array([STANDING[name] for name in JOINT_NAMES], float)
    return places @ np.array([RIGHT, UP, AHEAD]) + [0, 0, 2.5]


def turned(joints_m, names, about, axis, deg):
    """Turn some joints about an axis through another joint (or point)."""
    origin = joints_m[INDEX[about]] if isinstance(about, str) else about
    rotation = Rotation.from_rotvec(np.radians(deg) * np.asarray(axis)).as_matrix()
    found = joints_m.copy()
    places = [INDEX[name] for name in names]
    found[places] = (joints_m[places] - origin) @ rotation.T + origin
    return found


def degrees(joints_m, up=UP):
    return {name: float(np.degrees(found)) for name, found in joint_angles(joints_m, up).items()}


def assert_only(found, **expected):
    """Every other angle is 0."""
    for name, deg in found.items():
        assert deg == pytest.approx(expected.pop(name, 0.0), abs=1e-6), name
    assert not expected


def middle_of_hips(joints_m):
    return joints_m[[INDEX[name] for name in PELVIS]].mean(axis=0)


def test_upright_with_hanging_arms_everything_is_zero():
    assert_only(degrees(standing()))


@pytest.mark.parametrize("deg", [20.0, 90.0, 140.0])
def test_an_elbow_bends_by_its_angle_alone(deg):
    # Turning about the patient's right takes what hangs down to the front.
    bent = turned(standing(), ["left_hand"], "left_elbow", RIGHT, deg)
    assert_only(degrees(bent), left_elbow_flexion=deg)


def test_a_knee_bends_backwards_by_its_angle_alone():
    bent = turned(standing(), ["right_foot"], "right_knee", -RIGHT, 60.0)
    assert_only(degrees(bent), right_knee_flexion=60.0)


def test_a_thigh_lifted_to_the_front_is_flexion_of_the_hip():
    lifted = turned(standing(), ["left_knee", "left_foot"], "left_hip", RIGHT, 50.0)
    assert_only(degrees(lifted), left_hip_flexion=50.0)


def test_a_thigh_taken_back_is_negative():
    back = turned(standing(), ["right_knee", "right_foot"], "right_hip", -RIGHT, 15.0)
    assert_only(degrees(back), right_hip_flexion=-15.0)


@pytest.mark.parametrize(("side", "sign"), [("left", -1), ("right", 1)])
def test_a_leg_away_from_the_body_is_positive_on_both_sides(side, sign):
    away = turned(standing(), [f"{side}_knee", f"{side}_foot"], f"{side}_hip", sign * -AHEAD, 25.0)
    towards_right = (away - standing())[INDEX[f"{side}_knee"]] @ RIGHT
    assert sign * towards_right > 0
    assert_only(degrees(away), **{f"{side}_hip_abduction": 25.0})


@pytest.mark.parametrize("axis", [RIGHT, AHEAD, (RIGHT + AHEAD) / np.sqrt(2)])
def test_an_arm_is_lifted_by_the_same_angle_in_any_plane(axis):
    arm = ["right_elbow", "right_hand"]
    assert_only(
        degrees(turned(standing(), arm, "right_shoulder", axis, 100.0)),
        right_shoulder_elevation=100.0,
    )


def test_bending_the_trunk_forward_flexes_trunk_and_hips_alike():
    joints_m = standing()
    # Turning about the patient's left takes what stands up to the front.
    bowed = turned(joints_m, UPPER_BODY, middle_of_hips(joints_m), -RIGHT, 40.0)
    assert (bowed - joints_m)[INDEX["head"]] @ AHEAD > 0
    assert_only(degrees(bowed), trunk_flexion=40.0, left_hip_flexion=40.0, right_hip_flexion=40.0)


def test_bending_the_trunk_to_the_right_is_positive():
    joints_m = standing()
    bent = turned(joints_m, UPPER_BODY, middle_of_hips(joints_m), AHEAD, 20.0)
    if (bent - joints_m)[INDEX["head"]] @ RIGHT < 0:
        bent = turned(joints_m, UPPER_BODY, middle_of_hips(joints_m), -AHEAD, 20.0)
    found = degrees(bent)
    assert found["trunk_side_bending"] == pytest.approx(20.0)
    assert found["trunk_flexion"] == pytest.approx(0.0, abs=1e-6)


def test_the_head_bends_forward_and_to_the_right_against_the_trunk():
    joints_m = standing()
    nod = turned(joints_m, ["head"], "neck", -RIGHT, 30.0)
    assert (nod - joints_m)[INDEX["head"]] @ AHEAD > 0
    assert_only(degrees(nod), neck_flexion=30.0)
    for axis in (AHEAD, -AHEAD):
        tilted = turned(joints_m, ["head"], "neck", axis, 10.0)
        is_right = (tilted - joints_m)[INDEX["head"]] @ RIGHT > 0
        assert_only(degrees(tilted), neck_side_bending=10.0 if is_right else -10.0)


def test_turning_the_shoulders_to_the_right_takes_the_right_one_back():
    joints_m = standing()
    shoulders = ["left_shoulder", "right_shoulder"]
    arms = [f"{side}_{part}" for side in ("left", "right") for part in ("elbow", "hand")]
    for axis in (UP, -UP):
        twisted = turned(joints_m, shoulders + arms, "neck", axis, 30.0)
        is_right = (twisted - joints_m)[INDEX["right_shoulder"]] @ AHEAD < 0
        assert_only(degrees(twisted), trunk_rotation=30.0 if is_right else -30.0)


@given(st.integers(0, 2**32 - 1))
def test_no_angle_depends_on_where_the_patient_stands_or_looks(seed):
    rng = np.random.default_rng(seed)
    pose = standing() + rng.normal(scale=0.05, size=(15, 3))
    rotation = Rotation.random(random_state=seed).as_matrix()
    before, after = degrees(pose), degrees(pose @ rotation.T + rng.normal(size=3), rotation @ UP)
    for name, deg in before.items():
        assert after[name] == pytest.approx(deg, abs=1e-6, nan_ok=True)


@given(st.integers(0, 2**32 - 1))
def test_the_mirrored_patient_has_the_angles_of_the_other_side(seed):
    pose = standing() + np.random.default_rng(seed).normal(scale=0.05, size=(15, 3))
    other = {"left": "right", "right": "left"}

    def swapped(name):
        side, _, rest = name.partition("_")
        return f"{other[side]}_{rest}" if side in other else name

    mirrored = np.array([pose[INDEX[swapped(name)]] for name in JOINT_NAMES]) * [-1, 1, 1]
    found, expected = degrees(mirrored), degrees(pose)
    sideways = {"neck_side_bending", "trunk_side_bending", "trunk_rotation"}
    for name in ANGLES:
        sign = -1 if name in sideways else 1
        assert found[swapped(name)] == pytest.approx(sign * expected[name], abs=1e-6, nan_ok=True)


def test_a_hidden_joint_hides_what_needs_it_alone():
    joints_m = standing()
    joints_m[INDEX["left_hand"]] = np.nan
    hidden = {name for name, deg in degrees(joints_m).items() if np.isnan(deg)}
    assert hidden == {"left_elbow_flexion"}


def test_a_thigh_that_points_ahead_has_no_abduction():
    seated = turned(standing(), ["left_knee"], "left_hip", RIGHT, 88.0)
    seated = turned(seated, ["left_knee"], "left_hip", UP, 10.0)
    found = degrees(seated)
    assert np.isnan(found["left_hip_abduction"])
    assert found["left_hip_flexion"] == pytest.approx(88.0, abs=0.2)


def test_up_must_be_a_direction_in_space():
    with pytest.raises(ValueError, match="up"):
        joint_angles(standing(), np.zeros(2))
