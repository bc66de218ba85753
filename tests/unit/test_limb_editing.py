"""Labels proposed from joints, corrected by hand, and carried over to the next frame."""

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from adibas.body.rays import viewing_rays
from adibas.data.frames import depth_in_metres
from adibas.data.joints import JOINT_NAMES
from adibas.data.limbs import FULL_BODY
from adibas.limbs.label_edits import LabelHistory, enclosed, filled, painted
from adibas.limbs.label_propagation import SeenPerson, carry_labels
from adibas.limbs.label_proposals import Capsule, capsules_of, outside_m, propose_labels
from adibas.simulation.limb_frames import FrameSettings, LimbFrames
from adibas.simulation.scenes import open_scene

SHAPE = (9, 12)
EVERYWHERE = np.ones(SHAPE, bool)
NOTHING = np.zeros(SHAPE, np.uint8)
places = st.tuples(st.floats(-3, 14), st.floats(-3, 11))


def distance_to_path(u, v, path):
    """The least distance to many points along a path."""
    shares = np.linspace(0, 1, 150)[:, None]
    pairs = list(pairwise(path)) or [(path[0], path[0])]
    points = np.concatenate([(1 - shares) * a + shares * b for a, b in np.array(pairs, float)])
    return np.hypot(points[:, 0] - u, points[:, 1] - v).min()


@given(st.lists(places, min_size=1, max_size=3), st.floats(0.5, 4))
@settings(max_examples=40)
def test_a_stroke_paints_what_is_within_reach_of_its_path(path, radius_px):
    stroke = painted(NOTHING, EVERYWHERE, path, radius_px, 3)
    for v, u in np.ndindex(SHAPE):
        distance = distance_to_path(u, v, path)
        if abs(distance - radius_px) > 0.05:
            assert stroke[v, u] == (3 if distance < radius_px else 0)


def test_nothing_is_painted_where_it_is_not_allowed_nor_without_a_path():
    allowed = EVERYWHERE.copy()
    allowed[:, :6] = False
    stroke = painted(NOTHING, allowed, [(0, 4), (11, 4)], 2, 1)
    assert not stroke[:, :6].any()
    assert stroke[4, 6:].all()
    assert not painted(NOTHING, allowed, [], 2, 1).any()


def brute_fill(labels, allowed, depth_m, at, step_m):
    """Flood from pixel to pixel."""
    u, v = at
    if not allowed[v, u]:
        return set()
    seen, waiting = {(v, u)}, [(v, u)]
    while waiting:
        row, column = waiting.pop()
        for other in ((row + 1, column), (row - 1, column), (row, column + 1), (row, column - 1)):
            if not (0 <= other[0] < SHAPE[0] and 0 <= other[1] < SHAPE[1]) or other in seen:
                continue
            one_m, other_m = depth_m[row, column], depth_m[other]
            is_near = abs(other_m - one_m) <= step_m or (np.isnan(one_m) and np.isnan(other_m))
            if allowed[other] and labels[other] == labels[v, u] and is_near:
                seen.add(other)
                waiting.append(other)
    return seen


@given(st.integers(0, 10_000))
def test_filling_stops_at_other_labels_at_edges_of_depth_and_of_the_person(seed):
    rng = np.random.default_rng(seed)
    labels = rng.integers(0, 2, SHAPE).astype(np.uint8)
    allowed = rng.random(SHAPE) < 0.9
    depth_m = rng.choice([1.0, 1.02, 1.2, np.nan], SHAPE).astype(np.float32)
    at = int(rng.integers(SHAPE[1])), int(rng.integers(SHAPE[0]))
    found = filled(labels, allowed, depth_m, at, 9)
    assert {(int(v), int(u)) for v, u in np.argwhere(found == 9)} == brute_fill(
        labels, allowed, depth_m, at, 0.03
    )


def test_filling_outside_of_the_picture_changes_nothing():
    depth_m = np.ones(SHAPE, np.float32)
    assert filled(NOTHING, EVERYWHERE, depth_m, (-2.0, 3.0), 1) is NOTHING


def test_a_polygon_is_filled_with_its_border_and_needs_three_corners():
    allowed = EVERYWHERE.copy()
    allowed[3, 3] = False
    inside = enclosed(NOTHING, allowed, [(2, 1), (6, 1), (6, 5), (2, 5)], 4)
    wanted = NOTHING.copy()
    wanted[1:6, 2:7] = 4
    wanted[3, 3] = 0
    np.testing.assert_array_equal(inside, wanted)
    assert enclosed(NOTHING, allowed, [(2, 1), (6, 1)], 4) is NOTHING


@given(st.lists(st.tuples(places, st.integers(0, 5)), max_size=8), st.data())
def test_every_step_is_taken_back_and_done_again(dabs, data):
    images, history = [NOTHING], LabelHistory(NOTHING)
    for at, label in dabs:
        history = history.changed(painted(history.now, EVERYWHERE, [at], 2, label))
        if (history.now != images[-1]).any():
            images.append(history.now)
    assert len(history.back) == len(images) - 1
    n_back = data.draw(st.integers(0, len(images) + 1))
    for _ in range(n_back):
        history = history.undone()
    at = max(len(images) - 1 - n_back, 0)
    np.testing.assert_array_equal(history.now, images[at])
    for _ in range(n_back):
        history = history.redone()
    np.testing.assert_array_equal(history.now, images[-1])


def test_a_step_keeps_what_it_changed_alone_and_old_ones_are_forgotten():
    history = LabelHistory(NOTHING, most_steps=2)
    for label in (1, 2, 3):
        history = history.changed(painted(history.now, EVERYWHERE, [(4, 4)], 0.6, label))
    assert [len(step.pixels) for step in history.back] == [1, 1]
    assert history.undone().undone().undone().now[4, 4] == 1
    assert history.changed(history.now) is history
    assert not history.undone().changed(NOTHING).forth


def test_the_surface_of_a_capsule_is_its_radius_from_its_axis():
    capsule = Capsule("neck", np.zeros(3), np.array([0.0, 0.4, 0.0]), 0.1)
    points_m = np.array([[0.3, 0.2, 0], [0, -0.5, 0], [0, 0.2, 0], [0.3, 0.8, 0]])
    np.testing.assert_allclose(outside_m(points_m, capsule), [0.2, 0.4, -0.1, 0.4])


def simulated(n_people):
    wanted = FrameSettings(
        has_clutter=False,
        has_damage=False,
        farthest_turn_rad=math.radians(60),
        distance_m=(2.0, 3.0),
    )
    frames = LimbFrames(4417, wanted)
    rays = viewing_rays(frames.camera)
    for person in range(n_people):
        frame = frames.frame(25 * person)
        yield frame, rays * depth_in_metres(frame.depth_mm, 0.001)[..., None]


def test_proposed_labels_are_mostly_those_of_the_simulator():
    right = total = 0
    for frame, points_m in simulated(2):
        mask = frame.labels > 0
        labels = propose_labels(points_m, mask, frame.joints_m)
        known = mask & np.isfinite(points_m[..., 2])
        assert not labels[~known].any()
        right += np.count_nonzero(labels[known] == frame.labels[known])
        total += np.count_nonzero(known)
    assert right > 0.87 * total


def test_limbs_whose_joints_are_not_seen_are_not_proposed():
    ((frame, points_m),) = simulated(1)
    joints_m = frame.joints_m.copy()
    joints_m[JOINT_NAMES.index("left_elbow")] = np.nan
    labels = propose_labels(points_m, frame.labels > 0, joints_m)
    missing = {"left_upper_arm", "left_lower_arm"}
    assert not np.isin(labels, [FULL_BODY.names.index(name) + 1 for name in missing]).any()
    assert {one.label for one in capsules_of(joints_m)} == set(FULL_BODY.names) - missing
    nothing = propose_labels(points_m, frame.labels > 0, np.full((15, 3), np.nan))
    assert not nothing.any()


@pytest.fixture(scope="module")
def clapping():
    """Two frames of somebody who moves the arms: points, mask and true labels."""
    scene = open_scene("clap", seed=3, color_size=(480, 640), distance_m=2.7)
    rays = viewing_rays(scene.info.calibration.depth)[::2, ::2]
    found = []
    for index in (40, 42):
        frame = scene.frame(index)
        depth_m = depth_in_metres(frame.sensor_frame.depth_raw, scene.info.depth_unit_m)[::2, ::2]
        truth = np.ascontiguousarray(frame.truth.labels[::2, ::2])
        found.append((SeenPerson(rays * depth_m[..., None], truth > 0), truth))
    return found


def test_carried_labels_are_right_more_often_than_a_copy(clapping):
    (before, old), (after, new) = clapping
    carried = carry_labels(before, old, after)
    assert not carried[~after.mask].any()
    known = after.known
    share, copied = (np.mean(one[known] == new[known]) for one in (carried, old))
    assert share > 0.95
    assert 1 - share < 0.5 * (1 - copied)


def test_labels_are_not_carried_farther_than_the_reach(clapping):
    (before, old), (after, _) = clapping
    away = SeenPerson(after.points_m + np.float32([0, 5, 0]), after.mask)
    assert not carry_labels(before, old, away).any()
    assert not carry_labels(before, np.zeros_like(old), after).any()
    nobody = SeenPerson(after.points_m, np.zeros_like(after.mask))
    assert not carry_labels(before, old, nobody).any()
