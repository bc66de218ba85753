"""The pixel loops of the simulated colour camera; all light is linear."""

import math
from typing import NamedTuple

import numpy as np

from adibas.arrays import (
    Float32Array,
    FloatArray,
    Int32Array,
    IntArray,
    UInt8Array,
    UInt16Array,
)
from adibas.kernels import compiled
from adibas.simulation.raster import ray_weights

FLOOR_BOUNCE = 0.55
"""Light from below against light from above, in the light from all around."""


class Lamp(NamedTuple):
    """The lamp, its shadow map, and the light from all around.

    Attributes
    ----------
    position : (3,) float64 array
        In camera axes, metres.
    pose : (3, 4) float64 array
        Camera points into the lamp's axes.
    lens : (2,) float64 array
        Focal length and principal point of the shadow map, pixels.
    nearest : (S, S) float32 array
        1/z of what the lamp meets first, 0 where nothing.
    strength : (4,) float64 array
        Of the lamp at 1 m, of the light from all around, and of the fill from the camera's side;
        last the tolerance of the shadow, metres.
    up : (3,) float64 array
        Against gravity, in camera axes.
    """

    position: FloatArray
    pose: FloatArray
    lens: FloatArray
    nearest: Float32Array
    strength: FloatArray
    up: FloatArray


class Mesh(NamedTuple):
    """A person's surface; V vertices, T triangles, C covers.

    Attributes
    ----------
    vertices, normals : (V, 3) float64 arrays
        In camera axes.
    rest : (V, 3) float32 array
        Where the grain of skin and cloth hangs, metres.
    covers : (V, C) float32 array
        See `looks.surface_fields`.
    triangles : (T, 3) int32 array
    """

    vertices: FloatArray
    normals: FloatArray
    rest: Float32Array
    covers: Float32Array
    triangles: Int32Array


@compiled
def _in_shadow_map(x: float, y: float, z: float, lamp: Lamp) -> tuple[float, float, float]:
    """Return column, row and distance from the lamp (<= 0 behind it) of a point."""
    pose = lamp.pose
    far = pose[2, 0] * x + pose[2, 1] * y + pose[2, 2] * z + pose[2, 3]
    if far <= 0.0:
        return 0.0, 0.0, far
    focal, middle = lamp.lens[0] / far, lamp.lens[1]
    u = focal * (pose[0, 0] * x + pose[0, 1] * y + pose[0, 2] * z + pose[0, 3]) + middle
    v = focal * (pose[1, 0] * x + pose[1, 1] * y + pose[1, 2] * z + pose[1, 3]) + middle
    return u, v, far


@compiled
def lit_share(x: float, y: float, z: float, lamp: Lamp) -> float:
    """Return how much of the lamp a point in camera axes sees, 0 to 1, with a soft border."""
    u, v, far = _in_shadow_map(x, y, z, lamp)
    u0, v0 = math.floor(u), math.floor(v)
    nearest = lamp.nearest
    size = nearest.shape[0]
    if far <= 0.0 or min(u0, v0) < 1 or max(u0, v0) >= size - 2:
        return 1.0
    fu, fv = u - u0, v - v0
    limit = 1.0 / (far - lamp.strength[3])
    shadow = 0.0
    for dv in range(-1, 3):
        weight_v = 1.0 - fv if dv == -1 else (fv if dv == 2 else 1.0)  # noqa: PLR2004
        for du in range(-1, 3):
            if nearest[v0 + dv, u0 + du] > limit:
                weight_u = 1.0 - fu if du == -1 else (fu if du == 2 else 1.0)  # noqa: PLR2004
                shadow += weight_u * weight_v
    return 1.0 - shadow / 9.0


@compiled
def brightness(
    point: tuple[float, float, float], normal: tuple[float, float, float], lit: float, lamp: Lamp
) -> tuple[float, float]:
    """Return diffuse light on a surface and the strength of a highlight, both >= 0."""
    x, y, z = point
    nx, ny, nz = normal
    lx, ly, lz = lamp.position[0] - x, lamp.position[1] - y, lamp.position[2] - z
    squared = lx * lx + ly * ly + lz * lz
    distance = math.sqrt(squared)
    facing = (nx * lx + ny * ly + nz * lz) / distance
    direct = lamp.strength[0] / squared * lit
    upward = nx * lamp.up[0] + ny * lamp.up[1] + nz * lamp.up[2]
    around = 0.5 * (1.0 + FLOOR_BOUNCE) + 0.5 * (1.0 - FLOOR_BOUNCE) * upward
    fill = lamp.strength[2] * max(-nz, 0.0)
    light = direct * max(facing, 0.0) + lamp.strength[1] * around + fill
    # Half way between lamp and eye, for the highlight (Blinn).
    eye = 1.0 / math.sqrt(x * x + y * y + z * z)
    hx, hy, hz = lx / distance - x * eye, ly / distance - y * eye, lz / distance - z * eye
    middle = (nx * hx + ny * hy + nz * hz) / math.sqrt(hx * hx + hy * hy + hz * hz)
    highlight = direct * max(middle, 0.0) ** 24 if facing > 0.0 else 0.0
    return light, highlight


@compiled
def _hash(i: int, j: int, k: int) -> float:
    """Return a number in -1 ... 1 that depends on three whole ones."""
    mixed = np.uint32(i * 73856093 ^ j * 19349663 ^ k * 83492791)
    mixed = np.uint32((mixed ^ (mixed >> np.uint32(15))) * np.uint32(2246822519))
    mixed = mixed ^ (mixed >> np.uint32(13))
    return np.float64(mixed) * (2.0 / 4294967295.0) - 1.0


@compiled
def grain(x: float, y: float, z: float) -> float:
    """Return smooth noise of about -1 ... 1 with grains of size 1."""
    i, j, k = math.floor(x), math.floor(y), math.floor(z)
    fx, fy, fz = x - i, y - j, z - k
    total = 0.0
    for corner in range(8):
        di, dj, dk = corner & 1, (corner >> 1) & 1, corner >> 2
        weight = (fx if di else 1 - fx) * (fy if dj else 1 - fy) * (fz if dk else 1 - fz)
        total += weight * _hash(i + di, j + dj, k + dk)
    return total


@compiled
def mixed(
    values: FloatArray | Float32Array, corners: Int32Array, weights: FloatArray, column: int
) -> float:
    """Interpolate one column of vertex values."""
    return float(
        values[corners[0], column] * weights[0]
        + values[corners[1], column] * weights[1]
        + values[corners[2], column] * weights[2]
    )


@compiled
def material_at(covers: Float32Array, corners: Int32Array, weights: FloatArray) -> int:
    """Return the row of `looks.MATERIALS` that is outermost: 0 bare skin."""
    for cover in range(covers.shape[1] - 1, -1, -1):
        if mixed(covers, corners, weights, cover) > 0.0:
            return cover + 1
    return 0


@compiled
def _look_at(
    covers: Float32Array,
    corners: Int32Array,
    weights: FloatArray,
    looks: tuple[Float32Array, float],
    look: FloatArray,
) -> None:
    """Write albedo and finish (6,) of a point: the covers laid over the skin, hems smoothed.

    `looks` are those of all materials (M, 6), and the width of a pixel in metres.
    """
    table, pixel_m = looks
    for k in range(6):
        look[k] = table[0, k]
    for cover in range(covers.shape[1]):
        inside_m = mixed(covers, corners, weights, cover)
        if inside_m > -0.5 * pixel_m:
            share = min(0.5 + inside_m / pixel_m, 1.0)
            for k in range(6):
                look[k] += share * (table[cover + 1, k] - look[k])


@compiled
def shade_person(
    mesh: Mesh,
    images: tuple[Float32Array, Int32Array, Float32Array],
    looks: tuple[Float32Array, float],
    lamp: Lamp,
    linear: Float32Array,
) -> None:
    """Paint the person over (H, W, 3) `linear`, which already holds the room.

    `images` are 1/z, triangle and rays (H, W, 2); `looks` are albedo and finish of the materials
    side by side (M, 6), see `looks.Materials`, and the angle of a pixel.
    """
    inverse_depth, seen, rays = images
    weights, look = np.empty(3), np.empty(6)
    normal, rest = np.empty(3), np.empty(3)
    for v in range(seen.shape[0]):
        for u in range(seen.shape[1]):
            if seen[v, u] < 0:
                continue
            corners = mesh.triangles[seen[v, u]]
            x, y, z = rays[v, u, 0], rays[v, u, 1], 1.0 / inverse_depth[v, u]
            weights[0], weights[1] = ray_weights(
                x, y, mesh.vertices, corners[0], corners[1], corners[2]
            )
            weights[2] = 1.0 - weights[0] - weights[1]
            _look_at(mesh.covers, corners, weights, (looks[0], looks[1] * z), look)
            for axis in range(3):
                normal[axis] = mixed(mesh.normals, corners, weights, axis)
                rest[axis] = mixed(mesh.rest, corners, weights, axis) / look[5]
            scale = 1.0 / math.sqrt(normal[0] ** 2 + normal[1] ** 2 + normal[2] ** 2)
            point = (x * z, y * z, z)
            light, highlight = brightness(
                point,
                (normal[0] * scale, normal[1] * scale, normal[2] * scale),
                lit_share(point[0], point[1], point[2], lamp),
                lamp,
            )
            light *= 1.0 + look[4] * grain(rest[0], rest[1], rest[2])
            for channel in range(3):
                linear[v, u, channel] = light * look[channel] + highlight * look[3]


@compiled
def light_room(
    places: Float32Array,
    normals: Float32Array,
    albedo: Float32Array,
    lamp: Lamp,
    images: tuple[Float32Array, Float32Array, Int32Array],
) -> None:
    """Paint the empty room: all light into the first of `images`, the lamp's into the second.

    Everything is (H, W, 3), `places` and `normals` in camera axes; only the third image is (H, W):
    the cell of the shadow map (row times width plus column) in which a pixel lies, -1 for none.
    """
    linear, direct, cells = images
    size = lamp.nearest.shape[0]
    for v in range(places.shape[0]):
        for u in range(places.shape[1]):
            point = (places[v, u, 0], places[v, u, 1], places[v, u, 2])
            normal = (normals[v, u, 0], normals[v, u, 1], normals[v, u, 2])
            lit = lit_share(point[0], point[1], point[2], lamp)
            whole, _ = brightness(point, normal, lit, lamp)
            without, _ = brightness(point, normal, 0.0, lamp)
            for channel in range(3):
                linear[v, u, channel] = whole * albedo[v, u, channel]
                direct[v, u, channel] = (whole - without) * albedo[v, u, channel]
            column, row, far = _in_shadow_map(point[0], point[1], point[2], lamp)
            i, j = int(row), int(column)
            if far > 0.0 and 0 <= i < size and 0 <= j < size:
                cells[v, u] = i * size + j


@compiled
def shade_room(
    images: tuple[Float32Array, Float32Array, Int32Array],
    occupied: Float32Array,
    lamp: Lamp,
    linear: Float32Array,
) -> None:
    """Take the lamp's light out of (H, W, 3) `linear` where a person shades the room.

    `images` are the room's points (H, W, 3) in camera axes, and the lamp's light and the cells
    that `light_room` wrote; `occupied` is the shadow map with all shadows grown.
    """
    places, direct, cells = images
    size = occupied.shape[0]
    for v in range(cells.shape[0]):
        for u in range(cells.shape[1]):
            cell = cells[v, u]
            if cell < 0 or occupied[cell // size, cell % size] == 0.0:
                continue
            shaded = 1.0 - lit_share(places[v, u, 0], places[v, u, 1], places[v, u, 2], lamp)
            for channel in range(3):
                linear[v, u, channel] -= shaded * direct[v, u, channel]


@compiled
def expose(
    linear: Float32Array,
    camera: FloatArray,
    noise: Float32Array,
    offsets: IntArray,
    raw: UInt16Array,
) -> None:
    """Turn light into the (H, W) uint16 raw image behind an RGGB filter, 12 bits.

    `camera` holds the light's colour (3) and the camera's gains (3) for red, green and blue, full
    well and read noise in electrons, and the share of light lost in the corners. Each row of the
    image takes its normal numbers out of `noise` from its own of `offsets` on.
    """
    height, width = raw.shape
    full_well, read = camera[6], camera[7]
    loss = 4.0 * camera[8] / (width * width + height * height)
    for v in range(height):
        start = offsets[v]
        down = (v - 0.5 * height) ** 2
        for u in range(width):
            channel = (v & 1) + (u & 1)
            across = (u - 0.5 * width) * (u - 0.5 * width)
            signal = linear[v, u, channel] * camera[channel] * (1.0 - loss * (across + down))
            # The converter is full before the pixel is: what is too bright has no noise.
            electrons = full_well * min(max(signal, 0.0), 1.2)
            noisy = electrons + math.sqrt(electrons + read * read) * noise[start + u]
            value = noisy * camera[3 + channel] * (4095.0 / full_well)
            raw[v, u] = np.uint16(min(max(value + 0.5, 0.0), 4095.0))


@compiled
def develop(raw: UInt16Array, curve: UInt8Array, image: UInt8Array) -> None:
    """Look every value of the (H, W, 3) `raw` up in `curve`."""
    for v in range(raw.shape[0]):
        for u in range(raw.shape[1]):
            for channel in range(3):
                image[v, u, channel] = curve[raw[v, u, channel]]
