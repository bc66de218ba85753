"""A group of pixels becomes a marker's centre and size, or is refused with a reason."""

import math
from dataclasses import dataclass, replace

import cv2
import numpy as np

from adibas.arrays import Float32Array, FloatArray, IntArray
from adibas.data.markers import RejectedBlob

Pixels = tuple[IntArray, IntArray]
"""Rows and columns."""

TOO_LARGE = "too large for a marker at that distance"
TOO_SMALL = "too small for a marker at that distance"
TOO_LONG = "too long and thin for a marker"
TOO_WEAK = "too faint against its surroundings"
NOT_ALONE = "part of a larger area of that colour"
SURROUND_PERCENTILE = 20.0
LEAST_TOLD_PX = 6


@dataclass(frozen=True, slots=True)
class BlobParams:
    """What a marker can look like.

    Attributes
    ----------
    least_diameter_m, greatest_diameter_m : float
        Of a marker, from its area: 4 to 60 mm.
    least_area_px : float
        Smaller is noise: 1.5 pixels.
    least_axis_ratio : float
        Short over long axis; a disc at 70 degrees has 0.34, and blur rounds it.
    unknown_distance_m : float
        Taken where no depth is known near the blob.
    least_separation : float
        Contrast of the core against the surround, in standard deviations of the surround: 5.
    least_prominence : float
        By how much the core is nearer to the model than the nearest fifth of its surround, as a
        share of theirs: 0.4. On the border of two garments one side is as near as the core.
    least_filling : float
        Share of the unmixed area that stands out by itself: 0.42. What goes on beyond its core,
        such as wall seen between arm and trunk, has less.
    centre_sd_px : float
        What remains of the centre's error besides noise (shading, foreshortening): 0.08.
    """

    least_diameter_m: float = 0.004
    greatest_diameter_m: float = 0.060
    least_area_px: float = 1.5
    least_axis_ratio: float = 0.38
    unknown_distance_m: float = 2.0
    least_separation: float = 5.0
    least_prominence: float = 0.4
    least_filling: float = 0.42
    centre_sd_px: float = 0.08


@dataclass(frozen=True, slots=True, eq=False)
class Blob:
    """One candidate, pixels of the image (or of the window it was cut from).

    Attributes
    ----------
    u, v : float
        Sub-pixel centre.
    radius_px : float
        Of the disc with its area.
    axis_ratio : float
        Short over long axis.
    separation : float
        Contrast in standard deviations of the surround.
    prominence : float
        1 - core's distance to the model / that of the nearest fifth of the surround.
    filling : float
        Pixels that stand out / unmixed area.
    covariance_px2 : (2, 2) array
        Of (u, v), from noise alone.
    """

    u: float
    v: float
    radius_px: float
    axis_ratio: float
    separation: float
    prominence: float
    filling: float
    covariance_px2: FloatArray


def measure_blob(values: Float32Array, distance: Float32Array, pixels: Pixels) -> Blob:
    """Unmix a group of pixels from its surround.

    Every pixel near it is taken as a mixture of the surround's colour and of the core's; the share
    of the core is its weight in the centre (6.4 with soft membership) and in the area.

    Parameters
    ----------
    values : (H, W, 3) array
        CIELAB.
    distance : (H, W) array
        To the model: the core is where it is least.
    pixels : tuple
        Rows and columns of the group.
    """
    rows, columns = pixels
    reach = max(3, round(0.8 * math.sqrt(len(rows))))
    part = _around(rows, columns, 2 * reach + 2, distance.shape)
    group = np.zeros(distance.shape, np.uint8)[part]
    group[rows - part[0].start, columns - part[1].start] = 1
    near = cv2.dilate(group, np.ones((5, 5), np.uint8)) > 0
    far = cv2.dilate(near.astype(np.uint8), np.ones((2 * reach + 1, 2 * reach + 1), np.uint8)) > 0
    local = values[part].astype(float)
    ring = far & ~near
    surround = np.median(local[ring], axis=0)
    in_group = group > 0
    best = np.argsort(distance[part][in_group])[: max(1, in_group.sum() // 3)]
    core = local[in_group][best].mean(axis=0)
    axis = core - surround
    contrast = max(float(axis @ axis), 1e-6)
    shares = (local - surround) @ axis / contrast
    noise = 1.4826 * float(np.median(np.abs(shares[ring])))
    weights = np.where(near & (shares > max(0.12, noise)), np.minimum(shares, 1.2), 0.0)
    around = max(float(np.percentile(distance[part][ring], SURROUND_PERCENTILE)), 1e-6)
    prominence = 1.0 - float(distance[part][in_group][best].mean()) / around
    filling = len(rows) / max(float(weights.sum()), 1e-6)
    return _moments(weights, part, noise, (prominence, filling))


def _moments(
    weights: FloatArray, part: tuple[slice, slice], noise: float, shape: tuple[float, float]
) -> Blob:
    v, u = np.mgrid[part].astype(float)
    area = max(float(weights.sum()), 1e-6)
    centre_u, centre_v = (float((weights * axis).sum()) / area for axis in (u, v))
    offsets = np.stack([(u - centre_u).ravel(), (v - centre_v).ravel()])
    spread = (offsets * weights.ravel()) @ offsets.T / area
    # One pixel spreads by 1/12: without it a few pixels in a row look like a line.
    short, long = np.linalg.eigvalsh(spread + np.eye(2) / 12.0)
    support = offsets[:, weights.ravel() > 0]
    covariance = noise**2 * support @ support.T / area**2
    return Blob(
        u=centre_u,
        v=centre_v,
        radius_px=math.sqrt(area / math.pi),
        axis_ratio=math.sqrt(short / long),
        separation=1.0 / max(noise, 1e-3),
        prominence=shape[0],
        filling=shape[1],
        covariance_px2=covariance,
    )


def judge(
    blob: Blob,
    offset_uv: FloatArray,
    depth_m: Float32Array,
    focal_px: float,
    params: BlobParams,
) -> Blob | RejectedBlob:
    """Return the blob in image pixels if it can be a marker at its depth, else why not."""
    u, v = blob.u + float(offset_uv[0]), blob.v + float(offset_uv[1])
    distance_m = depth_near(depth_m, u, v, 2.0 * blob.radius_px + 4.0)
    diameter_m = 2.0 * blob.radius_px * (distance_m or params.unknown_distance_m) / focal_px
    reason = _refusal(blob, diameter_m, params)
    if reason is not None:
        return RejectedBlob(u, v, reason)
    covariance_px2 = blob.covariance_px2 + np.eye(2) * params.centre_sd_px**2
    return replace(blob, u=u, v=v, covariance_px2=covariance_px2)


def _refusal(blob: Blob, diameter_m: float, params: BlobParams) -> str | None:
    if diameter_m > params.greatest_diameter_m:
        return TOO_LARGE
    if diameter_m < params.least_diameter_m or math.pi * blob.radius_px**2 < params.least_area_px:
        return TOO_SMALL
    if blob.prominence < params.least_prominence or blob.filling < params.least_filling:
        return NOT_ALONE
    if blob.axis_ratio < params.least_axis_ratio:
        return TOO_LONG
    return TOO_WEAK if blob.separation < params.least_separation else None


def is_worth_telling(blob: RejectedBlob, n_pixels: int) -> bool:
    """Say whether a user would ask why this is no marker; specks of noise nobody sees."""
    return n_pixels >= LEAST_TOLD_PX and blob.reason != NOT_ALONE


def depth_near(depth_m: Float32Array, u: float, v: float, reach_px: float) -> float | None:
    """Return the median depth within `reach_px` of a pixel, metres; None where there is none."""
    reach = math.ceil(reach_px)
    part = _around(np.array([round(v)]), np.array([round(u)]), reach, depth_m.shape)
    near = depth_m[part]
    return float(np.nanmedian(near)) if np.isfinite(near).any() else None


def _around(
    rows: IntArray, columns: IntArray, reach: int, shape: tuple[int, ...]
) -> tuple[slice, slice]:
    """Return the window `reach` pixels about a group, inside the image."""
    top, left = max(int(rows.min()) - reach, 0), max(int(columns.min()) - reach, 0)
    bottom = min(int(rows.max()) + reach + 1, shape[0])
    return slice(top, bottom), slice(left, min(int(columns.max()) + reach + 1, shape[1]))
