"""sRGB to CIELAB as floats, white point D65.

Source: CIE 15:2004, section 8.2.1.1; IEC 61966-2-1 (sRGB).
"""

import numpy as np

from adibas.arrays import Float32Array, FloatArray, UInt8Array, check_shape
from adibas.markers.lab_kernels import convert

XYZ_FROM_SRGB = np.array(
    [
        [0.412453, 0.357580, 0.180423],
        [0.212671, 0.715160, 0.072169],
        [0.019334, 0.119193, 0.950227],
    ]
)
WHITE_D65_XYZ = np.array([0.950456, 1.0, 1.088754])
N_STEPS = 16384
"""Of the table of the companding function; interpolated, it is good to 2e-4 in a and b."""


def _linear_from_srgb() -> Float32Array:
    encoded = np.arange(256) / 255.0
    linear = np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)  # noqa: PLR2004  (IEC 61966-2-1)
    return linear.astype(np.float32)


def _companded() -> Float32Array:
    """Return f of the CIE's formula at 0, 1/N_STEPS, ... (a little beyond 1 for rounding)."""
    t = np.arange(N_STEPS + 3) / N_STEPS
    delta = 6.0 / 29.0
    curve = np.where(t > delta**3, np.cbrt(t), t / (3.0 * delta**2) + 4.0 / 29.0)
    return curve.astype(np.float32)


_LINEAR = _linear_from_srgb()
_COMPANDED = _companded()
_MATRIX = (XYZ_FROM_SRGB / WHITE_D65_XYZ[:, None]).astype(np.float32)


def rgb_to_lab(color_rgb: UInt8Array) -> Float32Array:
    """Turn an (H, W, 3) uint8 sRGB image into (H, W, 3) float32 CIELAB (L 0-100, D65)."""
    check_shape("color_rgb", color_rgb, (None, None, 3))
    return convert(np.ascontiguousarray(color_rgb), _LINEAR, _COMPANDED, _MATRIX)


def lab_to_rgb(lab: FloatArray) -> UInt8Array:
    """Return the (..., 3) uint8 sRGB colours nearest to (..., 3) CIELAB colours, for showing."""
    lightness, a, b = np.moveaxis(np.asarray(lab, float), -1, 0)
    fy = (lightness + 16.0) / 116.0
    f = np.stack([fy + a / 500.0, fy, fy - b / 200.0], axis=-1)
    delta = 6.0 / 29.0
    t = np.where(f > delta, f**3, 3.0 * delta**2 * (f - 4.0 / 29.0))
    linear = np.clip((t * WHITE_D65_XYZ) @ np.linalg.inv(XYZ_FROM_SRGB).T, 0.0, 1.0)
    encoded = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)  # noqa: PLR2004  (IEC 61966-2-1)
    colors: UInt8Array = np.round(255.0 * encoded).astype(np.uint8)
    return colors
