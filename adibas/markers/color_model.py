"""The colour of the markers, learned from clicks.

Source: thesis, section 6.1.1: region growing (6.1), k-means (6.2-6.3), distance to the centroids.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

import cv2
import numpy as np

from adibas.arrays import BoolArray, Float32Array, FloatArray, IntArray, check_shape, read_only
from adibas.errors import MarkerError
from adibas.markers.lab_kernels import grow

MAX_ITERATIONS = 100
PURE_SHARE = 0.6
LIGHTNESS_COUNTS_LESS = np.array([0.4, 1.0, 1.0])
RIM_PX, RING_PX = 2, 6
"""About a region: what still holds some of the marker, and how far its surround goes from there."""


@dataclass(frozen=True, slots=True)
class LearningParams:
    """How a colour is learned.

    Attributes
    ----------
    sensitivity : float
        theta_c of 6.1, CIELAB distance from the clicked pixel. 20 spans a sticker's own shading
        and stays below the 38-80 that separate a 12 mm sticker from skin.
    n_clusters : int
        k of 6.2; a sticker has a lit and a shaded side and a rim.
    n_restarts : int
        Starts of k-means; the tightest result is kept.
    spread_factor, least_threshold, greatest_threshold : float
        The threshold is `spread_factor` times the 95th percentile of the learned pixels' distance
        to their centroid, but inside these limits (CIELAB units): a single flat patch must still
        match in another light, and a wide one must not match skin.
    """

    sensitivity: float = 20.0
    n_clusters: int = 3
    n_restarts: int = 8
    spread_factor: float = 1.5
    least_threshold: float = 12.0
    greatest_threshold: float = 25.0


@dataclass(frozen=True, slots=True, eq=False)
class ColorModel:
    """What the markers look like.

    Attributes
    ----------
    centroids_lab : (k, 3) array
        Float CIELAB, D65; m of equation 6.3.
    threshold : float
        theta_k: a pixel belongs to a marker if its nearest centroid is nearer than this.
    source : Mapping
        Where it comes from: clicks, sensitivity, number of pixels.
    surround_lab : (n, 3) array or None
        Colour of what was about each learned region; None where it is not known.
    """

    centroids_lab: FloatArray
    threshold: float
    source: Mapping[str, object] = field(default_factory=dict)
    surround_lab: FloatArray | None = None

    def __post_init__(self) -> None:
        check_shape("centroids_lab", self.centroids_lab, (None, 3))
        if len(self.centroids_lab) == 0 or not np.isfinite(self.centroids_lab).all():
            raise ValueError("a colour model needs finite centroids")
        if not (self.threshold > 0 and np.isfinite(self.threshold)):
            raise ValueError(f"threshold must be positive, got {self.threshold}")
        read_only(self.centroids_lab)
        if self.surround_lab is not None:
            check_shape("surround_lab", self.surround_lab, (None, 3))
            if not np.isfinite(self.surround_lab).all():
                raise ValueError("a colour model needs finite surrounds")
            read_only(self.surround_lab)

    def pure_centroids_lab(self) -> FloatArray:
        """Return the (m, 3) centroids that are no mixture of the marker with its surround.

        The rim of a sticker is mixed with skin or cloth, and of a sticker of four pixels most is
        rim: a centroid there would match other skin. The pure ones are those at least `PURE_SHARE`
        as far from each surround as the farthest.
        """
        if self.surround_lab is None:
            return self.centroids_lab
        centroids = self.centroids_lab * LIGHTNESS_COUNTS_LESS
        is_pure = np.ones(len(centroids), np.bool_)
        for surround in self.surround_lab * LIGHTNESS_COUNTS_LESS:
            from_surround = centroids - surround
            axis = from_surround[np.linalg.norm(from_surround, axis=1).argmax()]
            is_pure &= from_surround @ axis >= PURE_SHARE * (axis @ axis)
        return self.centroids_lab[is_pure] if is_pure.any() else self.centroids_lab


def grow_region(lab: Float32Array, seed_uv: tuple[float, float], sensitivity: float) -> BoolArray:
    """Return the region of one click (6.1).

    It is the 4-connected component of all pixels closer than `sensitivity` to the *seed's* colour
    that holds the seed; neighbours are not compared with each other, so it cannot leak along a
    gradient.

    Parameters
    ----------
    lab : (H, W, 3) array
        CIELAB.
    seed_uv : tuple
        Clicked pixel (u, v).
    sensitivity : float
        CIELAB distance (CIE76).

    Raises
    ------
    MarkerError
        The click is outside the image.
    """
    check_shape("lab", lab, (None, None, 3))
    column, row = round(seed_uv[0]), round(seed_uv[1])
    height, width, _ = lab.shape
    if not (0 <= row < height and 0 <= column < width):
        raise MarkerError(
            "The pixel {u}, {v} lies outside the picture of {width}x{height}. Click on a marker.",
            u=column,
            v=row,
            width=width,
            height=height,
        )
    return grow(np.ascontiguousarray(lab, np.float32), row, column, float(sensitivity))


def surround_of(lab: Float32Array, region: BoolArray) -> FloatArray | None:
    """Return the (3,) median colour about one grown region; None where it fills the picture."""
    rows, columns = np.nonzero(region)
    reach = RIM_PX + RING_PX
    top, left = max(rows.min() - reach, 0), max(columns.min() - reach, 0)
    part = np.s_[top : rows.max() + reach + 1, left : columns.max() + reach + 1]
    taken = region[part].astype(np.uint8)
    near, far = (
        cv2.dilate(taken, np.ones((2 * size + 1, 2 * size + 1), np.uint8)) > 0
        for size in (RIM_PX, reach)
    )
    ring = far & ~near
    if not ring.any():
        return None
    median: FloatArray = np.median(lab[part][ring].astype(float), axis=0)
    return median


def learn_colors(
    pixels_lab: FloatArray,
    rng: np.random.Generator,
    params: LearningParams,
    source: Mapping[str, object],
) -> ColorModel:
    """Cluster the pixels of all regions into a colour model.

    Parameters
    ----------
    pixels_lab : (N, 3) array
        CIELAB of every pixel in the regions; N >= 1.
    """
    check_shape("pixels_lab", pixels_lab, (None, 3))
    pixels_lab = np.asarray(pixels_lab, float)
    n_clusters = min(params.n_clusters, len(np.unique(pixels_lab, axis=0)))
    results = [_k_means(pixels_lab, n_clusters, rng) for _ in range(params.n_restarts)]
    centroids_lab, distances = min(results, key=lambda result: float((result[1] ** 2).sum()))
    spread = params.spread_factor * float(np.percentile(distances, 95))
    threshold = float(np.clip(spread, params.least_threshold, params.greatest_threshold))
    order = np.lexsort(centroids_lab.T)
    return ColorModel(centroids_lab[order], threshold, source)


def distance_to_centroids(lab: FloatArray, centroids_lab: FloatArray) -> FloatArray:
    """Return the (...) CIE76 distances of (..., 3) colours to their nearest centroid."""
    differences = np.asarray(lab, float)[..., None, :] - centroids_lab
    nearest: FloatArray = np.linalg.norm(differences, axis=-1).min(axis=-1)
    return nearest


def _k_means(
    pixels: FloatArray, n_clusters: int, rng: np.random.Generator
) -> tuple[FloatArray, FloatArray]:
    """Run equations 6.2 and 6.3 until no pixel changes its cluster.

    Returns the (k, 3) means and each pixel's distance to its own.
    """
    means = _spread_out_start(pixels, n_clusters, rng)
    members: IntArray | None = None
    for _ in range(MAX_ITERATIONS):
        distances = np.linalg.norm(pixels[:, None] - means, axis=2)
        nearest = distances.argmin(axis=1)
        if members is not None and np.array_equal(nearest, members):
            break
        members = nearest
        means = np.array(
            [
                pixels[nearest == i].mean(axis=0) if (nearest == i).any() else means[i]
                for i in range(n_clusters)
            ]
        )
    return means, np.linalg.norm(pixels[:, None] - means, axis=2).min(axis=1)


def _spread_out_start(pixels: FloatArray, n_clusters: int, rng: np.random.Generator) -> FloatArray:
    """Choose first means far from one another.

    Source: Arthur & Vassilvitskii, k-means++, SODA 2007.
    """
    means = [pixels[rng.integers(len(pixels))]]
    while len(means) < n_clusters:
        squared = distance_to_centroids(pixels, np.array(means)) ** 2
        means.append(pixels[rng.choice(len(pixels), p=squared / squared.sum())])
    return np.array(means)
