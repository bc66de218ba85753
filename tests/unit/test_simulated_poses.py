"""A pose puts every segment where it says, whatever the body, and keeps the bones whole."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import cKDTree

from adibas.data.joints import BODY_PART_NAMES, JOINT_NAMES
from adibas.simulation.arm_room import with_arm_room
from adibas.simulation.body import load_body_model
from adibas.simulation.body_shape import BodyShape
from adibas.simulation.figures import Figure, TrunkAngles
from adibas.simulation.poses import ArmAngles, LegAngles, Pose, arm_pose, leg_pose, standing
from adibas.simulation.postures import POSTURES, random_sway
from adibas.simulation.rotations import about, frame, onto, part_way, turn_about
from adibas.simulation.skeleton import bone_turns
from adibas.simulation.skinning import add_normals, skin

unit_vectors = st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda v: np.linalg.norm(v) > 0.1)
angles = st.floats(-3.0, 3.0)
arms = st.builds(
    ArmAngles,
    elevation=st.floats(0, 2.8),
    plane=st.floats(-1, 2),
    rotation=st.floats(-1.5, 1.5),
    elbow=st.floats(0, 2.4),
    pronation=st.floats(-1.5, 1.5),
    wrist=st.floats(-1, 1),
)
legs = st.builds(
    LegAngles,
    flexion=st.floats(-0.3, 1.6),
    spread=st.floats(-0.1, 0.6),
    knee=st.floats(0, 2.2),
    toe_out=st.floats(-0.2, 0.6),
    sole=st.floats(0, 0.7),
)
trunks = st.builds(TrunkAngles, *[st.floats(-0.5, 0.9)] * 7)
figures = st.builds(Figure, arms, arms, legs, legs, trunks)


@pytest.fixture(scope="module")
def person():
    return load_body_model().shaped(BodyShape("female", 30, 1.65, 58))


def joints_of(posed):
    return dict(zip(JOINT_NAMES, posed.joints_m, strict=True))


@settings(max_examples=30, deadline=None)
@given(figures)
def test_segments_point_where_the_pose_says(person, figure):
    posed = person.posed(figure.pose())
    pose, joints = posed.pose, joints_of(posed)
    wanted = {
        ("shoulder", "elbow"): lambda arm, _: arm.upper,
        ("hip", "knee"): lambda _, leg: leg.upper,
        ("knee", "foot"): lambda _, leg: leg.lower,
    }
    for side, arm, leg in (
        ("left", pose.left_arm, pose.left_leg),
        ("right", pose.right_arm, pose.right_leg),
    ):
        for (start, end), direction in wanted.items():
            segment = joints[f"{side}_{end}"] - joints[f"{side}_{start}"]
            cosine = segment @ direction(arm, leg) / np.linalg.norm(segment)
            # Half of a limb's twist is left to its first bone, so the joint moves a little.
            assert cosine > math.cos(math.radians(4)), (side, start)


@settings(max_examples=30, deadline=None)
@given(figures)
def test_bones_keep_their_lengths(person, figure):
    turns = bone_turns(person.skeleton, figure.pose())
    heads = person.skeleton.heads_m
    posed = np.einsum("bij,bj->bi", turns[:, :, :3], heads) + turns[:, :, 3]
    for bone, parent in enumerate(person.skeleton.parents[1:], start=1):
        length = np.linalg.norm(heads[bone] - heads[parent])
        assert np.linalg.norm(posed[bone] - posed[parent]) == pytest.approx(length, abs=1e-9)
    np.testing.assert_allclose(
        turns[:, :, :3] @ turns[:, :, :3].transpose(0, 2, 1),
        np.broadcast_to(np.eye(3), (len(heads), 3, 3)),
        atol=1e-9,
    )


@settings(max_examples=15, deadline=None)
@given(figures)
def test_lowest_point_rests_on_the_floor(person, figure):
    assert person.posed(figure.pose()).vertices_m[:, 1].max() == pytest.approx(0.0, abs=1e-12)
    assert person.posed(figure.pose(0.3)).vertices_m[:, 1].max() == pytest.approx(-0.3, abs=1e-12)


def mirrored(figure):
    trunk = figure.trunk
    flipped = {name: -getattr(trunk, name) for name in ("side_bend", "twist", "look", "tilt")}
    return Figure(
        figure.right_arm,
        figure.left_arm,
        figure.right_leg,
        figure.left_leg,
        replace(trunk, **flipped),
    )


@settings(max_examples=15, deadline=None)
@given(figures)
def test_mirrored_pose_is_the_mirror_image(person, figure):
    there = joints_of(person.posed(figure.pose()))
    here = joints_of(person.posed(mirrored(figure).pose()))
    swap = {"left": "right", "right": "left"}
    for name, position in there.items():
        side, _, joint = name.rpartition("_")
        other = f"{swap[side]}_{joint}" if side else joint
        # One bone of MakeHuman's neck lies 3 mm beside the midline.
        np.testing.assert_allclose(here[other], position * [-1, 1, 1], atol=0.002)


def test_arm_angles_mean_what_the_clinic_means():
    half = math.pi / 2
    raised = arm_pose("left", ArmAngles(elevation=half, plane=0, rotation=0, elbow=0))
    np.testing.assert_allclose(raised.upper, [1, 0, 0], atol=1e-12)
    forward = arm_pose("right", ArmAngles(elevation=half, plane=half, rotation=0, elbow=0))
    np.testing.assert_allclose(forward.upper, [0, 0, -1], atol=1e-12)
    for side, inward in (("left", -1), ("right", 1)):
        bent = arm_pose(side, ArmAngles(elevation=0, plane=0, rotation=0, elbow=half, pronation=0))
        np.testing.assert_allclose(bent.lower, [0, 0, -1], atol=1e-12)
        np.testing.assert_allclose(bent.thumb, [0, -1, 0], atol=1e-12)
        turned = ArmAngles(elevation=0, plane=0, rotation=half, elbow=half, pronation=0)
        np.testing.assert_allclose(arm_pose(side, turned).lower, [inward, 0, 0], atol=1e-12)
        palm_down = ArmAngles(elevation=0, plane=0, rotation=0, elbow=half, pronation=half)
        np.testing.assert_allclose(arm_pose(side, palm_down).thumb, [inward, 0, 0], atol=1e-12)


def test_leg_angles_mean_what_the_clinic_means():
    half = math.pi / 2
    for side, outward in (("left", 1), ("right", -1)):
        seated = leg_pose(side, LegAngles(flexion=half, spread=0, knee=half, toe_out=0))
        np.testing.assert_allclose(seated.upper, [0, 0, -1], atol=1e-12)
        np.testing.assert_allclose(seated.lower, [0, 1, 0], atol=1e-12)
        spread = leg_pose(side, LegAngles(flexion=0, spread=0.3, knee=0, toe_out=0.2))
        assert spread.upper[0] * outward == pytest.approx(math.sin(0.3))
        assert (spread.foot @ [0, 0, -1])[0] * outward == pytest.approx(math.sin(0.2))


def test_heavy_people_hang_their_arms_farther_out_and_clear_of_the_hips():
    heavy = load_body_model().shaped(BodyShape("male", 50, 1.75, 120))
    slender = load_body_model().shaped(BodyShape("male", 20, 1.85, 60))
    assert slender.arm_room_rad == 0.0
    assert 0.1 < heavy.arm_room_rad < 0.4
    posed = heavy.posed(standing())
    part = heavy.model.part_weights.argmax(1)
    on_trunk = np.isin(part, [BODY_PART_NAMES.index(n) for n in ("torso", "left_upper_leg")])
    trunk = posed.vertices_m[on_trunk]
    for name in ("left_lower_arm", "left_hand"):
        arm = posed.vertices_m[part == BODY_PART_NAMES.index(name)]
        near = cKDTree(trunk[:, 1:]).query(arm[:, 1:])[1]
        assert (arm[:, 0] > trunk[near, 0] - 0.001).all(), name


def test_raised_and_bent_arms_need_no_room():
    forward = standing(left_arm=ArmAngles(elevation=1.5), right_arm=ArmAngles(elbow=1.6))
    roomy = with_arm_room(forward, 0.3)
    for side in ("left_arm", "right_arm"):
        np.testing.assert_allclose(getattr(roomy, side).upper, getattr(forward, side).upper)
    hanging = with_arm_room(standing(), 0.3)
    assert hanging.left_arm.upper[0] > standing().left_arm.upper[0] + 0.2
    assert hanging.right_arm.upper[0] < standing().right_arm.upper[0] - 0.2


def test_palms_look_inward_when_the_arms_hang(person):
    """Fingers of a relaxed hand curl to the palm's side: towards the thigh."""
    straight = ArmAngles(elevation=0.1, plane=0, rotation=0, elbow=0, pronation=0, curl=0.0)
    curled = replace(straight, curl=0.6)
    names = person.model.bone_names
    for side, suffix, inward in (("left", "L", -1), ("right", "R", 1)):
        tips = []
        for arm in (straight, curled):
            turns = bone_turns(person.skeleton, standing(left_arm=arm, right_arm=arm))
            bone = names.index(f"finger3-3.{suffix}")
            tips.append(turns[bone, :, :3] @ person.skeleton.heads_m[bone] + turns[bone, :, 3])
        assert (tips[1] - tips[0])[0] * inward > 0.005, side


def test_each_view_shows_its_side(person):
    def hips(view):
        joints = joints_of(person.posed(standing().facing(view)))
        return joints["left_hip"] - joints["right_hip"], joints["left_hip"]

    assert hips("anterior")[0][0] > 0.1
    assert hips("posterior")[0][0] < -0.1
    assert hips("left_lateral")[0][2] < -0.1
    assert hips("right_lateral")[0][2] > 0.1


def test_the_body_stands_where_the_pose_says(person):
    ankles = ("left_foot", "right_foot")
    moved = joints_of(person.posed(replace(standing(), offset_m=np.array([0.4, -0.2]))))
    middle = np.mean([moved[name] for name in ankles], axis=0)
    np.testing.assert_allclose(middle[[0, 2]], [0.4, -0.2], atol=1e-12)


def test_pose_arrays_are_checked():
    arm, leg = arm_pose("left", ArmAngles()), leg_pose("left", LegAngles())
    with pytest.raises(ValueError, match="chest"):
        Pose(arm, arm, leg, leg, chest=np.eye(2))


@settings(max_examples=10, deadline=None)
@given(figures)
def test_figures_survive_being_vectors(figure):
    assert Figure.from_vector(figure.vector()) == figure


def test_default_figure_is_the_standing_pose(person):
    np.testing.assert_array_equal(
        person.posed(Figure().pose()).vertices_m, person.posed(standing()).vertices_m
    )


def test_benchmark_postures_keep_the_arms_off_the_trunk(person):
    for name, figure in POSTURES.items():
        joints = joints_of(person.posed(figure.pose()))
        assert joints["left_hand"][0] > joints["left_hip"][0] + 0.05, name
    assert len(POSTURES) == 4


def test_sway_moves_the_head_by_millimetres_and_the_feet_not_at_all(person):
    sway = random_sway(np.random.default_rng(5))
    times_s = np.arange(0.0, 120.0, 0.5)
    joints = [person.posed(sway.applied(standing(), t)).joints_m for t in times_s]
    spread = np.std(joints, axis=0)
    head, foot = (spread[JOINT_NAMES.index(name)] for name in ("head", "left_foot"))
    assert 0.004 < head[2] < 0.010
    assert 0.001 < head[0] < 0.006
    assert foot.max() < 0.0005


def test_sway_is_slow_and_repeats_with_its_seed():
    first, again = (random_sway(np.random.default_rng(1)) for _ in range(2))
    assert first.applied(standing(), 3.0).chest == pytest.approx(
        again.applied(standing(), 3.0).chest, abs=0
    )
    step = first.applied(standing(), 3.0).chest - first.applied(standing(), 3.0 + 1 / 30).chest
    assert np.abs(step).max() < 0.002


def test_skinning_kernel_agrees_with_plain_arithmetic():
    rng = np.random.default_rng(0)
    rest = rng.normal(size=(40, 3))
    indices = rng.integers(0, 7, (40, 4)).astype(np.uint8)
    weights = -np.sort(-rng.random((40, 4)), axis=1).astype(np.float32)
    weights[:10, 2:] = 0.0
    weights /= weights.sum(1, keepdims=True)
    turns = rng.normal(size=(7, 3, 4))
    posed = np.empty_like(rest)
    skin(rest, indices, weights, turns, posed)
    homogeneous = np.concatenate([rest, np.ones((40, 1))], axis=1)
    wanted = np.einsum("vk,vkij,vj->vi", weights.astype(float), turns[indices], homogeneous)
    np.testing.assert_allclose(posed, wanted, atol=1e-12)


def test_normals_of_an_octahedron_point_to_its_corners():
    corners = np.concatenate([np.eye(3), -np.eye(3)]) * 2.0
    faces = [(0, 1, 2), (1, 3, 2), (3, 4, 2), (4, 0, 2), (1, 0, 5), (3, 1, 5), (4, 3, 5), (0, 4, 5)]
    normals = np.zeros((7, 3))
    add_normals(np.concatenate([corners, [[9.0, 9, 9]]]), np.array(faces, np.int32), normals)
    np.testing.assert_allclose(normals[:6], corners / 2.0, atol=1e-12)
    np.testing.assert_array_equal(normals[6], 0.0)


@given(unit_vectors, unit_vectors)
def test_onto_turns_one_direction_onto_the_other(start, end):
    start, end = np.array(start), np.array(end)
    turn = onto(start, end)
    np.testing.assert_allclose(turn @ turn.T, np.eye(3), atol=1e-9)
    np.testing.assert_allclose(
        turn @ start / np.linalg.norm(start), end / np.linalg.norm(end), atol=1e-7
    )


def test_onto_handles_opposite_directions():
    np.testing.assert_allclose(onto(np.eye(3)[1], -np.eye(3)[1])[:, 1], [0, -1, 0], atol=1e-12)


@given(unit_vectors, st.floats(0.0, 3.1), st.floats(0, 1))
def test_part_way_divides_the_angle(axis, angle, share):
    start = about(np.array([1.0, 2.0, -1.0]), 0.7)
    end = about(np.array(axis), angle) @ start
    wanted = about(np.array(axis), share * angle) @ start
    np.testing.assert_allclose(part_way(start, end, share), wanted, atol=1e-6)


def test_part_way_takes_half_a_turn_about_its_axis():
    end = about(np.array([0.0, 0.0, 1.0]), math.pi)
    half = part_way(np.eye(3), end, 0.5)
    np.testing.assert_allclose(half @ half, end, atol=1e-9)


@given(unit_vectors, angles)
def test_turn_about_reads_the_angle_back(axis, angle):
    unit = np.array(axis) / np.linalg.norm(axis)
    assert turn_about(unit, about(unit, angle)) == pytest.approx(angle, abs=1e-7)


def test_a_frame_is_a_rotation_and_a_direction_must_not_vanish():
    turn = frame(np.array([0.0, 3.0, 0.0]), np.array([1.0, 5.0, 0.0]))
    np.testing.assert_allclose(turn, [[0, 1, 0], [1, 0, 0], [0, 0, -1]], atol=1e-12)
    with pytest.raises(ValueError, match="zero"):
        about(np.zeros(3), 1.0)
