"""Four recordings of a standing body become one surface, girths and a report."""

import json
from dataclasses import replace
from itertools import combinations

import numpy as np
import openpyxl
import pypdf
import pytest
from scipy.spatial import cKDTree

from adibas.data.frames import SensorFrame, SourceInfo
from adibas.data.markers import Marker
from adibas.data.posture import Provenance
from adibas.data.surface import BurstDisparity
from adibas.errors import BodyError
from adibas.geometry.rigid import IDENTITY, RigidTransform
from adibas.measures.protocol_store import find_protocol
from adibas.pipeline.back import measure_back
from adibas.pipeline.body import NO_CROWN, girths_of, measure_views
from adibas.pipeline.body_landmarks import MarkedView, doubts_about_landmarks, landmarks_of
from adibas.pipeline.body_views import person_in
from adibas.pipeline.protocol_measuring import ProtocolWish
from adibas.pipeline.whole_body import WholeBody, join_body
from adibas.recordings import create_recording
from adibas.reports.body import write_body
from adibas.reports.body_files import body_to_json
from adibas.reports.body_look_plots import LOOKS, shades_of
from adibas.simulation.depth_noise import EXACT
from adibas.surface.girths import slice_measures
from adibas.surface.merging import BodySurface
from benchmarks.body_scenes import burst, draw_back_scene
from tests.unit.test_back_command import run

PROVENANCE = Provenance("0" * 64, "sha256:0", "0", "2026-01-01T00:00:00+00:00", {})
SIDES = ("posterior", "anterior", "right_lateral", "left_lateral")


def marked_view(scene, view, names):
    """A view with exact markers of a millimetre on some landmarks."""
    marks = scene.posed(view.view).landmarks
    to_color = view.calibration.color_from_depth @ scene.depth_from_world
    markers = (
        Marker(
            *(name, 1.0, 1.0, 2.0, np.eye(2)),
            position_m=to_color.apply(marks[name]),
            covariance_m2=1e-6 * np.eye(3),
        )
        for name in names
    )
    return MarkedView(view, tuple(markers))


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


def test_heights_of_girths_are_shares_of_the_stature_of_views_that_show_the_crown(views):
    whole = join_body(views)
    of_all = {one.definition.measure_id: one.value for one in girths_of(whole, views)}
    cut = [replace(view, is_cut_above=view.view != "anterior") for view in views]
    of_one = {one.definition.measure_id: one.value for one in girths_of(whole, cut)}
    known = [name for name, value in of_all.items() if value is not None]
    assert len(known) >= 8
    for name in known:
        assert of_one[name] == pytest.approx(of_all[name], rel=0.03)


def test_where_every_view_cuts_the_head_off_no_girth_is_told_but_why(views):
    cut = [replace(view, is_cut_above=True) for view in views]
    measures = girths_of(join_body(views), cut)
    assert len(measures) == len(slice_measures(join_body(views).surface, 1.7))
    assert {one.value for one in measures} == {None}
    assert {one.reason for one in measures} == {NO_CROWN}


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
    markers = (
        Marker("c7", 1.0, 1.0, 2.0, np.eye(2), np.zeros(3), 1e-6 * np.eye(3)),
        Marker("m01", 9.0, 9.0, 2.0, np.eye(2), np.zeros(3), 1e-6 * np.eye(3)),
    )
    (found,) = landmarks_of([MarkedView(view, markers) for view in views[:2]], whole)
    assert found.name == "c7"
    assert found.apart_m == pytest.approx(0.002, abs=1e-6)
    assert not doubts_about_landmarks([found])
    far = replace(found, fused=replace(found.fused, apart_sds=4.0))
    (doubt,) = doubts_about_landmarks([far])
    assert "C7 lies 2.0 mm apart" in doubt.text


def test_landmarks_of_all_views_are_measured_between_and_written(views, scene, tmp_path):
    turns = {"posterior": ("c7", "left_psis"), "anterior": ("c7", "sternal_notch")}
    marked = [marked_view(scene, view, turns.get(view.view, ())) for view in views]
    body = measure_views(marked, {view.view: PROVENANCE for view in views}, "P1")
    marks = scene.posed("posterior").landmarks
    wanted_m = {
        frozenset(pair): np.linalg.norm(marks[pair[0]] - marks[pair[1]])
        for pair in combinations(("c7", "left_psis", "sternal_notch"), 2)
    }
    assert {frozenset((one.a, one.b)) for one in body.distances} == set(wanted_m)
    for one in body.distances:
        assert one.value_m == pytest.approx(wanted_m[frozenset((one.a, one.b))], abs=0.004)
        assert one.interval_m[0] < one.value_m < one.interval_m[1]
    assert len(body.angles) == 3
    document = body_to_json(body)
    assert len(document["distances"]) == len(document["angles"]) == 3
    assert {one["name"] for one in document["landmarks"]} == {"c7", "left_psis", "sternal_notch"}
    write_body(body, tmp_path / "r.xlsx", "en")
    book = openpyxl.load_workbook(tmp_path / "r.xlsx")
    assert book.sheetnames == [
        *("Summary", "Measures", "Landmarks", "Distances", "Angles", "Profile")
    ]
    rows = list(book["Landmarks"].iter_rows(values_only=True))
    assert len(rows) == 4
    assert rows[1][0] == "C7"


def test_a_protocol_is_measured_by_each_view_and_by_all_of_them(views, scene, tmp_path):
    protocol = find_protocol("sapo-1")
    of_view = {
        side: [one.landmark_id for one in protocol.landmarks if side in one.views] for side in SIDES
    }
    marked = [marked_view(scene, view, of_view[view.view]) for view in views]
    provenances = {view.view: PROVENANCE for view in views}
    body = measure_views(marked, provenances, "P1", ProtocolWish(protocol))
    rows = body_to_json(body)["protocol"]["measures"]
    assert [row["view"] for row in rows] == sorted(
        (row["view"] for row in rows), key=protocol.views.index
    )
    both = [row for row in rows if row["in_view"]["value"] is not None]
    assert len(both) > 20
    near = {"deg": 1.5, "mm": 6.0}
    for row in both:
        if row["unit"] in near:  # of who stands squarely both say nearly the same
            apart = row["all_views"]["value"] - row["in_view"]["value"]
            assert abs(apart) < near[row["unit"]], row
    write_body(body, tmp_path / "r.xlsx", "en")
    cells = list(openpyxl.load_workbook(tmp_path / "r.xlsx")["Protocol"].values)
    assert len(cells) == 1 + len(rows)
    assert cells[1][1] == rows[0]["id"]
    assert cells[1][7] == pytest.approx(rows[0]["all_views"]["value"])
    write_body(body, tmp_path / "r.pdf", "en")
    text = "".join(page.extract_text() for page in pypdf.PdfReader(tmp_path / "r.pdf").pages)
    assert "Measures of SAPO" in text
    assert rows[-1]["id"] in text


def test_a_report_without_a_back_shows_the_body_and_its_landmarks(views, scene, tmp_path):
    turns = {"right_lateral": ("c7",), "anterior": ("c7", "sternal_notch")}
    marked = [
        marked_view(scene, view, turns.get(view.view, ()))
        for view in views
        if view.view != "posterior"
    ]
    body = measure_views(marked, {one.view: PROVENANCE for one in marked}, "P1")
    # Exact depth lacks no rim, for which 8 mm are added.
    true_m = -scene.posed("anterior").vertices_m[:, 1].min()
    assert body.stature_m == pytest.approx(true_m + 0.008, abs=0.008)
    write_body(body, tmp_path / "r.pdf", "en")
    pages = pypdf.PdfReader(tmp_path / "r.pdf").pages
    told = " ".join(page.extract_text() for page in pages)
    assert "Report on the body" in told
    assert "Report on the back" not in told
    assert f"{1e3 * body.stature_m:.0f}" in told
    (mark,) = (one for one in body.landmarks if one.apart_m is not None)
    assert f"{1e3 * mark.apart_m:.1f}" in told.partition("Views apart")[2]
    assert len(pages[-1].images) == 1
    write_body(body, tmp_path / "r.xlsx", "en")
    assert len(openpyxl.load_workbook(tmp_path / "r.xlsx")["Summary"]._images) == 1


@pytest.mark.parametrize(("side", "is_front_right"), [("right_lateral", 1), ("left_lateral", 0)])
def test_a_body_is_drawn_as_each_side_sees_it(side, is_front_right):
    # Two flat pieces that face both sides: a low one of the trunk, and a nose before it.
    y_m, z_m = np.mgrid[0.0:1.0:50j, -0.1:0.1:12j]
    nose = (z_m > -0.06) & (y_m > 0.8)  # what lies behind the nose is missing
    flat = np.column_stack([np.zeros(y_m.size), y_m.ravel(), z_m.ravel()])[~nose.ravel()]
    across, towards = (np.array(axis) for axis in LOOKS[side])
    n = len(flat)
    surface = BodySurface(
        flat, np.tile(towards, (n, 1)), np.ones(n), np.ones(n), np.full((n, 3), np.nan)
    )
    shades, (left_m, right_m, bottom_m, top_m) = shades_of(surface, across, towards)
    upper = np.isfinite(shades[: shades.shape[0] // 6]).any(axis=0)
    assert upper[-1 if is_front_right else 0]
    assert not upper[0 if is_front_right else -1]
    assert (left_m, bottom_m) == pytest.approx((-0.1, 0.0))
    assert (right_m, top_m) == pytest.approx((0.1, 1.0), abs=0.01)
    away, _ = shades_of(surface, across, -towards)
    assert not np.isfinite(away).any(), "what faces the other way is not seen"


def test_a_protocol_takes_markers(tmp_path):
    code, _, err = run(
        "body", "posterior=x.mcap", "--protocol", "sapo-1", "--out", tmp_path / "b.ply"
    )
    assert code == 1
    assert "--markers" in err
