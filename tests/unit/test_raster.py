"""The rasteriser agrees with rays cast by hand, whatever the mesh and wherever it stands."""

import numpy as np
import pytest

from adibas.geometry.pinhole import Intrinsics, back_project
from adibas.simulation.raster import rasterise

CAMERA = Intrinsics(60.0, 62.0, 31.3, 23.8)
SIZE = (48, 64)


def sphere_mesh(center, radius, n_around=96, n_down=48):
    down, around = np.meshgrid(
        np.linspace(0, np.pi, n_down + 1),
        np.linspace(0, 2 * np.pi, n_around, endpoint=False),
        indexing="ij",
    )
    points = np.stack(
        [np.sin(down) * np.cos(around), np.sin(down) * np.sin(around), np.cos(down)], axis=-1
    )
    row, column = (grid.ravel() for grid in np.indices((n_down, n_around)))
    following = (column + 1) % n_around
    a, b = row * n_around + column, (row + 1) * n_around + column
    c, d = (row + 1) * n_around + following, row * n_around + following
    triangles = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    return points.reshape(-1, 3) * radius + center, triangles.astype(np.int32)


def rays():
    return back_project(np.ones(SIZE), CAMERA)


def cast_rays(vertices, triangles, near_m=0.05):
    """Möller & Trumbore, every ray against every triangle."""
    directions = rays()
    depth_m = np.full(SIZE, np.inf)
    for a, b, c in vertices[triangles]:
        across = np.cross(directions, c - a)
        determinant = across @ (b - a)
        with np.errstate(divide="ignore", invalid="ignore"):
            u = across @ -a / determinant
            q = np.cross(-a, b - a)
            v = directions @ q / determinant
            z = (c - a) @ q / determinant
        hit = (u >= 0) & (v >= 0) & (u + v <= 1) & (z > near_m)
        depth_m = np.where(hit, np.minimum(z, depth_m), depth_m)
    return np.where(np.isfinite(depth_m), depth_m, np.nan)


def test_random_triangles_are_seen_as_cast_rays_see_them():
    rng = np.random.default_rng(5)
    # Corners before and behind the camera: triangles that cross its plane are among them.
    vertices = rng.uniform((-2, -2, -0.5), (2, 2, 3), (60, 3))
    triangles = rng.permutation(60).reshape(20, 3).astype(np.int32)
    assert (
        (vertices[triangles][..., 2] < 0).any(1) & (vertices[triangles][..., 2] > 0).any(1)
    ).any()
    seen = rasterise(vertices, triangles, CAMERA, SIZE)
    np.testing.assert_allclose(seen.depth_m, cast_rays(vertices, triangles), rtol=1e-5)
    np.testing.assert_array_equal(seen.triangle >= 0, np.isfinite(seen.depth_m))


def test_weights_give_back_the_point_that_is_seen():
    vertices, triangles = sphere_mesh((0.1, -0.2, 2.0), 0.7)
    seen = rasterise(vertices, triangles, CAMERA, SIZE)
    hit = seen.triangle >= 0
    weights = seen.barycentric[hit].astype(float)
    weights = np.concatenate([weights, 1 - weights.sum(1, keepdims=True)], axis=1)
    points = np.einsum("nk,nkc->nc", weights, vertices[triangles[seen.triangle[hit]]])
    np.testing.assert_allclose(points, (rays() * seen.depth_m[..., None])[hit], atol=1e-5)
    assert hit.sum() > 500


def test_sphere_has_the_depth_of_the_formula_and_no_holes():
    center, radius = np.array([0.1, -0.2, 2.0]), 0.7
    vertices, triangles = sphere_mesh(center, radius, 400, 200)
    seen = rasterise(vertices, triangles, CAMERA, SIZE)
    direction = rays()
    length2 = (direction**2).sum(-1)
    middle = direction @ center
    inside = middle**2 - length2 * (center @ center - radius**2)
    with np.errstate(invalid="ignore"):
        depth_m = (middle - np.sqrt(inside)) / length2
    well_inside = inside > 0.02
    np.testing.assert_allclose(seen.depth_m[well_inside], depth_m[well_inside], atol=2e-4)
    assert np.isnan(seen.depth_m[inside < 0]).all()


def test_hiding_back_faces_changes_nothing_of_a_closed_surface():
    vertices, triangles = sphere_mesh((0.1, -0.2, 2.0), 0.7)
    both = rasterise(vertices, triangles, CAMERA, SIZE)
    front = rasterise(vertices, triangles, CAMERA, SIZE, hides_back_faces=True)
    np.testing.assert_array_equal(both.depth_m, front.depth_m)
    inside_out = rasterise(vertices, triangles[:, ::-1], CAMERA, SIZE, hides_back_faces=True)
    assert np.nanmax(inside_out.depth_m - front.depth_m) > 1.3


def test_nothing_is_seen_behind_the_camera():
    vertices, triangles = sphere_mesh((0.0, 0.0, -2.0), 0.7)
    seen = rasterise(vertices, triangles, CAMERA, SIZE)
    assert np.isnan(seen.depth_m).all()
    assert (seen.triangle == -1).all()


def test_points_must_have_three_coordinates():
    with pytest.raises(ValueError, match="vertices_camera_m"):
        rasterise(np.zeros((3, 2)), np.zeros((1, 3), np.int32), CAMERA, SIZE)
