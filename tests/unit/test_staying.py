"""Who bends towards the camera stays one person, and two who part do not."""

import numpy as np
import pytest

from adibas.body.people import find_people
from adibas.body.staying import Moment, put_together, shows_less
from adibas.data.masks import BodyMask
from adibas.gestures.model_file import read_model, shipped_gestures
from adibas.pipeline.live_gestures import LiveGestures
from adibas.pipeline.live_people import LivePeople
from adibas.simulation.scenes import open_scene


def metres(depth_raw, info):
    return np.where(depth_raw == 0, np.nan, depth_raw * info.depth_unit_m).astype(np.float32)


def parted(gap_px):
    """Return surfaces of an image, its depth, and who was one there: two halves and a gap."""
    labels = np.zeros((80, 120), np.int32)
    labels[10:70, 20:50] = 1
    labels[10:70, 50 + gap_px : 80 + gap_px] = 2
    depth_m = np.where(labels > 0, 2.0, 3.5).astype(np.float32)
    before = np.zeros(labels.shape, bool)
    before[10:70, 20 : 80 + gap_px] = True
    return labels, depth_m, Moment(depth_m, [before])


def test_halves_that_lie_close_are_the_one_that_was_there():
    labels, depth_m, before = parted(4)
    for found in ([], [BodyMask(labels == 1)], [BodyMask(labels == 1), BodyMask(labels == 2)]):
        (whole,) = put_together(found, labels, depth_m, before)
        assert whole.is_put_together
        np.testing.assert_array_equal(whole.pixels, labels > 0)


@pytest.mark.parametrize(
    ("share", "less"), [(0.0, True), (0.79, True), (0.81, False), (1.2, False)]
)
def test_a_part_may_be_missing_of_who_shows_less_than_four_fifths(share, less):
    were = np.zeros((20, 100), bool)
    were[:, :50] = True
    now = np.zeros_like(were)
    now.ravel()[: round(1000 * share)] = True
    before = Moment(np.ones(were.shape, np.float32), [were])
    assert shows_less(now, before) is less
    assert shows_less(None, before)


def test_two_who_part_are_two():
    labels, depth_m, before = parted(30)
    found = [BodyMask(labels == 1), BodyMask(labels == 2)]
    assert put_together(found, labels, depth_m, before) == tuple(found)


def test_who_is_whole_stays_as_found_and_who_left_leaves_nothing_behind():
    labels, depth_m, before = parted(0)
    whole = BodyMask(labels > 0)
    assert put_together([whole], labels, depth_m, before) == (whole,)
    wall = np.full_like(labels, 3)
    assert put_together([], wall, depth_m, before) == ()
    farther = (depth_m + 1.0).astype(np.float32)
    assert put_together([], labels, farther, before) == ()


def test_who_walks_on_has_not_fallen_apart():
    """A third of the place is left, and an arm is a surface of its own."""
    labels, depth_m, before = parted(0)
    labels[10:70, 50:60] = 1
    walked = np.roll(labels, 20, axis=1)
    found = (BodyMask(walked > 0),)
    assert put_together(found, walked, depth_m, before) == found


def test_who_is_hidden_by_somebody_is_not_put_together():
    labels, depth_m, before = parted(0)
    passing = np.zeros(labels.shape, bool)
    passing[:, 60:120] = True
    labels[passing] = 3
    found = (BodyMask(passing),)
    assert put_together(found, labels, depth_m, before) == found


@pytest.fixture(scope="module")
def bending():
    """Somebody who bends from 1.0 to 4.2 s, 15 frames a second."""
    scene = open_scene("bend", seed=4, has_color=False)
    return scene, [scene.frame(number) for number in range(0, 132, 2)]


def test_a_mask_is_of_the_whole_body_also_at_the_bottom_of_a_bend(bending):
    scene, frames = bending
    calibration = scene.info.calibration
    overlaps = {True: [], False: []}
    before = None
    for frame in frames[:50]:
        depth_m = metres(frame.sensor_frame.depth_raw, scene.info)
        for follows in (True, False):
            moment = before if follows else None
            masks = find_people(depth_m, calibration.depth, calibration.floor, None, None, moment)
            truth = (frame.truth.labels > 0) & np.isfinite(depth_m)
            found = masks[0].pixels if masks else np.zeros_like(truth)
            overlaps[follows].append((found & truth).sum() / (found | truth).sum())
            if follows:
                before = Moment(depth_m, [mask.pixels for mask in masks])
    assert min(overlaps[True]) > 0.8
    assert min(overlaps[False]) < 0.5


def test_a_bend_towards_the_camera_is_told_live(bending):
    scene, frames = bending
    people, live = LivePeople(), LiveGestures([read_model(shipped_gestures())])
    told = []
    for frame in frames:
        depth_m = metres(frame.sensor_frame.depth_raw, scene.info)
        timestamp_ns = frame.sensor_frame.timestamp_ns
        told += [
            (one, timestamp_ns / 1e9)
            for one in live.see(people.look(depth_m, timestamp_ns, scene.info.calibration))
        ]
    ((one, at_s),) = told
    assert (one.person, one.seen.label) == (1, "bend")
    assert one.seen.begin_s == pytest.approx(1.0, abs=0.4)
    assert one.seen.end_s == pytest.approx(4.2, abs=0.4)
    assert at_s - one.seen.end_s < 1.1
