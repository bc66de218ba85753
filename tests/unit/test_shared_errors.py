"""Markers share the calibration's error: its moves by differences, and what measures make of it."""

from dataclasses import replace

import numpy as np
import pytest

from adibas.data.calibration import CameraCalibration, DepthBias, RgbdCalibration
from adibas.data.markers import Marker
from adibas.geometry.distortion import pixel_rays, project_distorted
from adibas.geometry.pinhole import Intrinsics
from adibas.geometry.rigid import RigidTransform, rotation_from_vector
from adibas.markers.disparity import fuse_depth
from adibas.markers.position import DisparityNoise, PositionFinder, PositionParams
from adibas.markers.shared_errors import SharedErrors
from adibas.measures.geometry_tables import all_angles, all_distances

HEIGHT, WIDTH = 240, 320
SURE = np.eye(2) * 1e-8
NO_NOISE = PositionParams(
    noise=DisparityNoise(frame_sd_per_m=1e-5, quantum_per_m=1e-5, static_sd_per_m=0.0)
)
PIXELS = ((60.0, 60.0), (260.0, 90.0), (150.0, 190.0))
PLAIN = RgbdCalibration(
    color=CameraCalibration(640, 480, Intrinsics(530.0, 531.0, 322.0, 238.0), (0.02, -0.03, 0, 0)),
    depth=CameraCalibration(
        WIDTH, HEIGHT, Intrinsics(290.0, 292.0, 160.5, 119.5), (0.08, -0.1, 0.001, -0.002)
    ),
    color_from_depth=RigidTransform(
        rotation_from_vector(np.array([0.01, -0.02, 0.01])), np.array([-0.025, 0.001, 0.002])
    ),
)
LENS = ("k1", "k2", "p1", "p2")
STEPS = {
    "color.fx": 1.0,
    "color.cy": 1.0,
    "color.k1": 0.005,
    "depth.fx": 2.0,
    "depth.fy": 2.0,
    "depth.cx": 1.0,
    "depth.cy": 1.0,
    "depth.k1": 0.01,
    "depth.p2": 0.003,
    "color_from_depth.ry": 0.002,
    "color_from_depth.rz": 0.002,
    "color_from_depth.tx": 0.001,
    "color_from_depth.tz": 0.001,
    "depth_bias.a": 0.003,
    "depth_bias.b": 0.002,
    "depth_bias.c": 0.002,
    "depth_bias.image_term.0": 0.01,
    "depth_bias.image_term.4": 0.02,
}


def moved(name, step):
    """The calibration with one parameter changed."""
    group, _, rest = name.partition(".")
    if group in ("color", "depth"):
        camera = getattr(PLAIN, group)
        if rest in LENS:
            lens = list(camera.distortion)
            lens[LENS.index(rest)] += step
            changed = replace(camera, distortion=tuple(lens))
        else:
            k = camera.intrinsics
            changed = replace(camera, intrinsics=replace(k, **{rest: getattr(k, rest) + step}))
        return replace(PLAIN, **{group: changed})
    if group == "color_from_depth":
        axis = "xyz".index(rest[1])
        vector = np.eye(3)[axis] * step
        old = PLAIN.color_from_depth
        if rest[0] == "t":
            new = RigidTransform(old.rotation, old.translation_m + vector)
        else:
            new = RigidTransform(rotation_from_vector(vector) @ old.rotation, old.translation_m)
        return replace(PLAIN, color_from_depth=new)
    if rest.startswith("image_term"):
        terms = np.zeros(5)
        terms[int(rest[-1])] = step
        return replace(PLAIN, depth_bias=DepthBias(image_term=tuple(terms.tolist())))
    bias = PLAIN.depth_bias
    return replace(PLAIN, depth_bias=replace(bias, **{rest: getattr(bias, rest) + step}))


RAYS = pixel_rays((HEIGHT, WIDTH), PLAIN.depth.intrinsics, PLAIN.depth.distortion)


def surface_m():
    """A leaning plane."""
    return (1.6 / (1.0 + RAYS @ [0.2, -0.1])).astype(np.float32)


def places(calibration):
    """The markers of fixed colour pixels, by `calibration`."""
    depth_m = calibration.corrected_depth(surface_m())
    finder = PositionFinder(fuse_depth([depth_m], DepthBias()), calibration, NO_NOISE)
    found = []
    for u, v in PIXELS:
        z = surface_m()[int(v), int(u)]
        point_m = np.array([*RAYS[int(v), int(u)], 1.0]) * z
        color_m = PLAIN.color_from_depth.apply(point_m)
        pixel = project_distorted(color_m, PLAIN.color.intrinsics, PLAIN.color.distortion)
        found.append(finder.locate(pixel, SURE))
    return found


def known_to(name, step):
    return moving_together({name: step})


def moving_together(steps):
    """One cause that changes all of these at once."""
    sds = np.array(list(steps.values()))
    return replace(PLAIN, parameter_names=tuple(steps), covariance=np.outer(sds, sds))


@pytest.mark.parametrize("name", STEPS)
def test_a_marker_moves_as_it_does_under_the_changed_calibration(name):
    step = STEPS[name]
    before, after = places(PLAIN), places(moved(name, step))
    said = places(known_to(name, step))
    for old, new, shared in zip(before, after, said, strict=True):
        change = new.position_m - old.position_m
        expected = shared.shared_m[:, 0] * np.sign(shared.shared_m[:, 0] @ change)
        assert np.linalg.norm(change) > 1e-5
        np.testing.assert_allclose(expected, change, rtol=0.05, atol=3e-2 * np.abs(change).max())


def test_what_is_shared_is_part_of_the_covariance():
    plain, known = places(PLAIN)[0], places(known_to("color.fx", 2.0))[0]
    assert plain.shared_m.shape == (3, 0)
    np.testing.assert_allclose(
        known.covariance_m2, plain.covariance_m2 + known.shared_m @ known.shared_m.T
    )


def test_a_parameter_without_a_meaning_moves_nothing():
    assert not places(known_to("depth.baseline", 1.0))[0].shared_m.any()


def test_a_wrong_centre_that_the_shift_makes_good_moves_nothing_at_its_distance():
    """Boards that stand at one distance tell only the two together."""
    plain = replace(PLAIN.depth, distortion=())
    aside_m = 3.0 * 1.6 / plain.intrinsics.fx * PLAIN.color_from_depth.rotation[:, 0]
    shifts = {f"color_from_depth.t{axis}": m for axis, m in zip("xyz", aside_m, strict=True)}
    known = replace(moving_together({"depth.cx": 3.0, **shifts}), depth=plain)
    oblique, within = np.array([0.7, 0.0, 0.7]), np.zeros((3, 2))
    near_m, far_m = (
        SharedErrors(known).moves(
            PLAIN.color_from_depth.apply(np.array([0.2, -0.1, depth_m])), oblique, within
        )
        for depth_m in (1.6, 2.4)
    )
    assert np.abs(near_m).max() < 1e-6
    # What is left at 2.4 m: 3 pixels of 0.8 m, along a ray on skin that leans by 45 degrees.
    assert np.linalg.norm(far_m) == pytest.approx(3.0 * 0.8 / plain.intrinsics.fx, rel=0.2)


def test_markers_need_both_cameras():
    for camera in ({"depth": PLAIN.depth}, {"color": PLAIN.color}):
        with pytest.raises(ValueError, match="by a colour camera and measured by a depth camera"):
            SharedErrors(RgbdCalibration(**camera))


def markers(calibration):
    return [
        Marker(f"m{i}", 0, 0, 3, np.eye(2), p.position_m, p.covariance_m2, p.shared_m)
        for i, p in enumerate(places(calibration))
    ]


def test_a_common_shift_moves_no_distance_and_no_angle():
    shared_m = np.array([[0.01], [0.0], [0.0]])
    own_m2 = np.eye(3) * 1e-8
    points_m = np.array([[0, 0, 2.0], [0.5, 0, 2.0], [0, 0.5, 2.0]])
    common = [
        Marker(f"m{i}", 0, 0, 3, np.eye(2), p, own_m2 + shared_m @ shared_m.T, shared_m.copy())
        for i, p in enumerate(points_m)
    ]
    alone = [replace(marker, shared_m=None) for marker in common]
    for measured in (all_distances, all_angles):
        interval = "interval_m" if measured is all_distances else "interval_rad"
        narrow = [np.ptp(getattr(one, interval)) for one in measured(common)]
        wide = [np.ptp(getattr(one, interval)) for one in measured(alone)]
        assert max(narrow) < 0.1 * max(wide)


def test_distances_are_as_unsure_as_the_focal_length():
    """All lengths of a plane scale with 1 / f, which independent errors would not say."""
    step = 5.3
    plain = all_distances(markers(PLAIN))
    calibration = replace(
        PLAIN,
        parameter_names=("color.fx", "color.fy"),
        covariance=np.full((2, 2), step**2),
    )
    for before, after in zip(plain, all_distances(markers(calibration)), strict=True):
        half_m = np.ptp(after.interval_m) / 2
        assert half_m == pytest.approx(1.96 * before.value_m * step / 530.0, rel=0.15)


def test_markers_of_two_calibrations_are_independent():
    first, second = markers(PLAIN)[0], markers(known_to("color.fx", 2.0))[1]
    assert all_distances([first, second])[0].interval_m == pytest.approx(
        all_distances([replace(first, shared_m=None), replace(second, shared_m=None)])[0].interval_m
    )
