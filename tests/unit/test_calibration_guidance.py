"""The wizard knows which pictures of the board are lacking, and when to take one."""

import math

import numpy as np
import pytest

from adibas.calibration.guidance import (
    ENOUGH,
    FARTHER,
    LEAN_TEXTS,
    MORE,
    NEARER,
    PLACES,
    StillWatch,
    guide,
    is_new,
    stance_of,
)
from adibas.data.board import Board, BoardCorners
from adibas.data.calibration import CameraCalibration
from adibas.geometry.pinhole import Intrinsics
from adibas.geometry.rigid import RigidTransform, rotation_from_vector
from adibas.simulation.boards import corner_pixels
from adibas.simulation.boards_poses import random_board_poses

BOARD = Board(9, 6, 0.03)
CAMERA = CameraCalibration(1280, 1024, Intrinsics(1050.0, 1050.0, 639.5, 511.5))


def seen(camera_from_board, hidden=()):
    pixels = corner_pixels(BOARD, camera_from_board, CAMERA)
    pixels[list(hidden)] = np.nan
    return BoardCorners("a", 1280, 1024, pixels, np.where(np.isnan(pixels[:, 0]), np.nan, 0.05))


def held(right_rad=0.0, down_rad=0.0, middle_m=(0.0, 0.0, 1.0)):
    """Hold the board so that it faces so much to the right and down of the image."""
    rotation = rotation_from_vector(np.array([down_rad, -right_rad, 0.0]))
    middle = np.array([4.0, 2.5, 0.0]) * BOARD.square_m
    return RigidTransform(rotation, np.array(middle_m) - rotation @ middle)


def stance(*args, **kwargs):
    return stance_of(seen(held(*args, **kwargs)), BOARD, CAMERA.intrinsics)


@pytest.mark.parametrize(
    ("right_rad", "down_rad", "side"),
    [(-0.4, 0.0, "left"), (0.4, 0.0, "right"), (0.0, -0.4, "up"), (0.0, 0.4, "down")],
)
def test_a_board_leans_to_the_side_that_it_faces(right_rad, down_rad, side):
    found = stance(right_rad, down_rad)
    assert found.lean_rad == pytest.approx([right_rad, down_rad], abs=1e-6)
    assert found.leans(math.radians(15)) == (side,)
    assert stance(0.1, 0.1).leans(math.radians(15)) == ()


def test_place_and_size_are_shares_of_the_picture():
    found = stance(middle_m=(0.2, -0.1, 1.4))
    assert found.place == pytest.approx([0.2 / 1.4 * 1050 / 1280, -0.1 / 1.4 * 1050 / 1280])
    assert found.width_share == pytest.approx(0.30 / 1.4 * 1050 / 1280, rel=1e-6)
    assert found.size == pytest.approx(math.sqrt(0.24 * 0.15) / 1.4 * 1050 / 1280, rel=1e-6)


def test_without_a_calibration_a_usual_camera_tells_the_sides_as_well():
    assert stance_of(seen(held(0.4)), BOARD).leans(math.radians(15)) == ("right",)


def test_hidden_corners_change_nothing_and_too_few_tell_nothing():
    whole, partly = stance(0.3), stance_of(seen(held(0.3), range(9, 27)), BOARD, CAMERA.intrinsics)
    assert partly.lean_rad == pytest.approx(whole.lean_rad, abs=1e-6)
    assert stance_of(seen(held(0.3), range(9, 54)), BOARD) is None  # one line


def test_a_view_is_new_by_its_place_its_size_or_its_lean():
    first = stance()
    assert is_new(first, [])
    assert not is_new(stance(0.05, middle_m=(0.02, 0.02, 1.02)), [first])
    for other in (stance(0.3), stance(middle_m=(0.2, 0, 1)), stance(middle_m=(0, 0, 2))):
        assert is_new(other, [first])
        assert not is_new(other, [first, other])


def advice(poses):
    pictures = [seen(pose) for pose in poses]
    return guide(pictures, [stance_of(one, BOARD, CAMERA.intrinsics) for one in pictures])


def test_at_first_everything_is_lacking():
    found = guide([], [])
    assert set(found.lacking) == {*LEAN_TEXTS.values(), *PLACES.values(), NEARER, FARTHER, MORE}
    assert not found.covered.any()


def test_many_views_of_somebody_who_knows_what_is_wanted_suffice():
    poses = random_board_poses(np.random.default_rng(1), BOARD, CAMERA, 60)
    found = advice(poses)
    assert found.lacking == ()
    assert found.next_step == ENOUGH
    assert (found.has_near, found.has_far, len(found.leans)) == (True, True, 4)


def test_frontal_views_alone_lack_every_lean_however_many_they_are():
    poses = [held(middle_m=(x, y, 1.0)) for x in (-0.3, 0, 0.3) for y in (-0.25, 0, 0.25)] * 3
    found = advice(poses)
    assert found.lacking[:4] == tuple(LEAN_TEXTS.values())
    assert found.leans == ()


def test_a_part_of_the_picture_that_no_corner_reached_is_named():
    poses = [held(0.4), held(-0.4), held(0, 0.4), held(0, -0.4)]
    poses += [held(middle_m=(x, y, z)) for x in (-0.3, 0, 0.3) for y in (-0.2, 0) for z in (0.5, 1)]
    lacking = advice(poses).lacking
    assert PLACES[0, 0] not in lacking
    assert PLACES[1, 1] in lacking
    assert PLACES[1, -1] in lacking


def test_near_and_far_are_both_asked_for():
    assert {NEARER, FARTHER} <= set(advice([held(middle_m=(0, 0, 0.7))]).lacking)
    near, far = held(middle_m=(0, 0, 0.55)), held(middle_m=(0, 0, 1.0))
    assert NEARER not in advice([near]).lacking
    assert FARTHER in advice([near]).lacking
    assert {NEARER, FARTHER} & set(advice([near, far]).lacking) == set()


def watch(moves_px, step_s=0.1):
    """Return what the watch says of a board that moves so many pixels from frame to frame."""
    still, corners = StillWatch(), seen(held())
    told, shift = [], 0.0
    for i, move_px in enumerate(moves_px):
        if move_px is None:
            told.append(still.see(None, round(i * step_s * 1e9)))
            continue
        shift += move_px
        moved = BoardCorners("a", 1280, 1024, corners.pixels + shift, corners.sigma_px.copy())
        told.append(still.see(moved, round(i * step_s * 1e9)))
    return told


def test_a_board_is_still_after_four_tenths_of_a_second():
    assert watch([0.0] * 6) == pytest.approx([0, 0.25, 0.5, 0.75, 1, 1])


def test_a_board_that_moves_or_goes_begins_anew():
    assert watch([0, 0, 0, 5.0, 0, 0])[-3:] == pytest.approx([0, 0.25, 0.5])
    assert watch([0, 0, 0, None, 0, 0])[-3:] == pytest.approx([0, 0, 0.25])


def test_a_slow_drift_is_motion_too():
    assert watch([1.5] * 10) == [0.0] * 10


def test_frames_of_one_moment_tell_nothing():
    assert watch([0.0] * 5, step_s=0.0) == [0.0] * 5


def test_no_corner_in_common_is_motion():
    still = StillWatch()
    still.see(seen(held(), range(20)), 0)
    assert still.see(seen(held(), range(20, 54)), 100_000_000) == 0.0
