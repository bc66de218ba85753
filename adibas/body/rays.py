"""Viewing rays of a depth camera, computed once for each camera."""

from functools import lru_cache

import numpy as np

from adibas.arrays import Float32Array, read_only
from adibas.data.calibration import CameraCalibration
from adibas.geometry.distortion import pixel_rays


@lru_cache(maxsize=4)
def viewing_rays(camera: CameraCalibration) -> Float32Array:
    """Return (H, W, 3) float32: the point that each pixel sees at one metre of depth."""
    table = np.ones((camera.height, camera.width, 3), np.float32)
    table[..., :2] = pixel_rays((camera.height, camera.width), camera.intrinsics, camera.distortion)
    read_only(table)
    return table
