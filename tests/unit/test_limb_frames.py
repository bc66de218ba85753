"""Labelled frames of simulated people: the same every time, true, and as damaged as asked."""

import numpy as np
import pytest

from adibas.data.joints import BODY_PART_NAMES, JOINT_NAMES
from adibas.simulation.body import load_body_model
from adibas.simulation.body_shape import BodyShape
from adibas.simulation.driven_poses import driven_pose, turned_to_camera
from adibas.simulation.limb_frames import CLUTTER, FrameSettings, LimbFrames, dressed_person
from adibas.simulation.limb_masks import damaged_mask
from adibas.simulation.limb_people import KIND_SHARES, random_kind, random_shape, wide_pose
from adibas.simulation.poses import standing

CLEAN = FrameSettings(has_clutter=False, has_damage=False, distance_m=(2.5, 3.0))


@pytest.fixture(scope="module")
def body():
    return load_body_model().shaped(BodyShape("female", 30, 1.68, 62))


def test_a_frame_depends_on_its_seed_and_number_alone():
    first = LimbFrames(3)
    first.frame(1)
    again = LimbFrames(3).frame(2)
    before = first.frame(2)
    np.testing.assert_array_equal(before.depth_mm, again.depth_mm)
    np.testing.assert_array_equal(before.labels, again.labels)
    assert not np.array_equal(before.labels, LimbFrames(4).frame(2).labels)


def test_labels_lie_about_the_joints_of_their_limbs():
    """A pixel of a hand is nearer to the hand than to the other one, and near in depth."""
    frames = LimbFrames(3, CLEAN)
    k = frames.camera.intrinsics
    frame = frames.seen(dressed_person(3, 0), standing(), (0, "standing"), 5)
    assert CLUTTER not in frame.labels
    for side in ("left", "right"):
        value = BODY_PART_NAMES.index(f"{side}_hand") + 1
        rows, columns = np.nonzero((frame.labels == value) & (frame.depth_mm > 0))
        z = frame.depth_mm[rows, columns] / 1000
        points = np.stack([(columns - k.cx) * z / k.fx, (rows - k.cy) * z / k.fy, z], axis=1)
        joint = frame.joints_m[JOINT_NAMES.index(f"{side}_hand")]
        assert len(points) > 5
        assert np.median(np.linalg.norm(points - joint, axis=1)) < 0.12


def test_furniture_gets_into_some_masks_and_has_a_label_of_its_own():
    frames = LimbFrames(8)
    has = [CLUTTER in frames.frame(index).labels for index in range(12)]
    assert 0 < sum(has) < 12


@pytest.mark.parametrize("kind", KIND_SHARES)
def test_every_kind_of_pose_can_be_taken(kind, body):
    for seed in range(3):
        posed = body.posed(wide_pose(np.random.default_rng(seed), kind))
        assert np.isfinite(posed.vertices_m).all()
        assert abs(posed.vertices_m[:, 1].max()) < 0.5


def test_kinds_are_drawn_as_often_as_they_say():
    rng = np.random.default_rng(0)
    kinds = [random_kind(rng) for _ in range(400)]
    assert abs(kinds.count("moving") / 400 - KIND_SHARES["moving"]) < 0.08
    assert sum(KIND_SHARES.values()) == pytest.approx(1.0)


def test_people_are_children_and_grown_up_and_slight_and_heavy():
    shapes = [random_shape(np.random.default_rng(seed)) for seed in range(200)]
    ages = np.array([shape.age_years for shape in shapes])
    mass_index = np.array([shape.weight_kg / shape.stature_m**2 for shape in shapes])
    assert 0.2 < (ages < 18).mean() < 0.4
    assert mass_index.min() < 15
    assert mass_index.max() > 34


def test_damage_takes_away_and_adds_but_never_relabels():
    labels = np.zeros((80, 60), np.uint8)
    labels[10:70, 20:40] = 3
    depth_mm = np.full(labels.shape, 2000)
    sizes = []
    for seed in range(30):
        damaged = damaged_mask(np.random.default_rng(seed), labels, depth_mm, CLUTTER)
        assert set(np.unique(damaged)) <= {0, 3, CLUTTER}
        assert not ((damaged == 3) & (labels == 0)).any()
        assert not ((damaged == CLUTTER) & (labels == 3) & (damaged == 3)).any()
        sizes.append(np.count_nonzero(damaged == 3))
    assert sizes.count(1200) > 3
    assert min(sizes) < 1100


def test_an_empty_mask_stays_empty():
    labels = np.zeros((8, 8), np.uint8)
    for seed in range(5):
        assert not damaged_mask(np.random.default_rng(seed), labels, labels, CLUTTER).any()


def test_a_body_can_be_driven_by_its_own_joints(body):
    for kind in ("standing", "stepping", "overhead"):
        wanted = body.posed(wide_pose(np.random.default_rng(2), kind)).joints_m
        found = body.posed(driven_pose(wanted)).joints_m
        off = np.linalg.norm(wanted - wanted.mean(0) - (found - found.mean(0)), axis=1)
        assert off.mean() < 0.06


def test_joints_are_turned_to_the_camera(body):
    joints_m = body.posed(standing()).joints_m
    turn = np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]])
    again = turned_to_camera(joints_m @ turn.T)
    np.testing.assert_allclose(again, turned_to_camera(joints_m), atol=1e-9)
    left, right = (JOINT_NAMES.index(f"{side}_shoulder") for side in ("left", "right"))
    assert again[left, 0] > again[right, 0]
