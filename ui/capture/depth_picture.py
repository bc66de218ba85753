"""Depth as a picture: near is bright, what was not measured is black. Knows nothing of Qt."""

import cv2
import numpy as np

from adibas.arrays import Float32Array, UInt8Array

NEAREST_M, FARTHEST_M = 0.5, 4.5
BLEND = 0.55
"""Share of the colour picture where the two are blended."""


def _palette() -> UInt8Array:
    """Return (256, 1, 3) RGB: viridis from far to near, and black for level 0."""
    levels = np.arange(256, dtype=np.uint8)[:, None]
    colors = cv2.applyColorMap(levels, cv2.COLORMAP_VIRIDIS)
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
    """Return (H, W) levels, 1 (far) to 255 (near), of an (H, W) depth image; NaN saturates to 0.

    One pass of OpenCV over the picture, because it is drawn thirty times a second.
    """
    slope = -254.0 / (FARTHEST_M - NEAREST_M)
    near_m = np.minimum(depth_m, np.float32(FARTHEST_M))  # what is farther has the farthest's
    offset = 1.0 - slope * FARTHEST_M
    levels: UInt8Array = cv2.addWeighted(
        near_m, slope, near_m, 0.0, offset, dtype=cv2.CV_8U
    ).astype(np.uint8, copy=False)
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
