"""A protocol on landmarks of all views gives what a sensor would that saw the side squarely."""

from dataclasses import replace
from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest

from adibas.data.markers import Marker
from adibas.data.protocol_measures import PlaneChoice, VerticalOrigin
from adibas.geometry.planes import Plane
from adibas.geometry.rigid import IDENTITY, RigidTransform
from adibas.measures.protocol_measures import Capturing, measure_protocol
from adibas.measures.protocol_store import find_protocol
from adibas.measures.sight_plane import Vertical
from adibas.pipeline.body_landmarks import Landmark, MarkedView
from adibas.pipeline.body_protocol import notices_of_sides, protocol_of_body
from adibas.pipeline.protocol_measuring import ProtocolWish
from adibas.simulation.scenes import open_scene
from adibas.surface.fused_landmarks import SeenPlace, fuse_places

CAMERA_FROM_PATIENT = {
    # Rows: what lies right in the picture, below, and away; the patient: right, up, back.
    "posterior": np.array([[1.0, 0, 0], [0, -1, 0], [0, 0, -1]]),
    "anterior": np.array([[-1.0, 0, 0], [0, -1, 0], [0, 0, 1]]),
    "right_lateral": np.array([[0, 0, -1.0], [0, -1, 0], [-1, 0, 0]]),
    "left_lateral": np.array([[0, 0, 1.0], [0, -1, 0], [1, 0, 0]]),
}
"""By hand: from the right the face, which is before, is on the picture's right."""
AWAY_M = np.array([0.0, 0.0, 2.5])
SD_M = 0.001
FLOOR = Plane(np.array([0.0, -1.0, 0.0]), 1.0)


@cache
def scene():
    return open_scene("posterior", 3, has_color=False)


@cache
def places_m():
    """Landmarks of a simulated patient, seen from behind: right, up and back."""
    landmarks = scene().person(0)[1].landmarks
    return {name: np.array([1.0, -1.0, -1.0]) * place for name, place in landmarks.items()}


def wish(name="sapo-1", plane=PlaneChoice.SENSOR):
    return ProtocolWish(find_protocol(name), plane)


def sides_of(places, wanted, calibration=None, views=()):
    """Follow a protocol on landmarks that one view saw, the posterior one."""
    landmarks = [
        Landmark(
            *(name, {"posterior": place, "anterior": place}, 0.0),
            fuse_places([SeenPlace(0, place, SD_M**2 * np.eye(3), np.zeros((3, 1)))], None),
        )
        for name, place in places.items()
    ]
    seen = SimpleNamespace(
        view="posterior", calibration=calibration or scene().info.calibration, floor=FLOOR
    )
    level = RigidTransform(np.diag([1.0, -1.0, -1.0]), np.zeros(3))
    return protocol_of_body(wanted, [MarkedView(seen), *views], landmarks, level)


def as_seen(side, places):
    """Markers in the axes of a camera to which the side is shown."""
    return [
        Marker(
            *(name, 0.0, 0.0, 3.0, np.eye(2)),
            position_m=CAMERA_FROM_PATIENT[side] @ place + AWAY_M,
            covariance_m2=SD_M**2 * np.eye(3),
            shared_m=np.zeros((3, 1)),
        )
        for name, place in places.items()
    ]


@pytest.mark.parametrize("plane", [PlaneChoice.SENSOR, PlaneChoice.ACROMIA])
@pytest.mark.parametrize("side", tuple(CAMERA_FROM_PATIENT))
def test_each_side_measures_as_a_sensor_does_that_sees_it_squarely(side, plane):
    sides = {one.view: one for one in sides_of(places_m(), wish(plane=plane))}
    up = Vertical(np.array([0.0, -1.0, 0.0]), 0.0, VerticalOrigin.GRAVITY, is_sd_known=False)
    wanted = measure_protocol(
        wish().protocol, as_seen(side, places_m()), Capturing(side, up, plane)
    )
    found = sides[side].fused
    assert found.vertical is VerticalOrigin.GRAVITY
    n_known = 0
    for one, other in zip(found.results, wanted.results, strict=True):
        assert (one.main is None) == (other.main is None)
        if one.main is not None and other.main is not None:
            n_known += 1
            assert one.main.value == pytest.approx(other.main.value, abs=1e-9)
            assert one.main.interval == pytest.approx(other.main.interval, abs=1e-9)
    assert n_known > 2


def test_sides_that_nobody_captured_are_measured_where_others_saw_their_landmarks():
    sides = {one.view: one for one in sides_of(places_m(), wish())}
    assert sides["posterior"].seen is not None
    assert sides["right_lateral"].seen is None
    assert all(seen is None for seen, _fused in sides["right_lateral"].pairs())
    assert any(fused.main is not None for _seen, fused in sides["right_lateral"].pairs())


def test_a_view_is_measured_by_its_own_markers_beside():
    calibration = replace(scene().info.calibration, color_from_depth=IDENTITY)
    seen = SimpleNamespace(view="posterior", calibration=calibration)
    views = [MarkedView(seen, tuple(as_seen("posterior", places_m())))]
    (posterior,) = [
        one for one in sides_of(places_m(), wish(), views=views) if one.view == "posterior"
    ]
    pairs = [pair for pair in posterior.pairs() if pair[1].main is not None]
    assert pairs
    for own, fused in pairs:
        assert own.main.value == pytest.approx(fused.main.value, abs=1e-9)


def test_a_tilted_sensor_takes_the_vertical_that_it_knows():
    """The floor leans by 3 degrees in the picture; gravity tells, and everything leans with it."""
    tilt = np.radians(3.0)
    gravity = np.array([np.sin(tilt), np.cos(tilt), 0.0])
    calibration = replace(scene().info.calibration, gravity=gravity)
    level, leaning = (
        next(one for one in sides_of(places_m(), wish(), given) if one.view == "anterior")
        for given in (None, calibration)
    )
    straight, tilted = (
        {one.definition.measure_id: one.main for one in some.fused.results}
        for some in (level, leaning)
    )
    lines = [one for one in level.fused.results if one.definition.kind == "line_to_horizontal"]
    known = [one.definition.measure_id for one in lines if one.main is not None]
    assert known
    for name in known:
        apart = tilted[name].value - straight[name].value
        assert abs(apart) == pytest.approx(tilt, abs=1e-6)


def test_without_a_known_vertical_the_floor_gives_it_and_that_is_told():
    calibration = replace(scene().info.calibration, gravity=None, floor=None)
    sides = sides_of(places_m(), wish(), calibration)
    assert all(one.fused.vertical is VerticalOrigin.FLOOR for one in sides)
    own = replace(sides[0], seen=sides[0].fused)
    (notice,) = notices_of_sides([own, *(one for one in sides if one.seen is None)])
    assert "How sure the vertical is" in notice.text


def test_landmarks_of_other_sides_are_no_strangers_and_exchanged_ones_are_told_once():
    names = {"left": "right", "right": "left"}
    exchanged = {
        "_".join([names.get(name.split("_")[0], name.split("_")[0]), *name.split("_")[1:]]): place
        for name, place in places_m().items()
    }
    told = [notice.text for notice in notices_of_sides(sides_of(exchanged, wish()))]
    assert len([text for text in told if "left and right are exchanged" in text]) == 1
    assert not any("No landmark of this protocol" in text for text in told)
