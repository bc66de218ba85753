"""The plot of the markers: upright, to scale, and nothing where there is no scale."""

import math

import numpy as np
import pytest

from adibas.data.calibration import RgbdCalibration
from adibas.data.corrections import FreeMeasure
from adibas.data.markers import Marker
from adibas.data.posture import PostureAnalysis, Provenance
from adibas.data.report import CaptureReport
from adibas.geometry.planes import Plane
from adibas.geometry.rigid import RigidTransform
from adibas.reports.plots import marker_plot, upright_places_mm

LEAN = math.radians(10.0)
ROLLED = np.array(
    [
        [math.cos(LEAN), -math.sin(LEAN), 0.0],
        [math.sin(LEAN), math.cos(LEAN), 0.0],
        [0.0, 0.0, 1.0],
    ]
)
"""A camera that hangs aslant: turns points of the upright world into its own axes."""


def capture(places_m, calibration=None, measures=()):
    markers = tuple(
        Marker(f"m{i}", 0.0, 0.0, 2.0, np.eye(2), place_m, np.eye(3) * 1e-6)
        if place_m is not None
        else Marker(f"m{i}", 0.0, 0.0, 2.0, np.eye(2))
        for i, place_m in enumerate(places_m)
    )
    analysis = PostureAnalysis(
        patient="",
        view="anterior",
        n_frames=1,
        first_frame=0,
        markers=markers,
        rejected=(),
        distances=(),
        angles=(),
        picture_rgb=np.zeros((4, 4, 3), np.uint8),
        calibration=calibration or RgbdCalibration(),
        provenance=Provenance("", "", "", "", {}),
    )
    return CaptureReport(analysis, measures=measures)


@pytest.mark.parametrize("known", ["floor", "gravity"])
def test_a_camera_that_hangs_aslant_still_gives_upright_places(known):
    down_depth = ROLLED @ np.array([0.0, 1.0, 0.0])
    calibration = RgbdCalibration(
        color_from_depth=RigidTransform(np.eye(3), np.zeros(3)),
        floor=Plane(-down_depth, 1.0) if known == "floor" else None,
        gravity=down_depth if known == "gravity" else None,
    )
    world_m = [np.array([0.2, -0.5, 2.0]), np.array([-0.2, 0.5, 2.0]), np.array([0.0, 0.0, 2.5])]
    places = upright_places_mm(capture([ROLLED @ place for place in world_m], calibration))
    assert places["m0"] == pytest.approx((200.0, 500.0))
    assert places["m1"] == pytest.approx((-200.0, -500.0))
    assert places["m2"] == pytest.approx((0.0, 0.0), abs=1e-9)


@pytest.mark.parametrize("side_deg", [90.0, -90.0])
@pytest.mark.parametrize("off_deg", [-2.0, 0.0, 2.0])
def test_a_camera_on_its_side_that_looks_down_a_little_mirrors_nobody(side_deg, off_deg):
    roll, pitch = math.radians(side_deg + off_deg), math.radians(5.0)
    rolled = np.array(
        [
            [math.cos(roll), -math.sin(roll), 0.0],
            [math.sin(roll), math.cos(roll), 0.0],
            [0.0, 0.0, 1.0],
        ]
    )
    pitched = np.array(
        [
            [1.0, 0.0, 0.0],
            [0.0, math.cos(pitch), -math.sin(pitch)],
            [0.0, math.sin(pitch), math.cos(pitch)],
        ]
    )
    camera_from_world = rolled @ pitched
    calibration = RgbdCalibration(gravity=camera_from_world @ np.array([0.0, 1.0, 0.0]))
    world_m = [np.array([0.2, -0.5, 2.0]), np.array([-0.2, 0.5, 2.4])]
    places = upright_places_mm(capture([camera_from_world @ one for one in world_m], calibration))
    assert places["m0"] == pytest.approx((200.0, 500.0))
    assert places["m1"] == pytest.approx((-200.0, -500.0))


def test_without_a_vertical_the_upper_side_of_the_turned_picture_is_up():
    shown = capture([np.array([-0.3, -0.1, 2.0]), np.array([0.3, 0.1, 2.0])])
    assert upright_places_mm(shown, 90)["m0"] == pytest.approx((100.0, 300.0))
    assert upright_places_mm(shown, 180)["m0"] == pytest.approx((300.0, -100.0))
    assert upright_places_mm(shown, 270)["m0"] == pytest.approx((-100.0, -300.0))


def test_without_a_vertical_the_upper_side_of_the_picture_is_up():
    places = upright_places_mm(capture([np.array([0.1, -0.3, 2.0]), np.array([-0.1, 0.3, 2.0])]))
    assert places["m0"] == pytest.approx((100.0, 300.0))


def test_the_plot_has_the_size_asked_for_and_shows_its_measures():
    places_m = [np.array([0.2, -0.5, 2.0]), np.array([-0.2, 0.5, 2.0]), None]
    plain = marker_plot(capture(places_m), 288.0, 144.0)
    assert plain.shape == (400, 800, 3)
    measures = (FreeMeasure(("m0", "m1")), FreeMeasure(("m0", "m2")))
    drawn = marker_plot(capture(places_m, measures=measures), 288.0, 144.0)
    is_green = (drawn[..., 1] > drawn[..., 0] + 60) & (drawn[..., 1] > drawn[..., 2] + 20)
    assert is_green.sum() > 100
    assert not np.array_equal(plain, drawn)


@pytest.mark.parametrize("places_m", [[], [None, None], [np.array([0.0, 0.0, 2.0]), None]])
def test_fewer_than_two_places_make_no_plot(places_m):
    assert marker_plot(capture(places_m), 288.0, 144.0) is None
