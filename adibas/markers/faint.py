"""Markers that differ little from what is about them.

A sticker whose image is three pixels wide reaches its own colour nowhere: lens, mosaic and surround
are in every pixel. What is left of it is a round spot whose colour lies on the way from the
surround's to the marker's. So it is with a large sticker on cloth not unlike it. No spot of noise,
crease or border does that so clearly.
"""

import math
from dataclasses import dataclass, field

import numpy as np

from adibas.arrays import Float32Array, FloatArray
from adibas.markers.blobs import Blob, BlobParams, Groups, chosen_groups

N_LIGHTS = 9
LIGHTNESS_OFFSET = np.array([16.0, 0.0, 0.0])
"""CIELAB is a cube root of light: in dimmer light (L + 16, a, b) shrink together."""


@dataclass(frozen=True, slots=True)
class FaintParams:
    """What a spot must look like to be a marker though it differs little from its surround.

    In 606 pictures of 202 scenes (seeds 3 and 4, stickers of 8 and 12 mm, 2 to 3.5 m away) 7,231
    markers in view were found by their full colour and 569 were not. Of those 426 pass, and with
    them three spots that are no markers.

    Attributes
    ----------
    blobs : BlobParams
        Its form: rounder than a marker of full colour has to be.
    greatest_nearness : float
        A pixel of it is nearer to the model than this share of its surroundings' mean.
    least_direction : float
        Cosine between the ways from the surround to the spot and to the marker's colour.
    least_share : float
        How far it is on that way; 1 is the marker itself.
    greatest_aside : float
        How far it is beside that way, CIELAB units: a grey wall seen through a hole in red trousers
        is as far from red as green is, in nearly the same direction.
    least_clearness : float
        Prominence times separation: what is less prominent must stand out of the noise more.
    least_unexplained : float
        Share of its contrast that no colour beside it explains.
    light_range : float
        By how much the light may change (L + 16, a, b) of the marker's colour.
    """

    blobs: BlobParams = field(
        default_factory=lambda: BlobParams(
            least_axis_ratio=0.62, least_prominence=0.2, least_separation=3.5
        )
    )
    greatest_nearness: float = 0.72
    least_direction: float = 0.93
    least_share: float = 0.15
    greatest_aside: float = 11.0
    least_clearness: float = 1.6
    least_unexplained: float = 0.7
    light_range: float = 1.5


def clear_groups(
    groups: Groups,
    distance: Float32Array,
    surround: Float32Array,
    surround_px: int,
    params: FaintParams,
) -> Groups:
    """Return the groups of pixels that are worth a closer look.

    Parameters
    ----------
    groups : tuple
        From `connected_groups`.
    distance, surround : (H, W) arrays
        To the model, of every pixel and of its surroundings.
    surround_px : int
        Width of the surroundings; with what is wider a pixel is compared with itself.
    """
    rows, columns, starts = groups
    if len(rows) == 0:
        return groups
    begins = starts[:-1]
    nearness = np.minimum.reduceat(distance[rows, columns] / surround[rows, columns], begins)
    is_clear = (nearness < params.greatest_nearness) & (
        np.diff(starts) >= params.blobs.least_pixels
    )
    for places in (rows, columns):
        extent_px = np.maximum.reduceat(places, begins) - np.minimum.reduceat(places, begins)
        is_clear &= extent_px < surround_px
    return chosen_groups(groups, is_clear)


def in_other_light(centroids_lab: Float32Array, light_range: float) -> FloatArray:
    """Return the (N, 3) CIELAB colours in light dimmer and brighter by up to a factor."""
    lights = np.geomspace(1.0 / light_range, light_range, N_LIGHTS)
    lit_lab = (centroids_lab + LIGHTNESS_OFFSET) * lights[:, None, None] - LIGHTNESS_OFFSET
    colors_lab: FloatArray = lit_lab.reshape(-1, 3)
    return colors_lab


def is_on_the_way(
    blob: Blob, colors_lab: FloatArray, lightness_weight: float, params: FaintParams
) -> bool:
    """Say whether a blob's colour lies between its surround's and one of the marker's.

    Parameters
    ----------
    blob : Blob
        Measured in CIELAB.
    colors_lab : (N, 3) array
        The marker's colours in every light: from `in_other_light`.
    lightness_weight : float
        Of a squared difference in L against one in a and b.
    """
    if blob.prominence * blob.separation < params.least_clearness:
        return False
    if blob.unexplained < params.least_unexplained:
        return False
    weight = np.array([math.sqrt(lightness_weight), 1.0, 1.0])
    to_core = (blob.core - blob.surround) * weight
    to_marker = (colors_lab - blob.surround) * weight
    along = to_marker @ to_core
    lengths, way = np.linalg.norm(to_marker, axis=1), float(np.linalg.norm(to_core))
    directions = along / np.maximum(lengths * way, 1e-9)
    best = int(directions.argmax())
    direction, share = float(directions[best]), float(along[best] / max(lengths[best] ** 2, 1e-9))
    aside = way * math.sqrt(max(1.0 - direction**2, 0.0))
    is_toward = direction >= params.least_direction and aside <= params.greatest_aside
    return is_toward and share >= params.least_share
