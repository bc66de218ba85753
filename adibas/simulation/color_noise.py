"""From light to the 8-bit picture of an inexpensive colour camera."""

from dataclasses import dataclass

import cv2
import numpy as np

from adibas.arrays import Float32Array, UInt8Array
from adibas.data.calibration import CameraCalibration
from adibas.simulation.color_kernels import develop, expose
from adibas.simulation.light import Illumination, black_body_rgb

RAW_LEVELS = 4096
PAPER = 0.8
"""Brightness of white paper at level 1, as a share of full scale."""
_BANK_SIZE = 1 << 21


@dataclass(frozen=True, slots=True)
class ColorNoise:
    """How bad the picture is.

    Attributes
    ----------
    blur_px : float
        Standard deviation of lens blur at 1280x1024; half of it at 640x480 (assumed).
    full_well, read_noise : float
        Electrons: signal-to-noise 63 in white, as of a 2.8 um CMOS pixel at some gain (assumed).
    corner_loss : float
        Share of the light that the lens loses in the corners (assumed).
    is_mosaic : bool
        One colour a pixel behind an RGGB filter, the rest interpolated, as in the real device.
    """

    blur_px: float = 0.7
    full_well: float = 4000.0
    read_noise: float = 8.0
    corner_loss: float = 0.2
    is_mosaic: bool = True


EXACT_COLOR = ColorNoise(
    blur_px=0.0, full_well=1e12, read_noise=0.0, corner_loss=0.0, is_mosaic=False
)
"""A perfect camera: only rounding to 8 bits is left."""


class ColorSensor:
    """The colour camera of one device: light in, pictures out; moments in any order."""

    def __init__(
        self, camera: CameraCalibration, noise: ColorNoise, illumination: Illumination, seed: int
    ) -> None:
        self._noise = noise
        self._seed = seed
        self._size = (camera.height, camera.width)
        self._blur_px = noise.blur_px * camera.width / 1280
        lamp_rgb = black_body_rgb(illumination.temperature_k)
        red, blue = illumination.white_balance_error
        # Automatic white balance goes half of the way.
        gains = np.sqrt(lamp_rgb) * (1.0 + red, 1.0, 1.0 + blue) / lamp_rgb
        # No gain is under 1, so that full pixels are white.
        self._gains = gains / gains.min()
        self._light = PAPER * illumination.level * gains.min() * lamp_rgb
        self._curve = srgb_curve()
        bank = np.random.Generator(np.random.SFC64([seed, 0xC0]))
        self._bank = bank.standard_normal(_BANK_SIZE, np.float32)

    def take(self, linear: Float32Array, moment: int) -> UInt8Array:
        """Return the (H, W, 3) RGB picture of (H, W, 3) linear light; 1 is white paper."""
        if self._blur_px > 0:
            linear = np.asarray(cv2.GaussianBlur(linear, (0, 0), self._blur_px), np.float32)
        if not self._noise.is_mosaic:
            return self._perfect(linear)
        raw = np.empty(self._size, np.uint16)
        rng = np.random.default_rng([self._seed, 0xC1, moment])
        offsets = rng.integers(0, _BANK_SIZE - self._size[1], self._size[0])
        noise = self._noise
        camera = np.array(
            [*self._light, *self._gains, noise.full_well, noise.read_noise, noise.corner_loss]
        )
        expose(linear, camera, self._bank, offsets, raw)
        # OpenCV names a mosaic by its second row: its "BG" begins with red.
        whole = np.asarray(cv2.cvtColor(raw, cv2.COLOR_BayerBG2RGB), np.uint16)
        picture = np.empty((*self._size, 3), np.uint8)
        develop(whole, self._curve, picture)
        return picture

    def _perfect(self, linear: Float32Array) -> UInt8Array:
        signal = np.clip(linear * self._light, 0, 1) * self._gains
        raw = np.clip(signal * (RAW_LEVELS - 1) + 0.5, 0, RAW_LEVELS - 1).astype(np.uint16)
        picture: UInt8Array = self._curve[raw]
        return picture


def srgb_curve() -> UInt8Array:
    """Return what each raw value becomes.

    Source: IEC 61966-2-1.
    """
    value = np.arange(RAW_LEVELS) / (RAW_LEVELS - 1)
    is_dark = value <= 0.0031308  # noqa: PLR2004  (the standard's)
    srgb = np.where(is_dark, 12.92 * value, 1.055 * value ** (1 / 2.4) - 0.055)
    return np.rint(255.0 * srgb).astype(np.uint8)
