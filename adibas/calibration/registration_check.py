"""Do depth and colour fit together: outlines in the depth against edges in the colour image.

Each outline point of the depth image, where a near surface ends, is projected into the colour
image with its outward normal, and the strength of the colour's gradient is read along that normal.
Sought are one shift of all points, and a growth along the normals (structured light draws near
things larger by part of its window), under which the points lie on the strongest edges. The
standard error comes from leaving out one piece of the image after the other.

Source: Chen & Medioni's matching along normals (1992), with the gradient as the score as in active
contours (Kass, Witkin & Terzopoulos 1988); Efron & Tibshirani, An introduction to the bootstrap
(1993), chapter 11, for the jackknife.
"""

from dataclasses import dataclass, field, replace
from enum import Enum
from typing import TypeAlias

import numpy as np
from scipy import ndimage

from adibas.arrays import Float32Array, FloatArray, UInt8Array, check_shape
from adibas.calibration.registration_check_kernels import rough_scores
from adibas.calibration.registration_check_outline import (
    Outline,
    OutlineParams,
    outline_in_color,
)
from adibas.data.calibration import RgbdCalibration
from adibas.data.sentence import Sentence
from adibas.texts import message


class RegistrationResult(Enum):
    """What came of the check."""

    FITS = "fits"
    SHIFTED = "shifted"
    UNSURE = "unsure"


TEXTS = {
    RegistrationResult.FITS: message(
        "Depth and colour fit: edges differ by {shift_px} pixels (standard error {error_px})."
    ),
    RegistrationResult.SHIFTED: message(
        "Depth and colour do not fit: the depth must move by {right_px} pixels to the right and "
        "{down_px} down (negative: left and up) in the colour picture (standard error "
        "{error_px}). Calibrate the depth camera again, and check that the sensor was not opened "
        "or dropped."
    ),
    RegistrationResult.UNSURE: message(
        "Whether depth and colour fit cannot be told: the picture has too few clear edges, or in "
        "one direction only. Let somebody stand before a plain wall, 1 to 2 m from it."
    ),
}


@dataclass(frozen=True, slots=True)
class RegistrationCheckParams:
    """How the check is made.

    Attributes
    ----------
    outline : OutlineParams
        What an outline is.
    search_px : float
        Depth pixels over which the shift is sought at first: 40, as far as the principal points
        of two calibrations that were mixed up may be from each other.
    fine_px : float
        And then around what was found: 6.
    growth_px : float
        Largest growth, depth pixels: 3.
    search_blur_px, fine_blur_px : float
        Of the colour's gradient, depth pixels: 1.5 and 0.8.
    least_points : int
        Outline points needed: 200.
    least_agreement_px : float
        By how much the shifts of two halves of the outline, sought each for itself over the whole
        range, may differ: 4 depth pixels. Halves that meet by chance do so once in a hundred.
    tolerance_px : float
        Shift that is still good, depth pixels: 1.0, 3.5 mm at 2 m.
    largest_error_px : float
        Standard error beyond which nothing is said, depth pixels: 0.7.
    """

    outline: OutlineParams = field(default_factory=OutlineParams)
    search_px: float = 40.0
    fine_px: float = 6.0
    growth_px: float = 3.0
    search_blur_px: float = 1.5
    fine_blur_px: float = 0.8
    least_points: int = 200
    least_agreement_px: float = 4.0
    tolerance_px: float = 1.0
    largest_error_px: float = 0.7


@dataclass(frozen=True, slots=True, eq=False)
class RegistrationCheck:
    """How depth and colour fit.

    Attributes
    ----------
    shift_px : (2,) array
        From where the depth's outlines are drawn to where the colour shows them, (u, v) colour
        pixels; NaN where unknown.
    standard_error_px : (2,) array
        Of each; NaN where unknown.
    growth_px : float
        By which the outlines must grow to meet the edges; negative: the depth draws things too
        large.
    n_points : int
        Of the outlines.
    result : RegistrationResult
        Against the tolerance.
    sentence : Sentence
        For the reader.
    """

    shift_px: FloatArray
    standard_error_px: FloatArray
    growth_px: float
    n_points: int
    result: RegistrationResult
    sentence: Sentence


N_DIRECTIONS = 36
SAMPLES_PER_PX = 2
N_CLIMBS = 24
STEP_PX = 1.0
"""Of the grid on which the best shift is sought, colour pixels."""

Search: TypeAlias = tuple[float, float, float]
"""Largest shift, largest growth and blur, colour pixels."""


def check_registration(
    gray: UInt8Array,
    depth_m: Float32Array,
    calibration: RgbdCalibration,
    params: RegistrationCheckParams | None = None,
) -> RegistrationCheck:
    """Compare outlines of the depth with edges of the colour image.

    Parameters
    ----------
    gray : (H', W') uint8 array
        Brightness of the colour image.
    depth_m : (H, W) float32 array
        Of the depth camera at the same moment, bias corrected, metres; NaN where not measured.
    calibration : RgbdCalibration
        Of both cameras.

    Raises
    ------
    ValueError
        The calibration lacks a camera, or an image has another size.
    """
    params = params or RegistrationCheckParams()
    color, depth = calibration.color, calibration.depth
    if color is None or depth is None:
        raise ValueError("the check needs both cameras")
    check_shape("gray", gray, (color.height, color.width))
    check_shape("depth_m", depth_m, (depth.height, depth.width))
    scale = color.intrinsics.fx / depth.intrinsics.fx
    outline = outline_in_color(
        depth_m, (color, depth), calibration.color_from_depth, params.outline
    )
    n_points = len(outline.pixels)
    if n_points < params.least_points:
        return _unsure(n_points)
    growth_px = params.growth_px * scale
    coarse = (params.search_px * scale, growth_px, params.search_blur_px * scale)
    bins = _binned(_profiles(gray, outline, coarse), outline)
    near = _best(bins.sum(axis=0), coarse)
    # The fields of a chessboard of blocks.
    is_dark = np.unique(outline.blocks) % 2 == 0
    first, second = (_best(bins[part].sum(axis=0), coarse) for part in (is_dark, ~is_dark))
    if np.hypot(*(first - second)[:2]) > params.least_agreement_px * scale:
        return _unsure(n_points)
    moved = replace(outline, pixels=outline.pixels + near[:2])
    fine = (params.fine_px * scale, growth_px, params.fine_blur_px * scale)
    bins = _binned(_profiles(gray, moved, fine), moved)
    best = _best(bins.sum(axis=0), fine)
    errors_px = _jackknife(bins, best)
    if not (errors_px < params.largest_error_px * scale).all():
        return _unsure(n_points)
    best[:2] += near[:2]
    return _judged(best, errors_px, n_points, params.tolerance_px * scale)


def _unsure(n_points: int) -> RegistrationCheck:
    unknown = np.full(2, np.nan)
    result = RegistrationResult.UNSURE
    return RegistrationCheck(
        unknown, unknown, float("nan"), n_points, result, Sentence(TEXTS[result])
    )


def _judged(
    best: FloatArray, errors_px: FloatArray, n_points: int, tolerance_px: float
) -> RegistrationCheck:
    shift_px = best[:2]
    size_px, error_px = float(np.hypot(*shift_px)), float(np.hypot(*errors_px))
    is_good = size_px <= tolerance_px + error_px
    result = RegistrationResult.FITS if is_good else RegistrationResult.SHIFTED
    fields = {
        "shift_px": size_px,
        "right_px": float(shift_px[0]),
        "down_px": float(shift_px[1]),
        "error_px": error_px,
    }
    return RegistrationCheck(
        shift_px, errors_px, float(best[2]), n_points, result, Sentence(TEXTS[result], fields)
    )


def _profiles(gray: UInt8Array, outline: Outline, search: Search) -> FloatArray:
    """Return (N, K) strengths of the edge along each normal, 0 to 1, without the usual one."""
    shift_px, growth_px, blur_px = search
    image = gray.astype(np.float32)
    right = ndimage.gaussian_filter(image, blur_px, order=(0, 1))
    down = ndimage.gaussian_filter(image, blur_px, order=(1, 0))
    # A shift along a diagonal reaches farthest.
    offsets = _offsets(np.sqrt(2.0) * shift_px + growth_px + STEP_PX)
    along = outline.pixels[:, None, :] + offsets[:, None] * outline.normals[:, None, :]
    places = [along[..., 1], along[..., 0]]
    slope = outline.normals[:, None, 0] * ndimage.map_coordinates(right, places, order=1)
    slope += outline.normals[:, None, 1] * ndimage.map_coordinates(down, places, order=1)
    strength = np.abs(slope)
    # Strong edges of print and furniture must not outvote the rest.
    usual = np.median(strength) + 1.0
    strength /= strength + 4.0 * usual
    return np.asarray(strength - strength.mean(axis=1, keepdims=True), float)


def _offsets(reach_px: float) -> FloatArray:
    n = int(np.ceil(reach_px * SAMPLES_PER_PX))
    return np.arange(-n, n + 1) / SAMPLES_PER_PX


def _binned(profiles: FloatArray, outline: Outline) -> FloatArray:
    """Return the (blocks, directions, K) sums of the profiles."""
    turn = np.arctan2(outline.normals[:, 1], outline.normals[:, 0]) / (2.0 * np.pi)
    direction = np.round(turn * N_DIRECTIONS).astype(int) % N_DIRECTIONS
    blocks, member = np.unique(outline.blocks, return_inverse=True)
    sums = np.zeros((len(blocks), N_DIRECTIONS, profiles.shape[1]))
    np.add.at(sums, (member, direction), profiles)
    return sums


def _normals() -> FloatArray:
    turns = np.arange(N_DIRECTIONS) * (2.0 * np.pi / N_DIRECTIONS)
    return np.stack([np.cos(turns), np.sin(turns)], axis=-1)


def _score(parameters: FloatArray, sums: FloatArray) -> FloatArray:
    """Return the total strength for (..., 3) shifts and growths, smooth between the samples."""
    offsets = parameters[..., :2] @ _normals().T + parameters[..., 2:]
    middle = (sums.shape[1] - 1) / 2
    direction = np.broadcast_to(np.arange(N_DIRECTIONS), offsets.shape)
    places = [direction, middle + offsets * SAMPLES_PER_PX]
    values = ndimage.map_coordinates(sums, places, order=3, mode="constant")
    return np.asarray(values.sum(axis=-1))


def _best(sums: FloatArray, search: Search) -> FloatArray:
    """Return the best (u, v, growth)."""
    shift_px, growth_px, _ = search
    shifts, growths = _grid(shift_px), _grid(growth_px)
    scores = np.empty((len(shifts), len(shifts), len(growths)))
    rough_scores((shifts, growths), _normals(), sums, float(SAMPLES_PER_PX), scores)
    right, down, wide = np.unravel_index(int(scores.argmax()), scores.shape)
    return _climbed(np.array([shifts[right], shifts[down], growths[wide]]), sums)


def _grid(limit_px: float) -> FloatArray:
    n = int(np.ceil(limit_px / STEP_PX))
    return np.linspace(-limit_px, limit_px, 2 * n + 1)


def _climbed(start: FloatArray, sums: FloatArray) -> FloatArray:
    """Return the top of the hill by parabolas along each axis, in ever smaller steps."""
    best, step = start.copy(), STEP_PX
    for _ in range(N_CLIMBS):
        tried = best + step * np.concatenate([np.zeros((1, 3)), np.eye(3), -np.eye(3)])
        scores = _score(tried, sums)
        rise, bend = scores[1:4] - scores[4:], 2.0 * scores[0] - scores[1:4] - scores[4:]
        # Outside a hill there is no parabola: go uphill.
        moves = np.where(bend > 0, 0.5 * rise / np.maximum(bend, 1e-12), np.sign(rise))
        moved = best + step * np.clip(moves, -1.0, 1.0)
        if _score(moved, sums) > scores[0]:
            best = moved
        else:
            best, step = tried[int(scores.argmax())], 0.5 * step
    return np.asarray(best)


def _jackknife(bins: FloatArray, best: FloatArray) -> FloatArray:
    """Return the (2,) standard errors of the shift by leaving out one block at a time."""
    total, n = bins.sum(axis=0), len(bins)
    if n < 3:  # noqa: PLR2004  (no scatter)
        return np.full(2, np.inf)
    left = np.array([_climbed(best, total - block)[:2] for block in bins])
    return np.asarray(np.sqrt((n - 1) / n * ((left - left.mean(axis=0)) ** 2).sum(axis=0)))
