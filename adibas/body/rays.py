"""Viewing rays of a depth camera, computed once for each camera, and how they rise."""

from functools import lru_cache

import numpy as np

from adibas.arrays import Float32Array, read_only
from adibas.data.calibration import CameraCalibration
from adibas.geometry.distortion import pixel_rays
from adibas.geometry.planes import Plane


@lru_cache(maxsize=4)
def viewing_rays(camera: CameraCalibration) -> Float32Array:
    """Return (H, W, 3) float32: the point that each pixel sees at one metre of depth."""
    table = np.ones((camera.height, camera.width, 3), np.float32)
    table[..., :2] = pixel_rays((camera.height, camera.width), camera.intrinsics, camera.distortion)
    read_only(table)
    return table


@lru_cache(maxsize=4)
def rise_of_rays(camera: CameraCalibration, floor: Plane) -> Float32Array:
    """Return (H, W) float32: how far each pixel's ray rises over a floor in one metre of depth."""
    rise: Float32Array = viewing_rays(camera) @ floor.normal.astype(np.float32)
    read_only(rise)
    return rise
