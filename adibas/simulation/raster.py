"""Which triangle of a mesh each pixel sees: a z-buffer on homogeneous edge functions.

Triangles that cross the plane of the camera need no clipping here: the edge functions are taken
of the points before the division by z, and a pixel is kept where 1/z is positive.

Source: Olano & Greer, Triangle Scan Conversion using 2D Homogeneous Coordinates, 1997.
"""

import math
from typing import NamedTuple

import numpy as np

from adibas.arrays import Float32Array, FloatArray, Int32Array, check_shape, read_only
from adibas.geometry.pinhole import Intrinsics
from adibas.kernels import compiled

NEAR_M = 0.05


class Fragments(NamedTuple):
    """What each pixel sees of a mesh.

    Attributes
    ----------
    depth_m : (H, W) float32 array
        Along the camera's z, metres; NaN where no triangle is seen.
    triangle : (H, W) int32 array
        Row of the mesh's triangles; -1 where none is seen.
    barycentric : (H, W, 2) float32 array
        Weights of the triangle's first two corners (the third is 1 minus both), on the surface,
        that is with perspective; NaN where none is seen.
    """

    depth_m: Float32Array
    triangle: Int32Array
    barycentric: Float32Array


def rasterise(
    vertices_camera_m: FloatArray,
    triangles: Int32Array,
    intrinsics: Intrinsics,
    size: tuple[int, int],
    *,
    hides_back_faces: bool = False,
) -> Fragments:
    """Draw a mesh as a distortion-free camera sees it.

    Parameters
    ----------
    vertices_camera_m : (V, 3) array
        In the camera's axes (x right, y down, z forward), metres.
    triangles : (T, 3) int32 array
        Rows of `vertices_camera_m`; seen from outside they run counter-clockwise.
    intrinsics : Intrinsics
        Of the camera.
    size : (height, width)
        Of the image.
    hides_back_faces : bool
        Leaves out triangles that turn their inner side to the camera: right for closed surfaces,
        and twice as fast.

    Returns
    -------
    Fragments
        Depth, triangle and weights of every pixel centre; nothing nearer than 5 cm is seen.
    """
    check_shape("vertices_camera_m", vertices_camera_m, (None, 3))
    vertices = np.ascontiguousarray(vertices_camera_m, dtype=np.float64)
    corners = np.ascontiguousarray(triangles, dtype=np.int32).view()
    read_only(corners)
    lens = lens_vector(intrinsics, ())
    inverse_depth, seen = draw(vertices, corners, lens, size, hides_back_faces=hides_back_faces)
    depth_m = np.full(size, np.nan, np.float32)
    barycentric = np.full((*size, 2), np.nan, np.float32)
    _weigh(vertices, corners, lens, seen, barycentric)
    hit = seen >= 0
    depth_m[hit] = 1.0 / inverse_depth[hit]
    return Fragments(depth_m, seen, barycentric)


def draw(
    vertices: FloatArray,
    triangles: Int32Array,
    lens: FloatArray,
    size: tuple[int, int],
    *,
    hides_back_faces: bool,
) -> tuple[Float32Array, Int32Array]:
    """Return the (H, W) float32 1/z (0 = nothing) and the (H, W) int32 triangle (-1 = none).

    `vertices` is (V, 3) float64 and C-contiguous, metres in camera axes; `lens` is a
    `lens_vector`. With lens distortion the corners stand exactly where the lens shows them and
    the edges between them stay straight, which small triangles do not notice.
    """
    # numba compiles anew for arrays that can be written.
    triangles = triangles.view()
    read_only(triangles)
    inverse_depth = np.zeros(size, np.float32)
    seen = np.full(size, -1, np.int32)
    _fill(_homogeneous(vertices, lens), triangles, hides_back_faces, inverse_depth, seen)
    return inverse_depth, seen


def lens_vector(intrinsics: Intrinsics, distortion: tuple[float, ...]) -> FloatArray:
    """Return (9,) fx fy cx cy k1 k2 p1 p2 k3 for the kernels; at most five coefficients."""
    lens = np.zeros(9)
    lens[:4] = intrinsics.fx, intrinsics.fy, intrinsics.cx, intrinsics.cy
    lens[4 : 4 + len(distortion)] = distortion
    return lens


@compiled
def _homogeneous(vertices: FloatArray, lens: FloatArray) -> FloatArray:
    """Turn points into (u z, v z, z)."""
    fx, fy, cx, cy, k1, k2, p1, p2, k3 = lens
    pixels = np.empty_like(vertices)
    for i in range(vertices.shape[0]):
        z = vertices[i, 2]
        bent_x, bent_y = vertices[i, 0], vertices[i, 1]
        if z > NEAR_M:
            x, y = bent_x / z, bent_y / z
            r2 = x * x + y * y
            radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3))
            bent_x = z * (x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x))
            bent_y = z * (y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y)
        pixels[i, 0] = fx * bent_x + cx * z
        pixels[i, 1] = fy * bent_y + cy * z
        pixels[i, 2] = z
    return pixels


@compiled
def _bounds(a: float, b: float, c: float, length: int) -> tuple[int, int]:
    """Return the first and one past the last pixel centre between three coordinates."""
    first = max(math.ceil(min(a, b, c)), 0)
    last = min(math.floor(max(a, b, c)), length - 1)
    return first, last + 1


@compiled
def _fill(
    pixels: FloatArray,
    triangles: Int32Array,
    hides_back_faces: bool,
    inverse_depth: Float32Array,
    seen: Int32Array,
) -> None:
    edges = np.empty((3, 3))
    for t in range(triangles.shape[0]):
        a, b, c = pixels[triangles[t, 0]], pixels[triangles[t, 1]], pixels[triangles[t, 2]]
        if max(a[2], b[2], c[2]) <= NEAR_M:
            continue
        _cross(b, c, edges[0])
        determinant = a[0] * edges[0, 0] + a[1] * edges[0, 1] + a[2] * edges[0, 2]
        if determinant == 0.0 or (hides_back_faces and determinant > 0.0):
            continue
        _cross(c, a, edges[1])
        _cross(a, b, edges[2])
        u0, u1, v0, v1 = 0, seen.shape[1], 0, seen.shape[0]
        if min(a[2], b[2], c[2]) > NEAR_M:
            u0, u1 = _bounds(a[0] / a[2], b[0] / b[2], c[0] / c[2], seen.shape[1])
            v0, v1 = _bounds(a[1] / a[2], b[1] / b[2], c[1] / c[2], seen.shape[0])
        _fill_box((u0, u1, v0, v1), edges, determinant, (inverse_depth, seen), t)


@compiled
def _cross(a: FloatArray, b: FloatArray, product: FloatArray) -> None:
    product[0] = a[1] * b[2] - a[2] * b[1]
    product[1] = a[2] * b[0] - a[0] * b[2]
    product[2] = a[0] * b[1] - a[1] * b[0]


@compiled
def _fill_box(
    box: tuple[int, int, int, int],
    edges: FloatArray,
    determinant: float,
    images: tuple[Float32Array, Int32Array],
    t: int,
) -> None:
    """Draw triangle `t`; `edges` are the rows of its inverse matrix times `determinant`."""
    u0, u1, v0, v1 = box
    inverse_depth, seen = images
    # Neighbours share an edge with exactly opposite values, so that no pixel falls between.
    side = 1.0 if determinant > 0.0 else -1.0
    scale = 1.0 / abs(determinant)
    a0, a1, a2 = edges[0, 0], edges[1, 0], edges[2, 0]
    for v in range(v0, v1):
        r0 = edges[0, 1] * v + edges[0, 2]
        r1 = edges[1, 1] * v + edges[1, 2]
        r2 = edges[2, 1] * v + edges[2, 2]
        for u in range(u0, u1):
            w0, w1, w2 = side * (a0 * u + r0), side * (a1 * u + r1), side * (a2 * u + r2)
            if w0 >= 0.0 and w1 >= 0.0 and w2 >= 0.0:
                inverse_z = np.float32((w0 + w1 + w2) * scale)
                if inverse_depth[v, u] < inverse_z < 1.0 / NEAR_M:
                    inverse_depth[v, u] = inverse_z
                    seen[v, u] = t


@compiled
def ray_weights(
    x: float, y: float, vertices: FloatArray, i: int, j: int, k: int
) -> tuple[float, float]:
    """Return the weights of corners i and j where the ray (x, y, 1) meets their plane."""
    ax, ay, az = vertices[i]
    bx, by, bz = vertices[j]
    cx, cy, cz = vertices[k]
    w0 = (by * cz - bz * cy) * x + (bz * cx - bx * cz) * y + bx * cy - by * cx
    w1 = (cy * az - cz * ay) * x + (cz * ax - cx * az) * y + cx * ay - cy * ax
    w2 = (ay * bz - az * by) * x + (az * bx - ax * bz) * y + ax * by - ay * bx
    total = w0 + w1 + w2
    return w0 / total, w1 / total


@compiled
def _weigh(
    vertices: FloatArray,
    triangles: Int32Array,
    lens: FloatArray,
    seen: Int32Array,
    barycentric: Float32Array,
) -> None:
    height, width = seen.shape
    for v in range(height):
        y = (v - lens[3]) / lens[1]
        for u in range(width):
            t = seen[v, u]
            if t >= 0:
                x = (u - lens[2]) / lens[0]
                i, j, k = triangles[t]
                b0, b1 = ray_weights(x, y, vertices, i, j, k)
                barycentric[v, u, 0] = b0
                barycentric[v, u, 1] = b1
