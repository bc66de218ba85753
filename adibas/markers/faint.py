"""Markers that differ little from what is about them.

A sticker whose image is three pixels wide reaches its own colour nowhere: lens, mosaic and surround
are in every pixel. What is left of it is a round spot whose colour lies on the way from the
surround's to the marker's. So it is with a large sticker on cloth not unlike it. How round and
clear such a spot is, and how exactly it lies on that way, are the odds that it is a marker.
"""

import math
from dataclasses import dataclass, field
from typing import TypeAlias

import cv2
import numpy as np

from adibas.arrays import BoolArray, Float32Array, FloatArray
from adibas.markers.blobs import Blob, BlobParams, Groups, chosen_groups
from adibas.markers.faint_kernels import middle_and_about

SpotFeatures: TypeAlias = tuple[float, float, float, float, float, float, float]
N_LIGHTS = 9
LIGHTNESS_OFFSET = np.array([16.0, 0.0, 0.0])
"""CIELAB is a cube root of light: in dimmer light (L + 16, a, b) shrink together."""
LEAST_SPOT_PX = 9


@dataclass(frozen=True, slots=True)
class SpotOdds:
    """Log odds that a spot is a marker: a weight for each of its features, and a constant.

    Learned by logistic regression from 51,323 spots in 408 simulated scenes, of which 2,381 were
    markers (`python -m benchmarks.train_spots`).

    Attributes
    ----------
    unexplained : float
        Of the share of its contrast that no colour beside it explains.
    aside : float
        Of how far its colour is beside the way to the marker's, CIELAB units: a grey wall seen
        through a hole in red trousers is as far from red as green is, in nearly that direction.
    axis_ratio : float
        Of its short over its long axis.
    log_separation : float
        Of the logarithm of its contrast in standard deviations of the surround.
    log_contrast : float
        Of the logarithm of its contrast, CIELAB units.
    middle : float
        Of how much of its contrast the nine pixels in its middle have: noise is no disc.
    against : float
        Of the root of how far its ring goes the other way, as a share of its contrast: dots that
        the camera's mosaic makes of a seam have the opposite colour beside them.
    constant : float
    """

    unexplained: float = 10.389
    aside: float = -0.394
    axis_ratio: float = 8.626
    log_separation: float = 0.291
    log_contrast: float = 3.155
    middle: float = 4.642
    against: float = -4.928
    constant: float = -21.015


@dataclass(frozen=True, slots=True)
class FaintParams:
    """What a spot must look like to be a marker though it differs little from its surround.

    Attributes
    ----------
    spot_px : int
        What is narrower is a spot. Odd, in pixels of a 1280 wide image.
    least_rise_share, least_rise : float
        By how much a pixel is nearer to the model than the closing of the spot, as a share of that
        and in CIELAB units.
    greatest_nearness : float
        A pixel of it is nearer to the model than this share of what it is compared with: noise that
        is not is left out before it is measured.
    threshold_factor : float
        No pixel farther from the model than this times its threshold takes part.
    blobs : BlobParams
        Its form.
    least_direction : float
        Cosine between the ways from the surround to the spot and to the marker's colour.
    least_share : float
        How far it is on that way; 1 is the marker itself.
    greatest_aside : float
        How far it is beside that way, CIELAB units: stickers may be of several colours.
    odds : SpotOdds
    least_log_odds : float
        Below, it is no marker: 1.5 in one picture.
    light_range : float
        By how much the light may change (L + 16, a, b) of the marker's colour.
    """

    spot_px: int = 11
    least_rise_share: float = 0.2
    least_rise: float = 6.0
    greatest_nearness: float = 0.7
    threshold_factor: float = 6.0
    blobs: BlobParams = field(
        default_factory=lambda: BlobParams(
            least_axis_ratio=0.4, least_prominence=0.08, least_separation=1.0
        )
    )
    least_direction: float = 0.88
    least_share: float = 0.1
    greatest_aside: float = 12.0
    odds: SpotOdds = field(default_factory=SpotOdds)
    least_log_odds: float = 1.5
    light_range: float = 1.5


def closed_distance(distance: Float32Array, image_width: int, params: FaintParams) -> Float32Array:
    """Return the (H, W) distance with every spot filled that is narrower than a square.

    Also where a border or a shadow passes, and the mean of the surroundings says nothing of either
    side.

    Parameters
    ----------
    distance : (H, W) array
        To the model.
    image_width : int
        Of the whole image, pixels.

    Notes
    -----
    Source: Meyer, Contrast feature extraction, in Quantitative Analysis of Microstructures in
    Material Sciences, Biology and Medicine, 1978 (top-hat transformation).
    """
    spot_px = max(LEAST_SPOT_PX, round(params.spot_px * image_width / 1280) | 1)
    square = np.ones((spot_px, spot_px), np.uint8)
    return np.asarray(cv2.morphologyEx(distance, cv2.MORPH_CLOSE, square), np.float32)


def spot_seeds(
    distance: Float32Array, closed: Float32Array, threshold: float, params: FaintParams
) -> BoolArray:
    """Return the pixels that are nearer to the model than what is on all sides of them.

    Parameters
    ----------
    distance, closed : (H, W) arrays
        To the model, and with the spots filled.
    threshold : float
        Of the model.
    """
    rise = closed - distance
    seeds: BoolArray = (
        (distance < params.threshold_factor * threshold)
        & (rise > params.least_rise_share * closed)
        & (rise > params.least_rise)
    )
    return seeds


def clear_groups(
    groups: Groups,
    distance: Float32Array,
    reference: Float32Array,
    greatest_px: int,
    params: FaintParams,
) -> Groups:
    """Return the groups of pixels that come near the model and are worth to be measured.

    Those that are too small, or as wide as their surroundings, are not: with what is wider a pixel
    was compared with itself.

    Parameters
    ----------
    groups : tuple
        From `connected_groups`.
    distance, reference : (H, W) arrays
        To the model; of every pixel and of what it is compared with.
    greatest_px : int
        Width of the surroundings.
    """
    rows, columns, starts = groups
    if len(rows) == 0:
        return groups
    begins = starts[:-1]
    nearness = np.minimum.reduceat(distance[rows, columns] / reference[rows, columns], begins)
    is_clear = (np.diff(starts) >= params.blobs.least_pixels) & (
        nearness < params.greatest_nearness
    )
    for places in (rows, columns):
        extent_px = np.maximum.reduceat(places, begins) - np.minimum.reduceat(places, begins)
        is_clear &= extent_px < greatest_px
    return chosen_groups(groups, is_clear)


def in_other_light(centroids_lab: Float32Array, light_range: float) -> FloatArray:
    """Return the (N, 3) CIELAB colours in light dimmer and brighter by up to a factor."""
    lights = np.geomspace(1.0 / light_range, light_range, N_LIGHTS)
    lit_lab = (centroids_lab + LIGHTNESS_OFFSET) * lights[:, None, None] - LIGHTNESS_OFFSET
    colors_lab: FloatArray = lit_lab.reshape(-1, 3)
    return colors_lab


def is_on_the_way(
    blob: Blob,
    lab: Float32Array,
    colors_lab: FloatArray,
    lightness_weight: float,
    params: FaintParams,
) -> bool:
    """Say whether a blob is a marker whose colour is mixed with its surround's.

    Parameters
    ----------
    blob : Blob
    lab : (H, W, 3) array
        Where it was measured, CIELAB.
    colors_lab : (N, 3) array
        The marker's colours in every light: from `in_other_light`.
    lightness_weight : float
        Of a squared difference in L against one in a and b.
    """
    features = spot_features(blob, lab, colors_lab, lightness_weight, params)
    if features is None:
        return False
    odds = params.odds
    weights = (odds.unexplained, odds.aside, odds.axis_ratio, odds.log_separation,
               odds.log_contrast, odds.middle, odds.against)  # fmt: skip
    log_odds = odds.constant + sum(w * one for w, one in zip(weights, features, strict=True))
    return bool(log_odds >= params.least_log_odds)


def spot_features(
    blob: Blob,
    lab: Float32Array,
    colors_lab: FloatArray,
    lightness_weight: float,
    params: FaintParams,
) -> SpotFeatures | None:
    """Return what the odds go by, in the order of `SpotOdds`; None where it leads elsewhere.

    Parameters
    ----------
    blob, lab, colors_lab, lightness_weight
        See `is_on_the_way`.
    """
    weights = np.array([lightness_weight, 1.0, 1.0])
    to_core = (blob.core - blob.surround) * np.sqrt(weights)
    to_marker = (colors_lab - blob.surround) * np.sqrt(weights)
    along = to_marker @ to_core
    lengths, contrast = np.linalg.norm(to_marker, axis=1), float(np.linalg.norm(to_core))
    directions = along / np.maximum(lengths * contrast, 1e-9)
    best = int(directions.argmax())
    direction, share = float(directions[best]), float(along[best] / max(lengths[best] ** 2, 1e-9))
    aside = contrast * math.sqrt(max(1.0 - direction**2, 0.0))
    is_toward = direction >= params.least_direction and aside <= params.greatest_aside
    if not is_toward or share < params.least_share:
        return None
    separation = max(blob.separation, 1e-9)
    centre = round(blob.v), round(blob.u)
    middle, against = middle_and_about(
        lab, centre, blob.n_pixels, blob.surround, blob.core, weights
    )
    return (
        blob.unexplained, aside, blob.axis_ratio, math.log(separation), math.log(contrast),
        middle, math.sqrt(against),
    )  # fmt: skip
