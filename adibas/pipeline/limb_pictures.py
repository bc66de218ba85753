"""Limbs in colours over the depth."""

import cv2
import numpy as np

from adibas.arrays import AnyArray, UInt8Array

_HUES = 180
_GOLDEN = 0.618


def limb_colors(n_labels: int) -> UInt8Array:
    """Return (n_labels + 1, 3) RGB colours that differ, at least two; the first is black."""
    hues = (np.arange(n_labels) * _GOLDEN % 1.0 * _HUES).astype(np.uint8)
    bright = np.where(np.arange(n_labels) % 2 == 0, 255, 190).astype(np.uint8)
    hsv = np.stack([hues, np.full(n_labels, 210, np.uint8), bright], axis=1)
    rgb = cv2.cvtColor(hsv[None], cv2.COLOR_HSV2RGB)[0]
    colors: UInt8Array = np.concatenate([np.zeros((1, 3), np.uint8), rgb]).astype(np.uint8)
    return colors


def limb_picture(depth: AnyArray, labels: UInt8Array) -> UInt8Array:
    """Return the (H, W, 3) picture of labels 1 to L over depth in grey.

    Parameters
    ----------
    depth : (H, W) array
        In any unit; 0 or NaN where not measured (black).
    labels : (H, W) uint8 array
        0 where no limb is.
    """
    return tinted(grey_picture(depth), labels, limb_colors(int(labels.max(initial=1))))


def grey_picture(depth: AnyArray) -> UInt8Array:
    """Return the (H, W, 3) picture of depth in any unit: near is bright, not measured black."""
    known = np.isfinite(depth) & (depth > 0)
    grey = np.zeros(depth.shape)
    if known.any():
        near, far = np.percentile(depth[known], (1, 99))
        grey[known] = 255 - 200 * np.clip((depth[known] - near) / max(far - near, 1e-6), 0, 1)
    return np.repeat(grey[..., None], 3, axis=2).astype(np.uint8)


def tinted(ground: UInt8Array, labels: UInt8Array, colors: UInt8Array) -> UInt8Array:
    """Return an (H, W, 3) picture with (L + 1, 3) colours over it where a label is not 0."""
    picture = ground.copy()
    is_limb = labels > 0
    picture[is_limb] = 0.3 * picture[is_limb] + 0.7 * colors[labels[is_limb]]
    return picture
