"""Sensors other than the usual one: another resolution or field of view, depth with holes."""

from dataclasses import dataclass, replace

import cv2
import numpy as np

from adibas.arrays import UInt16Array
from adibas.data.calibration import CameraCalibration
from adibas.simulation.device import Device, draw_device

HOLE_PX = 3.0
"""Standard deviation of the blur that makes patches of noise."""


@dataclass(frozen=True, slots=True, eq=False)
class CrowdSensor:
    """What is other than with the usual sensor.

    Attributes
    ----------
    camera : CameraCalibration or None
        In place of the device's depth camera.
    hole_share : float
        Of the pixels that lose their depth, in patches that are others in every frame.
    """

    camera: CameraCalibration | None = None
    hole_share: float = 0.0

    def device(self, seed: int) -> Device:
        """Return the device number `seed` with this camera."""
        device = draw_device(seed)
        if self.camera is None:
            return device
        return replace(device, calibration=replace(device.calibration, depth=self.camera))

    def punch(self, depth_raw: UInt16Array, seed: int, index: int) -> None:
        """Take away the depth where frame `index` has holes, in place."""
        if self.hole_share > 0.0:
            noise = np.random.default_rng([seed, 0x40, index]).normal(size=depth_raw.shape)
            patches = cv2.GaussianBlur(noise, (0, 0), HOLE_PX)
            depth_raw[patches < np.quantile(patches, self.hole_share)] = 0
