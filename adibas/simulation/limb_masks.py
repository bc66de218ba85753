"""Masks of people as bad as real ones: too small, too large, torn, cut off, without feet."""

import math

import cv2
import numpy as np

from adibas.arrays import AnyArray, BoolArray, UInt8Array

SPARED_SHARE = 0.3
"""Of masks that are left as they are."""
_LARGEST_FRAYED_PX = 2


def damaged_mask(
    rng: np.random.Generator, labels: UInt8Array, depth_mm: AnyArray, clutter: int
) -> UInt8Array:
    """Return the labels of a mask that somebody else's program might have made.

    Parameters
    ----------
    rng : Generator
    labels : (H, W) uint8 array
        Of what is there; 0 is background.
    depth_mm : (H, W) array
        What is added to the mask has the depth that was measured there.
    clutter : int
        Label of what is added.
    """
    if rng.random() < SPARED_SHARE or not labels.any():
        return labels
    damaged = labels.copy()
    if rng.random() < 0.5:  # noqa: PLR2004  (a share, ours, as those below)
        _fray(rng, damaged)
    if rng.random() < 0.2:  # noqa: PLR2004
        _widen(rng, damaged, depth_mm, clutter)
    if rng.random() < 0.3:  # noqa: PLR2004
        _cut_below(rng, damaged)
    if rng.random() < 0.3:  # noqa: PLR2004
        _tear(rng, damaged)
    if rng.random() < 0.08:  # noqa: PLR2004
        _cut_across(rng, damaged)
    return damaged


def _fray(rng: np.random.Generator, labels: UInt8Array) -> None:
    """Take away the border, in some places more than in others."""
    depth_px = int(rng.integers(1, _LARGEST_FRAYED_PX + 1))
    inner = cv2.erode((labels > 0).astype(np.uint8), np.ones((3, 3), np.uint8), iterations=depth_px)
    noise = cv2.GaussianBlur(rng.standard_normal(labels.shape, np.float32), (0, 0), 3.0)
    labels[(inner == 0) & (noise > rng.normal(scale=0.05))] = 0


def _widen(rng: np.random.Generator, labels: UInt8Array, depth_mm: AnyArray, clutter: int) -> None:
    """Add a border of whatever is behind."""
    size = 2 * int(rng.integers(1, 3)) + 1
    wide = cv2.dilate((labels > 0).astype(np.uint8), np.ones((size, size), np.uint8))
    labels[(wide > 0) & (labels == 0) & (depth_mm > 0)] = clutter


def _cut_below(rng: np.random.Generator, labels: UInt8Array) -> None:
    """Take away the lowest rows, as whoever removes the floor does."""
    rows = np.flatnonzero(labels.any(axis=1))
    height_px = (rows[-1] - rows[0] + 1) * rng.uniform(0.01, 0.05)
    labels[rows[-1] + 1 - math.ceil(height_px) :] = 0


def _tear(rng: np.random.Generator, labels: UInt8Array) -> None:
    """Take away some discs."""
    rows, columns = np.nonzero(labels)
    if not len(rows):
        return
    for _ in range(int(rng.integers(1, 5))):
        chosen = int(rng.integers(len(rows)))
        hole = np.zeros(labels.shape, np.uint8)
        center = (int(columns[chosen]), int(rows[chosen]))
        axes = tuple(int(size) for size in rng.integers(1, 9, 2))
        cv2.ellipse(hole, center, axes, float(rng.uniform(0, 180)), 0, 360, 1, -1)
        labels[hole > 0] = 0


def _cut_across(rng: np.random.Generator, labels: UInt8Array) -> None:
    """Take away what lies on one side of a line through the mask."""
    rows, columns = np.nonzero(labels)
    if not len(rows):
        return
    chosen = int(rng.integers(len(rows)))
    angle = rng.uniform(-math.pi, math.pi)
    v, u = np.indices(labels.shape)
    side: BoolArray = (u - columns[chosen]) * math.cos(angle) + (v - rows[chosen]) * math.sin(
        angle
    ) > 0
    # The smaller side goes.
    is_small = np.count_nonzero(labels[side]) < 0.5 * len(rows)
    labels[side if is_small else ~side] = 0
