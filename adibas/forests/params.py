"""How a forest is trained."""

from dataclasses import dataclass

DEPTH, GRADIENT = 0, 1
"""Kinds of features: equation 6.16, equation 6.26."""


@dataclass(frozen=True, slots=True)
class ForestParams:
    """The settings of section 6.2.4 of the thesis unless said otherwise.

    Attributes
    ----------
    n_trees : int
    max_depth : int
        Splits between the root and the lowest leaf.
    n_images : int or None
        Drawn for each tree; None takes all.
    n_pixels : int
        Drawn from each image, evenly over the labelled ones (but see `evenness`).
    evenness : float
        0: every labelled pixel is drawn as likely as any other, as in the thesis; 1: every label of
        an image as likely as any other; 0.5 is between. Ours.
    n_candidates : int
        Depth-comparison features tried at a node.
    n_gradient_candidates : int
        Gradient-angle features tried beside them.
    n_thresholds : int
        Of each feature.
    max_offset_m : float
        O_max: how far from its pixel a feature looks, up or down and to the sides, in metres on
        the body. The thesis' 60 has no unit.
    min_offset_m : float
        0: offsets are drawn evenly over a square, as in the thesis. Above 0: in any direction, and
        evenly over the logarithm of their length, from this to O_max. Ours.
    pixel_share : float
        Of the features of a node, how many compare with the pixel itself (v = 0 in 6.16): half of
        them in Shotton et al., CVPR 2011, none in the thesis.
    min_gain : float
        Bits of information; a split that gives less is not made. Ours.
    min_pixels : int
        A node with fewer is a leaf. Ours.
    far_m : float
        What is read where there is no body, metres. Ours: beyond any indoor sensor.
    smoothing_px : float
        Standard deviation of the Gaussian before gradients, pixels. Ours.
    shrinkage : float
        How many pixels the node above counts for in a leaf. 0 is the thesis'; with few images 50
        are right more often (see ``docs/limbs.md``). Ours.
    """

    n_trees: int = 3
    max_depth: int = 20
    n_images: int | None = 130
    n_pixels: int = 1000
    evenness: float = 0.0
    n_candidates: int = 100
    n_gradient_candidates: int = 0
    n_thresholds: int = 20
    max_offset_m: float = 0.5
    min_offset_m: float = 0.0
    pixel_share: float = 0.0
    min_gain: float = 1e-3
    min_pixels: int = 5
    far_m: float = 10.0
    smoothing_px: float = 2.0
    shrinkage: float = 0.0

    def __post_init__(self) -> None:
        counts = (self.n_trees, self.n_pixels, self.n_thresholds, self.min_pixels)
        n_features = self.n_candidates + self.n_gradient_candidates
        n_images = 1 if self.n_images is None else self.n_images
        if min(*counts, n_features, n_images) < 1:
            raise ValueError("trees, images, pixels, candidates and thresholds must be positive")
        if min(self.n_candidates, self.n_gradient_candidates, self.max_depth) < 0:
            raise ValueError("candidates and depth must not be negative")
        if not min(self.max_offset_m, self.far_m, self.smoothing_px) > 0:
            raise ValueError("lengths must be positive")
        if not 0 <= self.min_offset_m < self.max_offset_m or not 0 <= self.pixel_share <= 1:
            raise ValueError("the least offset must be below the largest, a share from 0 to 1")
        if min(self.min_gain, self.shrinkage, self.evenness) < 0:
            raise ValueError("least gain, shrinkage and evenness must not be negative")
