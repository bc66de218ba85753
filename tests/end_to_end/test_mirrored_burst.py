"""A burst seen in a mirror: every place is mirrored, and every measure is the same.

The skin about a marker is fitted to a sample of its pixels, which is another one in the mirror:
positions differ by a part of their own standard deviation. A sign or a side taken wrongly makes
them differ by centimetres.
"""

from dataclasses import replace

import numpy as np
import pytest

from adibas.data.frames import RgbdFrame
from adibas.geometry.rigid import RigidTransform
from adibas.markers.color_model import LearningParams, grow_region, learn_colors
from adibas.markers.lab import rgb_to_lab
from adibas.pipeline.posture import PostureParams, analyse_burst
from adibas.pipeline.review import measures_of
from adibas.recordings.decoding import to_rgbd
from adibas.simulation.scenes import open_scene

N_FRAMES = 3
MIRROR = np.diag([-1.0, 1.0, 1.0])
ODD_DISTORTION = (3, 8, 9)
"""p2, s1 and s2 of OpenCV's order bend the picture towards one side."""


def mirrored_camera(camera):
    k = camera.intrinsics
    bent = [-d if i in ODD_DISTORTION else d for i, d in enumerate(camera.distortion)]
    return replace(
        camera, intrinsics=replace(k, cx=camera.width - 1 - k.cx), distortion=tuple(bent)
    )


def mirrored_calibration(calibration):
    pose, floor, gravity = calibration.color_from_depth, calibration.floor, calibration.gravity
    return replace(
        calibration,
        color=mirrored_camera(calibration.color),
        depth=mirrored_camera(calibration.depth),
        color_from_depth=RigidTransform(
            MIRROR @ pose.rotation @ MIRROR, MIRROR @ pose.translation_m
        ),
        floor=None if floor is None else replace(floor, normal=MIRROR @ floor.normal),
        gravity=None if gravity is None else MIRROR @ gravity,
    )


def mirrored_frame(frame: RgbdFrame):
    return replace(
        frame,
        depth_m=np.ascontiguousarray(frame.depth_m[:, ::-1]),
        color_rgb=np.ascontiguousarray(frame.color_rgb[:, ::-1]),
    )


def learned(frame, truths):
    lab = rgb_to_lab(frame.color_rgb)
    facing = sorted(truths, key=lambda marker: marker.view_angle_rad)[:3]
    taken = sum(grow_region(lab, (one.u, one.v), 20.0) for one in facing) > 0
    rng = np.random.default_rng(0)
    return learn_colors(lab[taken].astype(float), rng, LearningParams(), {})


@pytest.mark.parametrize("view", ["anterior", "right_lateral"])
def test_a_mirrored_burst_gives_mirrored_places_and_the_same_measures(view):
    scene = open_scene(view, seed=3, is_swaying=False)
    simulated = [scene.frame(i) for i in range(N_FRAMES)]
    frames = [to_rgbd(one.sensor_frame, scene.info) for one in simulated]
    target = learned(frames[0], [one for one in simulated[0].truth.markers if one.is_visible])
    params, calibration = PostureParams(), scene.info.calibration
    seen = analyse_burst(frames, calibration, target, params).markers
    in_mirror = analyse_burst(
        [mirrored_frame(frame) for frame in frames],
        mirrored_calibration(calibration),
        target,
        params,
    ).markers
    assert len(seen) == len(in_mirror) >= 5
    partners = []
    for marker in seen:
        place = (calibration.color.width - 1 - marker.u, marker.v)
        partner = min(in_mirror, key=lambda one: np.hypot(one.u - place[0], one.v - place[1]))
        partners.append(replace(partner, label=marker.label))
        np.testing.assert_allclose((partner.u, partner.v), place, atol=0.01)
        assert (partner.position_m is None) == (marker.position_m is None)
        if marker.position_m is not None:
            sd_m = np.sqrt(np.diag(marker.covariance_m2))
            assert (abs(MIRROR @ partner.position_m - marker.position_m) < sd_m).all()
    ours, theirs = measures_of(seen), measures_of(tuple(partners))
    assert len(ours.distances) == len(theirs.distances) >= 10
    for one, other in zip(ours.distances, theirs.distances, strict=True):
        assert one.interval_m[0] < other.value_m < one.interval_m[1]
    for one, other in zip(ours.angles, theirs.angles, strict=True):
        assert one.interval_rad[0] < other.value_rad < one.interval_rad[1]
