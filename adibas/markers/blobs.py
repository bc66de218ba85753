"""A group of pixels becomes a marker's centre and size, or is refused with a reason."""

import math
from dataclasses import dataclass, replace
from typing import NamedTuple, TypeAlias

import cv2
import numpy as np

from adibas.arrays import BoolArray, Float32Array, FloatArray, IntArray
from adibas.data.markers import RejectedBlob
from adibas.markers.blob_kernels import (
    group_pixels,
    join_groups,
    look_at_groups,
    median_depth,
    unmix_groups,
)
from adibas.texts import message

Groups: TypeAlias = tuple[IntArray, IntArray, IntArray]
"""Rows and columns of the pixels, group after group, and where each group begins and ends."""

TOO_LARGE = message("too large for a marker at that distance")
TOO_SMALL = message("too small for a marker at that distance")
TOO_LONG = message("too long and thin for a marker")
TOO_WEAK = message("too faint against its surroundings")
NOT_ALONE = "part of a larger area of that colour"
SURROUND_PERCENTILE = 5.0
LEAST_TOLD_PX = 6
LEAST_NOISE = 1e-3
"""Of the surround, as a share of the contrast."""
BLUR_PX2 = 0.75
"""Variance by which lens, mosaic and pixels blur a spot of the colour picture along an axis."""
SPECK_REACH_PX = 3
"""From speck to speck of one sticker: of 4 pixels, where white cloth mixes into nearly all."""


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
        By how much the core is nearer to the model than the nearest 5 % of its surround, as a
        share of theirs: 0.48. On the border of two garments one side is as near as the core.
    least_filling : float
        Share of the unmixed area that stands out by itself: 0.14. A small sticker on white cloth
        has no more, so much does the white mix into it.
    least_unexplained : float
        Share of a speck's contrast that no colour beside it explains: 0.5.
    least_pixels : int
        That stand out by themselves: 2; one alone is noise.
    """

    least_diameter_m: float = 0.004
    greatest_diameter_m: float = 0.060
    least_area_px: float = 1.5
    least_axis_ratio: float = 0.38
    unknown_distance_m: float = 2.0
    least_separation: float = 5.0
    least_prominence: float = 0.48
    least_filling: float = 0.14
    least_unexplained: float = 0.5
    least_pixels: int = 2


@dataclass(frozen=True, slots=True, eq=False)
class Blob:
    """One candidate, pixels of the image (or of the window it was cut from).

    Attributes
    ----------
    u, v : float
        Sub-pixel centre.
    n_pixels : int
        That stand out by themselves.
    radius_px : float
        Of the disc with its area.
    axis_ratio : float
        Short over long axis.
    separation : float
        Contrast in standard deviations of the surround.
    prominence : float
        1 - core's distance to the model / that of the nearest 5 % of the surround.
    filling : float
        Pixels that stand out / unmixed area.
    covariance_px2 : (2, 2) array
        Of (u, v), from noise alone.
    unexplained, middle, against : float
        See `Looks`.
    surround, core : (C,) arrays
        Colour about it, and of the third of its pixels that is nearest to the model.
    is_faint : bool
        It does not reach the model's colour, and was chosen by odds.
    """

    u: float
    v: float
    n_pixels: int
    radius_px: float
    axis_ratio: float
    separation: float
    prominence: float
    filling: float
    covariance_px2: FloatArray
    unexplained: float
    middle: float
    against: float
    surround: FloatArray
    core: FloatArray
    is_faint: bool = False


def long_radius_px(radius_px: float, axis_ratio: float) -> float:
    """Return half the long axis of a blurred spot: the radius of a disc, however it is turned.

    A disc that is seen slantingly is an ellipse with half axes a > b. Of the spot both the area,
    pi a b, and the ratio of its axes are known, and a disc's variance along an axis is a quarter of
    the half axis squared; the blur is added to both.

    Parameters
    ----------
    radius_px : float
        Of the disc with the spot's area.
    axis_ratio : float
        Short over long axis of the blurred spot.
    """
    squared = axis_ratio**2
    half = 2.0 * BLUR_PX2 * (1.0 - squared)
    return math.sqrt((half + math.sqrt(half**2 + squared * radius_px**4)) / squared)


class Looks(NamedTuple):
    """How each of N groups of pixels looks, whatever its form.

    Attributes
    ----------
    separation : (N,) array
        Contrast in standard deviations of the surround.
    unexplained : (N,) array
        Share of its contrast that is no mixture of its surround with another colour beside it.
    middle : (N,) array
        Share of its contrast that the nine pixels in its middle have on the average.
    against : (N,) array
        How far its ring goes the other way, as a share of its contrast.
    surround, core : (N, C) arrays
        See `Blob`.
    """

    separation: FloatArray
    unexplained: FloatArray
    middle: FloatArray
    against: FloatArray
    surround: FloatArray
    core: FloatArray


def connected_groups(seeds: BoolArray, taken: BoolArray) -> Groups:
    """Return the 8-connected groups of seeds that hold no taken pixel, from top to bottom."""
    n_labels, labels = cv2.connectedComponents(seeds.astype(np.uint8), None, 8, cv2.CV_32S)
    return group_pixels(np.asarray(labels, np.int32), n_labels, taken)


def joined_specks(groups: Groups) -> Groups:
    """Make one group of the specks near to one another.

    Of a sticker of four pixels on white cloth some pixels stand out that do not touch.
    """
    return join_groups(groups, LEAST_TOLD_PX, SPECK_REACH_PX)


def chosen_groups(groups: Groups, is_chosen: BoolArray) -> Groups:
    """Return some of the groups, those of the (N,) that are chosen."""
    rows, columns, starts = groups
    sizes = np.diff(starts)
    pixels = np.repeat(is_chosen, sizes)
    return rows[pixels], columns[pixels], np.append(0, np.cumsum(sizes[is_chosen]))


def pixels_of(groups: Groups, index: int) -> tuple[IntArray, IntArray]:
    """Return the rows and columns of one group."""
    rows, columns, starts = groups
    part = slice(starts[index], starts[index + 1])
    return rows[part], columns[part]


def measure_blobs(
    values: Float32Array, distance: Float32Array, groups: Groups, lightness_weight: float = 1.0
) -> tuple[Blob, ...]:
    """Unmix every group of pixels from its surround.

    Every pixel near a group is taken as a mixture of the surround's colour and of the core's; the
    share of the core is its weight in the centre (6.4 with soft membership) and in the area.

    Parameters
    ----------
    values : (H, W, C) array
        CIELAB, or brightness alone.
    distance : (H, W) array
        To the model: the core is where it is least.
    groups : tuple
        From `connected_groups`.
    lightness_weight : float
        Of a squared difference in the first channel against one in the others, in `Looks`.
    """
    numbers, looks, colors = unmix_groups(*_arrays(values, distance, groups, lightness_weight))
    sizes = np.diff(groups[2]).tolist()
    return tuple(map(_blob, numbers, looks, colors, sizes))


def look_at(
    values: Float32Array, distance: Float32Array, groups: Groups, lightness_weight: float
) -> Looks:
    """Return how every group of pixels looks, in a third of the time; see `measure_blobs`."""
    looks, colors = look_at_groups(*_arrays(values, distance, groups, lightness_weight))
    noise, _, unexplained, middle, against = looks.T
    separation = 1.0 / np.maximum(noise, LEAST_NOISE)
    return Looks(separation, unexplained, middle, against, colors[:, 0], colors[:, 1])


def _arrays(
    values: Float32Array, distance: Float32Array, groups: Groups, lightness_weight: float
) -> tuple[Float32Array, Float32Array, Groups, float, FloatArray]:
    """Return what the loops ask for."""
    weights = np.ones(values.shape[2])
    weights[0] = lightness_weight
    values, distance = np.ascontiguousarray(values), np.ascontiguousarray(distance)
    return values, distance, groups, SURROUND_PERCENTILE, weights


def _blob(numbers: FloatArray, looks: FloatArray, colors: FloatArray, n_pixels: int) -> Blob:
    """Return what the unmixing of one group found."""
    u, v, area, short, long, uu, uv, vv = numbers.tolist()
    noise, prominence, unexplained, middle, against = looks.tolist()
    return Blob(
        u=u,
        v=v,
        n_pixels=n_pixels,
        radius_px=math.sqrt(area / math.pi),
        axis_ratio=math.sqrt(short / long),
        separation=1.0 / max(noise, LEAST_NOISE),
        prominence=prominence,
        filling=n_pixels / area,
        covariance_px2=np.array([[uu, uv], [uv, vv]]),
        unexplained=unexplained,
        middle=middle,
        against=against,
        surround=colors[0],
        core=colors[1],
    )


def judge(
    blob: Blob,
    offset_uv: FloatArray,
    depth_m: Float32Array,
    focal_px: float,
    params: BlobParams,
) -> Blob | RejectedBlob | None:
    """Return the blob in image pixels if it can be a marker at its depth, else why not.

    None if it cannot, and no user would ask why: specks of noise, and parts of larger areas.
    """
    is_speck = blob.n_pixels < LEAST_TOLD_PX
    reason = _refusal_of_form(blob, params)
    if is_speck and reason is not None:
        return None
    u, v = blob.u + float(offset_uv[0]), blob.v + float(offset_uv[1])
    distance_m = depth_near(depth_m, u, v, 2.0 * blob.radius_px + 4.0)
    diameter_m = 2.0 * blob.radius_px * (distance_m or params.unknown_distance_m) / focal_px
    reason = _refusal_of_size(blob, diameter_m, params) or reason
    if reason is not None:
        return None if is_speck or reason == NOT_ALONE else RejectedBlob(u, v, reason)
    return replace(blob, u=u, v=v)


def _refusal_of_size(blob: Blob, diameter_m: float, params: BlobParams) -> str | None:
    if diameter_m > params.greatest_diameter_m:
        return TOO_LARGE
    if diameter_m < params.least_diameter_m or math.pi * blob.radius_px**2 < params.least_area_px:
        return TOO_SMALL
    return None


def _refusal_of_form(blob: Blob, params: BlobParams) -> str | None:
    if blob.n_pixels < params.least_pixels:
        return TOO_WEAK
    if blob.prominence < params.least_prominence or blob.filling < params.least_filling:
        return NOT_ALONE
    if blob.n_pixels < LEAST_TOLD_PX and blob.unexplained < params.least_unexplained:
        return NOT_ALONE
    if blob.axis_ratio < params.least_axis_ratio:
        return TOO_LONG
    return TOO_WEAK if blob.separation < params.least_separation else None


def depth_near(depth_m: Float32Array, u: float, v: float, reach_px: float) -> float | None:
    """Return the median depth within `reach_px` of a pixel, metres; None where there is none."""
    near_m = median_depth(depth_m, round(v), round(u), math.ceil(reach_px))
    return None if math.isnan(near_m) else near_m
