"""Markers that differ little from what is about them.

A sticker whose image is three pixels wide reaches its own colour nowhere: lens, mosaic and surround
are in every pixel. What is left of it is a round spot whose colour lies on the way from the
surround's to the marker's. So it is with a large sticker on cloth not unlike it. How round and
clear such a spot is, and how exactly it lies on that way, are the odds that it is a marker.
"""

import math
from dataclasses import dataclass, field
from typing import NamedTuple

import cv2
import numpy as np

from adibas.arrays import BoolArray, Float32Array, FloatArray, UInt8Array
from adibas.markers.blobs import BlobParams, Groups, Looks, chosen_groups
from adibas.markers.faint_kernels import grow_spots
from adibas.markers.spot_odds import SpotOdds, crowd_size

N_LIGHTS = 9
LIGHTNESS_OFFSET = np.array([16.0, 0.0, 0.0])
"""CIELAB is a cube root of light: in dimmer light (L + 16, a, b) shrink together."""
LEAST_SHARE = 0.01
MOST_LOG_SEPARATION = 4.0
"""A surround without any noise makes a spot no clearer than the clearest that was learned from."""
MIDDLE_RANGE = -1.0, 2.5
"""Of `Looks.middle`: beyond is noise, and tells nothing more."""


@dataclass(frozen=True, slots=True)
class FaintParams:
    """What a spot must look like to be a marker though it differs little from its surround.

    Attributes
    ----------
    blur_px : float
        Standard deviation, pixels, by which the picture is blurred before spots are looked for: the
        camera's mosaic gives the middle of a small sticker one false colour and its border another,
        and only their mean is the sticker's.
    spot_px : int
        What is narrower is a spot. Odd.
    least_rise_share, least_rise : float
        By how much the middle of a spot is nearer to the model than what is on all sides of it, as
        a share of that and in CIELAB units: 7 in one picture, where less is noise.
    group_share : float
        Pixels about it that have this share of its rise belong to it.
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
        Below, it is no marker: 0.5 in one picture.
    light_range : float
        By how much the light may change (L + 16, a, b) of the marker's colour.
    """

    blur_px: float = 0.7
    spot_px: int = 11
    least_rise_share: float = 0.1
    least_rise: float = 7.0
    group_share: float = 0.5
    blobs: BlobParams = field(
        default_factory=lambda: BlobParams(
            least_diameter_m=0.003,
            least_area_px=0.8,
            least_axis_ratio=0.2,
            least_separation=0.3,
            least_prominence=0.01,
            least_filling=0.05,
            least_unexplained=0.0,
            least_pixels=1,
        )
    )
    least_direction: float = 0.8
    least_share: float = 0.02
    greatest_aside: float = 12.0
    odds: SpotOdds = field(default_factory=SpotOdds)
    least_log_odds: float = 0.5
    light_range: float = 1.5


def blurred(color_rgb: UInt8Array, params: FaintParams) -> UInt8Array:
    """Return the (H, W, 3) picture in which spots are looked for."""
    return np.asarray(cv2.GaussianBlur(color_rgb, (3, 3), params.blur_px), np.uint8)


def find_spots(distance: Float32Array, free: BoolArray, params: FaintParams) -> Groups:
    """Return the pixels of every spot that is nearer to the model than what is on all sides of it.

    Also where a border or a shadow passes, and the mean of the surroundings says nothing of either
    side: every spot that is narrower than a square is filled (closing), and what that changes is
    where the spots are.

    Parameters
    ----------
    distance : (H, W) array
        Of the blurred picture to the model.
    free : (H, W) bool array
        Where spots may be.

    Notes
    -----
    Source: Meyer, Contrast feature extraction, in Quantitative Analysis of Microstructures in
    Material Sciences, Biology and Medicine, 1978 (top-hat transformation).
    """
    square = np.ones((params.spot_px, params.spot_px), np.uint8)
    closed = np.asarray(cv2.morphologyEx(distance, cv2.MORPH_CLOSE, square), np.float32)
    least_rise = np.maximum(params.least_rise_share * closed, np.float32(params.least_rise))
    reach = params.spot_px // 2
    return grow_spots(closed - distance, least_rise, free, params.group_share, reach)


def in_other_light(centroids_lab: Float32Array, light_range: float) -> FloatArray:
    """Return the (N, 3) CIELAB colours in light dimmer and brighter by up to a factor."""
    lights = np.geomspace(1.0 / light_range, light_range, N_LIGHTS)
    lit_lab = (centroids_lab + LIGHTNESS_OFFSET) * lights[:, None, None] - LIGHTNESS_OFFSET
    colors_lab: FloatArray = lit_lab.reshape(-1, 3)
    return colors_lab


class Likely(NamedTuple):
    """Spots that can be markers.

    Attributes
    ----------
    groups : tuple
        Their pixels, as `connected_groups` has them.
    looks : (N, 7) array
        Features of each but its form, see `look_features`.
    n_crowd : int
        How many spots of the picture look a little like a marker.
    """

    groups: Groups
    looks: FloatArray
    n_crowd: int


def likely_groups(
    groups: Groups,
    looks: Looks,
    colors_lab: FloatArray,
    lightness_weight: float,
    params: FaintParams,
) -> Likely:
    """Choose the groups that are as likely a marker as is asked for if their form is right.

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
    """
    way = ways_to_marker(looks, colors_lab, lightness_weight)
    features, odds = look_features(looks, way), params.odds
    is_on_way = (
        (way.direction >= params.least_direction)
        & (way.aside <= params.greatest_aside)
        & (way.share >= params.least_share)
    )
    in_best_form = odds.alone_in_best_form(features)
    n_crowd = crowd_size(in_best_form[is_on_way])
    is_likely = is_on_way & (odds.among(in_best_form, n_crowd) >= params.least_log_odds)
    return Likely(chosen_groups(groups, is_likely), features[is_likely], n_crowd)


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


def look_features(looks: Looks, way: Ways) -> FloatArray:
    """Return the (N, 7) features of spots but their form, in the order of `FEATURES`.

    Parameters
    ----------
    looks : Looks
    way : Ways
        From `ways_to_marker`.
    """
    return np.column_stack(
        [
            looks.unexplained,
            way.aside,
            np.minimum(np.log(looks.separation), MOST_LOG_SEPARATION),
            np.log(np.maximum(way.contrast, 1e-9)),
            np.clip(looks.middle, *MIDDLE_RANGE),
            np.sqrt(looks.against),
            np.log(np.maximum(way.share, LEAST_SHARE)),
        ]
    )
