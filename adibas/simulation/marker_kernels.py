"""Stickers, balls and LEDs, drawn with 8 x 8 samples a pixel."""

import math

import numpy as np

from adibas.arrays import Float32Array, FloatArray, IntArray
from adibas.kernels import compiled
from adibas.simulation.color_kernels import Lamp, brightness, lit_share

N_SAMPLES = 8
DISC = 0
BALL = 1
_NOT_HIT = -1.0


@compiled
def _distance(x: float, y: float, shape: FloatArray, kind: int) -> float:
    """Return z where the ray (x, y, 1) meets the marker, negative where it misses.

    `shape` is the centre (3), the normal (3) and the radius.
    """
    cx, cy, cz, nx, ny, nz, radius = shape
    if kind == DISC:
        z = (nx * cx + ny * cy + nz * cz) / (nx * x + ny * y + nz)
        dx, dy, dz = x * z - cx, y * z - cy, z - cz
        return z if dx * dx + dy * dy + dz * dz <= radius * radius else _NOT_HIT
    length2 = x * x + y * y + 1.0
    middle = (x * cx + y * cy + cz) / length2
    left = middle * middle - (cx * cx + cy * cy + cz * cz - radius * radius) / length2
    return middle - math.sqrt(left) if left >= 0.0 else _NOT_HIT


@compiled
def _ray_slopes(rays: Float32Array, v: int, u: int) -> tuple[float, float, float, float]:
    """Return change of x and y with u, then with v."""
    height, width = rays.shape[0], rays.shape[1]
    u0, u1 = max(u - 1, 0), min(u + 1, width - 1)
    v0, v1 = max(v - 1, 0), min(v + 1, height - 1)
    return (
        (rays[v, u1, 0] - rays[v, u0, 0]) / (u1 - u0),
        (rays[v, u1, 1] - rays[v, u0, 1]) / (u1 - u0),
        (rays[v1, u, 0] - rays[v0, u, 0]) / (v1 - v0),
        (rays[v1, u, 1] - rays[v0, u, 1]) / (v1 - v0),
    )


@compiled
def _sample(
    place: tuple[int, int], rays: Float32Array, shape: FloatArray, kind: int, normal: FloatArray
) -> tuple[float, float]:
    """Return the share of a pixel that shows the marker and its mean z there.

    `place` (v, u) may lie outside the image. For a ball the mean normal is written to `normal`.
    """
    v, u = place
    v2, u2 = min(max(v, 0), rays.shape[0] - 1), min(max(u, 0), rays.shape[1] - 1)
    xu, yu, xv, yv = _ray_slopes(rays, v2, u2)
    hits, total_z = 0, 0.0
    total = np.zeros(3)
    for i in range(N_SAMPLES):
        dv = (i + 0.5) / N_SAMPLES - 0.5 + (v - v2)
        for j in range(N_SAMPLES):
            du = (j + 0.5) / N_SAMPLES - 0.5 + (u - u2)
            x = rays[v2, u2, 0] + du * xu + dv * xv
            y = rays[v2, u2, 1] + du * yu + dv * yv
            z = _distance(x, y, shape, kind)
            if z > 0.0:
                hits += 1
                total_z += z
                total[0] += x * z - shape[0]
                total[1] += y * z - shape[1]
                total[2] += z - shape[2]
    if hits == 0:
        return 0.0, 0.0
    if kind == BALL:
        length = math.sqrt(total[0] ** 2 + total[1] ** 2 + total[2] ** 2)
        for axis in range(3):
            normal[axis] = total[axis] / length
    return hits / (N_SAMPLES * N_SAMPLES), total_z / hits


@compiled
def paint_markers(
    shapes: tuple[FloatArray, IntArray, int],
    images: tuple[Float32Array, Float32Array],
    looks: FloatArray,
    lamp: Lamp,
    linear: Float32Array,
) -> FloatArray:
    """Paint markers over (H, W, 3) `linear` and return the share of each that is seen (N,).

    `shapes` are centre, normal and radius (N, 7) in camera axes, metres; first and one past the
    last column and row (N, 4) of the pixels that each may touch; DISC or BALL. `images` are 1/z
    of all else and the rays. `looks` is albedo (3), gloss, and how far skin may stand out over a
    sticker without hiding it, metres.
    """
    markers, boxes, kind = shapes
    inverse_depth, rays = images
    seen = np.zeros(markers.shape[0])
    normal = np.empty(3)
    for m in range(markers.shape[0]):
        whole, shown = 0.0, 0.0
        away = 0.0
        for axis in range(3):
            normal[axis] = markers[m, 3 + axis]
            away += normal[axis] * markers[m, axis]
        if kind == DISC and away >= 0.0:
            continue
        for v in range(boxes[m, 2], boxes[m, 3]):
            for u in range(boxes[m, 0], boxes[m, 1]):
                share, z = _sample((v, u), rays, markers[m], kind, normal)
                whole += share
                outside = v < 0 or u < 0 or v >= linear.shape[0] or u >= linear.shape[1]
                if share == 0.0 or outside or inverse_depth[v, u] * (z - looks[4]) > 1.0:
                    continue
                shown += share
                point = (rays[v, u, 0] * z, rays[v, u, 1] * z, z)
                lit = lit_share(point[0], point[1], point[2], lamp)
                light, shine = brightness(point, (normal[0], normal[1], normal[2]), lit, lamp)
                for channel in range(3):
                    color = light * looks[channel] + shine * looks[3]
                    linear[v, u, channel] += share * (color - linear[v, u, channel])
        seen[m] = shown / whole if whole > 0.0 else 0.0
    return seen


@compiled
def place_balls(
    centers: FloatArray, radius: float, rays: Float32Array, inverse_depth: Float32Array
) -> None:
    """Put balls, centres (N, 3) in camera axes, before what (H, W) `inverse_depth` holds."""
    shape = np.zeros(7)
    shape[6] = radius
    for m in range(centers.shape[0]):
        for axis in range(3):
            shape[axis] = centers[m, axis]
        reach = 1.1 * radius / shape[2]
        x0, y0 = shape[0] / shape[2], shape[1] / shape[2]
        for v in range(rays.shape[0]):
            # Without distortion all pixels of a row share y.
            if abs(rays[v, 0, 1] - y0) > reach:
                continue
            for u in range(rays.shape[1]):
                if abs(rays[v, u, 0] - x0) > reach:
                    continue
                z = _distance(rays[v, u, 0], rays[v, u, 1], shape, BALL)
                if z * inverse_depth[v, u] < 1.0 and z > 0.0:
                    inverse_depth[v, u] = np.float32(1.0 / z)


@compiled
def add_glow(
    centers: FloatArray, power: FloatArray, spread: FloatArray, linear: Float32Array
) -> None:
    """Add the light of LEDs to (H, W, 3) `linear`.

    `centers` (N, 2) are u and v, `power` (N,) the brightness at the centre, `spread` the standard
    deviations of core and halo in pixels and the halo's share.
    """
    core, halo, share = spread
    reach = int(4.0 * halo)
    for m in range(centers.shape[0]):
        u0, v0 = int(centers[m, 0]), int(centers[m, 1])
        for v in range(max(v0 - reach, 0), min(v0 + reach + 2, linear.shape[0])):
            for u in range(max(u0 - reach, 0), min(u0 + reach + 2, linear.shape[1])):
                squared = (u - centers[m, 0]) ** 2 + (v - centers[m, 1]) ** 2
                glow = math.exp(-0.5 * squared / (core * core))
                glow += share * math.exp(-0.5 * squared / (halo * halo))
                for channel in range(3):
                    linear[v, u, channel] += power[m] * glow
