"""From linear light to the 8-bit picture: lens blur, noise, colour filter and curve."""

import functools

import cv2
import numpy as np

from adibas.arrays import Float32Array, IntArray, UInt8Array
from adibas.simulation.boards_kernels import expose_gray
from adibas.simulation.color_kernels import develop, expose
from adibas.simulation.color_noise import RAW_LEVELS, ColorNoise, srgb_curve

_BANK_SIZE = 1 << 21
_BANK_SEED = 0xB0A2D


def take_color(linear: Float32Array, camera: ColorNoise, rng: np.random.Generator) -> UInt8Array:
    """Return the (H, W, 3) uint8 sRGB picture of (H, W, 3) linear light, 1 = full scale."""
    height, width = linear.shape[:2]
    linear = _blurred(linear, camera)
    if not camera.is_mosaic:
        raw = np.clip(linear * (RAW_LEVELS - 1) + 0.5, 0, RAW_LEVELS - 1).astype(np.uint16)
    else:
        mosaic = np.empty((height, width), np.uint16)
        numbers = np.array(
            [*np.ones(6), camera.full_well, camera.read_noise, camera.corner_loss], float
        )
        expose(linear, numbers, _bank(), _offsets(rng, height, width), mosaic)
        # OpenCV names a mosaic by its second row: its "BG" begins with red.
        raw = np.asarray(cv2.cvtColor(mosaic, cv2.COLOR_BayerBG2RGB), np.uint16)
    picture = np.empty((height, width, 3), np.uint8)
    develop(raw, srgb_curve(), picture)
    return picture


def take_gray(linear: Float32Array, camera: ColorNoise, rng: np.random.Generator) -> UInt8Array:
    """Return the (H, W) uint8 picture of (H, W, 1) linear light, 1 = full scale, sRGB's curve."""
    blurred = _blurred(linear[..., 0], camera)
    height, width = blurred.shape
    signal = np.empty((height, width), np.float32)
    numbers = np.array([camera.full_well, camera.read_noise, camera.corner_loss], float)
    expose_gray(blurred, numbers, _bank(), _offsets(rng, height, width), signal)
    raw = np.clip(signal * (RAW_LEVELS - 1) + 0.5, 0, RAW_LEVELS - 1).astype(np.uint16)
    picture: UInt8Array = srgb_curve()[raw]
    return picture


def _blurred(linear: Float32Array, camera: ColorNoise) -> Float32Array:
    sd_px = camera.blur_px * linear.shape[1] / 1280
    if sd_px <= 0.0:
        return np.ascontiguousarray(linear)
    return np.asarray(cv2.GaussianBlur(linear, (0, 0), sd_px), np.float32)


@functools.cache
def _bank() -> Float32Array:
    """Return normal numbers that all pictures share; each row begins where its own luck says."""
    return np.random.default_rng(_BANK_SEED).standard_normal(_BANK_SIZE, np.float32)


def _offsets(rng: np.random.Generator, height: int, width: int) -> IntArray:
    return rng.integers(0, _BANK_SIZE - width, height)
