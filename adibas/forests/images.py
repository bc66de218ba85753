"""Depth images as features read them: the body alone, everything else far away."""

from dataclasses import dataclass

import cv2
import numpy as np

from adibas.arrays import AnyArray, BoolArray, Float32Array, IntArray, check_shape

_SMALLEST_WEIGHT = 1e-3


@dataclass(frozen=True, slots=True, eq=False)
class ForestImage:
    """The box of one image that holds the body.

    Attributes
    ----------
    depth_m : (h, w) float32 array
        `far_m` where there is no body or no depth.
    slope_x, slope_y : (h, w) float32 arrays
        Of the smoothed depth, metres a pixel; 0 where it has none. Empty (0, 0) unless wanted.
    top, left : int
        Of the box in the image.
    focal_px : float
    """

    depth_m: Float32Array
    slope_x: Float32Array
    slope_y: Float32Array
    top: int
    left: int
    focal_px: float


def prepare_image(
    depth_m: Float32Array,
    mask: BoolArray,
    focal_px: float,
    far_m: float,
    smoothing_px: float | None = None,
) -> ForestImage:
    """Cut the body out of a depth image.

    Parameters
    ----------
    depth_m : (H, W) float32 array
        Metres; NaN where not measured.
    mask : (H, W) bool array
        The body.
    focal_px : float
        Of the camera, pixels: features look as far on the body with any camera.
    far_m : float
        What is read outside the body.
    smoothing_px : float or None
        Standard deviation for gradients; None leaves these out.
    """
    check_shape("mask", mask, depth_m.shape)
    left, top, width, height = cv2.boundingRect(np.ascontiguousarray(mask).view(np.uint8))
    box = slice(top, top + height), slice(left, left + width)
    is_body = mask[box] & np.isfinite(depth_m[box])
    boxed = np.where(is_body, depth_m[box], np.float32(far_m)).astype(np.float32, copy=False)
    none = np.zeros((0, 0), np.float32)
    if smoothing_px is None:
        return ForestImage(boxed, none, none, top, left, focal_px)
    slope_x, slope_y = _slopes(boxed, is_body, smoothing_px)
    return ForestImage(boxed, slope_x, slope_y, top, left, focal_px)


def _slopes(
    depth_m: Float32Array, is_body: BoolArray, smoothing_px: float
) -> tuple[Float32Array, Float32Array]:
    """Return the gradient of the depth smoothed within the body; 0 at its border and outside."""
    if depth_m.size == 0:
        return depth_m, depth_m
    weight = _smoothed(is_body.astype(np.float32), smoothing_px)
    total = _smoothed(np.where(is_body, depth_m, 0).astype(np.float32), smoothing_px)
    smooth = np.where(is_body, total / np.maximum(weight, _SMALLEST_WEIGHT), np.nan)
    padded = np.pad(smooth, 1, constant_values=np.nan)
    slope_x = (padded[1:-1, 2:] - padded[1:-1, :-2]) / 2
    slope_y = (padded[2:, 1:-1] - padded[:-2, 1:-1]) / 2
    has_both = np.isfinite(slope_x + slope_y) & is_body
    return (
        np.where(has_both, slope_x, 0).astype(np.float32),
        np.where(has_both, slope_y, 0).astype(np.float32),
    )


def _smoothed(image: Float32Array, sigma_px: float) -> AnyArray:
    return cv2.GaussianBlur(image, (0, 0), sigma_px, borderType=cv2.BORDER_CONSTANT)


@dataclass(frozen=True, slots=True, eq=False)
class ImageBatch:
    """Images end to end, for the kernels.

    Attributes
    ----------
    depth_m, slope_x, slope_y : (S,) float32 arrays
        Slopes are a few zeros where they are not wanted.
    places : (B, 4) int64 array
        Where the first pixel of each image is, its height, its width, and how much further the
        next row is: there is a border about each image.
    focal_px : (B,) float32 array
    """

    depth_m: Float32Array
    slope_x: Float32Array
    slope_y: Float32Array
    places: IntArray
    focal_px: Float32Array

    @property
    def n_bytes(self) -> int:
        """Return what the images take."""
        return self.depth_m.nbytes + self.slope_x.nbytes + self.slope_y.nbytes


def join_images(images: list[ForestImage], far_m: float) -> ImageBatch:
    """Lay images end to end, each with a border of what is outside."""
    places = np.zeros((len(images), 4), np.int64)
    begin = 0
    for place, image in zip(places, images, strict=True):
        height, width = image.depth_m.shape
        stride = width + 2
        place[:] = begin + stride + 1, height, width, stride
        begin += (height + 2) * stride
    return ImageBatch(
        _end_to_end([image.depth_m for image in images], far_m),
        _end_to_end([image.slope_x for image in images], 0.0),
        _end_to_end([image.slope_y for image in images], 0.0),
        places,
        np.array([image.focal_px for image in images], np.float32),
    )


def _end_to_end(images: list[Float32Array], border: float) -> Float32Array:
    joined = np.full(sum((h + 2) * (w + 2) for h, w in _sizes(images)), border, np.float32)
    begin = 0
    for image, (height, width) in zip(images, _sizes(images), strict=True):
        end = begin + (height + 2) * (width + 2)
        joined[begin:end].reshape(height + 2, width + 2)[1:-1, 1:-1] = image
        begin = end
    return joined


def _sizes(images: list[Float32Array]) -> list[tuple[int, int]]:
    return [(image.shape[0], image.shape[1]) for image in images]
