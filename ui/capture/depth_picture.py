"""Depth as a picture: near is bright, what was not measured is black. Knows nothing of Qt."""

import cv2
import numpy as np

from adibas.arrays import Float32Array, UInt8Array

NEAREST_M, FARTHEST_M = 0.5, 4.5
BLEND = 0.55
"""Share of the colour picture where the two are blended."""


def depth_picture(depth_m: Float32Array) -> UInt8Array:
    """Return an (H, W, 3) RGB picture of an (H, W) depth image; the palette is viridis."""
    scaled = (np.nan_to_num(depth_m, nan=FARTHEST_M) - NEAREST_M) * (
        255.0 / (FARTHEST_M - NEAREST_M)
    )
    levels = 255 - np.clip(scaled, 0.0, 255.0).astype(np.uint8)
    colors = cv2.applyColorMap(levels, cv2.COLORMAP_VIRIDIS)
    picture: UInt8Array = cv2.cvtColor(colors, cv2.COLOR_BGR2RGB).astype(np.uint8, copy=False)
    picture[np.isnan(depth_m)] = 0
    return picture


def blended(color_rgb: UInt8Array, depth_in_color_m: Float32Array) -> UInt8Array:
    """Return the colour picture with its registered depth over it, as it is where none is."""
    over = depth_picture(depth_in_color_m)
    mixed: UInt8Array = cv2.addWeighted(color_rgb, BLEND, over, 1.0 - BLEND, 0.0).astype(
        np.uint8, copy=False
    )
    unknown = np.isnan(depth_in_color_m)
    mixed[unknown] = color_rgb[unknown]
    return mixed
