"""People in simulated rooms: each one found, furniture never, and joints where they are."""

import numpy as np
import pytest

from adibas.body.mask import heights_over
from adibas.body.people import PeopleParams, find_people, tables
from adibas.data.frames import depth_in_metres
from adibas.data.joints import JOINT_NAMES
from adibas.data.limbs import FULL_BODY, LimbParts
from adibas.pipeline.pose_following import PoseEstimator
from adibas.simulation.crowds import crowd_names, open_crowd


def depth_of(scene, frame):
    depth_m = depth_in_metres(frame.sensor_frame.depth_raw, scene.info.depth_unit_m)
    return np.ascontiguousarray(scene.info.calibration.corrected_depth(depth_m))


def people_in(scene, frame):
    calibration = scene.info.calibration
    return find_people(depth_of(scene, frame), calibration.depth, calibration.floor)


def owner(mask, frame):
    """The person whom most of a mask shows; 0: nobody."""
    counts = np.bincount(frame.owners[mask.pixels], minlength=4)
    return int(counts.argmax())


@pytest.fixture(scope="module")
def children():
    return open_crowd("two_children_cross", seed=0)


@pytest.fixture(scope="module")
def pupil():
    return open_crowd("seated_child", seed=0)


def test_two_children_are_two_people_before_and_after_they_cross(children):
    for index in (0, 60):
        frame = children.frame(index)
        masks = people_in(children, frame)
        assert sorted(owner(mask, frame) for mask in masks) == [1, 2]
        for mask in masks:
            truth = frame.owners == owner(mask, frame)
            overlap = (mask.pixels & truth).sum() / (mask.pixels | truth).sum()
            assert overlap > 0.8
        assert not (masks[0].pixels & masks[1].pixels).any()


def test_a_child_at_a_table_is_found_without_the_table(pupil):
    frame = pupil.frame(30)
    masks = people_in(pupil, frame)
    assert [owner(mask, frame) for mask in masks] == [1]
    depth_m = depth_of(pupil, frame)
    calibration = pupil.info.calibration
    heights_m = heights_over(depth_m, calibration.depth, calibration.floor)
    table = tables(depth_m, heights_m, calibration.depth, calibration.floor, PeopleParams())
    assert table.sum() > 5000
    assert (frame.owners[table] == 0).mean() > 0.98
    assert not (masks[0].pixels & table).any()


def test_furniture_is_nobody():
    scene = open_crowd("furniture_before", seed=0)
    frame = scene.frame(0)
    for mask in people_in(scene, frame):
        assert owner(mask, frame) == 1


def test_without_people_nobody_is_found():
    depth_m = np.full((480, 640), 3.0, np.float32)
    scene = open_crowd("seated_child", seed=0)
    assert find_people(depth_m, scene.info.calibration.depth, None) == ()
    nothing = np.full((480, 640), np.nan, np.float32)
    assert find_people(nothing, scene.info.calibration.depth, scene.info.calibration.floor) == ()


def test_a_raised_hand_does_not_hide_who_was_there_before(pupil):
    frame = pupil.frame(0)
    calibration = pupil.info.calibration
    place_m = np.median(frame.people[0].joints_m[:9], axis=0)
    masks = find_people(
        depth_of(pupil, frame), calibration.depth, calibration.floor, known_m=place_m[None]
    )
    assert [owner(mask, frame) for mask in masks] == [1]


@pytest.mark.parametrize("name", crowd_names()[1:3])
def test_frames_of_crowds_come_out_the_same_every_time(name):
    first, second = (open_crowd(name, seed=3).frame(5) for _ in range(2))
    np.testing.assert_array_equal(first.sensor_frame.depth_raw, second.sensor_frame.depth_raw)
    assert [one.visible_share for one in first.people] == [
        one.visible_share for one in second.people
    ]


def test_the_truth_of_a_crowd_lies_in_its_pictures(children):
    frame = children.frame(45)
    for person in frame.people:
        assert 0.0 <= person.visible_share <= 1.0
        assert (frame.owners == person.person).any()
    assert ((frame.labels > 0) == (frame.owners > 0)).all()
    hidden = min(frame.people, key=lambda one: one.visible_share)
    assert hidden.visible_share < 0.95
    with pytest.raises(IndexError, match="frame 90 of 90"):
        children.frame(90)


def test_joints_of_true_parts_are_where_they_are_and_numbers_stay(children):
    calibration = children.info.calibration
    now = {}

    def true_parts(_depth_m, pixels):
        labels = now["frame"].labels
        chosen = np.where(pixels, labels.astype(np.int16) - 1, -1).astype(np.int16)
        rows = np.zeros((int(pixels.sum()), len(FULL_BODY)), np.float32)
        of_pixel = chosen[pixels]
        rows[np.flatnonzero(of_pixel >= 0), of_pixel[of_pixel >= 0]] = 1.0
        return LimbParts(FULL_BODY, pixels.copy(), rows, chosen)

    estimator = PoseEstimator(calibration.depth, true_parts, calibration.floor)
    numbers, errors_m = {}, []
    for index in range(0, 90, 15):
        now["frame"] = frame = children.frame(index)
        found = estimator.look(depth_of(children, frame), frame.sensor_frame.timestamp_ns * 1e-9)
        for one in found.people:
            who = int(np.bincount(frame.owners[one.pixels], minlength=3)[1:].argmax()) + 1
            numbers.setdefault(who, set()).add(one.person)
            truth = frame.people[who - 1]
            far_m = np.linalg.norm(one.joints.joints_m - truth.joints_m, axis=1)
            errors_m.append(np.where(truth.in_view, far_m, np.nan))
    assert all(len(found) == 1 for found in numbers.values())
    assert numbers[1] != numbers[2]
    errors_m = np.array(errors_m)
    assert np.nanmedian(errors_m) < 0.05
    head = errors_m[:, JOINT_NAMES.index("head")]
    assert np.nanmax(head) < 0.1
