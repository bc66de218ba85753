"""What the body mask does fast gives the same as its definition, written down plainly."""

import cv2
import numpy as np
import pytest

from adibas.body.grid_kernels import grid_normals
from adibas.body.mask import fill_holes, heights_over
from adibas.body.person import BodyParams
from adibas.body.rays import viewing_rays
from adibas.data.calibration import CameraCalibration
from adibas.geometry.pinhole import Intrinsics
from adibas.geometry.planes import Plane


def normals_by_definition(points_m):
    normals = np.full_like(points_m, np.nan)
    across = points_m[2:-2, 4:] - points_m[2:-2, :-4]
    down = points_m[4:, 2:-2] - points_m[:-4, 2:-2]
    normal = np.cross(down, across)
    with np.errstate(invalid="ignore"):
        normals[2:-2, 2:-2] = normal / np.linalg.norm(normal, axis=-1, keepdims=True)
    return normals


def filled_by_definition(pixels, measured, params):
    """Look at each hole by itself."""
    holes = (~measured & ~pixels).astype(np.uint8)
    n_holes, labels = cv2.connectedComponents(holes, connectivity=4)
    filled = pixels.copy()
    for number in range(1, n_holes):
        hole = labels == number
        inner = hole & (cv2.dilate(pixels.astype(np.uint8), np.ones((3, 3))) > 0)
        outside = (~pixels & measured).astype(np.uint8)
        outer = hole & (cv2.dilate(outside, np.ones((3, 3))) > 0)
        is_small = hole.sum() < params.max_hole_share * pixels.sum()
        if is_small and outer.sum() <= 0.1 * inner.sum():
            filled |= hole
    return filled


@pytest.mark.parametrize("seed", range(3))
def test_normals_of_a_grid_are_cross_products_to_the_last_bit(seed):
    rng = np.random.default_rng(seed)
    points_m = rng.normal(0.0, 1.0, (30, 40, 3))
    points_m[rng.random((30, 40)) < 0.1] = np.nan
    points_m[10:16, 10:16] = 1.0
    np.testing.assert_array_equal(grid_normals(points_m), normals_by_definition(points_m))


@pytest.mark.parametrize("shape", [(0, 0, 3), (3, 40, 3), (40, 4, 3)])
def test_a_grid_without_neighbours_has_no_normals(shape):
    assert np.isnan(grid_normals(np.ones(shape))).all()


@pytest.mark.parametrize("seed", range(5))
def test_holes_are_filled_as_each_by_itself(seed):
    rng = np.random.default_rng(seed)
    smooth = cv2.GaussianBlur(rng.standard_normal((60, 80)), (0, 0), 6.0)
    gaps = cv2.GaussianBlur(rng.standard_normal((60, 80)), (0, 0), 1.5)
    pixels, measured = smooth > 0, gaps < 1.2 * gaps.std()
    pixels &= measured
    found = fill_holes(pixels, measured, BodyParams())
    expected = filled_by_definition(pixels, measured, BodyParams())
    np.testing.assert_array_equal(found, expected)
    assert (found != pixels).any()


def test_heights_are_those_of_the_floor_that_is_asked_for():
    camera = CameraCalibration(40, 30, Intrinsics(35.0, 36.0, 19.5, 14.5))
    depth_m = np.random.default_rng(0).uniform(1.0, 4.0, (30, 40)).astype(np.float32)
    depth_m[3, 4] = np.nan
    points_m = viewing_rays(camera) * depth_m[..., None]
    for tilt_rad, height_m in ((0.0, 1.0), (0.3, 1.0), (0.3, 1.4)):
        floor = Plane(np.array([0.0, -np.cos(tilt_rad), np.sin(tilt_rad)]), height_m)
        for _ in range(2):
            np.testing.assert_allclose(
                heights_over(depth_m, camera, floor),
                floor.signed_distance_m(points_m),
                atol=1e-5,
            )
