"""The choice of joints against brute force, and people who must keep sides, sizes and numbers."""

import itertools

import numpy as np
import pytest

from adibas.data.joint_proposals import JointProposals
from adibas.data.joints import JOINT_NAMES
from adibas.pipeline.pose_model import read_joint_model, shipped_joint_model, write_joint_model
from adibas.simulation.body import load_body_model
from adibas.simulation.body_shape import BodyShape
from adibas.simulation.poses import standing
from adibas.skeleton.choice_kernels import FAR, bone_cost, choose
from adibas.skeleton.following import ChosenJoints, PersonFollower
from adibas.skeleton.identities import Identities
from adibas.skeleton.person_size import PersonSize, SizeParams
from adibas.skeleton.proportions import (
    MIRRORED,
    ORDER,
    PARENTS,
    bone_lengths_m,
    learn_proportions,
    proportions_from_json,
    proportions_to_json,
)
from adibas.skeleton.sides import BACK, FRONT
from adibas.skeleton.smoothing import Smoother, SmoothingParams

N_JOINTS = len(JOINT_NAMES)
RATE_HZ = 30.0
AWAY_M = np.array([0.0, 1.0, 2.5])
PLENTY_M2 = 0.02


@pytest.fixture(scope="module")
def adult_m():
    body = load_body_model().shaped(BodyShape("female", 30, 1.68, 62))
    return body.posed(standing()).joints_m + AWAY_M


@pytest.fixture(scope="module")
def proportions():
    return shipped_joint_model().proportions


def only(joints_m, weights_m2=PLENTY_M2):
    """One proposal for each joint that has a place."""
    seen = np.isfinite(joints_m[:, 0])
    positions_m = np.full((N_JOINTS, 3, 3), np.nan)
    positions_m[:, 0] = joints_m
    weights = np.zeros((N_JOINTS, 3))
    weights[:, 0] = np.where(seen, weights_m2, 0.0)
    return JointProposals(positions_m, weights)


def test_the_choice_is_that_of_brute_force():
    rng = np.random.default_rng(0)
    parents, order = np.array([-1, 0, 1, 1]), np.array([0, 1, 2, 3])
    for _case in range(20):
        places_m = rng.normal(0, 0.3, (4, 2, 3))
        costs = rng.uniform(0, 3, (4, 3))
        places_m[2, 1], costs[2, 1] = np.nan, FAR
        bones = (np.full(4, 0.4), np.full(4, 0.1))
        chosen, margins = choose(places_m, costs, (parents, order), bones, 6.0)

        def total(states, places_m=places_m, costs=costs, bones=bones):
            cost = sum(costs[joint, state] for joint, state in enumerate(states))
            for joint in range(1, 4):
                child, above = states[joint], states[parents[joint]]
                if child < 2 and above < 2 and costs[joint, child] < FAR:
                    ends = places_m[joint, child], places_m[parents[joint], above]
                    if np.isfinite(ends).all():
                        cost += bone_cost(*ends, bones[0][joint], bones[1][joint], 6.0)
            return cost

        every = list(itertools.product(range(3), repeat=4))
        best = min(every, key=total)
        assert total(tuple(chosen)) == pytest.approx(total(best))
        for joint in range(4):
            without = min(total(states) for states in every if states[joint] == 2)
            withal = min(total(states) for states in every if states[joint] != 2)
            assert margins[joint] == pytest.approx(without - withal)


def test_every_joint_comes_after_its_parent_and_has_a_mirror_image():
    assert sorted(ORDER) == list(range(N_JOINTS))
    for place, joint in enumerate(ORDER):
        assert PARENTS[joint] == -1 or PARENTS[joint] in ORDER[:place]
    assert [MIRRORED[other] for other in MIRRORED] == list(range(N_JOINTS))


def test_clear_proposals_are_taken_as_they_are(adult_m, proportions):
    found = PersonFollower(proportions).follow(only(adult_m), 0.0)
    np.testing.assert_allclose(found.joints_m, adult_m)
    assert (found.confidence > 0.5).all()
    assert found.n_seen == N_JOINTS


def test_what_has_no_proposal_is_not_seen(adult_m, proportions):
    hidden = adult_m.copy()
    legs = [k for k, name in enumerate(JOINT_NAMES) if name.endswith(("hip", "knee", "foot"))]
    hidden[legs] = np.nan
    found = PersonFollower(proportions).follow(only(hidden), 0.0)
    assert np.isnan(found.joints_m[legs]).all()
    assert np.isnan(found.confidence[legs]).all()
    assert found.n_seen == N_JOINTS - len(legs)


def test_nothing_gives_no_skeleton(proportions):
    nothing = only(np.full((N_JOINTS, 3), np.nan))
    assert PersonFollower(proportions).follow(nothing, 0.0).n_seen == 0


def test_a_stronger_place_that_no_arm_reaches_loses(adult_m, proportions):
    hand = JOINT_NAMES.index("left_hand")
    proposals = only(adult_m)
    positions_m, weights = proposals.positions_m.copy(), proposals.weights_m2.copy()
    positions_m[hand, 1], weights[hand, 1] = positions_m[hand, 0], weights[hand, 0]
    positions_m[hand, 0] += np.array([1.2, 0.3, 0.0])
    weights[hand, 0] *= 2.0
    follower = PersonFollower(proportions)
    found = follower.follow(JointProposals(positions_m, weights), 0.0)
    np.testing.assert_allclose(found.joints_m[hand], adult_m[hand])


def test_a_hand_out_of_reach_is_not_seen_even_where_the_elbow_is_hidden(adult_m, proportions):
    elbow, hand = JOINT_NAMES.index("left_elbow"), JOINT_NAMES.index("left_hand")
    strange = adult_m.copy()
    strange[elbow] = np.nan
    strange[hand] += np.array([1.5, 0.0, 0.0])
    found = PersonFollower(proportions).follow(only(strange), 0.0)
    assert np.isnan(found.joints_m[hand]).all()


def test_exchanged_sides_are_exchanged_back(adult_m, proportions):
    follower = PersonFollower(proportions)
    for frame in range(10):
        follower.follow(only(adult_m), frame / RATE_HZ)
    found = follower.follow(only(adult_m[list(MIRRORED)]), 10 / RATE_HZ)
    np.testing.assert_allclose(found.joints_m, adult_m)
    assert follower.sides.n_exchanged == 1


@pytest.mark.parametrize(("view", "is_kept"), [(FRONT, True), (BACK, False)])
def test_a_declared_view_decides_the_sides(adult_m, proportions, view, is_kept):
    found = PersonFollower(proportions, view).follow(only(adult_m), 0.0)
    wanted = adult_m if is_kept else adult_m[list(MIRRORED)]
    np.testing.assert_allclose(found.joints_m, wanted)
    assert found.front_probability == float(is_kept)


def test_front_is_inferred_with_growing_confidence(adult_m, proportions):
    follower = PersonFollower(proportions)
    first = follower.follow(only(adult_m), 0.0).front_probability
    for frame in range(1, 10):
        last = follower.follow(only(adult_m), frame / RATE_HZ).front_probability
    assert 0.5 < first < last < 1.0


def test_toes_that_point_away_exchange_the_sides(adult_m, proportions):
    follower = PersonFollower(proportions)
    for frame in range(60):
        found = follower.follow(only(adult_m), frame / RATE_HZ, front_evidence=-0.4)
    assert found.front_probability < 0.05
    np.testing.assert_allclose(found.joints_m, adult_m[list(MIRRORED)])


def test_labels_that_insist_are_believed_in_the_end(adult_m, proportions):
    follower = PersonFollower(proportions)
    follower.follow(only(adult_m), 0.0)
    for frame in range(1, 90):
        found = follower.follow(only(adult_m[list(MIRRORED)]), frame / RATE_HZ)
    np.testing.assert_allclose(found.joints_m, adult_m[list(MIRRORED)])


def test_the_size_of_a_child_is_learned(proportions):
    body = load_body_model().shaped(BodyShape("male", 7, 1.22, 23))
    joints_m = body.posed(standing()).joints_m
    size = PersonSize(proportions)
    before_m = size.bones_m()[1]
    for _frame in range(10):
        size.learn(joints_m)
    assert size.stature_m == pytest.approx(1.22, abs=0.1)
    assert (size.bones_m()[1] <= before_m).all()


@pytest.mark.parametrize("n_frames", [1, 4, 5])
def test_a_bone_is_as_long_as_in_the_middle_one_of_the_frames_that_show_it(
    adult_m, proportions, n_frames
):
    rng = np.random.default_rng(n_frames)
    size, lengths_m = PersonSize(proportions), []
    for _ in range(n_frames):
        joints_m = adult_m + rng.normal(scale=0.01, size=adult_m.shape)
        joints_m[rng.choice(N_JOINTS, 3, replace=False)] = np.nan
        size.learn(joints_m)
        lengths_m.append(bone_lengths_m(joints_m))
    assert size.n_seen == n_frames
    usual_m = proportions.lengths * size.stature_m
    seen = np.isfinite(lengths_m).sum(axis=0)
    for bone in np.flatnonzero((seen > 0) & (usual_m > 0)):
        middle_m = np.clip(np.nanmedian(np.array(lengths_m)[:, bone]) / usual_m[bone], 0.75, 1.25)
        share = seen[bone] / (seen[bone] + SizeParams().n_own)
        expected_m = usual_m[bone] * (1 + share * (middle_m - 1))
        assert size.bones_m()[0][bone] == pytest.approx(expected_m)
    for bone in np.flatnonzero((seen == 0) & (usual_m > 0)):
        assert size.bones_m()[0][bone] == pytest.approx(usual_m[bone])


def test_few_joints_teach_no_size(proportions):
    size = PersonSize(proportions)
    size.learn(np.full((N_JOINTS, 3), np.nan))
    assert size.n_seen == 0
    assert size.guess_m(np.full((N_JOINTS, 3), np.nan)) == size.stature_m


def frames_of(joints_m):
    sure = np.where(np.isfinite(joints_m[..., 0]), 0.9, np.nan)
    return [(k / RATE_HZ, ChosenJoints(one, sure[k], 1.0)) for k, one in enumerate(joints_m)]


def smoothed_m(joints_m, **changes):
    smoother = Smoother(SmoothingParams(**changes))
    given = [ready for one in frames_of(joints_m) if (ready := smoother.push(*one)) is not None]
    given += smoother.finish()
    times_s = [time_s for time_s, _ in given]
    np.testing.assert_allclose(times_s, np.arange(len(joints_m)) / RATE_HZ)
    return np.stack([one.joints_m for _, one in given])


@pytest.mark.parametrize("lag_frames", [0, 1, 2, 5])
def test_a_steady_movement_passes_unchanged_with_any_lag(adult_m, lag_frames):
    moving_m = adult_m + np.arange(20)[:, None, None] * np.array([0.02, 0.0, -0.01])
    np.testing.assert_allclose(smoothed_m(moving_m, lag_frames=lag_frames), moving_m, atol=1e-9)


def test_a_frame_comes_after_as_many_later_ones_as_are_stated(adult_m):
    smoother = Smoother(SmoothingParams(lag_frames=2))
    frames = frames_of(np.repeat(adult_m[None], 4, axis=0))
    assert [smoother.push(*one) is not None for one in frames] == [False, False, True, True]


def test_noise_becomes_less(adult_m):
    rng = np.random.default_rng(1)
    noisy_m = adult_m + rng.normal(0, 0.02, (200, N_JOINTS, 3))
    assert (smoothed_m(noisy_m) - adult_m).std() < 0.6 * (noisy_m - adult_m).std()


def test_one_wild_frame_is_left_out_and_unseen_stays_unseen(adult_m):
    joints_m = np.repeat(adult_m[None], 9, axis=0)
    joints_m[4, 0] += 0.8
    joints_m[5, 6] = np.nan
    result_m = smoothed_m(joints_m)
    np.testing.assert_allclose(result_m[:, 0], adult_m[None, 0].repeat(9, 0), atol=1e-9)
    assert np.isnan(result_m[5, 6]).all()
    assert np.isfinite(np.delete(result_m, 5, axis=0)).all()


def crossing(n_frames, hidden):
    """Two people who walk past one another; the farther one is hidden in some frames."""
    for frame in range(n_frames):
        x_m = -1.0 + 2.0 * frame / (n_frames - 1)
        near, far = [x_m, 0.0, 2.0], [-x_m, 0.0, 2.6]
        yield frame / RATE_HZ, np.array([near] if frame in hidden else [near, far])


def test_numbers_are_kept_through_a_crossing_and_a_short_absence():
    identities = Identities()
    for time_s, places_m in crossing(60, range(27, 34)):
        numbers = identities.match(places_m, np.array([1.2, 1.3])[: len(places_m)], time_s)
        assert numbers == [1, 2][: len(places_m)]


def test_whoever_comes_after_long_absence_or_elsewhere_is_somebody_else():
    identities = Identities()
    place_m = np.array([[0.0, 0.0, 2.0]])
    top_m = np.array([1.6])
    assert identities.match(place_m, top_m, 0.0) == [1]
    assert identities.match(place_m + 2.5, top_m, 0.1) == [2]
    assert identities.match(place_m, top_m, 9.0) == [3]
    assert identities.match(np.empty((0, 3)), np.empty(0), 9.1) == []


def test_somebody_whom_the_picture_cuts_off_is_told_by_the_place():
    """A sleeve that comes into view, then the whole person, then a sleeve again."""
    sleeve, whole = np.array([[-0.70, 0.0, 1.7]]), np.array([[-0.55, 0.0, 1.6]])
    identities = Identities()
    assert identities.match(sleeve, np.array([np.nan]), 0.0) == [1]
    assert identities.match(whole, np.array([1.7]), 0.1) == [1]
    assert identities.match(sleeve, np.array([np.nan]), 0.2) == [1]
    assert identities.match(whole, np.array([1.7]), 0.3) == [1]
    child_m = whole + np.array([0.2, 0.0, 0.0])
    assert identities.match(child_m, np.array([1.1]), 0.4) == [2]  # the height is still known


def test_of_two_who_may_be_meant_the_height_decides_where_it_is_seen():
    places_m = np.array([[0.0, 0.0, 2.0], [0.2, 0.0, 2.0]])
    for top_m, wanted in ((1.2, [1]), (1.45, [2])):
        identities = Identities()
        assert identities.match(places_m, np.array([1.2, 1.45]), 0.0) == [1, 2]
        middle_m = places_m.mean(axis=0, keepdims=True)
        assert identities.match(middle_m, np.array([top_m]), 0.1) == wanted


def test_proportions_are_those_of_the_examples_and_survive_their_file(adult_m):
    joints_m = np.stack([adult_m, adult_m])
    learned = learn_proportions(joints_m, np.array([1.68, 1.68]), np.full((2, N_JOINTS), 0.01))
    elbow, shoulder = JOINT_NAMES.index("left_elbow"), JOINT_NAMES.index("left_shoulder")
    wanted = np.linalg.norm(adult_m[elbow] - adult_m[shoulder]) / 1.68
    assert learned.lengths[elbow] == pytest.approx(wanted, rel=0.02)
    again = proportions_from_json(proportions_to_json(learned))
    np.testing.assert_array_equal(again.areas, learned.areas)
    with pytest.raises(ValueError, match="no adibas-proportions"):
        proportions_from_json({})


def test_a_model_of_joints_survives_its_file_and_a_broken_one_is_told(tmp_path):
    path = tmp_path / "joints.json"
    model = shipped_joint_model()
    write_joint_model(path, model, {"seed": 1})
    assert read_joint_model(path).offsets.of_kind == model.offsets.of_kind
    for broken in ("{}", "[1]", "no json"):
        path.write_text(broken)
        with pytest.raises(Exception, match=r"joints\.json is no model of joints"):
            read_joint_model(path)
