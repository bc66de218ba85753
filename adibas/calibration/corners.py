"""X-corners of an image: a pyramid, saddles with a chessboard's ring, and their last hundredths.

Source: thesis, section 4.2.2 (Harris' response 4.16-4.17, saddle 4.18-4.19).
"""

import math
from dataclasses import dataclass
from enum import Enum

import numpy as np

from adibas.arrays import Float32Array, FloatArray, UInt8Array, check_shape
from adibas.calibration.corner_fit_kernels import N_UNKNOWNS, fit_all
from adibas.calibration.corner_gradient_kernels import meet_all
from adibas.calibration.corner_response_kernels import (
    as_level,
    grey_of,
    halved,
    peaks,
    saddle_response,
    smoothed,
)
from adibas.calibration.corner_saddle_kernels import examine_all, seek_all
from adibas.calibration.grid_link_kernels import merge_levels

SMALLEST_LEVEL = 24
Pyramid = tuple[Float32Array, ...]


@dataclass(frozen=True, slots=True)
class CornerParams:
    """What counts as an X-corner. Defaults hold for 8-bit images of any size.

    Attributes
    ----------
    ring_px : float
        Radius of the ring around a corner in pixels of a level: two standard deviations of the
        smoothing outside the blurred centre, inside squares of 5 px.
    least_contrast : float
        Bright minus dark in grey levels: a black board in the shadow has 20.
    most_unlike : float
        Of opposite arcs of the ring, as a share of the contrast: uneven light, glare.
    least_harris : float
        Of Harris' R divided by the squared trace; 0.21 at an ideal corner.
    most_peaks : int
        Saddles looked at in each level.
    """

    ring_px: float = 4.0
    least_contrast: float = 8.0
    most_unlike: float = 0.4
    least_harris: float = 0.02
    most_peaks: int = 60_000

    def limits(self) -> FloatArray:
        """Return the numbers that the kernels take."""
        return np.array([self.ring_px, self.least_contrast, self.most_unlike, self.least_harris])


class CornerMethod(Enum):
    """What a corner is where the lens blurs to one side; with a symmetric blur both are one.

    EDGES is where the middles of the blurred edges cross: as a marker's centre, it moves with the
    blur's centroid. GRADIENT is where the steepest lines of the edges meet, as Bouguet's toolbox
    and OpenCV's cornerSubPix place it: for comparison with calibrations made by those.
    """

    EDGES = "edges"
    GRADIENT = "gradient"


@dataclass(frozen=True, slots=True)
class FitParams:
    """The window of the fit, measured on simulated boards of 6 to 60 px a square.

    Attributes
    ----------
    square_share : float
        Of a square on each side of the corner.
    longest_px : float
        From the corner; more costs time and leaves the straight part of an edge.
    band_blurs, band_squares : float
        Pixels farther from both edges than so many standard deviations of the blur, or such a
        share of a square, say nothing of the place.
    model_error_px : float
        Added to the standard deviation in squares: what the model of the edge lacks.
    most_residual : float
        Left over, as a share of half the contrast: a finger's edge crosses the window.
    method : CornerMethod
        The default is three times and more as precise on simulated boards.
    """

    square_share: float = 0.45
    longest_px: float = 11.0
    band_blurs: float = 3.0
    band_squares: float = 0.25
    model_error_px: float = 0.007
    most_residual: float = 0.35
    method: CornerMethod = CornerMethod.EDGES

    def limits(self) -> FloatArray:
        """Return the numbers that the kernels take."""
        return np.array([self.square_share, self.longest_px, self.band_blurs, self.band_squares])


def as_gray(color_rgb: UInt8Array) -> UInt8Array:
    """Return the (H, W) brightness of an (H, W, 3) RGB image, 0-255."""
    check_shape("color_rgb", color_rgb, (None, None, 3))
    return grey_of(np.ascontiguousarray(color_rgb))


def build_pyramid(gray: UInt8Array) -> Pyramid:
    """Return the smoothed image and its halves, finest first; empty for a tiny image."""
    check_shape("gray", gray, (None, None))
    if min(gray.shape) < SMALLEST_LEVEL:
        return ()
    levels = [smoothed(as_level(np.ascontiguousarray(gray)))]
    while min(levels[-1].shape) >= 2 * SMALLEST_LEVEL:
        levels.append(smoothed(halved(levels[-1])))
    return tuple(levels)


def find_corners(pyramid: Pyramid, params: CornerParams) -> FloatArray:
    """Return (N, N_FIELDS) candidates of all levels, each corner once."""
    # A saddle of contrast c has a response of c^2 / 5 at least, and the smoothing takes half.
    least_response = params.least_contrast**2 / 10.0
    found = [
        examine_all(
            level,
            peaks(saddle_response(level), least_response, params.most_peaks),
            params.limits(),
            2.0**n,
        )
        for n, level in enumerate(pyramid)
    ]
    return merge_levels(np.concatenate(found)) if found else np.empty((0, 7))


def seek_corners(
    pyramid: Pyramid, places: FloatArray, scale: float, params: CornerParams
) -> FloatArray:
    """Return (N, N_FIELDS) the corner near each of `places` (N, 3), NaN without one.

    `places` are u, v and the widest ring in pixels; `scale` is that of the level to look at.
    """
    level = min(max(round(math.log2(scale)), 0), len(pyramid) - 1)
    return seek_all(pyramid[level], np.ascontiguousarray(places), params.limits(), 2.0**level)


def fit_corners(
    gray: UInt8Array, starts: FloatArray, shapes: FloatArray, params: FitParams
) -> FloatArray:
    """Return (N, 12) what `fit_all` finds; NaN where the image shows no such corner.

    `starts` (N, 9) and `shapes` (N, 16) are those of `corner_fit_kernels`.
    """
    fitted = fit_all(
        np.ascontiguousarray(gray),
        np.ascontiguousarray(starts),
        np.ascontiguousarray(shapes),
        params.limits(),
    )
    squares_px = np.sqrt(np.abs(shapes[:, 0] * shapes[:, 3] - shapes[:, 1] * shapes[:, 2]))
    moved_px = np.linalg.norm(fitted[:, :2] - starts[:, :2], axis=-1)
    is_good = (
        (fitted[:, N_UNKNOWNS + 1] <= params.most_residual)
        & (moved_px <= 1.0 + 0.2 * squares_px)
        & (fitted[:, N_UNKNOWNS] <= 0.2 * squares_px)
    )
    fitted[~is_good] = np.nan
    fitted[:, N_UNKNOWNS] = np.hypot(fitted[:, N_UNKNOWNS], params.model_error_px)
    return fitted


def meet_corners(
    gray: UInt8Array, starts: FloatArray, shapes: FloatArray, params: FitParams
) -> FloatArray:
    """Return (N, 3) u, v and standard deviation of `CornerMethod.GRADIENT` near (N, 2) `starts`.

    `shapes` (N, 16) are those of `corner_fit_kernels`; NaN where the edges meet nowhere near.
    """
    met = meet_all(
        np.ascontiguousarray(gray),
        np.ascontiguousarray(starts),
        np.ascontiguousarray(shapes),
        params.limits(),
    )
    met[:, 2] = np.hypot(met[:, 2], params.model_error_px)
    return met
