"""Learning a colour step by step: clicks on one picture, each with its region, and the colours."""

from collections.abc import Mapping
from copy import copy
from dataclasses import dataclass, replace

import cv2
import numpy as np

from adibas.arrays import BoolArray, Float32Array, FloatArray, UInt8Array
from adibas.markers.color_model import (
    ColorModel,
    LearningParams,
    grow_region,
    learn_colors,
    surround_of,
)
from adibas.markers.lab import rgb_to_lab

SEED = 0
"""Of k-means: the same clicks give the same colours."""

MOST_PIXELS = 5_000
"""For k-means; of a larger region every n-th pixel is taken, which says the same sooner."""


@dataclass(frozen=True, slots=True, eq=False)
class LearnedRegion:
    """What one click took.

    Attributes
    ----------
    seed_uv : (float, float)
        The clicked pixel.
    sensitivity : float
        With which it grew.
    pixels : (H, W) bool array
        The region.
    mean_rgb : (3,) uint8 array
        Its mean colour, for showing.
    """

    seed_uv: tuple[float, float]
    sensitivity: float
    pixels: BoolArray
    mean_rgb: UInt8Array

    @property
    def n_pixels(self) -> int:
        """How many pixels it has."""
        return int(np.count_nonzero(self.pixels))


class LearningBoard:
    """The regions of one picture; the last one follows the sensitivity.

    Parameters
    ----------
    color_rgb : (H, W, 3) uint8 array
        The picture.
    params : LearningParams
        Sensitivity and number of clusters to begin with.
    """

    def __init__(self, color_rgb: UInt8Array, params: LearningParams) -> None:
        self.color_rgb = color_rgb
        self.params = params
        self.regions: tuple[LearnedRegion, ...] = ()
        self.lab: Float32Array = rgb_to_lab(color_rgb)

    def click(self, u: float, v: float) -> LearnedRegion:
        """Grow one more region from pixel (u, v).

        Raises
        ------
        MarkerError
            The click is outside the picture.
        """
        region = self._grown((u, v), self.params.sensitivity)
        self.regions = (*self.regions, region)
        return region

    def set_sensitivity(self, sensitivity: float) -> None:
        """Grow the last region anew, and those to come, with another sensitivity."""
        self.params = replace(self.params, sensitivity=sensitivity)
        if self.regions:
            *others, last = self.regions
            self.regions = (*others, self._grown(last.seed_uv, sensitivity))

    def set_clusters(self, n_clusters: int) -> None:
        """Learn so many centroids."""
        self.params = replace(self.params, n_clusters=n_clusters)

    def discard(self, index: int) -> None:
        """Take one region away."""
        self.regions = self.regions[:index] + self.regions[index + 1 :]

    def taken(self) -> BoolArray:
        """Return the (H, W) pixels of all regions."""
        taken = np.zeros(self.color_rgb.shape[:2], np.bool_)
        for region in self.regions:
            taken |= region.pixels
        return taken

    def without_regions(self) -> "LearningBoard":
        """Return a board for the same picture on which nothing was clicked."""
        board = copy(self)
        board.params, board.regions = LearningParams(), ()
        return board

    def model(self) -> ColorModel | None:
        """Return the colours of all regions; None without a region."""
        return learned_model(self.lab, self.regions, self.params) if self.regions else None

    def _grown(self, seed_uv: tuple[float, float], sensitivity: float) -> LearnedRegion:
        pixels = grow_region(self.lab, seed_uv, sensitivity)
        mean_rgb = np.round(cv2.mean(self.color_rgb, pixels.view(np.uint8))[:3]).astype(np.uint8)
        return LearnedRegion(seed_uv, sensitivity, pixels, mean_rgb)


def learned_model(
    lab: Float32Array, regions: tuple[LearnedRegion, ...], params: LearningParams
) -> ColorModel:
    """Learn the colours of at least one region of a (H, W, 3) CIELAB picture."""
    taken = np.logical_or.reduce([region.pixels for region in regions])
    indices = np.flatnonzero(taken)
    indices = indices[:: -(-len(indices) // MOST_PIXELS)]
    pixels_lab = lab.reshape(-1, 3)[indices].astype(np.float64)
    model = learn_colors(pixels_lab, np.random.default_rng(SEED), params, _source(regions, taken))
    surrounds = (surround_of(lab, region.pixels) for region in regions)
    known: list[FloatArray] = [surround for surround in surrounds if surround is not None]
    return replace(model, surround_lab=np.array(known) if known else None)


def _source(regions: tuple[LearnedRegion, ...], taken: BoolArray) -> Mapping[str, object]:
    """Return where a model comes from; one number where all regions grew alike."""
    sensitivities = [region.sensitivity for region in regions]
    alike = len(set(sensitivities)) == 1
    return {
        "seeds": [list(region.seed_uv) for region in regions],
        "sensitivity": sensitivities[0] if alike else sensitivities,
        "n_pixels": int(np.count_nonzero(taken)),
    }
