"""Markers in one colour image.

The thesis compares every pixel inside the body with the learned centroids. Here that distance is
also compared with its surroundings, since shadow and changed light move marker and skin together;
lightness counts less than colour for the same reason. What is left is unmixed from the surround,
which gives sub-pixel centres of stickers that are only some pixels wide.

Source: thesis, section 6.1.1 (distance to the centroids, morphology, blob centres, 6.4).
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import cv2
import numpy as np

from adibas.arrays import BoolArray, Float32Array, FloatArray, UInt8Array, check_shape
from adibas.data.markers import RejectedBlob
from adibas.markers.blobs import (
    Blob,
    BlobParams,
    Groups,
    connected_groups,
    joined_specks,
    judge,
    look_at,
    measure_blobs,
    pixels_of,
)
from adibas.markers.burst import BurstMarker
from adibas.markers.color_model import ColorModel
from adibas.markers.faint import (
    FaintParams,
    clear_groups,
    closed_distance,
    in_other_light,
    likely_groups,
    log_odds_in_form,
    spot_seeds,
)
from adibas.markers.lab import rgb_to_lab
from adibas.markers.likeness_kernels import unlikeness

MARGIN_PX = 24
"""About the body: what a marker on the outline is compared with."""


@dataclass(frozen=True, slots=True)
class SeedParams:
    """Which pixels a blob grows from.

    Attributes
    ----------
    surround_share : float
        A marker's distance to the centroids is below this share of its surroundings'.
    least_contrast : float
        And smaller than theirs by this, CIELAB units.
    threshold_factor : float
        No pixel farther than this times the model's threshold takes part.
    """

    surround_share: float = 0.62
    least_contrast: float = 9.0
    threshold_factor: float = 1.8


@dataclass(frozen=True, slots=True)
class DetectionParams:
    """How markers are found.

    Attributes
    ----------
    lightness_weight : float
        Of a difference in L against one in a and b: 0.15, since light changes L first.
    light_range : float
        By how much (L + 16, a, b) may shrink or grow with the light: 1.15, half the light more.
    surround_px : tuple of int
        Widths of the surroundings, smallest first: for stickers of some pixels, and for large
        ones. Odd, in pixels of a 1280 wide image.
    seeds, blobs : SeedParams, BlobParams
        Pixels and blobs of markers that reach their own colour somewhere.
    faint_seeds, faint : SeedParams, FaintParams
        The same of those that do not; they are looked for last, beside the others: first by what
        is on all sides of them, and then, for those of more pixels, by their surroundings' mean,
        in which noise does not count.
    """

    lightness_weight: float = 0.15
    light_range: float = 1.15
    surround_px: tuple[int, ...] = (31, 121)
    seeds: SeedParams = field(default_factory=SeedParams)
    blobs: BlobParams = field(default_factory=BlobParams)
    faint_seeds: SeedParams = field(
        default_factory=lambda: SeedParams(
            surround_share=0.8, least_contrast=6.0, threshold_factor=4.0
        )
    )
    faint: FaintParams = field(default_factory=FaintParams)


@dataclass(frozen=True, slots=True, eq=False)
class Detections:
    """What was found in one image.

    Attributes
    ----------
    blobs : tuple of Blob
        Markers.
    rejected : tuple of RejectedBlob
        Of the marker's colour, but no marker.
    matched_share : float
        Of the body's pixels that match the model by themselves; near 1 the model fits everything.
    """

    blobs: tuple[Blob, ...]
    rejected: tuple[RejectedBlob, ...]
    matched_share: float


def find_color_markers(
    color_rgb: UInt8Array,
    body: BoolArray,
    depth_m: Float32Array,
    focal_px: float,
    model: ColorModel,
    params: DetectionParams,
) -> Detections:
    """Find the blobs of the learned colour on the body.

    Parameters
    ----------
    color_rgb : (H, W, 3) array
        The image.
    body : (H, W) bool array
        The person in it.
    depth_m : (H, W) array
        Depth registered to it, NaN = unknown: for the size of things.
    focal_px : float
        Of the colour camera.
    """
    check_shape("body", body, color_rgb.shape[:2])
    window = bounding_box(body)
    if window is None:
        return Detections((), (), 0.0)
    lab, inside = rgb_to_lab(color_rgb[window]), body[window]
    centroids_lab = model.pure_centroids_lab().astype(np.float32)
    distance = unlikeness(lab, centroids_lab, params.lightness_weight, params.light_range)
    offset_uv = np.array([window[1].start, window[0].start], float)
    search = _Search(inside, offset_uv, depth_m, focal_px)
    widths_px = _odd_widths(params.surround_px, color_rgb.shape[1])
    surrounds = [_surround(distance, inside, width_px) for width_px in widths_px]
    for surround in surrounds:
        groups = search.groups(_stands_out(distance, surround, model.threshold, params.seeds))
        search.judge(
            groups, measure_blobs(lab, distance, groups, params.lightness_weight), params.blobs
        )
    rejected = tuple(search.rejected)  # of faint spots nobody asks why they are none
    colors_lab = in_other_light(centroids_lab, params.faint.light_range)
    closed = closed_distance(distance, color_rgb.shape[1], params.faint)
    for reference, seeds in (
        (closed, spot_seeds(distance, closed, model.threshold, params.faint)),
        (
            surrounds[0],
            _stands_out(distance, surrounds[0], model.threshold, params.faint_seeds),
        ),
    ):
        groups = search.groups(seeds)
        groups = clear_groups(groups, distance, reference, widths_px[0], params.faint)
        looks = look_at(lab, distance, groups, params.lightness_weight)
        groups, as_discs = likely_groups(
            groups, looks, colors_lab, params.lightness_weight, params.faint
        )
        measured = measure_blobs(lab, distance, groups, params.lightness_weight)
        blobs = tuple(
            blob if _is_likely(log_odds, blob, params.faint) else None
            for log_odds, blob in zip(as_discs.tolist(), measured, strict=True)
        )
        search.judge(groups, blobs, params.faint.blobs)
    matched = float((distance[inside] < model.threshold).mean())
    return Detections(tuple(search.found), without_found(rejected, search.found), matched)


def _is_likely(log_odds: float, blob: Blob, params: FaintParams) -> bool:
    in_form = log_odds_in_form(log_odds, blob.axis_ratio, params.odds)
    return in_form >= params.least_log_odds


class _Search:
    """One window of a picture, what was found in it so far, and which pixels that has taken."""

    def __init__(
        self, inside: BoolArray, offset_uv: FloatArray, depth_m: Float32Array, focal_px: float
    ) -> None:
        self._inside = inside
        self._at = offset_uv, depth_m, focal_px
        self._taken = np.zeros(inside.shape, np.bool_)
        self.found: list[Blob] = []
        self.rejected: list[RejectedBlob] = []

    def groups(self, seeds: BoolArray) -> Groups:
        """Return the groups of seeds on the body that hold no pixel of what was found."""
        return joined_specks(connected_groups(self._inside & seeds, self._taken))

    def judge(self, groups: Groups, blobs: Sequence[Blob | None], params: BlobParams) -> None:
        """Take what can be a marker of the blobs of all groups; None: that group cannot."""
        for index, blob in enumerate(blobs):
            found = None if blob is None else judge(blob, *self._at, params)
            if isinstance(found, Blob):
                self.found.append(found)
                self._taken[pixels_of(groups, index)] = True
            elif found is not None:
                self.rejected.append(found)


def _odd_widths(widths_px: tuple[int, ...], image_width: int) -> list[int]:
    """Scale the surroundings to the image; they are odd and at least 15 pixels wide."""
    return [max(15, round(width * image_width / 1280) | 1) for width in widths_px]


def _surround(distance: Float32Array, inside: BoolArray, width_px: int) -> Float32Array:
    """Return the mean distance of the body about every pixel."""
    size = (width_px, width_px)
    weight = inside.astype(np.float32)
    total = cv2.boxFilter(distance * weight, -1, size, normalize=False)
    count = cv2.boxFilter(weight, -1, size, normalize=False)
    return np.asarray(total / np.maximum(count, 1.0), np.float32)


def _stands_out(
    distance: Float32Array, surround: Float32Array, threshold: float, params: SeedParams
) -> BoolArray:
    """Return the pixels that are nearer to the model than their surroundings."""
    stands_out: BoolArray = (
        (distance < params.threshold_factor * threshold)
        & (distance < params.surround_share * surround)
        & (surround - distance > params.least_contrast)
    )
    return stands_out


def bounding_box(body: BoolArray) -> tuple[slice, slice] | None:
    """Return the rows and columns of the body and a margin; None where there is no body."""
    rows, columns = np.flatnonzero(body.any(axis=1)), np.flatnonzero(body.any(axis=0))
    if len(rows) == 0:
        return None
    top, left = max(int(rows[0]) - MARGIN_PX, 0), max(int(columns[0]) - MARGIN_PX, 0)
    return slice(top, int(rows[-1]) + MARGIN_PX), slice(left, int(columns[-1]) + MARGIN_PX)


def without_found(
    rejected: Sequence[RejectedBlob], found: Sequence[Blob | BurstMarker]
) -> tuple[RejectedBlob, ...]:
    """Leave out what was refused in one surrounding, or one frame, but is a marker in another."""
    return tuple(
        blob
        for blob in rejected
        if all(np.hypot(blob.u - one.u, blob.v - one.v) > 2 * one.radius_px for one in found)
    )
