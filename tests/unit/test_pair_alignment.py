"""Two moments of a simulated room are aligned as they were taken, or it is said why not."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from adibas.alignment.features import Pairs
from adibas.alignment.inverse_plane_kernels import fit_planes, halved
from adibas.alignment.joint_fit import JointFit, fit_joint, moved, pair_equations
from adibas.alignment.pairing import Moment, Unaligned, align, align_anywhere
from adibas.alignment.sights import see
from adibas.alignment.start_search import fit_triples
from adibas.data.calibration import CameraCalibration, RgbdCalibration
from adibas.geometry.pinhole import Intrinsics
from adibas.geometry.rigid import IDENTITY, RigidTransform, fit_rigid, rotation_vector
from adibas.simulation.furnished_room import FurnishedRoom

CALIBRATION = RgbdCalibration(
    depth=CameraCalibration(320, 240, Intrinsics(290.0, 290.0, 159.5, 119.5)),
    color=CameraCalibration(
        320, 240, Intrinsics(280.0, 281.0, 161.0, 118.0), (0.03, -0.02, 0.0, 0.0)
    ),
    color_from_depth=RigidTransform(
        Rotation.from_euler("y", 0.4, degrees=True).as_matrix(), np.array([0.025, 0.0, 0.001])
    ),
)


def posed(turn_deg, shift_m, before=None):
    turn = Rotation.from_euler("xyz", turn_deg, degrees=True).as_matrix()
    motion = RigidTransform(turn, np.asarray(shift_m, float))
    return motion if before is None else motion @ before


FIRST = posed((8.0, 20.0, 0.0), (0.2, 1.4, 1.2))


def moment(room, camera_from_world):
    depth_m = 1.0 / room.look(CALIBRATION.depth, camera_from_world).inverse_depth
    colored = room.look(CALIBRATION.color, CALIBRATION.color_from_depth @ camera_from_world)
    return Moment(see(depth_m, np.round(255 * colored.rgb).astype(np.uint8), CALIBRATION))


@pytest.fixture(scope="module")
def room():
    return FurnishedRoom(3)


@pytest.fixture(scope="module")
def first(room):
    return moment(room, FIRST)


def error_of(fit, truth):
    apart = fit.target_from_source @ truth.inverse()
    return np.linalg.norm(apart.translation_m), np.linalg.norm(rotation_vector(apart.rotation))


def test_a_small_motion_is_found_from_no_motion(room, first):
    motion = posed((1.0, -1.5, 0.8), (0.02, -0.01, 0.03))
    fit = align(moment(room, motion @ FIRST), first, IDENTITY)
    assert isinstance(fit, JointFit)
    shift_m, turn_rad = error_of(fit, motion)
    assert shift_m < 0.0005
    assert turn_rad < np.radians(0.015)
    assert fit.overlap > 0.8
    assert fit.before < 0.01


def test_a_large_motion_is_found_without_a_guess(room, first):
    motion = posed((4.0, 14.0, -6.0), (0.2, 0.05, -0.1))
    fit = align_anywhere(moment(room, motion @ FIRST), first)
    assert isinstance(fit, JointFit)
    shift_m, turn_rad = error_of(fit, motion)
    assert shift_m < 0.004
    assert turn_rad < np.radians(0.1)


def test_another_room_is_not_aligned(first):
    other = moment(FurnishedRoom(8), FIRST)
    assert isinstance(align_anywhere(other, first), Unaligned)
    assert isinstance(align(other, first, IDENTITY), Unaligned)


def test_bare_walls_leave_the_motion_open():
    bare = FurnishedRoom(1, is_plain=True)
    towards_wall = posed((0.0, 0.0, 0.0), (0.0, 1.3, 0.0))
    one, other = (moment(bare, posed((0, 0, 0), (x, 0, 0), towards_wall)) for x in (0.0, 0.05))
    assert align(other, one, IDENTITY) in (Unaligned.UNDETERMINED, Unaligned.TOO_FEW_FEATURES)
    assert align_anywhere(other, one) is Unaligned.TOO_FEW_FEATURES


def test_a_fit_of_the_surfaces_that_the_pictures_deny_is_refused(room, first):
    depth_m = 1.0 / room.look(CALIBRATION.depth, FIRST).inverse_depth
    elsewhere = FurnishedRoom(8).look(CALIBRATION.color, CALIBRATION.color_from_depth @ FIRST)
    other = Moment(see(depth_m, np.round(255 * elsewhere.rgb).astype(np.uint8), CALIBRATION))
    surfaces = fit_joint(other.sight, first.sight, IDENTITY)
    assert surfaces is not None
    assert surfaces.overlap > 0.9
    refused = (Unaligned.DISAGREEMENT, Unaligned.TOO_FEW_FEATURES)
    assert align(other, first, IDENTITY) in refused


def test_without_features_the_surfaces_align_alone(room, first):
    motion = posed((0.5, 0.7, -0.4), (0.01, 0.0, -0.015))
    fit = fit_joint(moment(room, motion @ FIRST).sight, first.sight, IDENTITY)
    assert fit is not None
    shift_m, turn_rad = error_of(fit, motion)
    assert shift_m < 0.005
    assert turn_rad < np.radians(0.1)
    assert fit.n_pairs == 0


def test_a_pixel_of_colour_and_its_point_belong_together(first):
    sight = first.sight
    pixels = np.random.default_rng(0).uniform((40, 40), (280, 200), (50, 2))
    points_m = sight.points_m(pixels)
    known = ~np.isnan(points_m[:, 0])
    assert known.sum() > 30
    np.testing.assert_allclose(sight.pixels_of(points_m[known]), pixels[known], atol=1e-6)


def test_the_equations_of_pairs_are_the_slope_of_their_squares(first):
    rng = np.random.default_rng(2)
    points_m = rng.uniform((-0.5, -0.5, 1.5), (0.5, 0.5, 3.0), (20, 3))
    pixels = first.sight.pixels_of(points_m) + rng.normal(0, 0.5, (20, 2))
    pairs = Pairs(points_m, pixels, 1.0)
    (_, right), n_kept = pair_equations(first.sight, pairs, IDENTITY, 1e6)
    assert n_kept == 20

    def cost(twist):
        seen = first.sight.pixels_of(moved(IDENTITY, twist).apply(points_m))
        return 0.5 * ((seen - pixels) ** 2).sum()

    step = 1e-6
    slopes = [(cost(step * axis) - cost(-step * axis)) / (2 * step) for axis in np.eye(6)]
    np.testing.assert_allclose(right, -np.array(slopes), rtol=0.06, atol=20.0)


def test_rounding_does_not_grow_where_each_motion_is_guessed_from_the_two_before():
    last, step = IDENTITY, posed((0.3, -0.2, 0.1), (0.01, 0.0, 0.02))
    for _ in range(500):
        now = moved(last @ step, np.array([1e-4, -2e-4, 1e-4, 0.0, 1e-4, 0.0]))
        last, step = now, last.inverse() @ now
    off = last.rotation @ last.rotation.T - np.eye(3)
    assert np.abs(off).max() < 1e-12


def test_planes_in_inverse_depth_are_exact_on_a_plane_and_absent_across_an_edge():
    rays = np.stack(np.meshgrid(np.linspace(-0.3, 0.3, 30), np.linspace(-0.2, 0.2, 20)), axis=-1)
    plane = np.array([0.2, -0.1, 0.5])
    inverse = plane[0] * rays[..., 0] + plane[1] * rays[..., 1] + plane[2]
    inverse[:, 15:] += 0.4
    found = fit_planes(inverse.astype(np.float32), rays.astype(np.float32), 3, 1, 0.05, 12)
    np.testing.assert_allclose(found[:, :15], np.broadcast_to(plane, (20, 15, 3)), atol=2e-4)
    sparse = np.full((20, 30), np.nan, np.float32)
    sparse[10, 10] = 0.5
    assert np.isnan(fit_planes(sparse, rays.astype(np.float32), 3, 1, 0.05, 12)).all()


def test_halving_keeps_to_the_nearest_surface():
    image = np.array([[0.5, 0.51, np.nan, np.nan], [0.2, 0.5, np.nan, 0.3]], np.float32)
    np.testing.assert_allclose(halved(image, 0.05), [[np.mean([0.5, 0.51, 0.5]), 0.3]], rtol=1e-6)


def test_many_triples_are_fitted_as_one_after_the_other():
    rng = np.random.default_rng(4)
    goals, own = rng.normal(size=(6, 3, 3)), rng.normal(size=(6, 3, 3))
    rotations, shifts = fit_triples(goals, own)
    for k in range(6):
        one = fit_rigid(goals[k], own[k])
        np.testing.assert_allclose(rotations[k], one.rotation, atol=1e-9)
        np.testing.assert_allclose(shifts[k], one.translation_m, atol=1e-9)
