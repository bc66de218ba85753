"""Pose of the depth camera from boards in colour and infrared, beside the truth."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from adibas.calibration.extrinsics_infrared import (
    InfraredPair,
    fit_infrared,
    joint_covariance,
)
from adibas.calibration.extrinsics_pose import find_pose
from adibas.geometry.rigid import RigidTransform, rotation_vector
from tests.unit.depth_shots import (
    BOARD,
    COLOR,
    COLOR_FROM_DEPTH,
    DEPTH,
    corners_of,
    random_pose,
)

RNG = np.random.default_rng
INFRARED = replace(DEPTH, distortion=(-0.08, 0.2, 0.001, -0.001))


def poses_of(n, rng):
    """Give places of a board that both cameras see whole."""
    while n:
        pose = random_pose(rng, 0.6)
        seen = [
            corners_of(pose, rng, 0.0),
            corners_of(COLOR_FROM_DEPTH.inverse() @ pose, rng, 0.0, camera=INFRARED),
        ]
        if all(
            (
                (corners.pixels > 2) & (corners.pixels < (corners.width - 3, corners.height - 3))
            ).all()
            for corners in seen
        ):
            n -= 1
            yield pose


def pair_of(name, pose, rng, sd_px, *, moved=None, cameras=(COLOR, INFRARED)):
    """Return what both cameras say of a board, which may be `moved` between the images."""
    in_infrared = COLOR_FROM_DEPTH.inverse() @ (moved or pose)
    return InfraredPair(
        name,
        find_pose(corners_of(pose, rng, sd_px), BOARD, cameras[0]),
        find_pose(corners_of(in_infrared, rng, sd_px, camera=INFRARED), BOARD, cameras[1]),
    )


def pairs_of(n, seed, sd_px=0.0, **changes):
    rng = RNG(seed)
    found = [
        pair_of(f"p{i}", pose, rng, sd_px, **changes) for i, pose in enumerate(poses_of(n, rng))
    ]
    return [pair for pair in found if pair.color is not None and pair.infrared is not None]


def errors(pose):
    turn = rotation_vector(pose.rotation @ COLOR_FROM_DEPTH.rotation.T)
    return np.concatenate([turn, pose.translation_m - COLOR_FROM_DEPTH.translation_m])


def test_exact_corners_give_the_exact_pose():
    fit = fit_infrared(pairs_of(4, 1))
    np.testing.assert_allclose(errors(fit.color_from_depth), 0.0, atol=1e-8)
    np.testing.assert_allclose(fit.turns_rad, 0.0, atol=1e-8)
    assert fit.outliers == ()


def test_the_pose_is_that_of_opencv():
    rng = RNG(2)
    color, infrared = [], []
    for pose in poses_of(12, rng):
        color.append(corners_of(pose, rng, 0.1))
        in_infrared = COLOR_FROM_DEPTH.inverse() @ pose
        infrared.append(corners_of(in_infrared, rng, 0.1, camera=INFRARED))
    found = cv2.stereoCalibrate(
        [BOARD.points_m().astype(np.float32)] * len(color),
        [corners.pixels.astype(np.float32) for corners in infrared],
        [corners.pixels.astype(np.float32) for corners in color],
        INFRARED.intrinsics.matrix(),
        np.array(INFRARED.distortion),
        COLOR.intrinsics.matrix(),
        np.array(COLOR.distortion),
        (INFRARED.width, INFRARED.height),
        flags=cv2.CALIB_FIX_INTRINSIC,
    )
    ours = fit_infrared(
        [
            InfraredPair("p", find_pose(seen, BOARD, COLOR), find_pose(other, BOARD, INFRARED))
            for seen, other in zip(color, infrared, strict=True)
        ]
    )
    theirs = errors(RigidTransform(found[5], found[6].ravel()))
    sds = np.sqrt(np.diag(ours.covariance))
    assert (np.abs(errors(ours.color_from_depth) - theirs) < 0.5 * sds).all()
    assert (np.abs(theirs) < 4 * sds).all()


def test_intervals_hold_the_truth():
    squares = []
    for seed in range(40):
        fit = fit_infrared(pairs_of(6, 100 + seed, 0.15))
        error = errors(fit.color_from_depth)
        squares.append(error @ np.linalg.solve(fit.covariance, error) / 6.0)
    assert 0.75 < np.mean(squares) < 1.3


@pytest.mark.parametrize(("camera", "name"), [("color", "fx"), ("infrared", "fy")])
def test_the_pose_goes_with_the_cameras_as_its_derivatives_say(camera, name):
    before = fit_infrared(pairs_of(6, 5))
    known = COLOR if camera == "color" else INFRARED
    step = 0.1
    intrinsics = replace(known.intrinsics, **{name: getattr(known.intrinsics, name) + step})
    wrong = replace(known, intrinsics=intrinsics)
    cameras = (wrong, INFRARED) if camera == "color" else (COLOR, wrong)
    after = fit_infrared(pairs_of(6, 5, cameras=cameras))
    moved = errors(after.color_from_depth) - errors(before.color_from_depth)
    by_camera = before.by_color if camera == "color" else before.by_infrared
    expected = step * by_camera[:, {"fx": 0, "fy": 1}[name]]
    np.testing.assert_allclose(moved, expected, atol=0.05 * np.abs(expected).max())


def test_a_board_that_was_moved_between_the_images_is_named():
    rng = RNG(7)
    poses = list(poses_of(8, rng))
    pairs = [pair_of(f"p{i}", pose, rng, 0.1) for i, pose in enumerate(poses)]
    shift = RigidTransform(np.eye(3), np.array([0.03, 0.0, 0.01]))
    pairs[2] = pair_of("moved", poses[2], rng, 0.1, moved=shift @ poses[2])
    fit = fit_infrared(pairs)
    assert fit.outliers == ("moved",)
    assert fit.shifts_m[2] > 0.02
    sds = np.sqrt(np.diag(fit.covariance))
    assert (np.abs(errors(fit.color_from_depth)) < 4 * sds).all()


def test_boards_held_by_hand_widen_the_intervals():
    rng = RNG(8)
    pairs = []
    for i, pose in enumerate(poses_of(10, rng)):
        shake = RigidTransform(np.eye(3), rng.normal(0.0, 0.003, 3))
        pairs.append(pair_of(f"p{i}", pose, rng, 0.05, moved=shake @ pose))
    fit = fit_infrared(pairs)
    assert fit.birge_ratio > 2.0
    sds = np.sqrt(np.diag(fit.covariance))
    assert (np.abs(errors(fit.color_from_depth)) < 4 * sds).all()


def test_two_pairs_are_too_few():
    assert fit_infrared(pairs_of(2, 9)) is None


def test_the_errors_of_both_cameras_are_joined():
    fit = fit_infrared(pairs_of(6, 10, 0.1))
    color, infrared = (("fx", "k1"), np.diag([4.0, 1e-6])), (("cx",), np.array([[1.0]]))
    names, joint = joint_covariance(fit, color, infrared)
    assert names[:3] == ("color.fx", "color.k1", "depth.cx")
    assert names[3:] == tuple(f"color_from_depth.{n}" for n in ("rx", "ry", "rz", "tx", "ty", "tz"))
    by = np.stack([fit.by_color[:, 0], fit.by_color[:, 5], fit.by_infrared[:, 2]], axis=1)
    expected = fit.covariance + by @ np.diag([4.0, 1e-6, 1.0]) @ by.T
    np.testing.assert_allclose(joint[3:, 3:], expected)
    np.testing.assert_allclose(joint[3:, 2], fit.by_infrared[:, 2])
    assert np.linalg.eigvalsh(joint).min() > -1e-12
