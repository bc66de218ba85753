"""What holds for every frame of an OpenNI2 source, as far as the device tells it."""

from collections.abc import Mapping
from dataclasses import replace

from adibas.calibration.registered import in_color_image
from adibas.data.calibration import CameraCalibration, RgbdCalibration
from adibas.data.frames import SourceInfo
from adibas.errors import SensorError
from adibas.geometry.rigid import IDENTITY, RigidTransform
from adibas.sensors.openni2_modes import DEPTH_UNITS_M
from adibas.sensors.openni2_streams import OpenStream
from adibas.sensors.ports import SensorDescription, StreamName

PRIMESENSE_VENDORS = ("primesense", "asus")
PRIMESENSE_COLOR_FROM_DEPTH = RigidTransform(
    IDENTITY.rotation, IDENTITY.translation_m - [0.025, 0, 0]
)
"""The colour camera sits 25 mm to the right of the depth camera (ROS openni2_launch, nominal)."""

PRIMESENSE_SHIFT = (5.0 / 640.0, 4.0 / 640.0)
"""By which the depth image lacks columns and rows of the infrared image, whose camera the field of
view describes, as shares of the width: half of the sensor's matching window (ROS openni2_camera,
getDepthCameraInfo)."""


def describe_source(
    sensor: SensorDescription, streams: Mapping[StreamName, OpenStream], *, is_registered: bool
) -> SourceInfo:
    """Return the header of a source; its calibration is nominal (`rms_px` is None).

    Raises
    ------
    SensorError
        The depth is in a format that has no unit of length.
    """
    depth_format = streams["depth"].mode.pixel_format
    unit_m = DEPTH_UNITS_M.get(depth_format)
    if unit_m is None:
        raise SensorError(
            "The depth is in the format {format}, which cannot be turned into metres. Record in "
            "units of 1 mm or 0.1 mm.",
            format=depth_format,
        )
    return SourceInfo(
        depth_unit_m=unit_m,
        frame_rate_hz=min(stream.mode.frame_rate_hz for stream in streams.values()),
        sensor_name=sensor.name,
        sensor_serial=sensor.serial,
        is_depth_registered=is_registered,
        calibration=_nominal_calibration(sensor, streams, unit_m, is_registered=is_registered),
    )


def _nominal_calibration(
    sensor: SensorDescription,
    streams: Mapping[StreamName, OpenStream],
    unit_m: float,
    *,
    is_registered: bool,
) -> RgbdCalibration | None:
    color = streams["color"].nominal_camera() if "color" in streams else None
    known = RgbdCalibration(color=color, depth_unit_m=unit_m, sensor_serial=sensor.serial)
    if is_registered:
        mode = streams["depth"].mode
        return None if color is None else in_color_image(known, (mode.width, mode.height))
    depth = streams["depth"].nominal_camera()
    if color is None and depth is None:
        return None
    if not sensor.vendor.lower().startswith(PRIMESENSE_VENDORS):
        return replace(known, depth=depth)
    return replace(
        known,
        depth=None if depth is None else _shifted(depth),
        color_from_depth=IDENTITY if color is None else PRIMESENSE_COLOR_FROM_DEPTH,
    )


def _shifted(camera: CameraCalibration) -> CameraCalibration:
    """Return the depth camera of a PrimeSense sensor, whose infrared camera is given."""
    k = camera.intrinsics
    cx, cy = (
        c - camera.width * share for c, share in zip((k.cx, k.cy), PRIMESENSE_SHIFT, strict=True)
    )
    return replace(camera, intrinsics=replace(k, cx=cx, cy=cy))
