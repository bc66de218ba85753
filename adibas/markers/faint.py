"""Markers that differ little from what is about them.

A sticker whose image is three pixels wide reaches its own colour nowhere: lens, mosaic and surround
are in every pixel. What is left of it is a round spot whose colour lies on the way from the
surround's to the marker's. So it is with a large sticker on cloth not unlike it. How round and
clear such a spot is, and how exactly it lies on that way, are the odds that it is a marker.
"""

import math
from dataclasses import astuple, dataclass, field
from typing import NamedTuple

import cv2
import numpy as np

from adibas.arrays import BoolArray, Float32Array, FloatArray
from adibas.markers.blobs import BlobParams, Groups, Looks, chosen_groups

N_LIGHTS = 9
LIGHTNESS_OFFSET = np.array([16.0, 0.0, 0.0])
"""CIELAB is a cube root of light: in dimmer light (L + 16, a, b) shrink together."""
LEAST_SPOT_PX = 9


@dataclass(frozen=True, slots=True)
class SpotOdds:
    """Log odds that a spot is a marker: a weight for each of its features, and a constant.

    Learned by logistic regression from 50,763 spots in 408 simulated scenes, of which 2,381 were
    markers (`python -m benchmarks.train_spots`).

    Attributes
    ----------
    unexplained : float
        Of the share of its contrast that no colour beside it explains.
    aside : float
        Of how far its colour is beside the way to the marker's, CIELAB units: a grey wall seen
        through a hole in red trousers is as far from red as green is, in nearly that direction.
    axis_ratio : float
        Of its short over its long axis, at least 0: a disc is likeliest.
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

    unexplained: float = 8.883
    aside: float = -0.358
    axis_ratio: float = 7.62
    log_separation: float = 0.253
    log_contrast: float = 2.759
    middle: float = 4.033
    against: float = -4.484
    constant: float = -18.049

    def __post_init__(self) -> None:
        if self.axis_ratio < 0.0:
            raise ValueError("a disc is the likeliest form: axis_ratio must be 0 or more")


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


def likely_groups(
    groups: Groups,
    looks: Looks,
    colors_lab: FloatArray,
    lightness_weight: float,
    params: FaintParams,
) -> tuple[Groups, FloatArray]:
    """Return the groups that are as likely a marker as is asked for if they are discs.

    Parameters
    ----------
    groups : tuple
        From `connected_groups`.
    looks : Looks
        Of the groups.
    colors_lab : (N, 3) array
        The marker's colours in every light: from `in_other_light`.
    lightness_weight : float
        Of a squared difference in L against one in a and b.

    Returns
    -------
    tuple
        The groups, and the log odds of each as a disc; see `log_odds_in_form`.
    """
    way = ways_to_marker(looks, colors_lab, lightness_weight)
    features = spot_features(looks, way, np.ones(len(way.contrast)))
    log_odds = features @ np.array(astuple(params.odds)[:-1]) + params.odds.constant
    is_likely = (
        (way.direction >= params.least_direction)
        & (way.aside <= params.greatest_aside)
        & (way.share >= params.least_share)
        & (log_odds >= params.least_log_odds)
    )
    return chosen_groups(groups, is_likely), log_odds[is_likely]


def log_odds_in_form(log_odds: float, axis_ratio: float, odds: SpotOdds) -> float:
    """Return the log odds of a spot that is no disc: from those as a disc, and its axis ratio."""
    return log_odds - odds.axis_ratio * (1.0 - axis_ratio)


class Ways(NamedTuple):
    """Of N spots: the way from the surround's colour to the core's, and that to the marker's.

    Attributes
    ----------
    direction : (N,) array
        Cosine between both ways.
    share : (N,) array
        How far the core is on the way to the marker; 1 is the marker itself.
    contrast, aside : (N,) arrays
        Length of the way to the core, and how far it ends beside the other; CIELAB units.
    """

    direction: FloatArray
    share: FloatArray
    contrast: FloatArray
    aside: FloatArray


def ways_to_marker(looks: Looks, colors_lab: FloatArray, lightness_weight: float) -> Ways:
    """Compare the way from surround to core with that to the marker's colour nearest in direction.

    Parameters
    ----------
    looks, colors_lab, lightness_weight
        See `likely_groups`.
    """
    weight = np.array([math.sqrt(lightness_weight), 1.0, 1.0])
    to_core = (looks.core - looks.surround) * weight
    to_marker = (colors_lab - looks.surround[:, None]) * weight
    along = (to_marker * to_core[:, None]).sum(axis=2)
    lengths, contrasts = np.linalg.norm(to_marker, axis=2), np.linalg.norm(to_core, axis=1)
    directions = along / np.maximum(lengths * contrasts[:, None], 1e-9)
    best = (np.arange(len(directions)), directions.argmax(axis=1))
    direction, share = directions[best], along[best] / np.maximum(lengths[best] ** 2, 1e-9)
    asides = contrasts * np.sqrt(np.maximum(1.0 - direction**2, 0.0))
    return Ways(direction, share, contrasts, asides)


def spot_features(looks: Looks, way: Ways, axis_ratios: FloatArray) -> FloatArray:
    """Return the (N, 7) features that the odds go by, in the order of `SpotOdds`.

    Parameters
    ----------
    looks : Looks
    way : Ways
        From `ways_to_marker`.
    axis_ratios : (N,) array
        Short over long axis.
    """
    return np.column_stack(
        [
            looks.unexplained,
            way.aside,
            axis_ratios,
            np.log(looks.separation),
            np.log(np.maximum(way.contrast, 1e-9)),
            looks.middle,
            np.sqrt(looks.against),
        ]
    )
