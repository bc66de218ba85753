"""From linear light to the 8-bit picture: lens blur, pixels, noise, colour filter and curve."""

import functools
import math
from dataclasses import replace

import cv2
import numpy as np

from adibas.arrays import Float32Array, IntArray, UInt8Array
from adibas.data.calibration import CameraCalibration
from adibas.geometry.pinhole import Intrinsics
from adibas.simulation.boards_kernels import expose_gray
from adibas.simulation.color_kernels import develop, expose
from adibas.simulation.color_noise import RAW_LEVELS, ColorNoise, srgb_curve

FINE_BLUR = 1.4
"""Standard deviation of a blur in the samples that it is drawn with. What the samples fold back
into the picture (aliasing) is then under a hundredth of an edge; with 0.7 it moves corners by
0.02 px where edges run along the pixels."""
MOST_FINE, MOST_FINE_IN_COLOR = 6, 2
"""Behind a colour filter the pixels between err more than what is folded back."""

_BANK_SIZE = 1 << 21
_BANK_SEED = 0xB0A2D


def take_color(linear: Float32Array, camera: ColorNoise, rng: np.random.Generator) -> UInt8Array:
    """Return the (H, W, 3) uint8 sRGB picture of (H, W, 3) light on the pixels, 1 = full scale."""
    height, width = linear.shape[:2]
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
    """Return the (H, W) uint8 picture of (H, W, 1) light on the pixels, 1 = full, sRGB's curve."""
    light = np.ascontiguousarray(linear[..., 0])
    height, width = light.shape
    signal = np.empty((height, width), np.float32)
    numbers = np.array([camera.full_well, camera.read_noise, camera.corner_loss], float)
    expose_gray(light, numbers, _bank(), _offsets(rng, height, width), signal)
    raw = np.clip(signal * (RAW_LEVELS - 1) + 0.5, 0, RAW_LEVELS - 1).astype(np.uint16)
    picture: UInt8Array = srgb_curve()[raw]
    return picture


def fineness(camera: ColorNoise, width: int, *, in_color: bool = False) -> int:
    """Return into how many parts each way a pixel is drawn, so that its lens blurs before it."""
    most = MOST_FINE_IN_COLOR if in_color and camera.is_mosaic else MOST_FINE
    blur_px = _blur_px(camera, width)
    if blur_px <= 0.0:
        return 1
    return min(max(math.ceil(FINE_BLUR / blur_px - 1e-9), 1), most)


def finer(camera: CameraCalibration, n: int) -> CameraCalibration:
    """Return the camera with each pixel cut into n by n."""
    k = camera.intrinsics
    middle = ((k.cx + 0.5) * n - 0.5, (k.cy + 0.5) * n - 0.5)
    return replace(
        camera,
        width=n * camera.width,
        height=n * camera.height,
        intrinsics=Intrinsics(n * k.fx, n * k.fy, *middle),
    )


def gathered(fine: Float32Array, camera: ColorNoise, n: int) -> Float32Array:
    """Blur (n H, n W, C) light as the lens does, and return the (H, W, C) light of the pixels."""
    height, width, n_channels = fine.shape
    sd_px = _blur_px(camera, width)
    if sd_px > 0.0:
        fine = np.asarray(cv2.GaussianBlur(fine, (0, 0), sd_px), np.float32)
    if n > 1:
        size = (width // n, height // n)
        fine = np.asarray(cv2.resize(fine, size, interpolation=cv2.INTER_AREA), np.float32)
    return np.ascontiguousarray(fine.reshape(height // n, width // n, n_channels))


def _blur_px(camera: ColorNoise, width: int) -> float:
    return camera.blur_px * width / 1280


@functools.cache
def _bank() -> Float32Array:
    """Return normal numbers that all pictures share; each row begins where its own luck says."""
    return np.random.default_rng(_BANK_SEED).standard_normal(_BANK_SIZE, np.float32)


def _offsets(rng: np.random.Generator, height: int, width: int) -> IntArray:
    return rng.integers(0, _BANK_SIZE - width, height)
