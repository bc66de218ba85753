"""Depth as a picture: near is bright, what was not measured is black. Knows nothing of Qt."""

import cv2
import numpy as np

from adibas.arrays import Float32Array, UInt8Array

NEAREST_M, FARTHEST_M = 0.5, 4.5
LEVELS_PER_M = 255.0 / FARTHEST_M
BLEND = 0.55
"""Share of the colour picture where the two are blended."""


def _palette() -> UInt8Array:
    """Return (256, 1, 3) RGB: viridis from far to near, and black for level 0."""
    depth_m = np.arange(256) / LEVELS_PER_M
    nearness = np.clip((FARTHEST_M - depth_m) / (FARTHEST_M - NEAREST_M), 0.0, 1.0)
    shades = np.round(255.0 * nearness).astype(np.uint8)[:, None]
    colors = cv2.applyColorMap(shades, cv2.COLORMAP_VIRIDIS)
    palette: UInt8Array = cv2.cvtColor(colors, cv2.COLOR_BGR2RGB).astype(np.uint8)
    palette[0] = 0
    return palette


_PALETTE = _palette()
PACKED_PALETTE = tuple(
    0xFF000000 | red << 16 | green << 8 | blue for red, green, blue in _PALETTE[:, 0].tolist()
)
"""Of `depth_levels`, as Qt packs colours."""


def depth_picture(depth_m: Float32Array) -> UInt8Array:
    """Return an (H, W, 3) RGB picture of an (H, W) depth image; the palette is viridis."""
    levels = depth_levels(depth_m)
    picture: UInt8Array = cv2.applyColorMap(levels, _PALETTE).astype(np.uint8, copy=False)
    return picture


def depth_levels(depth_m: Float32Array) -> UInt8Array:
    """Return (H, W) levels, 1 (at the camera) to 255 (far), of an (H, W) depth image; 0 for NaN.

    One pass of OpenCV over the picture, because it is drawn thirty times a second; what is farther
    than the farthest level saturates. No depth is negative.
    """
    levels: UInt8Array = cv2.convertScaleAbs(depth_m, alpha=LEVELS_PER_M).astype(
        np.uint8, copy=False
    )
    return levels


def blended(color_rgb: UInt8Array, depth_in_color_m: Float32Array) -> UInt8Array:
    """Return the colour picture with its registered depth over it, as it is where none is."""
    over = depth_picture(depth_in_color_m)
    mixed: UInt8Array = cv2.addWeighted(color_rgb, BLEND, over, 1.0 - BLEND, 0.0).astype(
        np.uint8, copy=False
    )
    unknown = np.isnan(depth_in_color_m)
    mixed[unknown] = color_rgb[unknown]
    return mixed
