"""The pixel loops of the simulated depth camera."""

import math
from typing import NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from adibas.arrays import BoolArray, Float32Array, UInt16Array
from adibas.kernels import compiled

Int8Array: TypeAlias = npt.NDArray[np.int8]

NO_PATTERN = 2047
"""Raw disparity that the device gives where it found nothing; everything beyond is nothing."""


class Numbers(NamedTuple):
    """What the kernels need of device and noise; all float, units as in their classes."""

    focal_px: float
    pixel_rad: float
    cx: float
    cy: float
    bias_a: float
    bias_b: float
    disparity_factor: float
    disparity_offset: float
    edge_step_m: float
    edge_dropout: float
    random_dropout: float
    flying_share: float
    grazing_begin_cos: float
    grazing_slope: float
    dim_echo: float
    dark_slope: float
    nearest_m: float
    farthest_m: float


Around: TypeAlias = tuple[float, float, float, float, float]
"""1/z of the pixels left, right, above and below, and of the pixel itself."""


class NoiseFields(NamedTuple):
    """What differs from pixel to pixel in one frame, all (H, W); random but for the bias.

    Attributes
    ----------
    disparity : float32
        Added to the disparity, raw units.
    jitter_u, jitter_v : int8
        Where an outline is seen instead, pixels.
    luck : float32
        Uniform in 0 to 1; a pixel fails where that is below its probability to fail.
    bias_c : float32
        `DepthBias.square_term_per_m` of the device.
    """

    disparity: Float32Array
    jitter_u: Int8Array
    jitter_v: Int8Array
    luck: Float32Array
    bias_c: Float32Array


@compiled
def find_lit(
    inverse_depth: Float32Array, factor_px_m: float, lit: BoolArray, nearest: Float32Array
) -> None:
    """Mark the pixels that the projector, `factor_px_m / focal` to the right, shines on.

    Row by row, the surface is drawn into the projector's columns (`nearest`, one row's scratch)
    and a pixel is lit where nothing nearer came to stand in its column. `factor_px_m` is focal
    length times baseline.
    """
    height, width = inverse_depth.shape
    n_columns = nearest.shape[0]
    for v in range(height):
        nearest[:] = 0.0
        for u in range(width):
            shift = factor_px_m * inverse_depth[v, u]
            first = u - shift
            last = first
            if u + 1 < width:
                step = factor_px_m * (inverse_depth[v, u + 1] - inverse_depth[v, u])
                # A drop of more than two pixels between neighbours is a gap, not a surface.
                last = first + 1.0 - step if abs(step) < 2.0 else first + 0.5  # noqa: PLR2004
            begin = math.floor(min(first, last) + 0.5) + n_columns - width
            end = math.floor(max(first, last) + 0.5) + n_columns - width
            for column in range(max(begin, 0), min(end, n_columns - 1) + 1):
                nearest[column] = max(nearest[column], shift)
        for u in range(width):
            shift = factor_px_m * inverse_depth[v, u]
            column = math.floor(u - shift + 0.5) + n_columns - width
            lit[v, u] = column < 0 or nearest[column] < shift + 1.5


@compiled
def _gentlest(before: float, middle: float, after: float) -> float:
    """Return the smaller of two one-sided differences: the slope on this pixel's own surface."""
    behind, ahead = middle - before, after - middle
    return behind if abs(behind) < abs(ahead) else ahead


@compiled
def _cosine(around: Around, v: int, u: int, n: Numbers) -> float:
    """Return the cosine between the line of sight and the surface's normal."""
    left, right, up, down, here = around
    # On a plane 1/z is linear in the pixel, and its coefficients are the normal.
    slope_u = n.focal_px * _gentlest(left, here, right)
    slope_v = n.focal_px * _gentlest(up, here, down)
    x, y = (u - n.cx) * n.pixel_rad, (v - n.cy) * n.pixel_rad
    normal_z = here - slope_u * x - slope_v * y
    return here / math.sqrt(
        (slope_u * slope_u + slope_v * slope_v + normal_z * normal_z) * (x * x + y * y + 1.0)
    )


@compiled
def _is_edge(around: Around, edge_step_m: float) -> bool:
    left, right, up, down, here = around
    # |1/a - 1/b| of the depths, turned so that nothing is divided.
    limit = edge_step_m * here
    return (
        abs(left - here) > limit * left
        or abs(right - here) > limit * right
        or abs(up - here) > limit * up
        or abs(down - here) > limit * down
    )


@compiled
def _around(inverse_depth: Float32Array, v: int, u: int) -> Around:
    height, width = inverse_depth.shape
    return (
        inverse_depth[v, max(u - 1, 0)],
        inverse_depth[v, min(u + 1, width - 1)],
        inverse_depth[max(v - 1, 0), u],
        inverse_depth[min(v + 1, height - 1), u],
        inverse_depth[v, u],
    )


@compiled
def _wavering(
    inverse_depth: Float32Array, v: int, u: int, fields: NoiseFields, n: Numbers
) -> float:
    """Return 1/z with the outlines displaced by the frame's jitter."""
    height, width = inverse_depth.shape
    here = float(inverse_depth[v, u])
    v2 = min(max(v + fields.jitter_v[v, u], 0), height - 1)
    u2 = min(max(u + fields.jitter_u[v, u], 0), width - 1)
    there = float(inverse_depth[v2, u2])
    if abs(there - here) <= n.edge_step_m * here * there:
        return here
    fraction = float(fields.luck[v, u]) * 64.0 % 1.0
    if fraction < n.flying_share:
        return here + (there - here) * fraction / n.flying_share
    return there


@compiled
def _failure(inverse_depth: Float32Array, v: int, u: int, reflectance: float, n: Numbers) -> float:
    """Return the probability that the device finds no depth here."""
    around = _around(inverse_depth, v, u)
    cosine = _cosine(around, v, u, n)
    echo = reflectance * cosine * around[4] * around[4]
    grazing = (n.grazing_begin_cos - cosine) * n.grazing_slope
    dark = (n.dim_echo - echo) * n.dark_slope
    failure = max(n.random_dropout, grazing, dark)
    if _is_edge(around, n.edge_step_m):
        failure = max(failure, n.edge_dropout)
    return failure


@compiled
def _millimetres(inverse_z: float, disparity_noise: float, bias_c: float, n: Numbers) -> int:
    """Return what the device reports of a true 1/z; 0 where that is out of its range."""
    # The device measures m where truth = a + b m + c m^2; solved for 1/m.
    excess_m = 1.0 / inverse_z - n.bias_a
    root = n.bias_b
    if bias_c != 0.0:
        root = math.sqrt(n.bias_b * n.bias_b + 4.0 * bias_c * excess_m)
    disparity = n.disparity_factor * (n.bias_b + root) / (2.0 * excess_m) + disparity_noise
    raw = math.floor(n.disparity_offset - disparity + 0.5)
    if raw < 0 or raw >= NO_PATTERN or raw >= n.disparity_offset:
        return 0
    depth_m = n.disparity_factor / (n.disparity_offset - raw)
    if depth_m < n.nearest_m or depth_m > n.farthest_m:
        return 0
    return int(depth_m * 1000.0 + 0.5)


@compiled
def measure(
    inverse_depth: Float32Array,
    reflectance: Float32Array,
    lit: BoolArray,
    fields: NoiseFields,
    n: Numbers,
    depth_mm: UInt16Array,
) -> None:
    """Fill (H, W) `depth_mm`, already zero, with what the device reports.

    `inverse_depth` is the true 1/z (0 = nothing there), `reflectance` that of the surface in
    infrared; `lit` is the work of `find_lit`.
    """
    height, width = inverse_depth.shape
    for v in range(height):
        for u in range(width):
            if inverse_depth[v, u] <= 0.0 or not lit[v, u]:
                continue
            if fields.luck[v, u] < _failure(inverse_depth, v, u, reflectance[v, u], n):
                continue
            inverse_z = _wavering(inverse_depth, v, u, fields, n)
            if inverse_z > 0.0:
                depth_mm[v, u] = np.uint16(
                    _millimetres(inverse_z, fields.disparity[v, u], fields.bias_c[v, u], n)
                )
