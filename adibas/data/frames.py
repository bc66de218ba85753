"""Images as sensors deliver them, and the same images in one unit for the measuring stages."""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from adibas.arrays import (
    Float32Array,
    UInt8Array,
    UInt16Array,
    check_shape,
    read_only,
)
from adibas.data.calibration import RgbdCalibration


@dataclass(frozen=True, slots=True)
class EncodedImage:
    """A colour image as the bytes of a JPEG or PNG file."""

    encoding: Literal["jpeg", "png"]
    payload: bytes


@dataclass(frozen=True, slots=True, eq=False)
class SensorFrame:
    """One moment of a sensor, exactly as it gave it; recordings keep this, bit by bit.

    Attributes
    ----------
    sequence : int
        The sensor's own count; a gap means dropped frames.
    timestamp_ns : int
        Sensor clock of the depth (of the colour where there is no depth), nanoseconds.
    depth_raw : (H, W) uint16 array or None
        Depth in the source's unit (`SourceInfo.depth_unit_m`); 0 = no reading.
    color : (H, W, 3) uint8 array, EncodedImage or None
        RGB.
    color_timestamp_ns : int or None
        Sensor clock of the colour; None where there is no colour.
    infrared_raw : (H, W) uint16 array or None
        Brightness seen by the depth camera, for calibration.
    """

    sequence: int
    timestamp_ns: int
    depth_raw: UInt16Array | None = None
    color: UInt8Array | EncodedImage | None = None
    color_timestamp_ns: int | None = None
    infrared_raw: UInt16Array | None = None

    def __post_init__(self) -> None:
        for name in ("depth_raw", "infrared_raw"):
            image = getattr(self, name)
            if image is not None:
                _check_image(name, image, (None, None), np.uint16)
        if isinstance(self.color, np.ndarray):
            _check_image("color", self.color, (None, None, 3), np.uint8)
        if (self.color is None) != (self.color_timestamp_ns is None):
            raise ValueError("color and color_timestamp_ns stand or lack together")


@dataclass(frozen=True, slots=True)
class SourceInfo:
    """What holds for every frame of a sensor or a recording.

    Attributes
    ----------
    depth_unit_m : float
        Metres in one count of `SensorFrame.depth_raw`.
    frame_rate_hz : float
        Nominal.
    sensor_name, sensor_serial : str
        As the sensor says; empty where unknown.
    is_depth_registered : bool
        True where the sensor already moved the depth into the colour image.
    calibration : RgbdCalibration or None
        None where the source brings none.
    n_dropped : int
        Frames that the sensor counted and that were not kept.
    """

    depth_unit_m: float = 0.001
    frame_rate_hz: float = 30.0
    sensor_name: str = ""
    sensor_serial: str = ""
    is_depth_registered: bool = False
    calibration: RgbdCalibration | None = None
    n_dropped: int = 0

    def __post_init__(self) -> None:
        if not (self.depth_unit_m > 0 and self.frame_rate_hz > 0):
            raise ValueError("depth_unit_m and frame_rate_hz must be positive")


@dataclass(frozen=True, slots=True, eq=False)
class RgbdFrame:
    """One moment in metres, safe to share between threads.

    Attributes
    ----------
    sequence, timestamp_ns : int
        As in `SensorFrame`.
    depth_m : (H, W) float32 array
        Distance along the depth camera's z, metres; NaN where not measured.
    color_rgb : (H', W', 3) uint8 array
        The colour image; its size may differ from the depth's.
    """

    sequence: int
    timestamp_ns: int
    depth_m: Float32Array
    color_rgb: UInt8Array

    def __post_init__(self) -> None:
        _check_image("depth_m", self.depth_m, (None, None), np.float32)
        _check_image("color_rgb", self.color_rgb, (None, None, 3), np.uint8)


def depth_in_metres(depth_raw: UInt16Array, depth_unit_m: float) -> Float32Array:
    """Return (H, W) float32 metres, NaN where `depth_raw` is 0 (no reading)."""
    depth_m = depth_raw.astype(np.float32) * np.float32(depth_unit_m)
    depth_m[depth_raw == 0] = np.nan
    return depth_m


def _check_image(
    name: str,
    image: Float32Array | UInt8Array | UInt16Array,
    shape: tuple[int | None, ...],
    dtype: type[np.generic],
) -> None:
    check_shape(name, image, shape)
    if image.dtype != dtype:
        raise ValueError(f"{name} must be {dtype.__name__}, got {image.dtype}")
    read_only(image)
