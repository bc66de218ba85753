"""Depth that falls to pieces: how much of it is missing, and small gaps filled."""

import cv2
import numpy as np

from adibas.arrays import BoolArray, Float32Array

GAP_SHARE = 0.015
"""Of the picture's width: twice so wide a gap between measured pixels is a hole."""
STEP = 2
"""Of how many rows and columns one is looked at to count holes."""


def hole_share(measured: BoolArray) -> float:
    """Return the share of a (H, W) picture's measured area that is in holes without depth.

    0 where nothing is measured.
    """
    thin = np.ascontiguousarray(measured[::STEP, ::STEP]).view(np.uint8)
    radius_px = max(2, round(GAP_SHARE * thin.shape[1]))
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * radius_px + 1,) * 2)
    closed = cv2.morphologyEx(thin, cv2.MORPH_CLOSE, disc)
    n_closed = int(np.count_nonzero(closed))
    return 1.0 - float(np.count_nonzero(thin)) / n_closed if n_closed else 0.0


def fill_gaps(depth_m: Float32Array) -> Float32Array:
    """Return (H, W) depth whose small gaps have the depth of the nearest measured pixel.

    Nothing is averaged: no pixel gets a depth between a person and the wall behind.
    """
    missing = ~np.isfinite(depth_m)
    if missing.all():
        return depth_m
    way_px, nearest = cv2.distanceTransformWithLabels(
        missing.astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_3, labelType=cv2.DIST_LABEL_PIXEL
    )
    of_label = np.empty(int(nearest.max()) + 1, np.float32)
    of_label[nearest[~missing]] = depth_m[~missing]
    small = missing & (way_px <= GAP_SHARE * depth_m.shape[1])
    filled = depth_m.copy()
    filled[small] = of_label[nearest[small]]
    return filled
