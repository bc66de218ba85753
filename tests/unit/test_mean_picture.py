"""The mean of a burst, and the markers that only it shows."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from adibas.data.joints import JOINT_NAMES
from adibas.markers.blobs import Blob
from adibas.markers.burst import BurstParams, BurstTracker
from adibas.markers.mean_picture import MeanPicture
from adibas.pipeline.learning import LearningRequest, learn_from_picture
from adibas.pipeline.posture import PostureParams, analyse_burst
from adibas.recordings.decoding import to_rgbd
from adibas.simulation.patient import MarkerSettings
from adibas.simulation.scenes import SceneSettings, SimulatedScene

N_FRAMES = 6
GATE_M = 0.012


def spot(u, v, radius_px=1.7):
    nothing = np.zeros(3)
    covariance_px2 = 0.04 * np.eye(2)
    return Blob(
        u, v, 9, radius_px, 1.0, 8.0, 0.5, 0.8, covariance_px2, 1.0, 1.0, 0.0, nothing, nothing
    )


def test_the_mean_is_rounded_to_the_nearest_level_and_noise_averages_out():
    rng = np.random.default_rng(4)
    pictures = rng.integers(0, 256, (7, 5, 6, 3), dtype=np.uint8)
    mean = MeanPicture()
    for picture in pictures:
        mean.add(picture)
    np.testing.assert_array_equal(mean.result(), np.rint(pictures.mean(axis=0)))


def test_pictures_of_two_sizes_and_none_at_all_have_no_mean():
    mean = MeanPicture()
    with pytest.raises(ValueError, match="no pictures"):
        mean.result()
    mean.add(np.zeros((4, 5, 3), np.uint8))
    with pytest.raises(ValueError, match="one size"):
        mean.add(np.zeros((5, 4, 3), np.uint8))


def test_what_the_mean_shows_beside_the_followed_markers_is_one_more_of_them():
    params = BurstParams()
    tracker = BurstTracker(params)
    for _ in range(4):
        tracker.add([spot(20.0, 60.0), spot(90.0, 10.0, radius_px=8.0)])
    again, near_large = spot(24.0, 60.0), spot(90.0, 25.0, radius_px=8.0)
    faint, far_from_large = spot(26.0, 60.0), spot(90.0, 27.0, radius_px=8.0)
    found = tracker.markers([again, near_large, faint, far_from_large])
    assert [(one.u, one.v) for one in found] == [(90, 10), (90, 27), (20, 60), (26, 60)]
    assert [one.n_sightings for one in found] == [4] * 4
    lasting = params.centre_variance_px2(1.7) * np.eye(2)
    np.testing.assert_allclose(found[3].covariance_px2, 0.04 * np.eye(2) + lasting)
    assert found[2].covariance_px2[0, 0] == pytest.approx(0.03 + lasting[0, 0])


def test_two_spots_of_the_mean_that_are_one_marker_are_one():
    found = BurstTracker(BurstParams()).markers([spot(20.0, 60.0), spot(22.0, 60.0)])
    assert [(one.u, one.v) for one in found] == [(20, 60)]


@pytest.fixture(scope="module")
def far_scene():
    """Stickers of 8 mm on a patient 3.5 m away: two and a half pixels wide."""
    settings = SceneSettings(
        seed=22_035,
        posture="arms_abducted",
        distance_m=3.5,
        markers=MarkerSettings(JOINT_NAMES, diameter_m=0.008),
    )
    scene = SimulatedScene(settings)
    simulated = [scene.frame(index) for index in range(N_FRAMES)]
    return scene, [to_rgbd(one.sensor_frame, scene.info) for one in simulated], simulated[0].truth


def learned(settings):
    """Learn the colour by three clicks on another scene, nearer."""
    near = replace(settings, seed=990_017, distance_m=2.0, posture="relaxed")
    scene = SimulatedScene(near)
    frame = scene.frame(0)
    seen = sorted(
        (one for one in frame.truth.markers if one.is_visible), key=lambda one: one.view_angle_rad
    )
    seeds = tuple((float(round(one.u)), float(round(one.v))) for one in seen[:3])
    request = LearningRequest(Path("learning"), seeds, sensitivity=12.0)
    return learn_from_picture(to_rgbd(frame.sensor_frame, scene.info).color_rgb, request)[0]


def n_found(markers, truth):
    focal_px = truth.calibration.color.intrinsics.fx
    visible = [one for one in truth.markers if one.is_visible]
    return len(visible), sum(
        any(
            np.hypot(found.u - one.u, found.v - one.v) < GATE_M * focal_px / one.position_m[2]
            for found in markers
        )
        for one in visible
    )


def test_stickers_that_noise_hides_in_each_frame_are_found_in_their_mean(far_scene):
    scene, frames, truth = far_scene
    model = learned(scene.settings)
    counts = []
    for least in (np.inf, PostureParams().least_log_odds_of_mean):
        params = PostureParams(least_log_odds_of_mean=least)
        markers = analyse_burst(frames, truth.calibration, model, params).markers
        n_visible, n_right = n_found(markers, truth)
        assert n_right == len(markers)
        assert all(one.position_m is not None for one in markers)
        counts.append(n_right)
    assert counts[0] + 2 <= counts[1] <= n_visible
