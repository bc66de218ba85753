"""Hidden faces stay hidden: in every view, however the sensor stands, and beyond restoring."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from adibas.data.frames import depth_in_metres
from adibas.data.joints import BODY_PART_NAMES
from adibas.data.markers import Marker
from adibas.data.posture import PostureAnalysis, Provenance
from adibas.data.report import PictureChoice
from adibas.errors import ReportError
from adibas.geometry.distortion import project_distorted
from adibas.markers.disparity import fuse_depth
from adibas.pipeline.posture import PostureParams
from adibas.reports.head import head_in_color
from adibas.reports.pictures import Picture, Spot, draw_markers, picture_of
from adibas.reports.privacy import blurred, depth_picture, see_patient
from adibas.simulation.scenes import open_scene
from tests.unit.films import patient_with_leds


def surface(scene, index):
    depth_m = depth_in_metres(scene.frame(index).sensor_frame.depth_raw, scene.info.depth_unit_m)
    return fuse_depth(
        [depth_m], scene.info.calibration.depth_bias, scene.info.calibration.depth
    ).mean_per_m


def capture(scene, rng, **changes):
    """Return an analysis of the scene with noise for a picture, so that no two pixels are alike."""
    calibration = scene.info.calibration
    color = calibration.color
    return PostureAnalysis(
        **{
            "patient": "p1",
            "view": "",
            "n_frames": 1,
            "first_frame": 0,
            "markers": (),
            "rejected": (),
            "distances": (),
            "angles": (),
            "picture_rgb": rng.integers(0, 256, (color.height, color.width, 3), np.uint8),
            "calibration": calibration,
            "provenance": Provenance("", "", "", "", {}),
            "surface_per_m": surface(scene, 0),
        }
        | changes
    )


def head_vertices_px(scene):
    """Return where the skin of the simulated head is in the colour image, (N, 2)."""
    _patient, posed = scene.person(0)
    parts = posed.body.model.part_weights.argmax(1)
    vertices_m = posed.vertices_m[parts == BODY_PART_NAMES.index("head")]
    calibration = scene.device.calibration
    color_from_world = calibration.color_from_depth @ scene.depth_from_world
    camera = calibration.color
    return project_distorted(
        color_from_world.apply(vertices_m), camera.intrinsics, camera.distortion
    )


def share_covered(region, pixels):
    height, width = region.shape
    columns, rows = np.rint(pixels).astype(int).T
    inside = (columns >= 0) & (columns < width) & (rows >= 0) & (rows < height)
    return region[rows[inside], columns[inside]].mean() if inside.any() else 1.0


SMALL = {"color_size": (480, 640), "has_color": False}
SCENES = {
    "anterior": ("anterior", {}),
    "posterior": ("posterior", {}),
    "left": ("left_lateral", {}),
    "right": ("right_lateral", {}),
    "arm-forward": ("right_lateral", {"posture": "right_arm_forward"}),
    "near": ("anterior", {"distance_m": 1.5}),
    "waving": ("greet", {}),
}


@pytest.mark.parametrize("scene", SCENES)
def test_the_whole_head_is_covered(scene):
    name, changes = SCENES[scene]
    scene = open_scene(name, seed=sum(map(ord, scene)), **SMALL, **changes)
    analysis = capture(scene, np.random.default_rng(1))
    unlevelled = replace(analysis.calibration, floor=None, gravity=None)
    for calibration in (analysis.calibration, unlevelled):
        sight = see_patient(replace(analysis, calibration=calibration), 0)
        region = head_in_color(sight, calibration, PostureParams().up)
        assert share_covered(region, head_vertices_px(scene)) == 1.0
        assert region.mean() < 0.2


def test_a_sensor_on_its_side_shows_an_upright_patient_with_the_head_covered():
    scene = open_scene("anterior", seed=4, mounting="portrait", **SMALL)
    analysis = capture(scene, np.random.default_rng(1))
    sight = see_patient(analysis, 90)
    region = head_in_color(sight, analysis.calibration, PostureParams(rotation_deg=90).up)
    assert share_covered(region, head_vertices_px(scene)) == 1.0
    picture = picture_of(analysis, PictureChoice.DEPTH, 90)
    assert picture.pixels_rgb.shape == (640, 480, 3)


def test_gravity_says_where_the_head_is_where_no_floor_is_known():
    scene = open_scene("anterior", seed=4, mounting="portrait", **SMALL)
    analysis = capture(scene, np.random.default_rng(1))
    calibration = replace(analysis.calibration, floor=None)
    analysis = replace(analysis, calibration=calibration)
    is_hidden = (blurred(analysis, 0) != analysis.picture_rgb).any(axis=2)
    assert share_covered(is_hidden, head_vertices_px(scene)) > 0.99
    region = head_in_color(see_patient(analysis, 0), calibration, -calibration.gravity)
    assert share_covered(region, head_vertices_px(scene)) == 1.0


@pytest.fixture(scope="module")
def scene():
    return open_scene("anterior", seed=3, **SMALL)


@pytest.fixture(scope="module")
def standing(scene):
    return capture(scene, np.random.default_rng(2))


@pytest.mark.parametrize(("n_on_arm", "is_refused"), [(4, True), (9, False)])
def test_a_body_beside_which_markers_lie_is_not_hidden_by_halves(n_on_arm, is_refused):
    """Who bends down may be found as an arm alone, on which a head is found again."""
    scene = patient_with_leds(seed=1, gesture="bend")
    seen = surface(scene, 36)
    bent = capture(scene, np.random.default_rng(0), surface_per_m=seen)
    sight = see_patient(bent, 0)
    (rows, columns), (far_rows, far_columns) = (
        np.nonzero(o) for o in (sight.outline, ~sight.outline)
    )
    places = [(columns[100 * i], rows[100 * i]) for i in range(n_on_arm)]
    places += [(far_columns[100 * i], far_rows[100 * i]) for i in range(10 - n_on_arm)]
    markers = tuple(
        Marker(f"m{i:02d}", float(u), float(v), 3.0, np.eye(2))
        for i, (u, v) in enumerate(places, 1)
    )
    marked = replace(bent, markers=markers)
    if is_refused:
        with pytest.raises(ReportError, match="No head is found"):
            blurred(marked, 0)
    else:
        assert blurred(marked, 0).shape == bent.picture_rgb.shape


def test_nothing_brings_back_what_was_blurred(scene, standing):
    hidden = blurred(standing, 0).astype(float)
    columns, rows = np.rint(head_vertices_px(scene)).astype(int).T
    across = np.diff(hidden, axis=1)[rows, columns]
    original = np.diff(standing.picture_rgb.astype(float), axis=1)[rows, columns]
    assert np.abs(original).mean() > 70
    assert np.abs(across).mean() < 4
    sight = see_patient(standing, 0)
    background = ~cv2.dilate(sight.outline.astype(np.uint8), np.ones((61, 61))).astype(bool)
    assert np.abs(hidden[background] - 127.5).mean() < 12


def test_the_body_below_the_head_stays_as_it_was(standing):
    hidden = blurred(standing, 0)
    sight = see_patient(standing, 0)
    head = head_in_color(sight, standing.calibration, PostureParams().up)
    body = sight.outline & ~head
    assert body.sum() > 10_000
    np.testing.assert_array_equal(hidden[body], standing.picture_rgb[body])


def test_no_picture_is_given_where_no_head_is_found(standing):
    empty = open_scene("empty", seed=3, **SMALL)
    with pytest.raises(ReportError, match="No head is found"):
        blurred(capture(empty, np.random.default_rng(1)), 0)
    with pytest.raises(ReportError, match="No depth was kept"):
        blurred(replace(standing, surface_per_m=None), 0)
    lacking = replace(standing.calibration, color=None)
    with pytest.raises(ReportError, match="lacks a camera"):
        blurred(replace(standing, calibration=lacking), 0)
    with pytest.raises(ReportError, match="No depth was kept"):
        depth_picture(replace(standing, surface_per_m=None), 0)


def test_the_head_of_someone_who_bends_is_covered_or_refused():
    bend = open_scene("bend", seed=3, **SMALL)
    analysis = capture(bend, np.random.default_rng(1))
    camera = bend.device.calibration.color
    n_covered = 0
    for index in range(20, 120, 25):
        sight = see_patient(replace(analysis, surface_per_m=surface(bend, index)), 0)
        region = head_in_color(sight, analysis.calibration, PostureParams().up)
        if region is not None:
            head_m = bend.frame(index).truth.joints_color_m[0]
            u, v = project_distorted(head_m, camera.intrinsics, camera.distortion)
            assert region[round(v), round(u)]
            n_covered += 1
    assert n_covered > 0


def test_the_depth_picture_holds_nothing_of_the_colour_camera(standing):
    other = replace(standing, picture_rgb=np.zeros_like(standing.picture_rgb))
    picture = depth_picture(standing, 0)
    np.testing.assert_array_equal(picture, depth_picture(other, 0))
    sight = see_patient(standing, 0)
    saturation = picture.max(axis=2).astype(int) - picture.min(axis=2)
    body = cv2.erode(sight.outline.astype(np.uint8), np.ones((9, 9))).astype(bool)
    around = ~cv2.dilate(sight.outline.astype(np.uint8), np.ones((9, 9))).astype(bool)
    assert np.median(saturation[body]) > 40
    assert saturation[around].max() < 5


def test_an_empty_room_has_a_depth_picture():
    empty = capture(open_scene("empty", seed=3, **SMALL), np.random.default_rng(1))
    assert depth_picture(empty, 0).std() > 5


@pytest.mark.parametrize("rotation_deg", [0, 90, 180, 270])
def test_markers_turn_with_the_picture(analysis, rotation_deg):
    pixels = np.zeros((120, 160, 3), np.uint8)
    pixels[20, 30] = 255
    marker = Marker("m01", 30.0, 20.0, 4.0, np.eye(2))
    turned = picture_of(
        replace(analysis, picture_rgb=pixels, markers=(marker,)), rotation_deg=rotation_deg
    )
    (spot,) = turned.spots
    assert turned.pixels_rgb[round(spot.v), round(spot.u)].tolist() == [255] * 3
    assert turned.pixels_rgb.shape[:2] == ((120, 160) if rotation_deg % 180 == 0 else (160, 120))


def test_a_cropped_picture_shows_patient_and_markers_and_little_else(standing):
    far = Marker("far", 5.0, 300.0, 4.0, np.eye(2))
    whole = picture_of(standing)
    part = picture_of(standing, is_cropped=True)
    assert part.pixels_rgb.size < 0.6 * whole.pixels_rgb.size
    wider = picture_of(replace(standing, markers=(far,)), is_cropped=True)
    (spot,) = wider.spots
    row, column = round(spot.v), round(spot.u)
    np.testing.assert_array_equal(wider.pixels_rgb[row, column], standing.picture_rgb[300, 5])
    unknown = picture_of(replace(standing, surface_per_m=None), is_cropped=True)
    assert unknown.pixels_rgb.shape == whole.pixels_rgb.shape


def test_names_of_any_script_are_drawn_inside_the_picture_and_apart():
    labels = ["espalda·izq", "col·lí", "Ωμέγα", "\N{BONE}", "bell\x07", "m06"]
    spots = tuple(Spot(name, 60.0, 40.0 + 9 * i, 3.0, True) for i, name in enumerate(labels))
    grey = Picture(np.full((120, 160, 3), 90, np.uint8), spots)
    drawn = draw_markers(grey, 480)
    white = (drawn.min(axis=2) > 200).sum()
    alone = draw_markers(Picture(grey.pixels_rgb, spots[5:]), 480)
    assert drawn.shape == (480, 640, 3)
    assert white > 3 * (alone.min(axis=2) > 200).sum() > 0


def test_a_long_name_is_written_whole_at_the_edge_and_shortened_where_it_cannot_be():
    grey = np.full((300, 200, 3), 90, np.uint8)
    at_edge = Picture(grey, (Spot("left_shoulder", 198.0, 150.0, 3.0, True),))
    free = Picture(grey, (Spot("left_shoulder", 20.0, 150.0, 3.0, True),))
    white = [(draw_markers(picture, 300).min(axis=2) > 200).sum() for picture in (at_edge, free)]
    assert white[0] == pytest.approx(white[1], rel=0.05)
    endless = Picture(grey, (Spot("x" * 300, 100.0, 150.0, 3.0, True),))
    drawn = draw_markers(endless, 300).min(axis=2) > 200
    assert drawn.sum() > 100
    assert not drawn[:, -1].any()
