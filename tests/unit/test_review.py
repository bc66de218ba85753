"""Correcting a capture: positions, snapping and measures, against the simulator's truth."""

from dataclasses import replace
from datetime import UTC, datetime

import numpy as np
import pytest

from adibas.data.corrections import CorrectionHistory, FreeMeasure, MarkerCorrection
from adibas.data.markers import Marker
from adibas.data.posture import Provenance
from adibas.data.sessions import Capture
from adibas.markers.color_model import LearningParams, grow_region, learn_colors
from adibas.markers.disparity import fuse_depth
from adibas.markers.lab import rgb_to_lab
from adibas.markers.led import LedParams
from adibas.pipeline.review import (
    CORRECTED,
    CaptureSurface,
    chosen_measures,
    posture_analysis,
)
from adibas.recordings.decoding import to_rgbd
from adibas.simulation.scenes import open_scene

N_FRAMES = 4


class Captured:
    """The surface, the picture and the true markers of a simulated burst."""

    def __init__(self, name):
        scene = open_scene(name, seed=7, distance_m=2.4, is_swaying=False)
        simulated = [scene.frame(i) for i in range(N_FRAMES)]
        self.calibration = scene.info.calibration
        depths = (to_rgbd(one.sensor_frame, scene.info).depth_m for one in simulated)
        surface = fuse_depth(depths, self.calibration.depth_bias, self.calibration.depth)
        self.surface = CaptureSurface(surface, self.calibration)
        self.picture_rgb = simulated[0].sensor_frame.color
        self.truths = [one for one in simulated[0].truth.markers if one.is_visible]


@pytest.fixture(scope="module")
def stickers():
    return Captured("anterior")


@pytest.fixture(scope="module")
def leds():
    return Captured("anterior_led")


@pytest.fixture(scope="module")
def target(stickers):
    lab = rgb_to_lab(stickers.picture_rgb)
    facing = sorted(stickers.truths, key=lambda marker: marker.view_angle_rad)[:3]
    taken = sum(grow_region(lab, (one.u, one.v), 20.0) for one in facing) > 0
    rng = np.random.default_rng(0)
    return learn_colors(lab[taken].astype(float), rng, LearningParams(), {})


def marker(label, position_m=(0.0, 0.0, 2.0)):
    if position_m is None:
        return Marker(label, 1.0, 2.0, 3.0, np.eye(2))
    return Marker(
        label, 1.0, 2.0, 3.0, np.eye(2), np.array(position_m, float), np.diag([1e-6, 1e-6, 4e-6])
    )


def test_a_point_set_by_hand_lies_on_the_body(stickers):
    errors_m, deviations = [], []
    for truth in stickers.truths:
        placed = stickers.surface.measured("new", truth.u, truth.v)
        assert (placed.label, placed.u, placed.v) == ("new", truth.u, truth.v)
        np.testing.assert_array_equal(placed.covariance_px2, np.eye(2))
        if placed.position_m is not None:
            error_m = placed.position_m - truth.position_m
            errors_m.append(np.linalg.norm(error_m))
            deviations.append(np.sqrt(error_m @ np.linalg.solve(placed.covariance_m2, error_m)))
    assert len(errors_m) >= len(stickers.truths) - 2
    assert np.median(errors_m) < 0.008
    assert np.median(deviations) < 2.5, "in standard deviations; of three axes 1.5 is usual"


def test_a_surer_centre_gives_a_surer_position(stickers):
    truth = stickers.truths[1]
    hand = stickers.surface.measured("a", truth.u, truth.v)
    blob = stickers.surface.measured("a", truth.u, truth.v, np.eye(2) * 0.05, 2.5)
    assert blob.radius_px == 2.5
    assert np.linalg.det(blob.covariance_m2) < np.linalg.det(hand.covariance_m2)
    np.testing.assert_allclose(blob.position_m, hand.position_m)


def test_a_point_beside_the_depth_has_no_position(stickers):
    assert stickers.surface.measured("a", -300.0, 5.0).position_m is None
    unkept = CaptureSurface(None, stickers.calibration)
    truth = stickers.truths[0]
    assert unkept.measured("a", truth.u, truth.v).position_m is None


@pytest.mark.parametrize("kind", ["learned", "anything", "led"])
def test_a_click_near_a_marker_snaps_to_its_centre(stickers, leds, target, kind):
    captured = leds if kind == "led" else stickers
    sought = {"learned": target, "anything": None, "led": LedParams()}[kind]
    rng = np.random.default_rng(3)
    errors_px, errors_hand_px = [], []
    for truth in captured.truths:
        clicked = np.array([truth.u, truth.v]) + rng.uniform(-6, 6, 2)
        snap = captured.surface.snapped(captured.picture_rgb, *clicked, target=sought)
        errors_px.append(np.hypot(snap.u - truth.u, snap.v - truth.v))
        errors_hand_px.append(np.hypot(*(clicked - [truth.u, truth.v])))
        if snap.is_blob:
            assert snap.covariance_px2[0, 0] < 0.25
            assert 1.0 < snap.radius_px < 8.0
        else:
            np.testing.assert_array_equal(snap.covariance_px2, np.eye(2))
    assert np.median(errors_px) < 0.3
    assert np.median(errors_hand_px) > 3.0
    assert np.mean(np.array(errors_px) < 1.0) >= 0.75


@pytest.mark.parametrize("below_px", [25.0, 60.0], ids=["out of reach", "far away"])
def test_a_click_on_bare_skin_stays_where_it_is(stickers, target, below_px):
    sternum = next(one for one in stickers.truths if one.name == "sternal_notch")
    clicked = sternum.u, sternum.v + below_px
    for sought in (target, None):
        snap = stickers.surface.snapped(stickers.picture_rgb, *clicked, target=sought)
        assert (snap.u, snap.v, snap.is_blob) == (*clicked, False)


def test_the_nearer_of_two_markers_is_meant(stickers, target):
    first, second = sorted(stickers.truths, key=lambda one: one.v)[:2]
    apart_px = np.hypot(first.u - second.u, first.v - second.v)
    share = 0.4
    clicked = first.u + share * (second.u - first.u), first.v + share * (second.v - first.v)
    snap = stickers.surface.snapped(stickers.picture_rgb, *clicked, apart_px, target)
    assert np.hypot(snap.u - first.u, snap.v - first.v) < 1.0


@pytest.mark.parametrize("click", [(-5.0, 10.0), (1279.4, 1023.4), (0.0, 0.0), (5000.0, 10.0)])
def test_a_click_at_the_border_or_beside_the_picture_stays(stickers, target, click):
    for sought in (target, None, LedParams()):
        snap = stickers.surface.snapped(stickers.picture_rgb, *click, target=sought)
        assert (snap.u, snap.v) == click


def test_without_reach_nothing_snaps(stickers):
    truth = stickers.truths[0]
    snap = stickers.surface.snapped(stickers.picture_rgb, truth.u + 1, truth.v, 0.0)
    assert (snap.u, snap.is_blob) == (truth.u + 1, False)


def test_only_what_was_asked_for_is_measured():
    markers = (marker("a"), marker("b", (0.3, 0, 2)), marker("c", (0, 0.4, 2)), marker("d", None))
    asked = tuple(map(FreeMeasure, [("c", "b"), ("b", "a", "c"), ("a", "d"), ("a", "b", "gone")]))
    measures = chosen_measures(markers, asked)
    (distance,), (angle,) = measures.distances, measures.angles
    assert (distance.a, distance.b) == ("c", "b")
    assert distance.value_m == pytest.approx(0.5)
    assert (angle.a, angle.vertex, angle.c) == ("b", "a", "c")
    assert angle.value_rad == pytest.approx(np.pi / 2)


def capture_of(stickers, markers, history=None):
    return Capture(
        capture_id="c",
        session_id="s",
        view="anterior",
        captured_utc=datetime(2026, 1, 2, tzinfo=UTC),
        recording_id="r",
        first_frame=0,
        n_frames=N_FRAMES,
        calibration=stickers.calibration,
        detected=markers,
        rejected=(),
        provenance=Provenance("00", "sha256:0", "0.1.0", "2026-01-02T00:00:00+00:00", {}),
        history=history or CorrectionHistory(),
        notices=("as it was",),
    )


def test_a_report_shows_the_markers_as_corrected(stickers):
    detected = (marker("a"), marker("b", (0.3, 0, 2)))
    history = CorrectionHistory()
    plain = posture_analysis(capture_of(stickers, detected), stickers.picture_rgb, "P1")
    assert (plain.patient, plain.view, plain.notices) == ("P1", "anterior", ("as it was",))
    history = history.after(MarkerCorrection(detected[1], marker("b", (0.6, 0, 2))))
    history = history.after(MarkerCorrection(None, marker("c", (0, 0.8, 2))))
    corrected = posture_analysis(capture_of(stickers, detected, history), stickers.picture_rgb)
    assert [one.value_m for one in corrected.distances] == pytest.approx([0.6, 0.8, 1.0])
    assert len(corrected.angles) == 3
    assert corrected.notices == ("as it was", CORRECTED)


def test_a_new_name_alone_is_no_correction_of_the_measures(stickers):
    detected = (marker("a"), marker("b", (0.3, 0, 2)))
    renamed = MarkerCorrection(detected[0], replace(detected[0], label="acromion"))
    history = CorrectionHistory().after(renamed)
    analysis = posture_analysis(capture_of(stickers, detected, history), stickers.picture_rgb)
    assert analysis.notices == ("as it was",)
    assert analysis.distances[0].a == "acromion"
    undone = posture_analysis(
        capture_of(stickers, detected, history.undone()), stickers.picture_rgb
    )
    assert undone.distances[0].a == "a"
