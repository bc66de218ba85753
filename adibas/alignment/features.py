"""Features of a picture with their places in space, and pairs of them between two moments.

Source: thesis, section 5.2.1 (figure 5.3, the features of RGBD-ICP); Lowe (2004) for SIFT and the
ratio test; Lucas & Kanade (1981) and Bouguet (2001) for the re-measured places.
"""

from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np

from adibas.alignment.sights import Sight
from adibas.arrays import (
    BoolArray,
    Float32Array,
    FloatArray,
    IntArray,
    UInt8Array,
    check_shape,
    read_only,
)
from adibas.geometry.rigid import RigidTransform


@dataclass(frozen=True, slots=True)
class FeatureParams:
    """How features are found and paired.

    Attributes
    ----------
    n_features : int
        Strongest that are kept for a search without a guess: 800.
    ratio : float
        A pair's distance in descriptors over that of the second best: 0.85 (Lowe, section 7.1:
        0.8).
    n_corners : int
        Places that are measured anew from a guess: 400.
    corner_quality, corner_distance_px : float
        Of those: weakest over strongest, and how far apart: 0.01 and 10.
    window_px : int
        Of the patch that is followed: 15.
    return_px : float
        Followed back, a patch must come home to within this: 0.3.
    """

    n_features: int = 800
    ratio: float = 0.85
    n_corners: int = 400
    corner_quality: float = 0.01
    corner_distance_px: float = 10.0
    window_px: int = 15
    return_px: float = 0.3


@dataclass(frozen=True, slots=True, eq=False)
class Features:
    """What can be found again.

    Attributes
    ----------
    pixels : (N, 2) array
        Of the colour picture.
    points_m : (N, 3) array
        In the depth camera's axes; all known.
    descriptors : (N, 128) float32 array
        Roots of SIFT's (Arandjelovic & Zisserman 2012).
    """

    pixels: FloatArray
    points_m: FloatArray
    descriptors: Float32Array

    def __post_init__(self) -> None:
        n = len(self.pixels)
        check_shape("pixels", self.pixels, (n, 2))
        check_shape("points_m", self.points_m, (n, 3))
        check_shape("descriptors", self.descriptors, (n, None))
        for array in (self.pixels, self.points_m, self.descriptors):
            read_only(array)


@dataclass(frozen=True, slots=True, eq=False)
class Pairs:
    """Points of a source and where a target sees them.

    Attributes
    ----------
    source_m : (N, 3) array
        In the source's depth camera.
    pixels : (N, 2) array
        Of the target's colour picture.
    sd_px : float
        Of each coordinate of `pixels`.
    """

    source_m: FloatArray
    pixels: FloatArray
    sd_px: float

    def __post_init__(self) -> None:
        check_shape("source_m", self.source_m, (None, 3))
        check_shape("pixels", self.pixels, (len(self.source_m), 2))
        for array in (self.source_m, self.pixels):
            read_only(array)


FOLLOWED_SD_PX = 0.1
"""Of a patch that was followed there and back."""


def find_features(sight: Sight, params: FeatureParams | None = None) -> Features:
    """Find what can be found again from far away, where there is depth."""
    params = params or FeatureParams()
    finder = cv2.SIFT_create(nfeatures=params.n_features)  # type: ignore[attr-defined]
    points, descriptors = finder.detectAndCompute(sight.gray, _with_depth(sight))
    pixels = np.array([point.pt for point in points], float).reshape(-1, 2)
    points_m = sight.points_m(pixels)
    is_known = ~np.isnan(points_m[:, 0])
    if not is_known.any():
        return Features(np.empty((0, 2)), np.empty((0, 3)), np.empty((0, 128), np.float32))
    rooted = np.asarray(descriptors, np.float32)[is_known]
    rooted = np.sqrt(rooted / np.maximum(rooted.sum(axis=1, keepdims=True), 1.0))
    return Features(pixels[is_known], points_m[is_known], rooted)


def pair_features(
    target: Features, source: Features, params: FeatureParams | None = None
) -> tuple[IntArray, IntArray]:
    """Return the indices of features that are each other's best, in the target and the source."""
    params = params or FeatureParams()
    if min(len(target.pixels), len(source.pixels)) < 2:  # noqa: PLR2004  (a second best)
        return np.empty(0, np.intp), np.empty(0, np.intp)
    likeness = source.descriptors @ target.descriptors.T  # of unit vectors
    best = likeness.argmax(axis=1)
    rows = np.arange(len(likeness))
    top = likeness[rows, best]
    second = np.partition(likeness, -2, axis=1)[:, -2]
    nearer = np.sqrt(np.maximum(1.0 - top, 0.0)) < params.ratio * np.sqrt(
        np.maximum(1.0 - second, 1e-12)
    )
    is_mutual = likeness.argmax(axis=0)[best] == rows
    chosen = np.nonzero(nearer & is_mutual)[0]
    return best[chosen], chosen


def follow_corners(
    target: Sight, source: Sight, guess: RigidTransform, params: FeatureParams | None = None
) -> Pairs:
    """Measure anew where the target sees the corners of the source, to a tenth of a pixel.

    Parameters
    ----------
    guess : RigidTransform
        Target from source; within about the window's half.
    """
    params = params or FeatureParams()
    none = Pairs(np.empty((0, 3)), np.empty((0, 2)), FOLLOWED_SD_PX)
    pixels = _corners(source, params)
    points_m = source.points_m(pixels)
    expected = target.pixels_of(guess.apply(points_m))
    height, width = target.gray.shape
    with np.errstate(invalid="ignore"):
        is_inside = ((expected > 0) & (expected < (width - 1, height - 1))).all(axis=1)
    if not is_inside.any():
        return none
    pixels, points_m, expected = pixels[is_inside], points_m[is_inside], expected[is_inside]
    there, found = _follow(source, target, pixels, expected, params)
    back, found_back = _follow(target, source, there, pixels, params)
    is_home = np.linalg.norm(back - pixels, axis=1) < params.return_px
    kept = found & found_back & is_home
    return Pairs(points_m[kept], there[kept], FOLLOWED_SD_PX)


def _corners(sight: Sight, params: FeatureParams) -> FloatArray:
    """Return the (N, 2) pixels of what can be followed; OpenCV gives None where there is none."""
    corners: Any = cv2.goodFeaturesToTrack(
        sight.gray,
        params.n_corners,
        params.corner_quality,
        params.corner_distance_px,
        mask=_with_depth(sight),
    )
    return np.empty((0, 2)) if corners is None else corners.reshape(-1, 2).astype(float)


def _with_depth(sight: Sight) -> UInt8Array:
    """Return where a picture shows a surface that the depth camera measured."""
    return (sight.source >= 0).astype(np.uint8)


def _follow(
    one: Sight, other: Sight, pixels: FloatArray, expected: FloatArray, params: FeatureParams
) -> tuple[FloatArray, BoolArray]:
    """Return where patches of one picture are in the other, and whether they are."""
    moved, status, _ = cv2.calcOpticalFlowPyrLK(
        one.gray,
        other.gray,
        pixels.astype(np.float32)[:, None],
        expected.astype(np.float32)[:, None].copy(),
        winSize=(params.window_px, params.window_px),
        maxLevel=1,
        criteria=(cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_COUNT, 20, 0.01),
        flags=cv2.OPTFLOW_USE_INITIAL_FLOW,
    )
    return moved.reshape(-1, 2).astype(float), status.ravel() == 1
