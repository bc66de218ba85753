"""Corrections of labelled images: brush, fill and polygon, and steps that can be taken back.

All give a new image of labels; where `allowed` is false nothing changes.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import cv2
import numpy as np

from adibas.arrays import (
    AnyArray,
    BoolArray,
    Float32Array,
    Int32Array,
    UInt8Array,
    check_shape,
    read_only,
)

Path = Sequence[tuple[float, float]]
"""Pixels (u, v), not only whole ones."""

LEAST_CORNERS = 3
_FIXED_POINT_BITS = 4


def painted(
    labels: UInt8Array, allowed: BoolArray, path: Path, radius_px: float, label: int
) -> UInt8Array:
    """Return labels after a stroke of a round brush along `path`.

    Parameters
    ----------
    labels : (H, W) uint8 array
    allowed : (H, W) bool array
    path : sequence of (u, v)
        One place is a dab.
    radius_px : float
        Pixels whose middle is so near to the path are painted; at least the pixel itself.
    label : int
        0 rubs out.
    """
    check_shape("allowed", allowed, labels.shape)
    touched = np.zeros(labels.shape, np.bool_)
    reach = max(radius_px, 0.5)
    places = [np.array(place, float) for place in path]
    for begin, end in pairwise(places[:1] + places):
        _touch(touched, begin, end, reach)
    return _replaced(labels, touched & allowed, label)


def _touch(touched: BoolArray, begin: AnyArray, end: AnyArray, reach: float) -> None:
    """Mark, in place, the pixels within reach of one piece of a path."""
    height, width = touched.shape
    left, top = np.maximum(np.floor(np.minimum(begin, end) - reach), 0).astype(int)
    right, bottom = np.ceil(np.maximum(begin, end) + reach).astype(int) + 1
    rows = slice(top, max(top, min(bottom, height)))
    columns = slice(left, max(left, min(right, width)))
    v, u = np.mgrid[rows, columns]
    along = end - begin
    length_sq = float(along @ along)
    du, dv = u - begin[0], v - begin[1]
    share = np.clip((du * along[0] + dv * along[1]) / length_sq, 0, 1) if length_sq else 0.0
    off_sq = (du - share * along[0]) ** 2 + (dv - share * along[1]) ** 2
    touched[rows, columns] |= off_sq <= reach**2


def filled(
    labels: UInt8Array,
    allowed: BoolArray,
    depth_m: Float32Array,
    at: tuple[float, float],
    label: int,
    *,
    step_m: float = 0.03,
) -> UInt8Array:
    """Return labels after the area about a pixel was filled, up to other labels and depth edges.

    Parameters
    ----------
    labels : (H, W) uint8 array
    allowed : (H, W) bool array
    depth_m : (H, W) float32 array
        NaN where not measured: such pixels are an area of their own.
    at : (u, v)
    label : int
    step_m : float
        From one pixel to the next of four neighbours, depth changes by less within an area:
        0.03, a hand before the trunk is farther from it.
    """
    check_shape("depth_m", depth_m, labels.shape)
    u, v = round(at[0]), round(at[1])
    height, width = labels.shape
    if not (0 <= v < height and 0 <= u < width) or not allowed[v, u]:
        return labels
    is_same = allowed & (labels == labels[v, u])
    is_same &= np.isfinite(depth_m) == np.isfinite(depth_m[v, u])
    values = np.nan_to_num(depth_m, nan=0.0).astype(np.float32)
    barrier = np.ones((height + 2, width + 2), np.uint8)
    barrier[1:-1, 1:-1] = ~is_same
    flags = 4 | cv2.FLOODFILL_MASK_ONLY | (2 << 8)
    cv2.floodFill(values, barrier, (u, v), 0.0, step_m, step_m, flags)
    return _replaced(labels, barrier[1:-1, 1:-1] == 2, label)  # noqa: PLR2004  (what is filled)


def enclosed(labels: UInt8Array, allowed: BoolArray, corners: Path, label: int) -> UInt8Array:
    """Return labels after a polygon, border included, was filled.

    Parameters
    ----------
    labels : (H, W) uint8 array
    allowed : (H, W) bool array
    corners : sequence of (u, v)
        With less than three nothing is enclosed.
    label : int
    """
    if len(corners) < LEAST_CORNERS:
        return labels
    inside = np.zeros(labels.shape, np.uint8)
    fixed = np.round(np.array(corners) * 2**_FIXED_POINT_BITS).astype(np.int32)
    cv2.fillPoly(inside, [fixed], 1, shift=_FIXED_POINT_BITS)
    return _replaced(labels, (inside > 0) & allowed, label)


def _replaced(labels: UInt8Array, chosen: BoolArray, label: int) -> UInt8Array:
    changed = labels.copy()
    changed[chosen] = label
    return changed


@dataclass(frozen=True, slots=True, eq=False)
class LabelChange:
    """What one step changed, and nothing else.

    Attributes
    ----------
    pixels : (N,) int32 array
        In row-major order of the image.
    before, after : (N,) uint8 array
        Labels.
    """

    pixels: Int32Array
    before: UInt8Array
    after: UInt8Array

    def __post_init__(self) -> None:
        for array in (self.pixels, self.before, self.after):
            read_only(array)


@dataclass(frozen=True, slots=True, eq=False)
class LabelHistory:
    """An image of labels and the steps that led to it, each kept as what it changed.

    Attributes
    ----------
    now : (H, W) uint8 array
    back, forth : tuple of LabelChange
        What can be undone, the last step last; what can be done again, the next one last.
    most_steps : int
        Older ones are forgotten.
    """

    now: UInt8Array
    back: tuple[LabelChange, ...] = ()
    forth: tuple[LabelChange, ...] = ()
    most_steps: int = 200

    def __post_init__(self) -> None:
        read_only(self.now)

    def changed(self, labels: UInt8Array) -> "LabelHistory":
        """Return the history with one more step; the same where nothing changed."""
        check_shape("labels", labels, self.now.shape)
        pixels = np.asarray(np.flatnonzero(labels != self.now), np.int32)
        if not len(pixels):
            return self
        change = LabelChange(pixels, self.now.ravel()[pixels], labels.ravel()[pixels])
        back = (*self.back, change)[-self.most_steps :]
        return LabelHistory(labels, back, (), self.most_steps)

    def undone(self) -> "LabelHistory":
        """Return the history one step back; the same where there is none."""
        if not self.back:
            return self
        step = self.back[-1]
        labels = _with(self.now, step.pixels, step.before)
        return LabelHistory(labels, self.back[:-1], (*self.forth, step), self.most_steps)

    def redone(self) -> "LabelHistory":
        """Return the history one step forth; the same where there is none."""
        if not self.forth:
            return self
        step = self.forth[-1]
        labels = _with(self.now, step.pixels, step.after)
        return LabelHistory(labels, (*self.back, step), self.forth[:-1], self.most_steps)


def _with(labels: UInt8Array, pixels: Int32Array, values: UInt8Array) -> UInt8Array:
    changed = labels.copy()
    changed.ravel()[pixels] = values
    return changed
