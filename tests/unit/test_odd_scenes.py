"""Scenes that joints are seldom found in show what their names say."""

import numpy as np
import pytest

from adibas.simulation.crowd_sensors import CrowdSensor
from adibas.simulation.crowds import CrowdScene
from adibas.simulation.lone_things import KINDS
from adibas.simulation.odd_plans import ODD_PLANS, pinhole


def shown(name, sensor=None, seed=5):
    scene = CrowdScene(ODD_PLANS[name], seed, sensor)
    return scene, scene.frame(3)


def test_somebody_cut_off_is_seen_in_part_at_the_edge_that_is_named():
    whole = shown("person")[1]
    assert whole.people[0].visible_share > 0.95
    for name, edge in (("cut_left", np.s_[:, 9]), ("cut_right", np.s_[:, -1]),
                       ("upper_body", np.s_[-1]), ("legs", np.s_[0])):  # fmt: skip
        _, frame = shown(name)
        assert frame.owners[edge].any(), name
        assert 0.02 < frame.people[0].visible_share < 0.85, name
        assert not frame.people[0].in_view.all(), name


def test_somebody_near_fills_the_picture_and_is_nearer_than_the_sensor_measures_well():
    _, frame = shown("near")
    assert np.median(frame.people[0].joints_m[:, 2]) < 0.9
    assert (frame.owners == 1).mean() > 0.25


@pytest.mark.parametrize("kind", KINDS)
def test_a_thing_alone_stands_before_the_wall_and_is_nobody(kind):
    _, frame = shown(kind)
    _, empty = shown("empty")
    assert not frame.people
    assert not frame.owners.any()
    nearer = frame.sensor_frame.depth_raw.astype(int) + 100 < empty.sensor_frame.depth_raw
    assert 0.005 < np.mean(nearer & (frame.sensor_frame.depth_raw > 0)) < 0.5


@pytest.mark.parametrize("share", [0.2, 0.5, 0.8])
def test_holes_have_their_share_of_the_picture(share):
    whole, holed = (shown("person", CrowdSensor(None, part))[1] for part in (0.0, share))
    measured = whole.sensor_frame.depth_raw > 0
    lost = measured & (holed.sensor_frame.depth_raw == 0)
    assert lost.sum() / measured.sum() == pytest.approx(share, abs=0.03)


def test_another_sensor_sees_the_same_person_at_its_own_size_and_field_of_view():
    camera = pinhole(512, 424, 70.0)
    rim_rad = np.arctan(0.5 * camera.width / camera.intrinsics.fx)
    assert np.degrees(2 * rim_rad) == pytest.approx(70.0)
    scene, frame = shown("person", CrowdSensor(camera))
    assert frame.sensor_frame.depth_raw.shape == (424, 512)
    assert scene.info.calibration.depth is camera
    usual = shown("person")[1]
    np.testing.assert_allclose(frame.people[0].joints_m, usual.people[0].joints_m)
    k = camera.intrinsics
    torso_m = frame.people[0].joints_m[8]
    u, v = k.fx * torso_m[:2] / torso_m[2] + (k.cx, k.cy)
    assert frame.owners[round(v), round(u)] == 1
