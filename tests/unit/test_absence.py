"""Why nobody is found in a picture, and where a picture cuts somebody off."""

import numpy as np
import pytest

from adibas.body.absence import why_nobody
from adibas.body.holes import fill_gaps, hole_share
from adibas.data.frames import depth_in_metres
from adibas.geometry.picture_edges import cut_px, seen_box
from adibas.limbs.judging import Judgement
from adibas.pipeline.mending import mended
from adibas.simulation.crowd_sensors import CrowdSensor
from adibas.simulation.crowds import CrowdScene
from adibas.simulation.odd_plans import ODD_PLANS
from adibas.skeleton.picture import CUT_MARGIN_M, Picture


def absence_in(name, holes=0.0, seed=3):
    scene = CrowdScene(ODD_PLANS[name], seed, CrowdSensor(None, holes))
    raw = scene.frame(0).sensor_frame.depth_raw
    depth_m = depth_in_metres(raw, scene.info.depth_unit_m)
    calibration = scene.info.calibration
    return why_nobody(depth_m, calibration.depth, calibration.floor)


@pytest.mark.parametrize(
    ("name", "holes", "expected"),
    [
        ("empty", 0.0, "nobody"),
        ("near", 0.0, "near"),
        ("empty", 0.5, "holes"),
        ("person", 0.95, "blind"),
        ("legs", 0.0, "cut"),
        ("sitting_dog", 0.0, "thing"),
        ("office_chair", 0.0, "thing"),
    ],
)
def test_the_reason_is_what_the_scene_was_made_of(name, holes, expected):
    assert absence_in(name, holes) == expected


def test_somebody_nearer_than_the_sensor_measures_leaves_a_large_part_without_depth():
    assert absence_in("near", seed=5) == "gap"


def test_holes_are_counted_where_measured_pixels_surround_them():
    measured = np.zeros((100, 200), np.bool_)
    measured[10:90, 20:120] = True
    assert hole_share(measured) == 0
    measured[20:80:4, 30:110] = measured[21:80:4, 30:110] = False
    assert hole_share(measured) == pytest.approx(30 * 80 / (80 * 100))


def test_small_gaps_get_the_depth_of_the_nearest_pixel_and_nothing_between_two():
    depth_m = np.full((100, 200), 3.0, np.float32)
    depth_m[:, 100:] = 1.5
    depth_m[::2, ::3] = np.nan
    depth_m[40:60, 20:60] = np.nan
    filled_m = fill_gaps(depth_m)
    measured = np.isfinite(depth_m)
    np.testing.assert_array_equal(filled_m[measured], depth_m[measured])
    assert set(np.unique(filled_m[np.isfinite(filled_m)])) == {np.float32(1.5), np.float32(3.0)}
    assert (filled_m[:, 103:] == np.float32(1.5)).all()
    assert np.isnan(filled_m[50, 40]), "a large hole stays"
    assert np.isfinite(filled_m[10]).all()
    nothing = np.full((4, 4), np.nan, np.float32)
    assert np.isnan(fill_gaps(nothing)).all()


def test_a_good_picture_stays_as_it_is_to_the_last_bit():
    scene = CrowdScene(ODD_PLANS["person"], 3)
    depth_m = depth_in_metres(scene.frame(0).sensor_frame.depth_raw, scene.info.depth_unit_m)
    same, said = mended(depth_m)
    assert same is depth_m
    assert said == Judgement(True, ())


def test_the_columns_that_never_have_depth_are_no_part_of_the_picture():
    measured = np.ones((100, 200), np.bool_)
    measured[:, :4] = False
    assert seen_box(measured) == (0, 100, 4, 200)
    measured[:, :60] = False
    assert seen_box(measured) == (0, 100, 0, 200), "a wide dark stretch is not the edge"
    alone = np.zeros((100, 200), np.bool_)
    alone[20:98, 80:120] = True
    assert seen_box(alone) == (0, 100, 0, 200), "nor is where somebody ends"


def test_what_touches_an_edge_is_counted_there():
    mask = np.zeros((100, 200), np.bool_)
    mask[30:80, 4:50] = True
    assert cut_px(mask, (0, 100, 4, 200)).tolist() == [0, 0, 50, 0]
    mask[80:, 20:30] = True
    assert cut_px(mask, (0, 100, 4, 200)).tolist() == [0, 10, 50, 0]


def test_joints_beyond_the_picture_or_beside_its_cut_are_not_shown():
    scene = CrowdScene(ODD_PLANS["empty"], 0)
    camera = scene.info.calibration.depth
    k = camera.intrinsics
    edge_m = 2.0 * (0 - k.cx) / k.fx
    joints_m = np.array(
        [[edge_m + 0.02, 0, 2.0], [edge_m - 0.02, 0, 2.0], [0, 0, 2.0], [np.nan] * 3]
    )
    whole = Picture(camera, (0, 480, 0, 640), (False, False, False, False))
    assert whole.shows(joints_m).tolist() == [True, False, True, False]
    cut = Picture(camera, (0, 480, 0, 640), (False, False, True, False))
    assert CUT_MARGIN_M > 0.02
    assert cut.shows(joints_m).tolist() == [False, False, True, False]


@pytest.mark.parametrize(
    ("is_cut", "shows_stature"),
    [
        ((False, False, False, False), True),
        ((False, True, False, False), True),
        ((True, False, False, False), False),
        ((False, False, True, False), False),
        ((False, True, False, True), False),
    ],
)
def test_how_high_somebody_reaches_is_seen_where_neither_head_nor_side_is_cut(
    is_cut, shows_stature
):
    camera = CrowdScene(ODD_PLANS["empty"], 0).info.calibration.depth
    assert Picture(camera, (0, 480, 0, 640), is_cut).shows_stature == shows_stature
