"""Front from back by the shape of the body; sides of a recording's first frames."""

import json

import numpy as np
import pytest

from adibas.data.joint_proposals import JointProposals
from adibas.data.joints import BODY_PART_NAMES, JOINT_NAMES
from adibas.limbs.facing import (
    Facing,
    FacingParams,
    facing_from_json,
    facing_to_json,
    front_evidence,
)
from adibas.limbs.facing_quantities import QUANTITIES, describe_shape, quantiles
from adibas.limbs.proposals import PartPoints
from adibas.pipeline.facing_file import shipped_facing
from adibas.pipeline.facing_training import described, held_out_share, learn_facing
from adibas.pipeline.shipped_limbs import shipped_model
from adibas.skeleton.following import ChosenJoints
from adibas.skeleton.proportions import MIRRORED
from adibas.skeleton.settled_sides import settled
from adibas.skeleton.sides import SideKeeper, SideParams, breadth

UNSEEN_SEED = 6590
BACK_BULGE_M = 0.03


def block(low, high, depth_m, n=6):
    """Points of a part in a box across the look, at a depth that may depend on the height."""
    x, y = np.meshgrid(np.linspace(low[0], high[0], n), np.linspace(low[1], high[1], n))
    z = np.vectorize(depth_m)(y) if callable(depth_m) else np.full_like(x, depth_m)
    return np.column_stack([x.ravel(), y.ravel(), z.ravel(), np.full(x.size, 4e-4)])


def parts_of(blocks):
    """Points as `part_points` gives them; what is not in `blocks` is not seen."""
    given = [blocks.get(name, np.empty((0, 4))) for name in BODY_PART_NAMES]
    starts = np.concatenate([[0], np.cumsum([len(one) for one in given])])
    return PartPoints(BODY_PART_NAMES, np.concatenate(given), starts, np.empty((0, 0, 4)))


@pytest.fixture
def somebody():
    """2 m away, feet and all; the left side is at the picture's right."""
    blocks = {
        "head": block((-0.08, -0.9), (0.08, -0.7), 1.95),
        "torso": block((-0.2, -0.6), (0.2, 0.0), 2.0, n=20),
    }
    for side, x in (("left", 0.15), ("right", -0.15)):
        blocks[f"{side}_upper_leg"] = block(
            (x - 0.05, 0.0), (x + 0.05, 0.4), lambda y: 2.0 + y / 10
        )
        blocks[f"{side}_lower_leg"] = block((x - 0.05, 0.4), (x + 0.05, 0.8), 2.05)
        blocks[f"{side}_foot"] = block((x - 0.05, 0.8), (x + 0.05, 0.85), 1.97, n=12)
        blocks[f"{side}_upper_arm"] = block((2 * x, -0.5), (2 * x + 0.05, -0.2), 2.0)
        blocks[f"{side}_lower_arm"] = block((2 * x, -0.2), (2 * x + 0.05, 0.05), 1.94)
        blocks[f"{side}_hand"] = block((2 * x, 0.05), (2 * x + 0.05, 0.15), 1.92)
    return blocks


def test_quantities_are_metres_between_parts(somebody):
    found = dict(zip(QUANTITIES, describe_shape(parts_of(somebody)), strict=True))
    expected = {"toes": 0.08, "head": -0.05, "loin": 0.0, "seat": 0.0, "shins": 0.03}
    expected |= {"forearms": -0.06, "hands": -0.02}
    for name, value in expected.items():
        assert found[name] == pytest.approx(value, abs=1e-9), name
    assert found["hips"] == pytest.approx(0.008, abs=1e-9)  # the mean of its upper 0.16 m
    assert found["thighs"] == pytest.approx(0.024, abs=1e-9)


def test_what_bulges_out_of_the_trunk_is_before_its_plane(somebody):
    somebody["torso"] = block(
        (-0.2, -0.6), (0.2, 0.0), lambda y: 2.0 - (BACK_BULGE_M if y > -0.12 else 0.0), n=20
    )
    found = dict(zip(QUANTITIES, describe_shape(parts_of(somebody)), strict=True))
    assert found["seat"] < -0.005
    assert found["loin"] > 0.0


@pytest.mark.parametrize("n_values", [1, 2, 3, 10, 257])
def test_quantiles_are_those_of_numpy(n_values):
    rng = np.random.default_rng(n_values)
    for shares in ((0.0, 1.0), (0.02, 0.98), (0.4, 0.6), (0.5,), tuple(rng.random(3))):
        values = rng.normal(2.0, 0.3, n_values)
        np.testing.assert_array_max_ulp(
            np.array(quantiles(values, *shares)), np.quantile(values, shares), maxulp=1
        )


def test_which_side_is_called_left_changes_nothing(somebody):
    other = {"left": "right", "right": "left"}
    exchanged = {
        "_".join([other.get(side, side), *rest]): points
        for (side, *rest), points in ((name.split("_"), one) for name, one in somebody.items())
    }
    np.testing.assert_allclose(
        describe_shape(parts_of(exchanged)), describe_shape(parts_of(somebody)), atol=1e-12
    )


def test_what_is_not_seen_tells_nothing(somebody):
    only_head = parts_of({"head": somebody["head"]})
    assert np.isnan(describe_shape(only_head)).all()
    facing = Facing(np.ones(9), np.ones(9), np.ones(9), 0.25)
    assert facing.log_odds(np.full(9, np.nan)) == 0.25
    assert front_evidence(only_head, facing, FacingParams(share=0.2)) == pytest.approx(0.05)


def test_one_frame_tells_no_more_than_it_may(somebody):
    facing = Facing(np.zeros(9), np.full(9, 1e-3), np.full(9, -10.0), 0.0)
    assert front_evidence(parts_of(somebody), facing) in (-0.5, 0.5)


def test_people_whom_nobody_learned_from_are_told_from_behind():
    """By the shipped weights, on labels that the shipped model of limbs finds."""
    quantities, is_front, people = described(UNSEEN_SEED, 10, shipped_model())
    odds = shipped_facing().log_odds(quantities)
    assert ((odds > 0) == is_front).mean() > 0.75
    is_sure = np.abs(odds) > 2
    assert ((odds > 0) == is_front)[is_sure].mean() > 0.9
    assert 0 <= held_out_share(quantities, is_front, people) <= 100


def test_weights_that_are_learned_tell_apart_what_differs():
    rng = np.random.default_rng(5)
    is_front = np.arange(400) % 2 == 0
    quantities = rng.normal(size=(400, len(QUANTITIES)))
    quantities[:, 1] += np.where(is_front, -1.5, 1.5)
    quantities[rng.random(quantities.shape) < 0.1] = np.nan
    facing = learn_facing(quantities, is_front, {"seed": 5})
    assert np.abs(facing.weights).argmax() == 1
    assert facing.weights[1] < 0
    assert ((facing.log_odds(quantities) > 0) == is_front).mean() > 0.85


def test_the_shipped_weights_are_of_the_shipped_labels():
    made = shipped_facing().provenance["limbs_created_utc"]
    assert shipped_model().is_made(made)


def test_a_file_of_other_quantities_is_refused():
    document = json.loads(json.dumps(facing_to_json(shipped_facing())))
    again = facing_from_json(document)
    np.testing.assert_array_equal(again.weights, shipped_facing().weights)
    with pytest.raises(ValueError, match="other quantities"):
        facing_from_json(document | {"quantities": ["toes"]})


def seen(front, left_is_at):
    """One frame: the shoulders, the left one at x = 0.2 or -0.2, and how probably it is a front."""
    joints_m = np.full((len(JOINT_NAMES), 3), np.nan)
    for side, x in (("left", left_is_at), ("right", -left_is_at)):
        joints_m[JOINT_NAMES.index(f"{side}_shoulder")] = x, 0.0, 2.0
    return ChosenJoints(joints_m, np.where(np.isfinite(joints_m[:, 0]), 0.9, np.nan), front)


def lefts(frames):
    left = JOINT_NAMES.index("left_shoulder")
    return [float(one.joints_m[left, 0]) for one in frames]


def test_frames_before_it_was_known_that_a_back_is_seen_get_its_sides():
    frames = [seen(0.5, 0.2), seen(0.4, 0.2), seen(0.2, 0.2), seen(0.03, -0.2), seen(0.1, -0.2)]
    told = settled(frames, SideParams())
    assert lefts(told) == [-0.2] * 5
    assert lefts(frames)[0] == 0.2


def test_frames_that_agree_and_people_who_turned_stay_as_they_were():
    agree = [seen(0.5, 0.2), seen(0.8, 0.2), seen(0.97, 0.2)]
    assert lefts(settled(agree, SideParams())) == [0.2] * 3
    turned = [seen(0.9, 0.2), seen(0.7, 0.2), seen(0.5, 0.2), seen(0.03, -0.2)]
    assert lefts(settled(turned, SideParams())) == [0.2, 0.2, -0.2, -0.2]
    never_sure = [seen(0.4, 0.2), seen(0.3, 0.2)]
    assert lefts(settled(never_sure, SideParams())) == [0.2] * 2


def test_the_shape_tells_less_the_less_squarely_somebody_is_seen():
    """Limbs of who walks past swing to both sides of the trunk."""
    turned_rad = np.radians(60.0)
    frame = seen(0.5, 0.2).joints_m
    aside = np.array([[np.cos(turned_rad), 0, 0], [0, 1, 0], [np.sin(turned_rad), 0, 1]])
    assert breadth(frame) == pytest.approx(1.0)
    assert breadth(frame @ aside.T) == pytest.approx(0.5)
    assert breadth(np.full_like(frame, np.nan)) == 0.0
    odds = []
    for joints_m in (frame, frame @ aside.T):
        proposals = JointProposals(joints_m[:, None], np.ones((len(JOINT_NAMES), 1)))
        keeper = SideKeeper(params=SideParams(label_weight=0.0))
        keeper.is_exchanged(proposals, 0.0, evidence=-0.4)
        odds.append(np.log(keeper.front_probability / (1 - keeper.front_probability)))
    np.testing.assert_allclose(odds, [-0.4, -0.1])


def told_of(evidence, left_is_at, n_frames=20, view=""):
    """Say of each frame whether the side that is seen is known, and the left shoulder lies so."""
    joints_m = seen(0.5, left_is_at).joints_m
    proposals = JointProposals(joints_m[:, None], np.ones((len(JOINT_NAMES), 1)))
    keeper = SideKeeper(view)
    told = []
    for k in range(n_frames):
        is_exchanged = keeper.is_exchanged(proposals, k / 30, evidence)
        given_m = joints_m[list(MIRRORED)] if is_exchanged else joints_m
        told.append((keeper.is_view_sure(given_m), keeper.front_probability, is_exchanged))
        keeper.learn(given_m, k / 30)
    return told


def test_the_side_that_is_seen_is_sure_once_it_is_probable_and_the_joints_lie_so():
    fronts = told_of(evidence=0.3, left_is_at=0.2)
    assert [is_sure for is_sure, *_ in fronts] == [front >= 0.85 for _, front, _ in fronts]
    backs = told_of(evidence=-0.4, left_is_at=0.2)
    assert any(front < 0.15 and not is_exchanged for _, front, is_exchanged in backs)
    # A back of which the labels make a front is not sure before the sides are exchanged.
    assert [is_sure for is_sure, *_ in backs] == [is_exchanged for *_, is_exchanged in backs]
    assert all(is_sure for is_sure, *_ in told_of(0.0, 0.2, view="posterior"))
