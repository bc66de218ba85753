"""Lens distortion: Brown-Conrady with radial, tangential and thin-prism terms, and its inverse.

Coefficients are in OpenCV's order, k1 k2 p1 p2 [k3 [k4 k5 k6 [s1 s2 s3 s4]]], and act on
normalised coordinates (x/z, y/z).

Around the axis the model is one-to-one; it may fold farther out, where the determinant of its
Jacobian reaches 0, or have a pole. Beyond that two directions share a pixel and no lens does so:
there is then no answer, and NaN is given.

Source: thesis, equations 4.1-4.5, with s1, s2 for x and s3, s4 for y as in OpenCV's `calib3d`;
Brown, Decentering distortion of lenses (1966).
"""

import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from adibas.arrays import BoolArray, FloatArray
from adibas.geometry import distortion_kernels as kernels
from adibas.geometry.pinhole import Intrinsics, denormalise, normalise

COEFFICIENT_COUNTS = (0, 4, 5, 8, 12)
N_DIRECTIONS = 720
FARTHEST = 1e6


class FoldWarning(UserWarning):
    """Some pixels lie where the distortion model is not one-to-one; they became NaN."""


def distort(normalised: FloatArray, coefficients: Sequence[float]) -> FloatArray:
    """Apply the lens to normalised coordinates.

    Parameters
    ----------
    normalised : (..., 2) array
        (x/z, y/z) without distortion; NaN stays NaN.
    coefficients : sequence of 0, 4, 5, 8 or 12 floats
        In OpenCV's order.

    Returns
    -------
    distorted : (..., 2) array
        The formula's value everywhere, also beyond the fold: see `is_one_to_one`.

    Raises
    ------
    ValueError
        Another number of coefficients, or one that is not finite.
    """
    k = _twelve(coefficients)
    points = _as_rows(normalised)
    return kernels.distort_points(points, k).reshape(np.shape(normalised))


def undistort(distorted: FloatArray, coefficients: Sequence[float]) -> FloatArray:
    """Undo `distort`.

    Parameters
    ----------
    distorted : (..., 2) array
        Normalised coordinates as the lens bent them; NaN stays NaN.
    coefficients : sequence of 0, 4, 5, 8 or 12 floats
        In OpenCV's order.

    Returns
    -------
    normalised : (..., 2) array
        The point inside the one-to-one region that distorts into it, within 2e-14 (1 + radius) as
        distorted again; NaN where there is none.

    Warns
    -----
    FoldWarning
        Some of `distorted` lie outside what the one-to-one region covers.

    Raises
    ------
    ValueError
        Another number of coefficients, or one that is not finite.
    """
    k = _twelve(coefficients)
    points = _as_rows(distorted)
    if k.any():
        region = _region(tuple(k))
        found = kernels.invert_points(points, k, region.folds, region.guesses, region.farthest)
    else:
        found = points.copy()
    n_lost = int((np.isnan(found[:, 0]) & ~np.isnan(points).any(axis=1)).sum())
    if n_lost > 0:
        warnings.warn(
            f"{n_lost} of {len(points)} points lie where the distortion is not one-to-one",
            FoldWarning,
            stacklevel=2,
        )
    return found.reshape(np.shape(distorted))


def is_one_to_one(normalised: FloatArray, coefficients: Sequence[float]) -> BoolArray:
    """Say of (..., 2) undistorted coordinates whether the lens model holds there.

    True where the Jacobian's determinant stays positive, and no pole is met, from the axis out to
    the point; False beyond, for NaN, and more than 86 degrees off the axis.
    """
    k = _twelve(coefficients)
    points = _as_rows(normalised)
    inside = kernels.are_one_to_one(points, k, _region(tuple(k)).folds)
    return inside.reshape(np.shape(normalised)[:-1])


def project_distorted(
    points_m: FloatArray, intrinsics: Intrinsics, coefficients: Sequence[float]
) -> FloatArray:
    """Map camera-frame points to the pixels of the image as taken.

    Parameters
    ----------
    points_m : (..., 3) array
        Camera-frame points in metres; NaN stays NaN.
    intrinsics : Intrinsics
        Pin-hole part.
    coefficients : sequence of 0, 4, 5, 8 or 12 floats
        In OpenCV's order.

    Returns
    -------
    pixels : (..., 2) array
        (u, v); NaN for points that are not in front of the camera (z <= 0) and for those beyond
        the fold of the model, which would otherwise come back into the image.
    """
    points_m = np.asarray(points_m, float)
    z_m = np.where(points_m[..., 2] > 0, points_m[..., 2], np.nan)
    normalised = points_m[..., :2] / z_m[..., None]
    if any(coefficients):
        is_lost = ~is_one_to_one(normalised, coefficients)
        normalised = distort(normalised, coefficients)
        normalised[is_lost] = np.nan
    return denormalise(normalised, intrinsics)


def undistort_pixels(
    pixels: FloatArray, intrinsics: Intrinsics, coefficients: Sequence[float]
) -> FloatArray:
    """Turn (..., 2) pixels of the image as taken into coordinates (x/z, y/z); see `undistort`."""
    return undistort(normalise(pixels, intrinsics), coefficients)


def pixel_rays(
    size: tuple[int, int], intrinsics: Intrinsics, coefficients: Sequence[float]
) -> FloatArray:
    """Return the viewing ray of every pixel, as a table to keep.

    Parameters
    ----------
    size : (height, width)
        Of the image.
    intrinsics : Intrinsics
        Pin-hole part.
    coefficients : sequence of 0, 4, 5, 8 or 12 floats
        In OpenCV's order.

    Returns
    -------
    rays : (height, width, 2) array
        (x/z, y/z): times the depth they are the point's x and y. NaN, and a `FoldWarning`, where
        the model is not one-to-one.
    """
    height, width = size
    pixels = np.empty((height, width, 2))
    pixels[..., 0] = np.arange(width)
    pixels[..., 1] = np.arange(height)[:, None]
    return undistort_pixels(pixels, intrinsics, coefficients)


@dataclass(frozen=True, slots=True, eq=False)
class _Region:
    """Where a model is one-to-one, and where to start its inversion.

    `folds` are radii by direction (one if the direction does not matter); see `invert_points` for
    the others.
    """

    folds: FloatArray
    guesses: FloatArray
    farthest: float


@lru_cache(maxsize=64)
def _region(k: tuple[float, ...]) -> _Region:
    coefficients = np.array(k)
    is_round = not (coefficients[2:4].any() or coefficients[8:].any())
    folds = kernels.fold_radii(1 if is_round else N_DIRECTIONS, coefficients)
    turns_rad = np.arange(N_DIRECTIONS) * (2.0 * np.pi / N_DIRECTIONS)
    rim = folds[:, None] * np.stack([np.cos(turns_rad), np.sin(turns_rad)], axis=-1)
    rim_radii = np.hypot(*kernels.distort_points(np.ascontiguousarray(rim), coefficients).T)
    # At a pole the rim is anywhere.
    farthest = (
        min(float(np.nan_to_num(rim_radii, nan=np.inf).max()), FARTHEST) * kernels.LIMIT_SLACK
    )

    radial = coefficients.copy()
    radial[[2, 3, 8, 9, 10, 11]] = 0.0
    # A start on the fold itself has no Newton step.
    widest_rad = np.arctan(0.99 * folds.min())
    radii = np.tan(np.linspace(0.0, widest_rad, 4 * kernels.N_GUESSES))
    on_axis = np.stack([radii, np.zeros_like(radii)], axis=-1)
    bent = np.maximum.accumulate(kernels.distort_points(on_axis, radial)[:, 0])
    shares = (np.arange(kernels.N_GUESSES) + 0.5) / kernels.N_GUESSES
    return _Region(folds, np.interp(shares / (1.0 - shares), bent, radii), farthest)


def _twelve(coefficients: Sequence[float]) -> FloatArray:
    """Return the coefficients with zeros for those that are left out."""
    if len(coefficients) not in COEFFICIENT_COUNTS:
        raise ValueError(
            f"distortion must have one of {COEFFICIENT_COUNTS} values, got {len(coefficients)}"
        )
    k = np.zeros(12)
    k[: len(coefficients)] = coefficients
    if not np.isfinite(k).all():
        raise ValueError("distortion must be finite")
    return k


def _as_rows(points: FloatArray) -> FloatArray:
    return np.ascontiguousarray(np.asarray(points, float).reshape(-1, 2))
