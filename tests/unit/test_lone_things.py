"""Things without people: the same every time, in front of a wall, of every kind."""

import cv2
import numpy as np
import pytest

from adibas.simulation.lone_things import KINDS, ThingFrames


def test_an_image_depends_on_its_seed_and_number_alone():
    first = ThingFrames(3)
    first.frame(0)
    before, again = first.frame(4), ThingFrames(3).frame(4)
    np.testing.assert_array_equal(before.depth_mm, again.depth_mm)
    np.testing.assert_array_equal(before.mask, again.mask)
    assert not np.array_equal(before.depth_mm, ThingFrames(4).frame(4).depth_mm)


@pytest.mark.parametrize("number", range(len(KINDS)))
def test_a_thing_stands_before_the_wall_and_nothing_else_is_there(number):
    frame = ThingFrames(8, has_damage=False).frame(number)
    assert frame.kind == KINDS[number]
    measured = frame.depth_mm > 0
    assert np.count_nonzero(frame.mask & measured) > 100
    around = cv2.dilate(frame.mask.astype(np.uint8), np.ones((11, 11), np.uint8)) > 0
    wall_mm = frame.depth_mm[measured & ~around]  # none where it is beyond the sensor's reach
    farthest_mm = np.percentile(frame.depth_mm[measured & frame.mask], 90)
    assert np.count_nonzero(wall_mm < farthest_mm) <= 0.02 * len(wall_mm)
