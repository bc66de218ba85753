"""Four recordings of a standing body become one surface, girths and a report."""

import json
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial import cKDTree

from adibas.data.frames import SensorFrame, SourceInfo
from adibas.data.markers import Marker
from adibas.data.surface import BurstDisparity
from adibas.errors import BodyError
from adibas.geometry.rigid import IDENTITY, RigidTransform
from adibas.pipeline.back import measure_back
from adibas.pipeline.body import _landmarks
from adibas.pipeline.body_views import person_in
from adibas.pipeline.whole_body import WholeBody, join_body
from adibas.recordings import create_recording
from adibas.simulation.depth_noise import EXACT
from benchmarks.body_scenes import burst, draw_back_scene
from tests.unit.test_back_command import run

SIDES = ("posterior", "anterior", "right_lateral", "left_lateral")


@pytest.fixture(scope="module")
def scene():
    return draw_back_scene(1, is_portrait=True)


@pytest.fixture(scope="module")
def depths(scene):
    return {
        side: next(burst(scene, scene.posed(side), 1, number, EXACT))
        for number, side in enumerate(SIDES)
    }


@pytest.fixture(scope="module")
def views(scene, depths):
    found = []
    for side, depth_m in depths.items():
        corrected_m = scene.calibration.corrected_depth(depth_m)
        surface = BurstDisparity(1.0 / corrected_m, np.ones(depth_m.shape, np.int64), 1)
        found.append(person_in(side, surface, scene.calibration))
    return found


def test_four_views_are_one_body(scene, views):
    whole = join_body(views)
    axes = whole.patient_from_camera["posterior"]
    body_m = axes.apply(scene.depth_from_world.apply(scene.posed("posterior").vertices_m))
    triangles = scene.patient.body.model.triangles
    corners = body_m[triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
    nearest = cKDTree(corners.mean(axis=1)).query(whole.surface.points_m)[1]
    off_m = ((whole.surface.points_m - corners.mean(axis=1)[nearest]) * normals[nearest]).sum(
        axis=1
    )
    assert np.median(np.abs(off_m)) < 0.0015
    assert np.quantile(np.abs(off_m), 0.95) < 0.006


def test_the_surface_has_the_colours_of_the_picture(views):
    calibration = views[0].calibration
    picture = np.zeros((calibration.color.height, calibration.color.width, 3), np.uint8)
    picture[:] = (200, 100, 50)
    whole = join_body([replace(views[0], picture_rgb=picture)])
    colors = whole.surface.colors
    known = np.isfinite(colors).all(axis=1)
    assert known.mean() > 0.5
    np.testing.assert_array_equal(np.unique(colors[known], axis=0), [[200.0, 100.0, 50.0]])
    assert np.isnan(join_body([views[0]]).surface.colors).all()


def test_a_side_is_given_once(views):
    with pytest.raises(BodyError, match="given twice"):
        join_body([views[0], views[0]])


def test_opposite_sides_alone_do_not_hold_together(views):
    with pytest.raises(BodyError, match="posterior \\+ anterior"):
        join_body(views[:2])


def test_a_front_is_not_measured_as_a_back(views):
    with pytest.raises(BodyError, match="toes"):
        measure_back(replace(views[1], view="posterior"))
    assert measure_back(views[0]).shape is not None


def test_the_command_writes_surface_girths_and_report(tmp_path, scene, depths):
    told = []
    info = SourceInfo(calibration=scene.calibration, depth_unit_m=0.001)
    for side, depth_m in depths.items():
        path = tmp_path / f"{side}.mcap"
        raw = np.nan_to_num(np.round(1000.0 * depth_m)).astype(np.uint16)
        with create_recording(path, info) as recording:
            recording.write(
                SensorFrame(
                    sequence=0,
                    timestamp_ns=10**9,
                    depth_raw=raw,
                    color=None,
                    color_timestamp_ns=None,
                )
            )
        told.append(f"{side}={path}")
    ply, report = tmp_path / "body.ply", tmp_path / "body.pdf"
    code, out, _ = run("body", *told, "--out", ply, "--report", report, "--json")
    assert code == 0
    document = json.loads(out)
    measures = {one["id"]: one for one in document["measures"]}
    assert set(document["views"]) == set(SIDES)
    assert 600.0 < measures["GIRTH.TRUNK.LEAST"]["value"] < 1300.0
    low, high = measures["GIRTH.TRUNK.LEAST"]["ci95"]
    assert low < measures["GIRTH.TRUNK.LEAST"]["value"] < high
    assert measures["BACK.KYPHOSIS"]["value"] > 15.0
    assert ply.stat().st_size > 100_000
    assert report.stat().st_size > 10_000


def test_landmarks_seen_twice_tell_how_far_they_are_apart(views):
    moved = RigidTransform(np.eye(3), np.array([0.0, 0.0, 0.004]))
    poses = {"posterior": IDENTITY, "anterior": moved}
    whole = WholeBody(poses, join_body(views[:1]).surface, None)
    markers = {
        side: (
            Marker("c7", 1.0, 1.0, 2.0, np.eye(2), np.zeros(3), 1e-6 * np.eye(3)),
            Marker("m01", 9.0, 9.0, 2.0, np.eye(2), np.zeros(3), 1e-6 * np.eye(3)),
        )
        for side in poses
    }
    (found,) = _landmarks(views[:2], markers, whole)
    assert found.name == "c7"
    assert found.apart_m == pytest.approx(0.002, abs=1e-6)
