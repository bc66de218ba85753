"""Markers in one colour image.

The thesis compares every pixel inside the body with the learned centroids. Here that distance is
also compared with its surroundings, since shadow and changed light move marker and skin together;
lightness counts less than colour for the same reason. What is left is unmixed from the surround,
which gives sub-pixel centres of stickers that are only some pixels wide.

Source: thesis, section 6.1.1 (distance to the centroids, morphology, blob centres, 6.4).
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import cv2
import numpy as np

from adibas.arrays import BoolArray, Float32Array, FloatArray, UInt8Array, check_shape
from adibas.data.markers import RejectedBlob
from adibas.markers.blobs import (
    TOO_LARGE,
    TOO_LONG,
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
    blurred,
    find_spots,
    in_other_light,
    likely_groups,
)
from adibas.markers.lab import rgb_to_lab
from adibas.markers.likeness_kernels import unlikeness

MARGIN_PX = 24
"""About the body: what a marker on the outline is compared with."""

LEAST_PIXELS = 10
"""Of a marker that is told by its own colour: fewer may as well be of a border or a seam, and what
they are is left to the odds of faint spots."""

REASONS_OF_FORM = TOO_LARGE, TOO_LONG
"""What is the marker's colour and was refused for these reasons holds no faint marker."""

BESIDE_PX = 3
"""About the pixels of a marker: its rim is no spot of its own."""


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
        Pixels and blobs of markers that reach their own colour, 10 pixels of them.
    faint : FaintParams
        Those that do not; they are looked for last, beside the others.
    """

    lightness_weight: float = 0.15
    light_range: float = 1.15
    surround_px: tuple[int, ...] = (31, 121)
    seeds: SeedParams = field(default_factory=SeedParams)
    blobs: BlobParams = field(default_factory=lambda: BlobParams(least_pixels=LEAST_PIXELS))
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
    search = _begun(color_rgb, body, depth_m, focal_px, model, params)
    if search is None:
        return Detections((), (), 0.0)
    rejected = tuple(search.rejected)  # of faint spots nobody asks why they are none
    spots, odds = search.spots(), params.faint.odds
    log_odds = odds.among(odds.alone(spots.features), spots.n_crowd)
    is_likely = log_odds >= params.faint.least_log_odds
    likely = [
        replace(blob, is_faint=True) if is_one else None
        for blob, is_one in zip(spots.blobs, is_likely, strict=True)
    ]
    search.judge(spots.groups, likely, params.faint.blobs)
    matched = search.matched_share(model.threshold)
    return Detections(tuple(search.found), without_found(rejected, search.found), matched)


def spots_with_features(
    color_rgb: UInt8Array,
    body: BoolArray,
    depth_m: Float32Array,
    focal_px: float,
    model: ColorModel,
    params: DetectionParams,
) -> tuple[tuple[Blob | None, FloatArray], ...]:
    """Return what faint markers are chosen from, each with the (8,) features its odds go by.

    For those who learn the odds; see `find_color_markers`. None: it has not the form of a marker,
    and is only one of the picture's crowd.
    """
    search = _begun(color_rgb, body, depth_m, focal_px, model, params)
    if search is None:
        return ()
    spots = search.spots()
    judged = [search.judged(blob, params.faint.blobs) for blob in spots.blobs]
    found = [blob if isinstance(blob, Blob) else None for blob in judged]
    return tuple(zip(found, spots.features, strict=True))


def _begun(
    color_rgb: UInt8Array,
    body: BoolArray,
    depth_m: Float32Array,
    focal_px: float,
    model: ColorModel,
    params: DetectionParams,
) -> "_Search | None":
    """Return the search with the markers that reach their own colour; None without a body."""
    check_shape("body", body, color_rgb.shape[:2])
    window = bounding_box(body)
    if window is None:
        return None
    offset_uv = np.array([window[1].start, window[0].start], float)
    at = offset_uv, depth_m, focal_px
    centroids_lab = model.pure_centroids_lab().astype(np.float32)
    search = _Search(color_rgb[window], body[window], at, centroids_lab, params)
    widths_px = _odd_widths(params.surround_px, color_rgb.shape[1])
    for surround in [search.surround(width_px) for width_px in widths_px]:
        seeds = _stands_out(search.distance, surround, model.threshold, params.seeds)
        groups = search.groups(seeds)
        search.judge(groups, search.measured(groups), params.blobs)
    return search


class _Spots(NamedTuple):
    """N spots: pixels of each, their blobs, the (N, 8) features, and the size of the crowd."""

    groups: Groups
    blobs: tuple[Blob, ...]
    features: FloatArray
    n_crowd: int


class _Search:
    """One window of a picture, what was found in it so far, and which pixels that has taken."""

    def __init__(
        self,
        color_rgb: UInt8Array,
        inside: BoolArray,
        at: tuple[FloatArray, Float32Array, float],
        centroids_lab: Float32Array,
        params: DetectionParams,
    ) -> None:
        self._color_rgb, self._inside, self._at = color_rgb, inside, at
        self._centroids_lab, self._params = centroids_lab, params
        self._lab, self.distance = self._compared(color_rgb)
        self._taken = np.zeros(inside.shape, np.bool_)
        self._refused = np.zeros(inside.shape, np.bool_)
        self.found: list[Blob] = []
        self.rejected: list[RejectedBlob] = []

    def _compared(self, color_rgb: UInt8Array) -> tuple[Float32Array, Float32Array]:
        """Return CIELAB, and how far that is from the model."""
        lab, params = rgb_to_lab(color_rgb), self._params
        distance = unlikeness(lab, self._centroids_lab, params.lightness_weight, params.light_range)
        return lab, distance

    def matched_share(self, threshold: float) -> float:
        """Return which share of the body's pixels match the model."""
        return float((self.distance[self._inside] < threshold).mean())

    def surround(self, width_px: int) -> Float32Array:
        """Return the mean distance of the body about every pixel."""
        size = (width_px, width_px)
        weight = self._inside.astype(np.float32)
        total = cv2.boxFilter(self.distance * weight, -1, size, normalize=False)
        count = cv2.boxFilter(weight, -1, size, normalize=False)
        return np.asarray(total / np.maximum(count, 1.0), np.float32)

    def groups(self, seeds: BoolArray) -> Groups:
        """Return the groups of seeds on the body that hold no pixel of what was found."""
        return joined_specks(connected_groups(self._inside & seeds, self._taken))

    def measured(self, groups: Groups) -> tuple[Blob, ...]:
        """Return a blob for each of the groups, in pixels of the window."""
        weight = self._params.lightness_weight
        return measure_blobs(self._lab, self.distance, groups, weight)

    def spots(self) -> "_Spots":
        """Return the spots that can be faint markers.

        They are looked for in the blurred picture, and measured in the sharp one.
        """
        weight, faint = self._params.lightness_weight, self._params.faint
        lab, distance = self._compared(blurred(self._color_rgb, faint))
        groups = find_spots(distance, self._free(), faint)
        looks = look_at(lab, distance, groups, weight)
        colors_lab = in_other_light(self._centroids_lab, faint.light_range)
        likely = likely_groups(groups, looks, colors_lab, weight, faint)
        blobs = self.measured(likely.groups)
        features = np.column_stack([likely.looks, [blob.axis_ratio for blob in blobs]])
        return _Spots(likely.groups, blobs, features, likely.n_crowd)

    def _free(self) -> BoolArray:
        """Return the pixels of the body that are not near to what was found or has no such form."""
        near = np.ones((2 * BESIDE_PX + 1, 2 * BESIDE_PX + 1), np.uint8)
        told = (self._taken | self._refused).astype(np.uint8)
        free: BoolArray = self._inside & (cv2.dilate(told, near) == 0)
        return free

    def judge(self, groups: Groups, blobs: Sequence[Blob | None], params: BlobParams) -> None:
        """Take what can be a marker of the blobs of all groups; None: that group cannot."""
        for index, blob in enumerate(blobs):
            found = None if blob is None else self.judged(blob, params)
            if isinstance(found, Blob):
                self.found.append(found)
                self._taken[pixels_of(groups, index)] = True
            elif found is not None:
                self.rejected.append(found)
                if found.reason in REASONS_OF_FORM:
                    self._refused[pixels_of(groups, index)] = True

    def judged(self, blob: Blob, params: BlobParams) -> Blob | RejectedBlob | None:
        """Return the blob in pixels of the picture if it can be a marker; see `judge`."""
        return judge(blob, *self._at, params)


def _odd_widths(widths_px: tuple[int, ...], image_width: int) -> list[int]:
    """Scale the surroundings to the image; they are odd and at least 15 pixels wide."""
    return [max(15, round(width * image_width / 1280) | 1) for width in widths_px]


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
